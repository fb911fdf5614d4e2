// The numbers in the report: the JSON inside is read back and compared with what the page prints.
#include <catch2/catch.hpp>
#include <limits>
#include <nlohmann/json.hpp>

#include "analysis/report/page/html.h"
#include "analysis/report/report.h"
#include "tests/analysis/report/report_example.h"
#include "tests/analysis/report/report_page.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

constexpr PressureUnit kFiguresUnit = PressureUnit::kKilopascal;
constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

// `text` without its tags.
std::string untagged(const std::string& text) {
  std::string out;
  bool in_tag = false;
  for (const char c : text) {
    if (c == '<') in_tag = true;
    if (!in_tag) out += c;
    if (c == '>') in_tag = false;
  }
  return out;
}

// Text of the cells (td and th) of the row whose head is `head`, in the table whose caption begins with `caption`.
std::vector<std::string> row_of(const std::string& page, const std::string& caption, const std::string& head) {
  const std::size_t table = page.find("<caption>" + caption);
  REQUIRE(table != std::string::npos);
  const std::string body = page.substr(table, page.find("</table>", table) - table);
  for (std::size_t row = body.find("<tr>"); row != std::string::npos; row = body.find("<tr>", row + 1)) {
    const std::size_t end = body.find("</tr>", row);
    std::vector<std::string> out;
    for (std::size_t at = body.find("<t", row + 4); at < end; at = body.find("<t", at + 1)) {
      const std::string element = body.substr(at + 1, 2);
      if ((element != "td" && element != "th") || body.compare(at, 6, "<thead") == 0) continue;
      out.push_back(untagged(body.substr(at, body.find("</" + element + ">", at) - at)));
    }
    if (!out.empty() && out.front() == head) return out;
  }
  FAIL("no row " << head << " in " << caption);
  return {};
}

std::string percent(const nlohmann::json& share, int digits) {
  return html::percent(share.get<double>(), digits).value;
}

}  // namespace

TEST_CASE("the per-level table prints the levels of the JSON, rounded") {
  const Report report = render_report(example::example_input());
  const auto data = nlohmann::json::parse(data_text(report.html));
  CHECK(data["schema"] == "tactbench.report");
  CHECK(data["version"] == 2);
  CHECK(data["number"] == report.number);
  const auto& levels = data["results"]["evaluation"]["levels"];
  REQUIRE(levels.size() == 31);
  for (const auto& level : levels) {
    const double pressure = level["pressure_psi"];
    const auto row = row_of(report.html, "Levels of the external loop", html::in_unit(pressure, kFiguresUnit, 1).value);
    REQUIRE(row.size() == 14);
    CHECK(row[1] == html::fixed(pressure, 1).value);
    CHECK(row[2] == html::fixed(6.894757293168 * level["up_psi"].get<double>(), 1).value);
    CHECK(row[4] == percent(level["raw_std_up_fs"], 2));
    CHECK(row[5] == percent(level["raw_std_down_fs"], 2));
    CHECK(row[6] == percent(level["raw_distance_fs"], 2));
    CHECK(row[7] == percent(level["comp_std_up_fs"], 2));
    CHECK(row[8] == percent(level["comp_std_down_fs"], 2));
    CHECK(row[9] == percent(level["comp_distance_fs"], 2));
    CHECK(row[10] == percent(level["comp_distance_observable_fs"], 2));
    CHECK(row[11] == percent(level["worst_taxel_distance_fs"], 2));
    CHECK(row[12] == std::to_string(level["flat_taxels"].get<int>()));
    const bool worse = level["made_worse"] || level["std_up_made_worse"] || level["std_down_made_worse"];
    CHECK((row[13].find("▲ worse") == 0) == worse);
    CHECK((row[13] == "smaller") == !worse);
  }
}

