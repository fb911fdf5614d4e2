// What a judgement's notes say of the runs that it rests on: each source of uncertainty by a run that shows it, by one
// that just does not, and by a study's budget. On runs of one taxel that are stored by hand.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/reporting/conditions.h"
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
  std::int64_t add_calibrated(const std::string& calibrated, const std::string& due) {
    FilmRun made;
    made.calibration = fmt::format(R"({{"calibrated":"{}","due":"{}"}})", calibrated, due);
    return add(made);
  }
  analysis::JudgementNotes notes(const std::vector<std::int64_t>& judged,
                                 const analysis::UncertaintyInputs* inputs = nullptr,
                                 const std::string& verdict = "pass") {
    analysis::Runs runs(store);
    std::vector<db::VerdictRecord> verdicts;
    for (const std::int64_t run : judged) {
      verdicts.emplace_back().run = run;
      verdicts.back().verdict = verdict;
    }
    analysis::JudgementNotes notes = before;
    bench::note_conditions(runs, models, verdicts, inputs, {}, notes);
    return notes;
  }
  std::string missing(const std::vector<std::int64_t>& judged, const analysis::UncertaintyInputs* inputs = nullptr) {
    std::string sources;
    for (const auto& source : notes(judged, inputs).not_assessed) sources += source.source + "; ";
    return sources;
  }
  analysis::JudgementNotes before = {};
  analysis::SensorModel models = film_line_model();  // of run 1
};

}  // namespace

TEST_CASE("noted conditions: a judged run that is like that of the models leaves five sources open") {
  NotedRuns made;
  (void)made.add();
  const std::int64_t same = made.add();
  const analysis::JudgementNotes notes = made.notes({same, same});
  REQUIRE(notes.trajectories.size() == 1);
  CHECK(notes.trajectories[0].run == same);
  CHECK(notes.trajectories[0].trajectory == analysis::Trajectory::kAsFitted);
  CHECK(notes.untraced.empty());
  CHECK(made.missing({same}) == kAllOpen);
}

TEST_CASE("noted conditions: each source by a judged run that shows it, whichever of them") {
  NotedRuns made;
  (void)made.add();
  const std::int64_t same = made.add(), mounted = made.add_set({{"simulation.mount_seed", "1"}});
  for (const auto& judged : {std::vector{mounted}, std::vector{mounted, same}, std::vector{same, mounted}})
    CHECK(made.missing(judged) == "history; temperature; time; creep; ");
  const std::string later = "history; re-mounting; temperature; creep; ";
  CHECK(made.missing({made.add_set({{"simulation.age_months", "1"}})}) == later);
  CHECK(made.missing({made.add_set({{"simulation.temperature_c", "40"}})}) == "history; re-mounting; time; creep; ");
  FilmRun other_way;
  other_way.levels = {0.0, 60.0, 30.0, 60.0, 0.0};
  CHECK(made.missing({made.add(other_way)}) == "re-mounting; temperature; time; creep; ");
  // A day, and a second more, in either direction.
  CHECK(made.missing({made.add_at("2026-03-02T00:00:00Z")}) == kAllOpen);
  CHECK(made.missing({made.add_at("2026-03-02T00:00:01Z")}) == later);
  CHECK(made.missing({made.add_at("2026-02-27T23:59:59Z")}) == later);
  made.models.dynamics.emplace();
  made.models.dynamics->creep.run = 9;  // lag and creep from holds
  CHECK(made.missing({same}) == "history; re-mounting; temperature; time; ");
}

