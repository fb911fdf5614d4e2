// What a judgement's notes say of the runs that it rests on: each source of uncertainty by a run that shows it, and by
// one that just does not. The runs are stored by hand, 0-20-0 psi on one taxel.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "analysis/report/runs.h"
#include "bench/config/config.h"
#include "bench/reporting/conditions.h"
#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench;

namespace {

struct StoredByHand {
  std::string started_utc = "2026-03-01T00:00:00Z";
  std::vector<double> levels = {0.0, 10.0, 20.0, 10.0, 0.0};
  std::string recipe =
      "schema = 1\nname = \"a\"\nunit = \"psi\"\nturning_points = [0, 20, 0]\nstep = 10\ndwell_s = 2\n";
  std::vector<std::pair<std::string, std::string>> set = {};  // of the simulated bench
  std::string calibration = R"({"calibrated":"2026-01-01","due":"2027-01-01"})";
  bool simulated = true;
};

class NotedRuns {
 public:
  std::int64_t add(const StoredByHand& made) {
    db::RunRecord run;
    run.uuid = db::new_uuid();
    run.origin = made.simulated ? "simulated" : "hardware";
    run.state = "prepared";
    run.sensor_serial = "S-1";
    run.started_utc = made.started_utc;
    if (made.simulated) run.bench_toml = tests::read_file(bench::find_config("simulated.toml"));
    std::string set;
    for (const auto& [key, value] : made.set)
      set += fmt::format(R"({}{{"key":"{}","value":"{}"}})", set.empty() ? "" : ",", key, value);
    run.overrides_json = "[" + set + "]";
    const auto count = static_cast<int>(made.levels.size());
    run.sequences = {{0, "a", made.recipe, "", 1, count}};
    run.devices = {{"tactile scanner", "synthetic", "SC-1", "", run.origin, R"({"volts_per_count":0.0001})"},
                   {"pressure reference", "synthetic", "R-1", "", run.origin, made.calibration}};
    const std::int64_t number = store_.begin_run(run);
    const std::int64_t branch = store_.begin_branch(number, {});
    for (int i = 0; i < count; ++i) {
      db::FrameRecord frame;
      frame.branch = branch;
      frame.ordinal = i;
      frame.rows = frame.columns = frame.scans = 1;
      frame.setpoint_psi = frame.feedback_psi = frame.reference_psi = made.levels[static_cast<std::size_t>(i)];
      frame.time_ns = 2'000'000'000LL * (i + 1);
      frame.since_command_ns = 2'000'000'000LL;
      frame.counts = {static_cast<std::uint16_t>(100 + 100 * i)};
      store_.append_frame(number, frame);
    }
    store_.end_run(number, db::Outcome::kCompleted, "", db::SafeState::kVerified, made.started_utc);
    return number;
  }

  analysis::JudgementNotes notes(const std::vector<std::int64_t>& judged,
                                 const analysis::UncertaintyInputs* inputs = nullptr, bool of_holds = false) {
    analysis::Runs runs(store_);
    analysis::SensorModel fit;
    fit.run = 1;
    fit.taxels.resize(1);
    if (of_holds) {
      fit.dynamics.emplace();
      fit.dynamics->creep.run = 9;
    }
    std::vector<db::VerdictRecord> verdicts;
    for (const std::int64_t run : judged) {
      db::VerdictRecord verdict;
      verdict.run = run;
      verdict.verdict = std::string("pass");
      verdicts.push_back(verdict);
    }
    analysis::JudgementNotes notes = before_;
    bench::note_conditions(runs, fit, verdicts, inputs, instruments_, notes);
    return notes;
  }
  [[nodiscard]] std::string missing(const std::vector<std::int64_t>& judged,
                                    const analysis::UncertaintyInputs* inputs = nullptr, bool of_holds = false) {
    std::string words;
    for (const auto& source : notes(judged, inputs, of_holds).not_assessed) words += source.source + "; ";
    return words;
  }
  analysis::JudgementNotes before_ = {};
  std::vector<analysis::InstrumentNote> instruments_ = {};

