// Further runs in a budget: which of them has the same state, is later, re-mounted, warmer or at another
// dwell, and what a thermometer resolves. On runs that are stored by hand.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "bench/reporting/report_budget.h"
#include "tests/bench/config/bench_text.h"
#include "tests/bench/reporting/film_runs.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

FilmRun film_set(std::vector<std::pair<std::string, std::string>> set) {
  FilmRun made;
  made.set = std::move(set);
  return made;
}

FilmRun film_at(const std::string& started_utc) {
  FilmRun made;
  made.started_utc = started_utc;
  return made;
}

FilmRun film_dwell(double dwell_s) {
  FilmRun made;
  made.dwells_s = {dwell_s, dwell_s};
  return made;
}

// "later mounted unknown "; what it is, is told in words.
std::string change_of(const bench::StateChange& change) {
  CHECK(change.any() == (change.later || change.mounted || change.unknown));
  return fmt::format("{}{}{}", change.later ? "later " : "", change.mounted ? "mounted " : "",
                     change.unknown ? "unknown " : "");
}

std::string numbers_of(const std::vector<const analysis::Dataset*>& runs) {
  std::string text;
  for (const analysis::Dataset* run : runs) text += fmt::format(" {}", run->run);
  return text;
}

// Runs of a report on run 1 with its models.
class BudgetStore : public FilmStore {
 public:
  bench::StateChange change(const FilmRun& made) { return bench::state_change(store.run(1), store.run(add(made))); }
  analysis::UncertaintyInputs inputs(const std::vector<std::int64_t>& held_out,
                                     const std::vector<std::int64_t>& further = {},
                                     const std::vector<std::string>& studies = {}) {
    analysis::ReportInput input;
    input.run = store.run(1);
    input.fit = film_line_model();
    for (const std::int64_t run : held_out) input.held_out.push_back({"", store.run(run), {}});
    input.more.studies = studies_;
    input.laboratory.instruments = {{"R-1", "certificate", "", "", "", ""}};
    return bench::budget_inputs(runs_, input, further, studies);
  }
  // Each list with its runs.
  std::string history(const std::vector<std::int64_t>& held_out, const std::vector<std::int64_t>& further = {},
                      const std::vector<std::string>& studies = {}) {
    const analysis::HistoryRuns runs = inputs(held_out, further, studies).history;
    return fmt::format("same{} later{} warm{} mounted{} paced{}", numbers_of(runs.same), numbers_of(runs.later),
                       numbers_of(runs.warm), numbers_of(runs.mounted), numbers_of(runs.paced));
  }
  analysis::Studies studies_ = {};

 private:
  analysis::Runs runs_{store};
};

db::RunRecord run_of_bench(const std::string& toml) {
  db::RunRecord run;
  run.bench_toml = toml;
  run.overrides_json = "[]";
  return run;
}

}  // namespace

TEST_CASE("budget runs: runs more than a day apart, before or after, count as another day") {
  BudgetStore made;
  FilmRun hardware;
  hardware.origin = "hardware";
  (void)made.add(hardware);
  struct Row {
    const char* utc;
    const char* days;  // null: the same state
  };
  for (const Row& row :
       {Row{"2026-03-01T00:00:00Z", nullptr}, Row{"2026-03-02T00:00:00Z", nullptr},
        Row{"2026-02-28T00:00:00Z", nullptr}, Row{"2026-03-02T00:00:01Z", " 1 "}, Row{"2026-02-27T23:59:59Z", " 1 "},
        Row{"2026-03-02T12:00:01Z", " 2 "}, Row{"2026-03-11T00:00:00Z", " 10 "}}) {
    FilmRun other = film_at(row.utc);
    other.origin = "hardware";
    const bench::StateChange change = made.change(other);
    CAPTURE(row.utc, change.text);
    CHECK(change_of(change) == (row.days == nullptr ? "" : "later "));
    if (row.days != nullptr) CHECK(change.text.find(row.days) != std::string::npos);
  }
  // A hardware bench does not record mounts.
  FilmRun mounted = film_set({{"simulation.mount_seed", "1"}});
  CHECK_FALSE(made.change(mounted).any());
}

