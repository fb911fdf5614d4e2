// Whether a sensor drifted, by which models and since when; its verdict and until when it counts.
#include "bench/reporting/sensor_state.h"

#include <catch2/catch.hpp>

#include "tests/bench/reporting/judged_store.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct SensorOverTime : FilmStore {
  void measure(const std::string& day, double zero_v = 0.0) {
    FilmRun run;
    run.started_utc = day + "T00:00:00Z";
    run.error_v = [zero_v](int, int, double) { return zero_v; };
    (void)add(run);
  }
  analysis::SensorModel fit(std::int64_t run) {
    analysis::Runs runs(store);
    return bench::fit_run(store, runs.dataset(run));
  }
  void judge(std::int64_t run, std::int64_t fit) {
    db::VerdictRecord row;
    row.verdict = "pass";
    row.limits_toml = film_limits_text(1.0);
    row.limits_sha256 = db::sha256_hex(row.limits_toml);
    store.replace_verdicts(run, fit, {row});
  }
  [[nodiscard]] bench::SensorState state(const analysis::Laboratory& laboratory = {}) const {
    return bench::sensor_state(store, "S-1", laboratory);
  }
};

}  // namespace

TEST_CASE("a sensor's drift: by the models before its newest run, since the first run that was off") {
  SensorOverTime made;
  CHECK(made.state().runs.empty());
  CHECK_FALSE(made.state().drift);
  made.measure("2026-03-01");
  const analysis::SensorModel first = made.fit(1);
  CHECK_FALSE(made.state().drift);  // nothing later to check
  made.measure("2026-03-02");
  const auto sound = made.state().drift;
  REQUIRE(sound);
  CHECK((sound->run == 2 && sound->model_run == 1));
  CHECK_FALSE(sound->drift.drifted());
  CHECK(std::abs(sound->drift.zero) <= sound->drift.zero_u);
  CHECK(sound->since_utc.empty());
  made.measure("2026-06-01", 0.1);
  made.measure("2026-06-02", 0.1);
  const auto off = made.state().drift;
  REQUIRE(off);
  CHECK((off->run == 4 && off->model_run == 1));
  CHECK(off->since_utc == "2026-06-01T00:00:00Z");
  CHECK(off->drift.verdict == analysis::DriftVerdict::kZero);
  const double zero = 0.1 / first.taxels.front().fit.full_scale;
  CHECK(off->drift.zero == Approx(zero).margin(off->drift.zero_u));
  CHECK(off->drift.zero_u < 0.2 * zero);
  const auto adjusts = [&] { return drift_text(made.state()).find("model adjust 1 4 --zero ") != std::string::npos; };
  CHECK(adjusts());
  // Calibrated again: run 4 is held out for the new models, and still shows how the sensor was found.
  const analysis::SensorModel second = made.fit(3);
  made.judge(4, second.fit);
  CHECK(made.state().drift->model_run == 1);
  CHECK(made.state().drift->drift.drifted());
  CHECK_FALSE(adjusts());
  made.measure("2026-06-03", 0.1);
  const auto later = made.state().drift;
  CHECK((later->run == 5 && later->model_run == 3));
  CHECK_FALSE(later->drift.drifted());
  made.store.void_run(5, "gauge closed", "me", "2026-06-04T00:00:00Z");
  CHECK(made.state().drift->run == 4);
}

TEST_CASE("a sensor's verdict is the newest that stands, and counts for as long as the laboratory says") {
  SensorOverTime made;
  made.measure("2026-03-01");
  made.measure("2026-03-02");
  CHECK_FALSE(made.state().verdict);
  made.judge(2, made.fit(1).fit);
  made.measure("2026-09-01");
  analysis::Laboratory laboratory;
  laboratory.recalibrate_after_months = 12;
  const bench::SensorState state = made.state(laboratory);
  REQUIRE(state.verdict);
  CHECK(state.verdict->verdict == analysis::Verdict::kPass);
  CHECK(state.judged_run == 2);
  CHECK(state.valid_until == "2027-03-02");
  CHECK(state.runs.size() == 3);
  CHECK(made.state().valid_until.empty());
}
