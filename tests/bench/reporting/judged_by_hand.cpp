// Which runs are gathered as evidence and what is measured on them, on evaluations and models that are known by hand.

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "tests/bench/reporting/judged_store.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Of each run: "own", "void", "asked" or "yes", and whether its figures were gathered.
std::string counted_runs(const analysis::Evidence& evidence) {
  std::string text;
  for (const analysis::EvidenceRun& run : evidence.runs) {
    const char* const words[] = {"yes", "asked", "void", "own"};
    text += fmt::format("{} {}{}; ", run.run, words[static_cast<int>(run.counts)], run.figures.empty() ? "" : " +");
  }
  return text;
}

}  // namespace

TEST_CASE(
    "evidence: each run but the models' own counts, the own figures are gathered only where there are no others") {
  const JudgedStore made(3);
  const auto own = film_evaluation(1, 0.25), second = film_evaluation(2, 0.5), third = film_evaluation(3, 2.0);
  CHECK(made.evidence({}).runs.empty());
  const analysis::Evidence both = made.evidence({own, third, second});
  CHECK(counted_runs(both) == "1 own; 3 yes +; 2 yes +; ");
  CHECK((both.model_run == 1 && both.models_void.empty()));
  CHECK(both.runs[1].figures[0].value == 2.0);
  CHECK(both.runs[1].figures[1].value == 3.0);
  CHECK(counted_runs(made.evidence({own})) == "1 own +; ");
  analysis::SensorModel with_creep = film_line_model();
  with_creep.dynamics.emplace();
  with_creep.dynamics->creep.run = 2;
  CHECK(counted_runs(made.evidence({own, third, second}, false, {}, with_creep)) == "1 own; 3 yes +; 2 own; ");
}

TEST_CASE("evidence: without a certificate U of an error is not known, that of a difference is") {
  const JudgedStore made(2);
  const std::vector<analysis::Figure> figures = made.evidence({film_evaluation(2, 0.5)}).runs[0].figures;
  REQUIRE(figures.size() > 4);
  CHECK(std::isnan(figures[0].u.expanded));
  CHECK_FALSE(figures[0].u.missing.empty());
  CHECK(std::isfinite(figures[2].u.expanded));
  CHECK(figures[3].u.expanded == 0.0);
}

TEST_CASE("evidence: a void run is known with its reason, and gathered on request") {
  JudgedStore made(3);
  made.declare_void(3);
  const std::vector<bench::NamedEvaluation> all = {film_evaluation(1, 0.25), film_evaluation(3, 2.0),
                                                   film_evaluation(2, 0.5)};
  const analysis::Evidence without = made.evidence(all);
  CHECK(counted_runs(without) == "1 own; 3 void; 2 yes +; ");
  CHECK(without.runs[1].voided.reason == "gauge closed");
  CHECK(counted_runs(made.evidence(all, true)) == "1 own; 3 asked +; 2 yes +; ");
  made.declare_void(1);
  const analysis::Evidence by_void = made.evidence(all);
  REQUIRE(by_void.models_void.size() == 1);
  CHECK(counted_runs(by_void) == "1 own +; 3 void; 2 yes; ");
  CHECK(counted_runs(made.evidence(all, true)) == "1 own; 3 asked +; 2 yes +; ");
}

TEST_CASE("evidence: the reference is that of the run's day, with what a laboratory's file says of it") {
  JudgedStore made(1);
  FilmRun dated;
  dated.calibration = R"({"calibrated":"2019-01-01","due":"2020-01-01"})";
  REQUIRE(made.add(dated) == 2);
  REQUIRE(made.add() == 3);
  FilmRun undated;
  undated.calibration = R"({"calibrated":"","due":""})";
  REQUIRE(made.add(undated) == 4);
  const auto of = [&](std::int64_t run, const std::vector<analysis::InstrumentNote>& notes = {}) {
    return made.evidence({film_evaluation(run, 0.5)}, false, notes).runs[0];
  };
  CHECK(of(2).reference.overdue);
  CHECK_FALSE(of(3).reference.overdue);
  CHECK(of(3, {{"R-1", "", "", "", "2026-02-01", ""}}).reference.untraced()->overdue_since == "2026-02-01");
  CHECK(of(2).shows.contains(analysis::Source::kReferenceAge));
  CHECK_FALSE(of(4).shows.contains(analysis::Source::kReferenceAge));
  CHECK(of(4, {{"R-1", "", "", "", "2027-02-01", ""}}).shows.contains(analysis::Source::kReferenceAge));
}