TEST_CASE("budget runs: age, specimen and mount are compared by the configuration of the simulated sensor") {
  BudgetStore made;
  (void)made.add({});
  CHECK_FALSE(made.change({}).any());
  CHECK(bench::other_state(made.store.run(1), made.store.run(1)).empty());
  const auto set = [&](const std::string& key, const std::string& value) {
    return change_of(made.change(film_set({{key, value}})));
  };
  CHECK(set("simulation.age_months", "1") == "later ");
  CHECK(set("simulation.age_months", "2.5") == "later ");
  CHECK_THAT(made.change(film_set({{"simulation.age_months", "2.5"}})).text, Catch::Contains(" 2.5 "));
  CHECK(set("simulation.mount_seed", "1") == "mounted ");
  CHECK(set("simulation.mount_turn", "\"turned-180\"") == "mounted ");
  CHECK(set("simulation.edge_outside_lines", "2") == "mounted ");
  CHECK(set("simulation.edge_outside", "\"first-row\"") == "mounted ");
  CHECK(set("simulation.specimen", "\"harsh\"") == "unknown ");
  // Several: the first in words.
  FilmRun all = film_set({{"simulation.age_months", "1"}, {"simulation.mount_seed", "1"}});
  CHECK(change_of(made.change(all)) == "later mounted ");
  all.started_utc = "2026-03-11T00:00:00Z";
  CHECK(change_of(made.change(all)) == "later mounted ");
  CHECK_THAT(made.change(all).text, Catch::Contains(" 10 "));
  db::RunRecord unread = made.store.run(1);
  for (const std::string& toml : {std::string("no bench"), bench_text("hardware")}) {
    unread.bench_toml = toml;
    CHECK(change_of(bench::state_change(unread, made.store.run(1))) == "unknown ");
    CHECK(change_of(bench::state_change(made.store.run(1), unread)) == "unknown ");
  }
}

TEST_CASE("budget runs: two kelvin count as another temperature, as measured or of the simulated sensor") {
  BudgetStore made;
  FilmRun measured;
  measured.temperatures_c = {22.0, 24.0};
  (void)made.add(measured);
  analysis::Runs runs(made.store);
  const auto differs = [&](const FilmRun& other) {
    const std::int64_t run = made.add(other);
    return bench::temperature_differs(made.store.run(1), made.store.run(run), runs.dataset(1), runs.dataset(run));
  };
  const auto read = [](double celsius) {
    FilmRun other;
    other.temperatures_c = {celsius};
    return other;
  };
  CHECK_FALSE(differs({}));
  for (const auto& [celsius, other] : {std::pair(24.5, false), {21.5, false}, {25.0, true}, {21.0, true}}) {
    CHECK(differs(read(celsius)) == other);
    CHECK(differs(film_set({{"simulation.temperature_c", fmt::format("{}", celsius)}})) == other);
  }
  db::RunRecord hardware = made.store.run(1),
                warm = made.store.run(made.add(film_set({{"simulation.temperature_c", "40"}})));
  hardware.origin = "hardware";
  CHECK_FALSE(bench::temperature_differs(hardware, warm, runs.dataset(1), runs.dataset(1)));
  CHECK(bench::temperature_differs(made.store.run(1), warm, runs.dataset(1), runs.dataset(1)));
  db::RunRecord unread = warm;
  unread.bench_toml = "no bench";
  CHECK_FALSE(bench::temperature_differs(made.store.run(1), unread, runs.dataset(1), runs.dataset(1)));
  CHECK_FALSE(bench::temperature_differs(unread, warm, runs.dataset(1), runs.dataset(1)));
}

