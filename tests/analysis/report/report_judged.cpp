// A report that was judged on several runs: overall verdict, number, signature.
#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/analysis/report/report_example.h"
#include "tests/analysis/report/report_page.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

// Verdicts on the held-out runs, in the order given; run 15 fails one criterion.
ReportInput judged_on(const std::vector<std::int64_t>& runs) {
  ReportInput input = example::example_input();
  std::vector<JudgedFigure> figures;
  for (const std::int64_t run : runs) {
    for (JudgedFigure figure : input.judgement.figures) {
      figure.run = run;
      figure.model_run = 12;
      figure.verdict = run == 15 && figure.criterion == Criterion::kWorstTaxelError ? Verdict::kFail : Verdict::kPass;
      figures.push_back(figure);
    }
  }
  input.judgement = by_hand::judgement_of(std::move(figures));
  return input;
}

}  // namespace

TEST_CASE("the overall verdict is the worst of all runs judged, in any order") {
  std::vector<std::int64_t> runs = {13, 14, 15};
  do {
    const auto results = report_json(judged_on(runs))["results"];
    CHECK(results["judgement"]["overall"] == "fail");
    REQUIRE(results["judgement"]["runs"].size() == 3);
    for (std::size_t i = 0; i < 3; ++i)
      CHECK(results["judgement"]["runs"][i]["verdict"] == (runs[i] == 15 ? "fail" : "pass"));
    CHECK(results["verdicts"][0]["on"] == results["judgement"]["runs"][0]["on"]);
  } while (std::ranges::next_permutation(runs).found);
  require_well_formed(render_report(judged_on(runs)).html);
}

TEST_CASE("what was not judged, worse stored verdicts and a void run are part of the report") {
  ReportInput input = judged_on({13});
  JudgedFigure worse = judged_on({15}).judgement.figures[1];
  worse.verdict = Verdict::kConditionalFail;
  input.judgement.stored_worse = {worse};
  input.judgement.remarks = {{Remark::Kind::kVoidLeftOut, {14, "me", "2024", "a leak"}, 14}};
  const auto judgement = [&] { return report_json(input)["results"]["judgement"]; };
  CHECK(judgement()["overall"] == "pass");
  CHECK(judgement()["stored_worse"][0]["verdict"] == "conditional fail");
  CHECK(judgement()["remarks"].size() == 1);
  CHECK(count(render_report(input).html, "a leak") == 2);  // on the page and in its data
  input.run.void_utc = "2024-06-01T00:00:00Z";
  input.run.void_by = "me";
  CHECK(contains(render_report(input).html, "<p class=\"void\">"));
  input.judgement.not_judged = {Remark::Kind::kModelsVoid, {12, "me", "2024", "no seal"}};
  conclude(input.judgement);
  CHECK(judgement()["overall"] == "inconclusive");
  CHECK(count(render_report(input).html, "no seal") > 1);
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