 private:
  tests::TemporaryFolder folder_;
  db::RunStore store_ = [this] {
    db::RunStore store = db::RunStore::open(folder_.path("noted.db"), db::Durability::kNormal);
    store.add_sensor({"S-1", "synthetic", "", db::sha256_hex(""), "SC-1", "", ""});
    return store;
  }();
};

StoredByHand set_by(std::vector<std::pair<std::string, std::string>> set) {
  StoredByHand made;
  made.set = std::move(set);
  return made;
}

}  // namespace

TEST_CASE("noted conditions: a judged run that is like that of the models leaves five sources open") {
  NotedRuns runs;
  runs.add({});
  const std::int64_t same = runs.add({});
  const analysis::JudgementNotes notes = runs.notes({same});
  REQUIRE(notes.trajectories.size() == 1);
  CHECK(notes.trajectories[0].run == same);
  CHECK(notes.trajectories[0].trajectory == analysis::Trajectory::kAsFitted);
  CHECK(notes.trajectories[0].dwell_s == 2.0);
  CHECK(notes.trajectories[0].fitted_dwell_s == 2.0);
  CHECK(notes.overdue.empty());
  std::vector<std::string> said;
  for (const auto& source : notes.not_assessed) said.push_back(source.source + ": " + source.why);
  CHECK(said == std::vector<std::string>{
                    "history: every judged run repeats the fitted set-points: nothing is known of other inner branches",
                    "re-mounting: no judged run and no study is of the sensor mounted anew",
                    "temperature: no judged run and no study is at another temperature",
                    "time: no judged run is a day or more apart from that of the models",
                    "creep: no study holds the load for longer than the runs do"});
}

TEST_CASE("noted conditions: each source by a judged run that shows it, whichever of them") {
  NotedRuns runs;
  runs.add({});
  const std::int64_t same = runs.add({});
  const std::string all = "history; re-mounting; temperature; time; creep; ";
  CHECK(runs.missing({same}) == all);
  const std::int64_t mounted = runs.add(set_by({{"simulation.mount_seed", "1"}}));
  CHECK(runs.missing({mounted}) == "history; temperature; time; creep; ");
  CHECK(runs.missing({mounted, same}) == "history; temperature; time; creep; ");
  CHECK(runs.missing({same, mounted}) == "history; temperature; time; creep; ");
  CHECK(runs.missing({runs.add(set_by({{"simulation.age_months", "1"}}))}) ==
        "history; re-mounting; temperature; creep; ");
  CHECK(runs.missing({runs.add(set_by({{"simulation.temperature_c", "40"}}))}) ==
        "history; re-mounting; time; creep; ");
  StoredByHand other_way;
  other_way.levels = {0.0, 20.0, 10.0, 20.0, 0.0};
  CHECK(runs.missing({runs.add(other_way)}) == "re-mounting; temperature; time; creep; ");
  // A day, and a second more, in either direction.
  StoredByHand day, more, before;
  day.started_utc = "2026-03-02T00:00:00Z";
  more.started_utc = "2026-03-02T00:00:01Z";
  before.started_utc = "2026-02-27T23:59:59Z";
  CHECK(runs.missing({runs.add(day)}) == all);
  CHECK(runs.missing({runs.add(more)}) == "history; re-mounting; temperature; creep; ");
  CHECK(runs.missing({runs.add(before)}) == "history; re-mounting; temperature; creep; ");
  CHECK(runs.missing({same}, nullptr, true) ==
        "history; re-mounting; temperature; time; ");  // lag and creep from holds
}

TEST_CASE("noted conditions: hardware says nothing of mounts and age, and a bench that is not simulated neither") {
  NotedRuns runs;
  StoredByHand own;
  own.simulated = false;
  runs.add(own);
  CHECK(runs.missing({runs.add(set_by({{"simulation.mount_seed", "1"}, {"simulation.age_months", "1"}}))}) ==
        "history; re-mounting; temperature; time; creep; ");
}