TEST_CASE("a level made worse is marked where it is, as in the paper's own tables near 50 psi") {
  ReportInput input = example::example_input();
  for (LevelFigures& level : input.evaluation.levels) {
    level.made_worse = level.pressure_psi == 50.0;
    level.comp_std_up = level.comp_std_down = 0.0;
    level.raw_std_up = level.raw_std_down = 0.1;
    if (level.made_worse) {
      level.raw_distance = 0.04;
      level.comp_distance = 0.07;
    }
  }
  const std::string page = render_report(input).html;
  CHECK(row_of(page, "Levels of the external loop", "344.7")[13] == "▲ worse: hysteresis");
  CHECK(row_of(page, "Levels of the external loop", "330.9")[13] == "smaller");
  CHECK(page.find("larger at 1 of 31 levels</span> (345 kPa)") != std::string::npos);
  CHECK(page.find("non-uniformity (s), increasing or decreasing: larger at none of 31 levels") != std::string::npos);
}

TEST_CASE("frames strips print std and distance of the levels that they show") {
  const ReportInput input = example::example_input();
  const Report report = render_report(input);
  const auto levels = nlohmann::json::parse(data_text(report.html))["results"]["evaluation"]["levels"];
  const auto frames = nlohmann::json::parse(data_text(report.html))["results"]["frames"];
  const auto raw = row_of(report.html, "Indication: output voltage", "mean, % FS");
  const auto compensated = row_of(report.html, "Corrected indication: pressure", "mean, % FS");
  const std::vector<std::size_t> shown = {2, 5, 10, 15, 20, 25, 30};
  REQUIRE(raw.size() == shown.size() + 1);
  for (std::size_t i = 0; i < shown.size(); ++i) {
    CHECK(raw[i + 1] == percent(levels[shown[i]]["raw_distance_fs"], 1));
    CHECK(compensated[i + 1] == percent(levels[shown[i]]["comp_distance_fs"], 1));
  }
  // The frames in the JSON give the printed non-uniformity again.
  const double full_scale = nlohmann::json::parse(data_text(report.html))["results"]["evaluation"]["full_scale_v"];
  const auto std_up = row_of(report.html, "Indication: output voltage", "s, % FS");
  for (std::size_t i = 0; i < shown.size(); ++i) {
    const auto values = frames[shown[i]]["raw_up_v"].get<std::vector<double>>();
    CHECK(std_up[i + 1] == html::percent(example::std_of(values, input.fit) / full_scale, 1).value);
  }
}