TEST_CASE("budget runs: the resolution of a thermometer is one register count, and at least that of the stored value") {
  const auto step = [](const std::string& sensors) {
    return bench::thermometer_step_c(run_of_bench(bench_text("simulated") + sensors));
  };
  const auto sensor = [](const std::string& quantity, const std::string& more) {
    return "[[environment.sensor]]\nquantity = \"" + quantity + "\"\nunit = 9\naddress = 0\n" + more;
  };
  CHECK(step("") == 0.001);
  CHECK(bench::thermometer_step_c(run_of_bench("no bench")) == 0.001);
  CHECK(step(sensor("temperature_c", "raw_span = [0, 1000]\nspan_c = [0, 100]\n")) == Approx(0.1));
  CHECK(step(sensor("temperature_c", "raw_span = [200, 1000]\nspan_c = [-20, 60]\n")) == Approx(0.1));
  CHECK(step(sensor("temperature_c", "raw_span = [0, 32000]\nspan_c = [0, 16]\n")) == 0.001);
  CHECK(step(sensor("temperature_c", "type = \"f32\"\nraw_span = [0, 1000]\nspan_c = [0, 100]\n")) == 0.001);
  CHECK(step(sensor("supply_bar", "raw_span = [0, 1000]\nspan_bar = [0, 100]\n")) == 0.001);
  CHECK(step(sensor("supply_bar", "raw_span = [0, 10]\nspan_bar = [0, 100]\n") +
             sensor("temperature_c", "raw_span = [0, 1000]\nspan_c = [0, 50]\n") +
             sensor("temperature_c", "raw_span = [0, 1000]\nspan_c = [0, 20]\n")) == Approx(0.05));
}

TEST_CASE("budget runs: a held-out run is evidence for the only condition that differs, whatever its dwell") {
  BudgetStore made;
  (void)made.add({});                                              // 1
  (void)made.add({});                                              // 2
  (void)made.add(film_at("2026-03-11T00:00:00Z"));                 // 3
  (void)made.add(film_set({{"simulation.mount_seed", "1"}}));      // 4
  (void)made.add(film_set({{"simulation.temperature_c", "40"}}));  // 5
  (void)made.add(film_dwell(6.1));                                 // 6
  FilmRun both = film_set({{"simulation.mount_seed", "1"}, {"simulation.age_months", "1"}});
  (void)made.add(both);                                              // 7, mounted and later
  (void)made.add(film_set({{"simulation.specimen", "\"harsh\""}}));  // 8
  FilmRun warm_later = film_at("2026-03-11T00:00:00Z");
  warm_later.set = {{"simulation.temperature_c", "40"}};
  (void)made.add(warm_later);  // 9, what another day brings
  (void)made.add(film_set({{"simulation.mount_seed", "1"}, {"simulation.temperature_c", "40"}}));  // 10
  CHECK(made.history({1, 2, 3, 4, 5, 6, 7, 8, 9, 10}) == "same 2 6 later 3 9 warm 5 mounted 4 paced");
}

TEST_CASE("budget runs: mount studies, and runs without a role as candidates for the dwell effect, each once") {
  BudgetStore made;
  for (int i = 0; i < 4; ++i) (void)made.add({});
  (void)made.add(film_at("2026-03-11T00:00:00Z"));
  CHECK(made.history({}, {2, 3}, {"4:mount", "3"}) == "same later warm mounted 4 paced 2 3");
  CHECK(made.history({}, {1, 2, 2}, {"4:90", "3"}) == "same later warm mounted paced 2 3");
  CHECK(made.history({}, {4, 2}, {"4:mount"}) == "same later warm mounted 4 paced 2");
  CHECK(made.history({}, {5, 2}) == "same later warm mounted paced 2");  // of another day
  CHECK(made.history({}, {}, {"2"}) == "same later warm mounted paced 2");
}

TEST_CASE("budget runs: study results enter the budget, mounting shares are multiplied by the root of two") {
  BudgetStore made;
  (void)made.add({});
  const analysis::UncertaintyInputs none = made.inputs({});
  CHECK_FALSE(none.uniformity);
  CHECK_FALSE(none.mounting);
  CHECK(none.notes.size() == 1);
  made.studies_.uniformity.not_assessed.clear();
  made.studies_.uniformity.u_offset_psi = 0.25;
  made.studies_.uniformity.u_share = 0.125;
  made.studies_.uniformity.degrees = 12.0;
  made.studies_.remount.not_assessed.clear();
  made.studies_.remount.common_share = 0.5;
  made.studies_.remount.per_taxel_share = 0.25;
  made.studies_.remount.degrees = 3;
  made.studies_.remount.per_taxel_degrees = 45;
  const analysis::UncertaintyInputs found = made.inputs({});
  REQUIRE(found.uniformity);
  CHECK(found.uniformity->psi == 0.25);
  CHECK(found.uniformity->share == 0.125);
  CHECK(found.uniformity->dof == 12.0);
  REQUIRE(found.mounting);
  CHECK(found.mounting->psi == 0.0);
  CHECK(found.mounting->share == Approx(0.5 * std::numbers::sqrt2));
  CHECK(found.mounting->dof == 3.0);
  CHECK(found.mounting_per_taxel->share == Approx(0.25 * std::numbers::sqrt2));
  CHECK(found.mounting_per_taxel->dof == 45.0);
}

