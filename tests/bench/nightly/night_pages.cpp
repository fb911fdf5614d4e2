// Pages, JUnit XML and metrics of a night that is known number by number; plots coordinate by coordinate.
#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "bench/nightly/followed_page.h"
#include "bench/nightly/night.h"
#include "bench/nightly/suite.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

FollowedFigure figure_of(std::vector<double> values) {
  FollowedFigure figure;
  figure.name = "error_psi";
  for (std::size_t i = 0; i < values.size(); ++i) figure.runs.push_back(static_cast<std::int64_t>(i) + 1);
  figure.accepted.assign(values.size(), false);
  figure.values = std::move(values);
  return figure;
}

FollowedFigure banded(std::vector<double> values) {
  FollowedFigure figure = figure_of(std::move(values));
  figure.chart.band = analysis::ControlBand{1.5, 0.125, 1.0, 2.0, 8};
  return figure;
}

std::string page_of(const FollowedFigure& figure, bool baseline = false) {
  Followed followed;
  followed.subject = "nightly/paper";
  if (baseline) followed.baseline = db::BaselineRecord{1, "nightly/paper", "as made", "K. Lee", "2026-01-01", {1, 2}};
  followed.counted = 8;
  followed.figures = {figure};
  return trend_page("Title", "hardware", {followed});
}

void check_parts(const std::string& text, const std::vector<std::string>& parts) {
  INFO(text);
  for (const std::string& part : parts) {
    INFO(part);
    CHECK(text.find(part) != std::string::npos);
  }
}

Suite three_scenarios() {
  return parse_suite(
      "schema = 1\nname = \"s\"\n[[scenario]]\nname = \"one\"\nabout = \"first\"\n[[scenario]]\nname = \"two\"\n"
      "about = \"second\"\n[[scenario]]\nname = \"three\"\nabout = \"third\"\n",
      "s.toml");
}

std::vector<ScenarioResult> two_results() {
  ScenarioResult green, red;
  green.name = "one";
  green.about = "first";
  green.seconds = 1.25;
  green.compared = "same";
  green.figures = {{"frames", 211.0}, {"error_psi", 0.5}};
  red.name = "two";
  red.about = "second";
  red.seconds = 2.5;
  red.wrong = {"this", "that"};
  return {green, red};
}

}  // namespace

TEST_CASE("small plot: three values before their band, the last one a dot") {
  check_parts(page_of(banded({1.0, 3.0, 2.0}), true),
              {"<caption>nightly/paper: baseline of 2 runs, as made, accepted by K. Lee on 2026-01-01</caption>",
               "<tr><th scope=\"row\">error_psi</th><td class=\"n\">2</td><td class=\"n\">1.5; 1 to 2</td>",
               "<svg width=\"170\" height=\"30\" role=\"img\"><title>error_psi over the last 3 runs, 1 to 3</title>"
               "<path class=\"band\" d=\"M0 15H170V27.93H0Z\"/><path class=\"line\" d=\"M4 27.93L85 2.07L166 15\"/>"
               "<circle class=\"dot\" cx=\"166\" cy=\"15\" r=\"2.5\"/></svg>",
               "<span class=\"sign\">✓</span> within</span>"});
  FollowedFigure figure = banded({1.25, 1.75});  // the band is wider than the values
  figure.outside = true;
  check_parts(page_of(figure),
              {"<path class=\"band\" d=\"M0 2.07H170V27.93H0Z\"/>",
               "<path class=\"line\" d=\"M4 21.47L166 8.53\"/><circle class=\"out\" cx=\"166\" cy=\"8.53\"",
               "<span class=\"sign\">✗</span> outside</span>"});
}

TEST_CASE("a page says what a short baseline and repeated seeds do not judge") {
  Followed followed;
  followed.subject = "nightly/paper";
  followed.baseline = db::BaselineRecord{1, "nightly/paper", "as made", "K. Lee", "2026-01-01", {1, 2, 3}};
  followed.counted = 3;
  followed.run = 9;
  followed.same_seeds = 7;
  check_parts(
      trend_page("Title", "simulated", {followed}),
      {"accepted by K. Lee on 2026-01-01; fewer than 8 measurements: it shows gross changes only, accept a longer "
       "one; run 9 has the seeds of run 7: no moving average</caption>"});
}

TEST_CASE("small plot: a single value in the middle, and the newest sixty of more") {
  check_parts(page_of(figure_of({5.0})), {"<title>error_psi over the last 1 run, 5 to 5</title><path class=\"line\" "
                                          "d=\"M85 15\"/><circle class=\"dot\" cx=\"85\" cy=\"15\" r=\"2.5\"/>",
                                          "<td class=\"n\">–</td>", "<td class=\"state\">no baseline</td>"});
  std::vector<double> many(61, 2.0);
  many.front() = 100.0;
  many.back() = 3.0;
  check_parts(page_of(figure_of(many)),
              {"<title>error_psi over the last 60 runs, 2 to 3</title>", "d=\"M4 27.93L6.75 "});
  FollowedFigure figure = banded({1.0, 2.0});
  figure.shifted = true;
  check_parts(page_of(figure), {"<span class=\"sign\">▲</span> shifted</span>"});
  figure.missing = figure.outside = true;
  check_parts(page_of(figure), {"<span class=\"sign\">✗</span> missing</span>"});
  CHECK(page_of(figure).find("SIMULATED") == std::string::npos);
  CHECK(trend_page("Title", "simulated", {}).find("SIMULATED") != std::string::npos);
}

