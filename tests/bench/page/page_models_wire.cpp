// Pressures on the page: which earlier run's models a run is shown through, and what they make of its frames and of the
// time between them. On runs of two taxels that are stored by hand. Not a unit test: arrays are identified by several
// threads.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"
#include "bench/page/frames.h"
#include "bench/reporting/evaluation.h"
#include "tests/bench/reporting/film_runs.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

FilmRun two_taxels() {
  FilmRun made;
  made.columns = 2;
  made.levels = {0.0,  10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 50.0, 40.0, 30.0, 20.0,
                 30.0, 40.0, 50.0, 60.0, 50.0, 40.0, 30.0, 20.0, 10.0, 0.0};
  return made;
}

class ModelledPage : public FilmStore {
 public:
  std::int64_t add_fitted(const FilmRun& made) {
    const std::int64_t run = add(made);
    analysis::Runs runs(store);
    (void)bench::fit_run(store, runs.dataset(run));
    return run;
  }
  [[nodiscard]] std::string words(std::int64_t run) const {
    const auto found = bench::CompensatedRun::of(store, store.run(run));
    return found ? found->model_text() : "none";
  }
  // A run under way, of the sensor.
  std::int64_t begin() {
    db::RunRecord run;
    run.uuid = db::new_uuid();
    run.origin = "simulated";
    run.state = "prepared";
    run.sensor_serial = "S-1";
    run.sequences = {{0, "a", "", "", 1, 100}};
    run.devices = store.run(1).devices;
    const std::int64_t number = store.begin_run(run);
    branch_ = store.begin_branch(number, {});
    return number;
  }
  void append(std::int64_t run, double volts, double seconds) {
    db::FrameRecord frame;
    frame.branch = branch_;
    frame.ordinal = frames_++;
    frame.rows = frame.scans = 1;
    frame.columns = 2;
    frame.time_ns = now_ns_ += static_cast<std::int64_t>(1e9 * seconds);
    frame.counts.assign(2, static_cast<std::uint16_t>(std::lround(1e4 * volts)));
    store.append_frame(run, frame);
  }

 private:
  std::int64_t branch_ = 0, now_ns_ = 0;
  int frames_ = 0;
};

}  // namespace

TEST_CASE("page models: come from the newest earlier valid run of the same sensor and origin with streaming models") {
  ModelledPage made;
  FilmRun other = two_taxels(), hardware = two_taxels();
  other.sensor = "S-2";
  hardware.origin = "hardware";
  CHECK(made.add_fitted(two_taxels()) == 1);
  CHECK(made.add_fitted(two_taxels()) == 2);
  CHECK(made.add_fitted(two_taxels()) == 3);
  CHECK(made.add(two_taxels()) == 4);  // without models
  (void)made.add_fitted(other);
  (void)made.add_fitted(hardware);
  CHECK(made.add(two_taxels()) == 7);
  (void)made.add_fitted(two_taxels());  // later
  CHECK(made.words(7) == "elam of run 3");
  CHECK(made.words(3) == "elam of run 2");
  CHECK(made.words(1) == "none");
  CHECK(made.words(5) == "none");
  CHECK(made.words(6) == "none");
  made.store.void_run(3, "by hand", "me", "2026-03-02T00:00:00Z");
  CHECK(made.words(7) == "elam of run 2");
  // A fit of only the mean does not represent its run.
  analysis::FitOptions mean;
  mean.mean_alone = true;
  mean.model = "monotone";
  analysis::Runs runs(made.store);
  (void)bench::keep_fit(made.store, analysis::fit_array(runs.dataset(2), mean));
  CHECK(made.words(7) == "elam of run 2");
}

TEST_CASE("page models: give pressures of the newest frame, leave out a spike, and are looked up once") {
  ModelledPage made;
  (void)made.add_fitted(two_taxels());
  const std::int64_t run = made.begin();
  bench::RunFrames frames(made.store, made.store.run(run));
  CHECK_FALSE(frames.advance());
  for (const double psi : {0.0, 10.0, 20.0, 30.0}) made.append(run, film_volts(psi, true), 2.0);
  CHECK(frames.advance());
  const nlohmann::json picture = frames.picture();
  CHECK(picture["model"] == "elam of run 1");
  const std::vector<double> loaded = picture["psi"];
  CHECK(std::abs(loaded[0] - 30.0) < 1.0);
  CHECK(loaded[1] == loaded[0]);
  made.append(run, 6.0, 2.0);  // a spike, until it has stayed
  CHECK(frames.advance());
  CHECK(frames.picture()["psi"] == loaded);
  for (int i = 0; i < 3; ++i) made.append(run, 6.0, 2.0);
  CHECK(frames.advance());
  CHECK(frames.picture()["psi"] == std::vector<double>{60.0, 60.0});
  // A page that began before there were models goes on without.
  ModelledPage late;
  (void)late.add(two_taxels());
  const std::int64_t early = late.begin();
  bench::RunFrames without(late.store, late.store.run(early));
  CHECK_FALSE(without.advance());
  analysis::Runs runs(late.store);
  (void)bench::fit_run(late.store, runs.dataset(1));
  late.append(early, 1.0, 2.0);
  CHECK(without.advance());
  CHECK_FALSE(without.picture().contains("psi"));
}

TEST_CASE("page models: a model with creep gets the time between two frames, if there is one") {
  ModelledPage made;
  FilmRun run = two_taxels();
  (void)made.add(run);
  (void)made.add(run);
  analysis::Runs runs(made.store);
  analysis::SensorModel dynamic = bench::fit_run_dynamic(made.store, runs, 1);
  dynamic.dynamics->shared.creep_share = {0.02, 0.03, 0.04};
  (void)bench::keep_fit(made.store, dynamic);
  const analysis::SensorModel kept = analysis::load_fit(made.store, 1);
  struct Step {
    double volts, time_s;
    double stream_s;  // what the stream is to be told
  };
  const double day = 86'400.0;
  const std::vector<Step> steps = {{0.2, 100.0, 0.0},
                                   {1.0, 103.0, 3.0},
                                   {1.5, 104.0, 1.0},
                                   {1.5, 104.0, 0.0},
                                   {1.6, 103.0, 0.0},
                                   {1.6, 103.0 + day, day},
                                   {1.7, 102.0 + 2.0 * day, day - 1.0},
                                   {1.7, 1102.0 + 2.0 * day, 1000.0}};
  const auto shown = bench::CompensatedRun::of(made.store, made.store.run(2));
  REQUIRE(shown);
  analysis::FrameCompensator stream = analysis::frames_of(kept);
  std::vector<float> pressure(2), uncertainty(2);
  std::vector<std::uint16_t> status(2);
  for (const Step& step : steps) {
    db::StoredFrame frame;
    frame.time_ns = static_cast<std::int64_t>(1e9 * step.time_s);
    shown->see(frame, {1.0, 2.0, 3.0});  // of another array: left out, its time, too
    shown->see(frame, {step.volts, step.volts});
    const auto volts = static_cast<float>(step.volts);
    stream.frame(std::vector<float>{volts, volts}, step.stream_s, {pressure, uncertainty, status});
    INFO(step.time_s);
    CHECK(shown->pressure_psi()[0] == Approx(pressure[0]).epsilon(1e-6));
    CHECK(shown->pressure_psi()[1] == Approx(pressure[1]).epsilon(1e-6));
    CHECK(shown->status() == status);
  }
}