TEST_CASE("budget runs: a warmer run in another state leaves temperature not assessed, and gives the reason") {
  BudgetStore made;
  FilmRun own, warm;
  own.temperatures_c = {23.0};
  warm.temperatures_c = {30.0, 31.0};
  (void)made.add(own);
  (void)made.add(warm);
  warm.set = {{"simulation.mount_seed", "1"}};
  (void)made.add(warm);
  FilmRun cool = own;
  cool.set = {{"simulation.mount_seed", "1"}};
  (void)made.add(cool);
  CHECK_THAT(made.inputs({}, {3}).temperature.not_assessed, Catch::Contains("30.5 °C"));
  const std::string none = made.inputs({}, {4}).temperature.not_assessed;
  CHECK_FALSE(none.empty());
  CHECK_THAT(none, !Catch::Contains("°C"));
  const analysis::TemperatureEffect assessed = made.inputs({}, {2, 3}).temperature;
  CHECK(assessed.not_assessed.empty());
  CHECK(assessed.temperature_c == std::vector<double>{23.0, 30.5});
  CHECK(assessed.resolution_c == 0.001);
}

// What evidence shows of conditions in use: each source of uncertainty by a run that shows it and by one that just does
// not. On runs of one taxel that are stored by hand.

namespace {

const std::string kAllOpen = "history; re-mounting; temperature; time; creep; ";

class NotedRuns : public FilmStore {
 public:
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

TEST_CASE("noted conditions: five uncertainty sources are open, each is closed by a judged run that varies it") {
  NotedRuns made;
  (void)made.add();
  const std::int64_t same = made.add();  // equal to the run of the models
  CHECK(made.evidence(same).trajectory.trajectory == analysis::Trajectory::kAsFitted);
  CHECK(made.missing(same) == kAllOpen);
  const std::int64_t mounted = made.add(film_set({{"simulation.mount_seed", "1"}}));
  CHECK(made.missing(mounted) == "history; temperature; time; creep; ");
  const std::string later = "history; re-mounting; temperature; creep; ";
  CHECK(made.missing(made.add(film_set({{"simulation.age_months", "1"}}))) == later);
  CHECK(made.missing(made.add(film_set({{"simulation.temperature_c", "40"}}))) ==
        "history; re-mounting; time; creep; ");
  FilmRun other_way;
  other_way.levels = {0.0, 60.0, 30.0, 60.0, 0.0};
  CHECK(made.missing(made.add(other_way)) == "re-mounting; temperature; time; creep; ");
  // A day, and a second more, in either direction.
  CHECK(made.missing(made.add(film_at("2026-03-02T00:00:00Z"))) == kAllOpen);
  CHECK(made.missing(made.add(film_at("2026-03-02T00:00:01Z"))) == later);
  CHECK(made.missing(made.add(film_at("2026-02-27T23:59:59Z"))) == later);
  made.models.dynamics.emplace();
  made.models.dynamics->creep.run = 9;  // lag and creep from holds
  CHECK(made.missing(same) == "history; re-mounting; temperature; time; ");
}

TEST_CASE("noted conditions: hardware, unreadable and not simulated benches give no information on mount and age") {
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
    "noted conditions: dwell is the recipe setting, the mean over repeats, or from the frames if it cannot be read") {
  NotedRuns made;
  (void)made.add();
  const auto dwells = [&](std::int64_t run) {
    const analysis::JudgedTrajectory judged = made.evidence(run).trajectory;
    return fmt::format("{} {} {}", judged.dwell_s, judged.fitted_dwell_s, judged.other_dwell);
  };
  CHECK(dwells(made.add()) == "2 2 false");
  CHECK(dwells(made.add(film_set({{"recipe.dwell_s", "5"}}))) == "5 2 true");
  CHECK(dwells(made.add(film_set({{"recipe.dwell_s", "[1, 4]"}}))) == "2.5 2 true");
  FilmRun unread;
  unread.recipe = "none";
  unread.dwells_s = {3.0, 3.0};
  CHECK(dwells(made.add(unread)) == "3 2 true");
}