TEST_CASE("lines about figures that lie outside, are missing or shifted") {
  Followed followed;
  followed.run = 9;
  followed.baseline = db::BaselineRecord{1, "s", "as made", "K. Lee", "", {1, 2}};
  followed.figures = {banded({1.5, 2.25}), banded({1.5}), banded({1.5})};
  followed.figures[0].outside = true;
  followed.figures[1].outside = followed.figures[1].missing = true;
  FollowedFigure& moved = followed.figures[2];
  moved.shifted = true;
  moved.chart.ewma = analysis::EwmaState{8, 5, 1.5, 0.125, -2.0, -4.5};
  moved.chart.level = 1.25;
  moved.chart.probability = 0.0002;
  moved.chart.slope = -0.125;
  CHECK(
      outside_lines(followed) ==
      std::vector<std::string>{"error_psi is 2.25, outside 1 to 2 of the baseline (mean 1.5, spread 0.12 of 8 runs; as "
                               "made, accepted by K. Lee)",
                               "error_psi is missing from run 9; the baseline has it (as made, accepted by K. Lee)"});
  CHECK(shift_lines(followed) ==
        std::vector<std::string>{
            "error_psi shifted: its moving average is 1.25, -2 of the baseline's deviations from its "
            "mean 1.5 (8 runs), by chance with p = 0.0002 in 60 runs; -0.125 per run"});
  followed.figures[0].chart.constant = true;
  CHECK(outside_lines(followed).front() ==
        "error_psi is 2.25, and was 1.5 in each of 8 runs of the baseline (as made, accepted by K. Lee)");
}

TEST_CASE("a night as JUnit XML and metrics, by the letter") {
  CHECK(junit_xml(three_scenarios(), two_results()) ==
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<testsuite name=\"s\" tests=\"3\" failures=\"1\" errors=\"1\" time=\"3.750\">\n"
        "  <testcase classname=\"s\" name=\"one\" time=\"1.250\"/>\n"
        "  <testcase classname=\"s\" name=\"two\" time=\"2.500\">\n"
        "    <failure message=\"this\">second\nthis\nthat</failure>\n  </testcase>\n"
        "  <testcase classname=\"s\" name=\"three\" time=\"0.000\"><error message=\"it did not run\"/></testcase>\n"
        "</testsuite>\n");
  std::vector<ScenarioResult> results = two_results();
  results[0].remarks = {"shifted <a>"};
  CHECK(junit_xml(three_scenarios(), results).find("time=\"1.250\"><system-out>shifted &lt;a&gt;</system-out>") !=
        std::string::npos);
  CHECK(metrics_text(three_scenarios(), two_results()) ==
        "# HELP tactbench_nightly_green 1 when a scenario gave the expected result.\n"
        "# TYPE tactbench_nightly_green gauge\n"
        "tactbench_nightly_green{scenario=\"one\"} 1\ntactbench_nightly_green{scenario=\"two\"} 0\n"
        "tactbench_nightly_green{scenario=\"three\"} 0\n"
        "# HELP tactbench_nightly_figure Figure measured by a scenario; its name includes the unit.\n"
        "# TYPE tactbench_nightly_figure gauge\n"
        "tactbench_nightly_figure{scenario=\"one\",figure=\"error_psi\"} 0.5\n"
        "tactbench_nightly_figure{scenario=\"one\",figure=\"frames\"} 211\n");
}

TEST_CASE("the page of a night: red ones first, those that did not run last, figures where nights are kept") {
  NightPage night;
  night.begun_utc = "2026-01-01T00:00:00Z";
  night.program = "tactbench 1";
  night.results = two_results();
  const std::string page = night_page(three_scenarios(), night);
  check_parts(
      page,
      {"<title>Night of 2026-01-01T00:00:00Z: suite s</title>", "<p>3 scenarios, 1 red, 1 not run. tactbench 1</p>",
       "<tr><th scope=\"row\">two</th><td class=\"state\"><span class=\"fail\"><span class=\"sign\">✗</span> "
       "red</span></td><td class=\"n\">2.5</td><td></td><td>second<br/><span class=\"fail\">this</span>"
       "<br/><span class=\"fail\">that</span></td></tr>\n<tr><th scope=\"row\">one</th>",
       "> green</span></td><td class=\"n\">1.2</td><td>same</td><td>first</td></tr>\n<tr><th "
       "scope=\"row\">three</th><td class=\"state fail\">✗ not run</td>",
       "SIMULATED"});
  CHECK(page.find("Figures over the nights") == std::string::npos);
  night.results[0].remarks = {"shifted"};
  night.followed.emplace_back();
  night.followed.back().subject = "nightly/one";
  night.followed.back().figures = {banded({1.0, 2.0})};
  check_parts(night_page(three_scenarios(), night),
              {"Figures over the nights", "▲</span> moved</span></td><td class=\"n\">1.2</td>",
               "<br/><span class=\"doubt\">shifted</span>", "<caption>nightly/one</caption>"});
}
