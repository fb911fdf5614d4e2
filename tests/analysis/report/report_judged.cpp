// Page 1 of a report that was judged on several runs, and the batch page's order.
#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "analysis/report/overview/overview.h"
#include "tests/analysis/report/report_example.h"
#include "tests/analysis/report/report_page.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

// Verdicts on the held-out runs, in the order given; run 15 fails one criterion.
ReportInput judged_on(const std::vector<std::int64_t>& runs) {
  ReportInput input = example::example_input();
  const std::vector<db::VerdictRecord> own = input.verdicts;
  input.verdicts.clear();
  for (const std::int64_t run : runs) {
    for (db::VerdictRecord verdict : own) {
      verdict.run = run;
      verdict.model_run = 12;
      verdict.verdict = run == 15 && verdict.criterion == "worst_taxel_error" ? "fail" : "pass";
      input.verdicts.push_back(verdict);
    }
  }
  return input;
}

std::string first_page(const ReportInput& input) {
  const Report report = render_report(input);
  require_well_formed(report.html);
  require_inert(report.html);
  const std::size_t from = report.html.find("id=\"verdicts\"");
  return report.html.substr(from, report.html.find("id=\"identification\"") - from);
}

ReportInput sensor_run(std::int64_t run, const std::string& sensor, double error, const std::string& verdict) {
  ReportInput input = example::example_input();
  input.run.run = run;
  input.run.sensor_serial = sensor;
  input.run.started_utc = fmt::format("2024-05-{:02}T00:00:00Z", run);
  input.held_out.clear();
  input.evaluation.mean_error_psi = error;
  input.verdicts.resize(verdict.empty() ? 0 : 1);
  if (!verdict.empty()) input.verdicts[0].verdict = verdict;
  return input;
}

}  // namespace

TEST_CASE("page 1 names every run judged and the one that decided, in any order") {
  std::vector<std::int64_t> runs = {13, 14, 15};
  do {
    const std::string page = first_page(judged_on(runs));
    CHECK_THAT(page, Catch::Contains("simulated fail</span>, decided by one month later at +5 °C.</p>"));
    CHECK_THAT(page, Catch::Contains("Runs judged") && Catch::Contains("<th scope=\"row\">held-out run</th>") &&
                         Catch::Contains("<th scope=\"row\">re-mounted</th>"));
    CHECK(count(page, "simulated fail") == 3);  // all together, the run, its criterion
    CHECK_THAT(page, Catch::Contains("worst taxel&#39;s mean error") && !Catch::Contains("worst taxel error"));
  } while (std::ranges::next_permutation(runs).found);
  const auto json = nlohmann::json::parse(render_report(judged_on({13, 14, 15})).json)["results"];
  CHECK(json["judgement"]["overall"] == "fail");
  CHECK(json["judgement"]["runs"].size() == 3);
  CHECK(json["judgement"]["runs"][2]["verdict"] == "fail");
  CHECK(json["verdicts"][0]["on"] == "held-out run");
}

TEST_CASE("the report's number does not depend on the numbers of the runs judged") {
  ReportInput input = judged_on({13, 14, 15});
  const std::string number = render_report(input).number;
  for (std::size_t i = 0; i < input.held_out.size(); ++i)
    input.held_out[i].run.run = input.held_out[i].evaluation.run = 70 + static_cast<std::int64_t>(i);
  for (db::VerdictRecord& verdict : input.verdicts) verdict.run += 57;
  CHECK(render_report(input).number == number);
  std::swap(input.verdicts.front().verdict, input.verdicts[11].verdict);  // another run fails
  CHECK(render_report(input).number != number);
}

TEST_CASE("missing verdicts, earlier stored verdicts and void runs are named on page 1") {
  ReportInput input = example::example_input();
  for (db::VerdictRecord& verdict : input.verdicts) verdict.verdict = "inconclusive";
  input.judgement.not_judged = "no independent data";
  const std::string own = first_page(input);
  CHECK_THAT(own, Catch::Contains("simulated inconclusive</span>, not judged: no independent data.") &&
                      Catch::Contains("– not judged") && !Catch::Contains("simulated pass"));

  input = judged_on({13});
  input.judgement.stored_worse = {judged_on({15}).verdicts[1]};
  input.judgement.remarks = {"run 14 was declared void by me"};
  const std::string both = first_page(input);
  CHECK_THAT(both, Catch::Contains("All requirements together: <span class=\"pass\">") &&
                       Catch::Contains("Stored verdict on these models, worse than the one above: <span "
                                       "class=\"fail\">") &&
                       Catch::Contains("one month later at +5 °C: fail") &&
                       Catch::Contains("run 14 was declared void by me"));
  input.run.void_utc = "2024-06-01T00:00:00Z";
  input.run.void_by = "me";
  CHECK_THAT(render_report(input).html,
             Catch::Contains("<p class=\"void\">") && Catch::Contains("It no longer counts"));
  CHECK_THAT(render_comparison(input, example::example_input()).html, Catch::Contains("by me, 2024-06-01 00:00:00Z"));
}

TEST_CASE("a signed report says so in its title, a draft with the same number does not") {
  ReportInput input = judged_on({13});
  const Report draft = render_report(input);
  CHECK(draft.html.find(signed_title_mark(draft.number) + "</title>") == std::string::npos);
  input.approvals.push_back({12, draft.number, draft.content_sha256, "C. Chief", "2024-06-01T00:00:00Z", "", ""});
  const Report issued = render_report(input);
  CHECK(issued.number == draft.number);
  CHECK(issued.html.find(signed_title_mark(issued.number) + "</title>") != std::string::npos);
}

TEST_CASE("a batch ranks by verdict before error, and has one row a sensor") {
  std::vector<ReportInput> named = {sensor_run(1, "S-fail", 0.1, "fail"),
                                    sensor_run(2, "S-none", 0.2, ""),
                                    sensor_run(3, "S-doubt", 0.3, "conditional pass"),
                                    sensor_run(4, "S-good", 0.5, "pass"),
                                    sensor_run(5, "S-better", 0.4, "pass"),
                                    sensor_run(6, "S-good", 0.6, "pass"),
                                    sensor_run(7, "S-bare", 0.1, "pass"),
                                    sensor_run(8, "S-bare", 0.1, "")};
  named[7].fit = {};  // newer, and without models: the one with models stands for the sensor
  CHECK(batch_rows(named) == std::vector<std::size_t>{0, 1, 2, 4, 5, 6});
  const Report report = render_batch(named);
  require_well_formed(report.html);
  std::vector<std::size_t> places;
  for (const char* sensor : {"S-bare", "S-better", "S-good", "S-doubt", "S-none", "S-fail"}) {
    INFO(sensor);
    places.push_back(report.html.find(fmt::format("<th scope=\"row\">{}</th>", sensor)));
    CHECK(places.back() != std::string::npos);
  }
  CHECK(std::ranges::is_sorted(places));
  CHECK(count(report.html, "<th scope=\"row\">S-good</th>") == 1);
  CHECK_THAT(report.html, Catch::Contains("S-good, run 4; S-bare, run 8") && Catch::Contains("4 of 5 sensors, 80.0 %"));
  named[0].judgement.not_judged = "no independent data";
  CHECK_THAT(render_batch(named).html, Catch::Contains("1 not judged"));
  named[5].judgement.stored_worse = {named[0].verdicts[0]};
  CHECK_THAT(render_batch(named).html, Catch::Contains("stored; now pass"));
}
