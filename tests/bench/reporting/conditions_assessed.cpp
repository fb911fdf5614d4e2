// What a judgement's notes leave open: sources that a study's budget holds, runs on hardware whose files tell nothing
// of a simulated sensor, and repeats of a recipe as they were set.

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/reporting/conditions.h"
#include "tests/bench/config/bench_text.h"
#include "tests/bench/reporting/judged_store.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

class AssessedStore : public FilmStore {
 public:
  analysis::JudgementNotes notes(const std::vector<std::int64_t>& judged,
                                 const analysis::UncertaintyInputs* inputs = nullptr,
                                 const std::string& verdict = "pass") {
    analysis::Runs runs(store);
    std::vector<db::VerdictRecord> verdicts;
    for (const std::int64_t run : judged) {
      verdicts.emplace_back().run = run;
      verdicts.back().verdict = verdict;
    }
    analysis::JudgementNotes notes;
    bench::note_conditions(runs, film_line_model(), verdicts, inputs, {}, notes);
    return notes;
  }
  std::string open_sources(const std::vector<std::int64_t>& judged,
                           const analysis::UncertaintyInputs* inputs = nullptr) {
    std::string words;
    for (const auto& source : notes(judged, inputs).not_assessed) words += source.source + "; ";
    return words;
  }
};

}  // namespace

TEST_CASE("conditions assessed: creep and temperature by a study's budget, whatever the runs") {
  AssessedStore made;
  (void)made.add({});
  (void)made.add({});
  analysis::UncertaintyInputs inputs;
  CHECK(made.open_sources({2}, &inputs) == "history; re-mounting; temperature; time; creep; ");
  inputs.temperature.not_assessed.clear();
  CHECK(made.open_sources({2}, &inputs) == "history; re-mounting; time; creep; ");
  inputs.creep.not_assessed.clear();
  CHECK(made.open_sources({2}, &inputs) == "history; re-mounting; time; ");
  inputs.mounting.emplace();
  CHECK(made.open_sources({2}, &inputs) == "history; time; ");
}

TEST_CASE("conditions assessed: on hardware a simulated sensor's mount and age say nothing, a day apart does") {
  AssessedStore made;
  FilmRun hardware;
  hardware.origin = "hardware";
  hardware.bench_too = true;
  (void)made.add(hardware);
  hardware.set = {{"simulation.mount_seed", "1"}, {"simulation.age_months", "1"}};
  (void)made.add(hardware);
  const std::string all = "history; re-mounting; temperature; time; creep; ";
  CHECK(made.open_sources({2}) == all);
  hardware.started_utc = "2026-03-02T00:00:01Z";
  (void)made.add(hardware);
  CHECK(made.open_sources({3}) == "history; re-mounting; temperature; creep; ");
}

TEST_CASE("conditions assessed: a statement is a pass or a fail, and rows that state nothing have no notes") {
  AssessedStore made;
  (void)made.add({});
  (void)made.add({});
  for (const char* stated : {"pass", "conditional pass", "conditional fail", "fail"})
    CHECK(made.notes({2}, nullptr, stated).not_assessed.size() == 5);
  CHECK(made.notes({2}, nullptr, "report only").not_assessed.empty());
  CHECK(made.notes({2, 2}).trajectories.size() == 1);
}

TEST_CASE("conditions assessed: dwell as it was set, over all sequences, and of a changed recipe as the frames say") {
  AssessedStore made;
  (void)made.add({});
  FilmRun set;
  set.sequences = {"a"};
  set.set = {{"recipe.dwell_s", "[1, 4]"}};
  (void)made.add(set);
  const analysis::JudgedTrajectory mean = made.notes({2}).trajectories.at(0);
  CHECK(mean.dwell_s == 2.5);
  CHECK(mean.fitted_dwell_s == 2.0);
  FilmRun unread;
  unread.recipe = "none";
  unread.dwells_s = {3.0, 3.0};
  (void)made.add(unread);
  const analysis::JudgedTrajectory frames = made.notes({3}).trajectories.at(0);
  CHECK(frames.dwell_s == 3.0);
  CHECK(frames.fitted_dwell_s == 2.0);
}

TEST_CASE(
    "conditions assessed: a bench file that can no longer be read, or is not simulated, tells of no mount and age") {
  const std::string all = "history; re-mounting; temperature; time; creep; ";
  for (const std::string& bench : {std::string("no bench"), bench_text("hardware")}) {
    AssessedStore made;
    FilmRun unread;
    unread.bench_toml = bench;
    (void)made.add({});
    (void)made.add(unread);
    CHECK(made.open_sources({2}) == all);
    AssessedStore other;
    (void)other.add(unread);
    (void)other.add({});
    CHECK(other.open_sources({2}) == all);
  }
}