TEST_CASE("noted conditions: what a study's budget holds is assessed") {
  NotedRuns runs;
  runs.add({});
  const std::int64_t same = runs.add({});
  analysis::UncertaintyInputs inputs;
  CHECK(runs.missing({same}, &inputs) == "history; re-mounting; temperature; time; creep; ");
  inputs.mounting.emplace();
  CHECK(runs.missing({same}, &inputs) == "history; temperature; time; creep; ");
}

TEST_CASE("noted conditions: an undated reference, and one that was overdue, are named") {
  NotedRuns runs;
  runs.add({});
  StoredByHand undated, due_only, dated_only, overdue, later_overdue;
  undated.calibration = R"({"calibrated":"","due":""})";
  due_only.calibration = R"({"calibrated":"","due":"2027-01-01"})";
  dated_only.calibration = R"({"calibrated":"2026-01-01","due":""})";
  overdue.calibration = R"({"calibrated":"2019-01-31","due":"2020-01-31"})";
  later_overdue.calibration = R"({"calibrated":"2019-01-31","due":"2021-01-31"})";
  const std::string all = "history; re-mounting; temperature; time; creep; ";
  const std::int64_t without = runs.add(undated), good = runs.add(due_only);
  CHECK(runs.missing({without}) == all + "age of the reference's calibration; ");
  CHECK(runs.missing({without, good}) == all + "age of the reference's calibration; ");
  CHECK(runs.notes({without}).not_assessed.back().why ==
        "neither its date nor its due date is stated: its drift cannot be scaled with time");
  CHECK(runs.missing({good}) == all);
  CHECK(runs.missing({runs.add(dated_only)}) == all);
  CHECK(runs.notes({good}).overdue.empty());
  const std::int64_t first = runs.add(overdue), second = runs.add(later_overdue);
  CHECK(runs.notes({first, second}).overdue == "reference overdue since 2020-01-31");
  CHECK(runs.notes({good, second}).overdue == "reference overdue since 2021-01-31");
}

TEST_CASE("noted conditions: another dwell of the judged run's recipe, as it was carried out") {
  NotedRuns runs;
  runs.add({});
  const auto dwells = [&](const StoredByHand& made) {
    const analysis::JudgedTrajectory judged = runs.notes({runs.add(made)}).trajectories.at(0);
    return fmt::format("{} {} {}", judged.dwell_s, judged.fitted_dwell_s, judged.other_dwell);
  };
  CHECK(dwells({}) == "2 2 false");
  CHECK(dwells(set_by({{"recipe.dwell_s", "5"}})) == "5 2 true");
  StoredByHand two;
  two.recipe =
      "schema = 1\nname = \"a\"\nunit = \"psi\"\nturning_points = [0, 20, 0]\nstep = 10\nrepeats = 2\ndwell_s = [1, "
      "4]\n";
  CHECK(dwells(two) == "2.5 2 true");  // the mean of the repeats'
  StoredByHand unreadable;
  unreadable.recipe = "no recipe";
  CHECK(dwells(unreadable) == "2 2 false");  // as the frames say
}

TEST_CASE("noted conditions: rows that are no statement have none, and old notes are taken away") {
  NotedRuns runs;
  runs.add({});
  const std::int64_t same = runs.add({});
  runs.before_.overdue = "of before";
  runs.before_.not_assessed.push_back({"of before", ""});
  runs.before_.trajectories.resize(3);
  CHECK(runs.notes({same}).trajectories.size() == 1);
  CHECK(runs.notes({same}).overdue.empty());
  CHECK(runs.notes({same}).not_assessed.size() == 5);
  const auto nothing = [](const analysis::JudgementNotes& notes) {
    return notes.trajectories.empty() && notes.not_assessed.empty() && notes.overdue.empty();
  };
  CHECK(nothing(runs.notes({})));
  runs.before_.not_judged = "no limits";
  CHECK(nothing(runs.notes({same})));
}