TEST_CASE("noted conditions: hardware, and a bench that cannot be read or is not simulated, tell of no mount and age") {
  NotedRuns made;
  FilmRun hardware;
  hardware.origin = "hardware";
  hardware.bench_too = true;
  (void)made.add(hardware);
  CHECK(made.missing({made.add_set({{"simulation.mount_seed", "1"}, {"simulation.age_months", "1"}})}) == kAllOpen);
  hardware.set = {{"simulation.mount_seed", "1"}, {"simulation.age_months", "1"}};
  CHECK(made.missing({made.add(hardware)}) == kAllOpen);
  hardware.started_utc = "2026-03-02T00:00:01Z";
  CHECK(made.missing({made.add(hardware)}) == "history; re-mounting; temperature; creep; ");
  for (const std::string& bench : {std::string("no bench"), bench_text("hardware")}) {
    FilmRun unread;
    unread.bench_toml = bench;
    for (const auto& [models, judged] : {std::pair(FilmRun(), unread), std::pair(unread, FilmRun())}) {
      NotedRuns both;
      (void)both.add(models);
      CHECK(both.missing({both.add(judged)}) == kAllOpen);
    }
  }
}

TEST_CASE("noted conditions: what a study's budget holds is assessed, whatever the runs") {
  NotedRuns made;
  (void)made.add();
  const std::int64_t same = made.add();
  analysis::UncertaintyInputs inputs;
  CHECK(made.missing({same}, &inputs) == kAllOpen);
  inputs.temperature.not_assessed.clear();
  CHECK(made.missing({same}, &inputs) == "history; re-mounting; time; creep; ");
  inputs.creep.not_assessed.clear();
  CHECK(made.missing({same}, &inputs) == "history; re-mounting; time; ");
  inputs.mounting.emplace();
  CHECK(made.missing({same}, &inputs) == "history; time; ");
}

TEST_CASE("noted conditions: an undated reference, and one that was overdue, are named") {
  NotedRuns made;
  (void)made.add();
  const std::int64_t undated = made.add_calibrated("", ""), good = made.add_calibrated("", "2027-01-01");
  for (const auto& judged : {std::vector{undated}, std::vector{undated, good}}) {
    const auto open = made.notes(judged).not_assessed;
    REQUIRE(open.size() == 6);
    CHECK_THAT(open.back().source, Catch::Contains("reference"));
  }
  CHECK(made.missing({good}) == kAllOpen);
  CHECK(made.missing({made.add_calibrated("2026-01-01", "")}) == kAllOpen);
  CHECK(made.notes({good}).untraced.empty());
  const std::int64_t first = made.add_calibrated("2019-01-31", "2020-01-31"),
                     second = made.add_calibrated("2019-01-31", "2021-01-31");
  CHECK_THAT(made.notes({first, second}).untraced, Catch::EndsWith("2020-01-31"));
  CHECK_THAT(made.notes({good, second}).untraced, Catch::EndsWith("2021-01-31"));
}

TEST_CASE(
    "noted conditions: dwell as it was set, the mean of the repeats', and of a changed recipe as the frames say") {
  NotedRuns made;
  (void)made.add();
  const auto dwells = [&](std::int64_t run) {
    const analysis::JudgedTrajectory judged = made.notes({run}).trajectories.at(0);
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

TEST_CASE("noted conditions: a statement is a pass or a fail, others have no notes, and old notes are taken away") {
  NotedRuns made;
  (void)made.add();
  const std::int64_t same = made.add();
  made.before.untraced = "of before";
  made.before.not_assessed.push_back({"of before", ""});
  made.before.trajectories.resize(3);
  for (const char* stated : {"pass", "conditional pass", "conditional fail", "fail"}) {
    const analysis::JudgementNotes notes = made.notes({same}, nullptr, stated);
    CHECK((notes.trajectories.size() == 1 && notes.not_assessed.size() == 5 && notes.untraced.empty()));
  }
  const auto nothing = [](const analysis::JudgementNotes& notes) {
    return notes.trajectories.empty() && notes.not_assessed.empty() && notes.untraced.empty();
  };
  CHECK(nothing(made.notes({same}, nullptr, "report only")));
  CHECK(nothing(made.notes({})));
  made.before.not_judged = "no limits";
  CHECK(nothing(made.notes({same})));
}