TEST_CASE("model, loops, hysteresis, verdicts and held-out tables print the JSON's figures") {
  const Report report = render_report(example::example_input());
  const auto results = nlohmann::json::parse(data_text(report.html))["results"];
  const auto& evaluation = results["evaluation"];
  const auto hysteresis = row_of(report.html, "Hysteresis of the indication", "mean taxel, as in Loops and Levels");
  CHECK(hysteresis[1] == percent(evaluation["hysteresis_max_fs"], 1));
  CHECK(hysteresis[2] == percent(evaluation["hysteresis_mean_fs"], 1));
  CHECK(row_of(report.html, "Absolute error", "mean")[1] ==
        html::pressure(evaluation["mean_error_psi"], kFiguresUnit, 3).value);

  const auto& mean = results["model"]["mean_taxel"];
  const auto names = results["model"]["parameter_names"].get<std::vector<std::string>>();
  for (std::size_t i = 0; i < names.size(); ++i) {
    CHECK(row_of(report.html, "ELAM of the mean taxel", names[i])[1] == html::fixed(mean["parameters"][i], 4).value);
    std::vector<double> all;
    std::size_t bounds = 0;
    for (const auto& taxel : results["model"]["taxels"]) {
      if (taxel["status"] != "fitted") continue;
      all.push_back(taxel["parameters"][i]);
      bounds += (taxel["at_bound"].get<unsigned>() >> i) & 1u;
    }
    std::sort(all.begin(), all.end());
    const auto row = row_of(report.html, "ELAM of the 254 fitted taxels", names[i]);
    CHECK(row[2] == html::fixed(all.front(), 4).value);
    CHECK(row[3] == html::fixed(0.5 * (all[126] + all[127]), 4).value);
    CHECK(row[4] == html::fixed(all.back(), 4).value);
    CHECK(row[5] == std::to_string(bounds));
  }
  CHECK(row_of(report.html, "Taxels without a model", "37")[1] == "row 2, column 5");
  CHECK(row_of(report.html, "Taxels without a model", "200")[2] == "saturated");

  for (const auto& trace : results["traces"]) {
    double sum = 0.0, highest = 0.0;
    const auto model = trace["model_v"].get<std::vector<double>>(),
               measured = trace["measured_v"].get<std::vector<double>>();
    for (std::size_t i = 0; i < model.size(); ++i) {
      sum += std::abs(model[i] - measured[i]);
      highest = std::max(highest, std::abs(model[i] - measured[i]));
    }
    const auto row = row_of(report.html, "Errors of the mean taxel by sequence", trace["sequence"]);
    CHECK(row[2] == html::fixed(sum / static_cast<double>(model.size()), 4).value);
    CHECK(row[4] == html::fixed(highest, 4).value);
  }

  const auto held_out =
      row_of(report.html, "The models on this and other runs", "corrected: hysteresis, mean over taxels, % FS");
  REQUIRE(held_out.size() == 5);
  CHECK(held_out[1] == percent(evaluation["comp_distance_fs"], 2));
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(held_out[i + 2] == percent(results["held_out"][i]["evaluation"]["comp_distance_fs"], 2));

  const auto verdict = row_of(report.html, "Requirements", "hysteresis of the mean");
  CHECK(verdict[2] == percent(results["verdicts"][2]["value"], 2) + "\u00A0%\u00A0FS");
  CHECK(verdict[6] == "✓ simulated pass");
}

TEST_CASE("five runs and more go into further tables") {
  ReportInput input = example::example_input();
  for (int i = 0; i < 3; ++i) input.held_out.push_back(input.held_out.front());
  const std::string page = render_report(input).html;
  CHECK(row_of(page, "The models on this and other runs", "run").size() == 5);
  CHECK(row_of(page, "The models on other runs, continued", "run").size() == 4);
}

TEST_CASE("values that are not numbers are null in the JSON and not available on the page") {
  ReportInput input = example::example_input();
  Evaluation& e = input.evaluation;
  e.mean_error_psi = e.hysteresis_max_fs = e.levels[3].comp_distance = kNoNumber;
  e.max_error_psi = std::numeric_limits<double>::infinity();
  e.traces[0].model_v[5] = e.traces[0].pressure_psi[9] = kNoNumber;
  e.levels[2].raw_up_v[8] = kNoNumber;
  input.verdicts[0].value = kNoNumber;
  input.fit.taxels.back().fit.j = kNoNumber;
  e.levels[27].flat_taxels = 254;  // every fitted one: nothing observable is left
  e.levels[27].comp_distance_observable = 0.0;
  const Report report = render_report(input);
  const auto results = nlohmann::json::parse(data_text(report.html))["results"];
  CHECK(results["evaluation"]["levels"][27]["comp_distance_observable_fs"].is_null());
  CHECK(row_of(report.html, "Levels of the external loop", "372.3")[10] == "not available");
  CHECK(results["evaluation"]["mean_error_psi"].is_null());
  CHECK(results["evaluation"]["max_error_psi"].is_null());
  CHECK(results["traces"][0]["model_v"][5].is_null());
  CHECK(results["verdicts"][0]["value"].is_null());
  CHECK(results["taxel_mean_error_psi"][37].is_null());
  CHECK(row_of(report.html, "Absolute error", "mean")[1] == "not available");
  CHECK(row_of(report.html, "Levels of the external loop", "41.4")[9] == "not available");
  CHECK(row_of(report.html, "Requirements", "mean absolute error")[2] == "not available");
  CHECK(report.html.find("nan") == std::string::npos);
  CHECK(report.html.find("\"inf") == std::string::npos);
}
