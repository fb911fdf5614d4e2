// What a report's number is formed from: the runs of its verdicts by their place, and none of their numbers.
#include <catch2/catch.hpp>

#include "tests/analysis/report/report_example_full.h"

using namespace tactbench;
using namespace tactbench::analysis;

namespace {

std::string content_of_report(const ReportInput& input) { return render_report(input).content_sha256; }

}  // namespace

TEST_CASE("a report's content tells on which of its runs a verdict is: the own one, each held out, one of no part") {
  ReportInput input = example::example_input();
  REQUIRE(input.held_out.size() == 3);
  std::vector<std::string> contents;
  std::vector<std::int64_t> runs{input.run.run, 1, 2, 3};
  for (const HeldOut& held_out : input.held_out) runs.push_back(held_out.evaluation.run);
  for (const std::int64_t run : runs) {
    for (JudgedFigure& figure : input.judgement.figures) figure.run = run;
    conclude(input.judgement);
    contents.push_back(content_of_report(input));
  }
  for (std::size_t a = 0; a < contents.size(); ++a)
    for (std::size_t b = 0; b < a; ++b) {
      CAPTURE(runs[a], runs[b]);
      CHECK(contents[a] != contents[b]);
    }
}

TEST_CASE("a report's content is the same whatever numbers its runs have, in verdicts, stored ones and uncertainties") {
  const auto numbered = [](std::int64_t first) {
    ReportInput input = example::full_input();
    input.run.run = first;
    input.evaluation.run = first;
    JudgedFigure figure = input.judgement.figures.front();
    Judgement& judgement = input.judgement = {};
    for (std::size_t i = 0; i < 4; ++i) {
      const std::int64_t run = first + static_cast<std::int64_t>(i);
      if (i > 0) input.held_out[i - 1].run.run = input.held_out[i - 1].evaluation.run = run;
      figure.run = run;
      figure.model_run = first;
      figure.u.expanded = 0.1 * static_cast<double>(i + 1);
      judgement.figures.push_back(figure);
      judgement.stored_worse.push_back(figure);
      judgement.remarks.push_back({Remark::Kind::kUntraced, {}, run, 0, Untraced{.overdue_since = "2024-01-31"}});
    }
    conclude(judgement);
    input.more.studies.crosstalk.run = first + 30;
    input.more.contacts.front().run = first + 31;
    input.more.contacts.front().mount_run = first + 32;
    input.more.studies.rate_hold.runs.front().run = first + 33;
    input.more.studies.uniformity.runs = {first, first + 34};
    input.more.studies.remount.runs = {first, first + 35};
    input.history.earlier_seating_run = first + 36;
    input.more.previous->model = std::to_string(first);
    return input;
  };
  const std::string content = content_of_report(numbered(12));
  CHECK(content_of_report(numbered(70)) == content);
  ReportInput other = numbered(12);
  std::swap(other.judgement.figures[1].u, other.judgement.figures[2].u);
  CHECK(content_of_report(other) != content);
  other = numbered(12);
  other.judgement.stored_worse.pop_back();
  CHECK(content_of_report(other) != content);
}
