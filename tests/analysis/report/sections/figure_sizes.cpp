// The size of every figure of a report, by its title: the page's text is 682 pixels wide, so that two charts of 335 or
// three of 226 stand side by side.
#include <algorithm>
#include <catch2/catch.hpp>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "tests/analysis/report/report_example_full.h"
#include "tests/analysis/report/report_page.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

struct SizeRule {
  const char* title_begins;
  int width, height;  // of a map 16 x 16: both alike
};

// The first that a title begins with counts.
const std::vector<SizeRule> kSizeRules = {
    {"Colour scale of", 160, 10},
    // Health and indication.
    {"Span of each taxel", 220, 220},
    {"Noise of one sample, number of taxels", 420, 240},
    {"Indication of the mean taxel, sequence ", 335, 255},
    {"External loop of the indication of the mean, best, median and worst taxel", 682, 330},
    {"Output of each taxel over the mean at one level, pressure increasing", 480, 480},
    {"Repeatability of the output per level", 682, 245},
    // Loops, frames, levels.
    {"Output voltage measured and by the ELAM model against pressure, mean taxel, ", 335, 265},
    {"Corrected indication against reference value, mean taxel, sequence ascending", 335, 265},
    {"Corrected indication against reference value, mean taxel, sequence descending", 335, 265},
    {"Lack of fit of the ELAM model against pressure, ", 682, 180},
    {"Indication, increasing, ", 78, 78},
    {"Indication, decreasing, ", 78, 78},
    {"Indication, hysteresis, ", 78, 78},
    {"Corrected indication, increasing, ", 78, 78},
    {"Corrected indication, decreasing, ", 78, 78},
    {"Corrected indication, hysteresis, ", 78, 78},
    {"Hysteresis of indication and corrected indication per level", 335, 285},
    {"Standard deviation over the taxels per level, indication and corrected indication", 335, 285},
    // The models.
    {"Mean absolute error of each taxel in kPa", 416, 416},
    {"alpha_d of each taxel", 190, 190},
    {"beta_d of each taxel", 190, 190},
    {"alpha_a1 of each taxel", 190, 190},
    {"alpha_a0 of each taxel", 190, 190},
    {"beta_a of each taxel", 190, 190},
    {"Histogram of ", 335, 215},
    {"Output measured and by the model against pressure: ", 335, 225},
    {"Lack of fit, model minus measured: ", 335, 140},
    {"Residuals of the four models, model minus measured, step by step: ", 335, 340},
    {"Hysteresis per level: indication, as found, as left", 335, 265},
    {"The same of the corrected indication alone, on a scale of its own", 335, 265},
    // Single taxels.
    {"Share of the fitted taxels that meet the rule by noise, and by noise and model error", 335, 280},
    {"Pressure by which an output off by noise and model error moves the inverse, per level", 335, 280},
    {"Output measured and by the direct model against pressure, ", 226, 205},
    {"Pressure measured and by the inverse model against output, ", 226, 205},
    {"Corrected indication against reference value, ", 226, 205},
    // Studies and objects.
    {"Standard deviation within and between mounts per level", 335, 255},
    {"Standard deviation between mounts of each taxel", 190, 190},
    {"The chamber’s part, % of the pressure", 190, 190},
    {"The sensor’s part (error of its models), % of the pressure", 190, 190},
    {"Standard deviation of the chamber’s part and of the residual per level", 682, 225},
    {"Output of unloaded taxels along the loaded rows and columns over distance", 682, 200},
    {"Mean absolute error of the corrected indication over the time that a level was held", 335, 245},
    {"Mean absolute error of the corrected indication over the rate of the pressure", 335, 245},
    {"Total force of the array against the force sensor, ", 335, 260},
    {"Contact area over the force, ", 335, 260},
    {"Indication under the object, ", 78, 78},
    {"Corrected indication under the object, ", 78, 78}};

}  // namespace

TEST_CASE("every figure of a report has the size that its place on the page gives it") {
  ReportInput input = example::full_input();
  RateHoldRun& run = input.more.studies.rate_hold.runs.front();
  run.by_rate = run.by_hold;
  std::string page = render_report(input).html;
  input.evaluation.levels.clear();  // then the indication has charts of its own
  input.behaviour.traces = {{"up", {0.0, 60.0}, {0.0, 3.0}}};
  page += render_report(input).html;
  static const std::regex figure(
      "<svg role=\"img\"[^>]*viewBox=\"0 0 ([0-9.]+) ([0-9.]+)\" width=\"([0-9.]+)\" height=\"([0-9.]+)\">"
      "<title>([^<]*)</title>");
  std::set<std::string> met;
  std::size_t figures = 0;
  for (std::sregex_iterator at(page.begin(), page.end(), figure), end; at != end; ++at) {
    const std::smatch& own = *at;
    const std::string title = own[5].str();
    INFO(title);
    ++figures;
    const auto rule =
        std::ranges::find_if(kSizeRules, [&](const SizeRule& each) { return title.rfind(each.title_begins, 0) == 0; });
    if (rule == kSizeRules.end()) {
      FAIL_CHECK("no size is written down for it: " << own[3] << " x " << own[4]);
      continue;
    }
    met.insert(rule->title_begins);
    CHECK(own[1].str() == std::to_string(rule->width));
    CHECK(own[2].str() == std::to_string(rule->height));
    CHECK(own[3] == own[1]);
    CHECK(own[4] == own[2]);
  }
  CHECK(figures == count(page, "<svg "));
  for (const SizeRule& rule : kSizeRules) {
    INFO(rule.title_begins);
    CHECK(met.contains(rule.title_begins));
  }
}
