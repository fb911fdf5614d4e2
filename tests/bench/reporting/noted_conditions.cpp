// What evidence shows of conditions in use: each source of uncertainty by a run that shows it and by one that just does
// not. On runs of one taxel that are stored by hand.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "tests/bench/config/bench_text.h"
#include "tests/bench/reporting/judged_store.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

const std::string kAllOpen = "history; re-mounting; temperature; time; creep; ";

class NotedRuns : public FilmStore {
 public:
  std::int64_t add_set(std::vector<std::pair<std::string, std::string>> set) {
    FilmRun made;
    made.set = std::move(set);
    return add(made);
  }
  std::int64_t add_at(const std::string& started_utc) {
    FilmRun made;
    made.started_utc = started_utc;
    return add(made);
  }
  analysis::EvidenceRun evidence(std::int64_t run) {
    analysis::Runs runs(store);
    return bench::gather_evidence(runs, models, {film_evaluation(run, 0.5)}, film_limits(1.0), false).runs.front();
  }
  // Not shown by the run, nor known of the models; without the age of the reference's calibration.
  std::string missing(std::int64_t run) {
    analysis::Runs runs(store);
    const analysis::Evidence evidence =
        bench::gather_evidence(runs, models, {film_evaluation(run, 0.5)}, film_limits(1.0), false);
    std::string sources;
    for (const analysis::Source source : analysis::kSources)
      if (source != analysis::Source::kReferenceAge && !evidence.studied.contains(source) &&
          !evidence.runs.front().shows.contains(source))
        sources += std::string(to_string(source)) + "; ";
    return sources;
  }
  analysis::SensorModel models = film_line_model();  // of run 1
};

}  // namespace

TEST_CASE("noted conditions: a judged run that is like that of the models leaves five sources open") {
  NotedRuns made;
  (void)made.add();
  const std::int64_t same = made.add();
  CHECK(made.evidence(same).trajectory.trajectory == analysis::Trajectory::kAsFitted);
  CHECK(made.missing(same) == kAllOpen);
}

TEST_CASE("noted conditions: each source by a judged run that shows it") {
  NotedRuns made;
  (void)made.add();
  const std::int64_t same = made.add(), mounted = made.add_set({{"simulation.mount_seed", "1"}});
  CHECK(made.missing(mounted) == "history; temperature; time; creep; ");
  const std::string later = "history; re-mounting; temperature; creep; ";
  CHECK(made.missing(made.add_set({{"simulation.age_months", "1"}})) == later);
  CHECK(made.missing(made.add_set({{"simulation.temperature_c", "40"}})) == "history; re-mounting; time; creep; ");
  FilmRun other_way;
  other_way.levels = {0.0, 60.0, 30.0, 60.0, 0.0};
  CHECK(made.missing(made.add(other_way)) == "re-mounting; temperature; time; creep; ");
  // A day, and a second more, in either direction.
  CHECK(made.missing(made.add_at("2026-03-02T00:00:00Z")) == kAllOpen);
  CHECK(made.missing(made.add_at("2026-03-02T00:00:01Z")) == later);
  CHECK(made.missing(made.add_at("2026-02-27T23:59:59Z")) == later);
  made.models.dynamics.emplace();
  made.models.dynamics->creep.run = 9;  // lag and creep from holds
  CHECK(made.missing(same) == "history; re-mounting; temperature; time; ");
}

TEST_CASE("noted conditions: hardware, and a bench that cannot be read or is not simulated, tell of no mount and age") {
  NotedRuns made;
  FilmRun hardware;
  hardware.origin = "hardware";
  hardware.bench_too = true;
  (void)made.add(hardware);
  made.models.origin = "hardware";
  hardware.set = {{"simulation.mount_seed", "1"}, {"simulation.age_months", "1"}};
  CHECK(made.missing(made.add(hardware)) == kAllOpen);
  hardware.started_utc = "2026-03-02T00:00:01Z";
  CHECK(made.missing(made.add(hardware)) == "history; re-mounting; temperature; creep; ");
  for (const std::string& bench : {std::string("no bench"), bench_text("hardware")}) {
    FilmRun unread;
    unread.bench_toml = bench;
    for (const auto& [models, judged] : {std::pair(FilmRun(), unread), std::pair(unread, FilmRun())}) {
      NotedRuns both;
      (void)both.add(models);
      CHECK(both.missing(both.add(judged)) == kAllOpen);
    }
  }
}

TEST_CASE(
    "noted conditions: dwell as it was set, the mean of the repeats', and of a changed recipe as the frames say") {
  NotedRuns made;
  (void)made.add();
  const auto dwells = [&](std::int64_t run) {
    const analysis::JudgedTrajectory judged = made.evidence(run).trajectory;
    return fmt::format("{} {} {}", judged.dwell_s, judged.fitted_dwell_s, judged.other_dwell);
  };
  CHECK(dwells(made.add()) == "2 2 false");
  CHECK(dwells(made.add_set({{"recipe.dwell_s", "5"}})) == "5 2 true");
  CHECK(dwells(made.add_set({{"recipe.dwell_s", "[1, 4]"}})) == "2.5 2 true");
  FilmRun unread;
  unread.recipe = "none";
  unread.dwells_s = {3.0, 3.0};
  CHECK(dwells(made.add(unread)) == "3 2 true");
}
