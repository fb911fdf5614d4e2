// Streams of a taxel whose model has lag and creep are its dynamic compensator's, call by call.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <tuple>
#include <vector>

#include "analysis/compensate/dynamic_compensator.h"
#include "analysis/compensate/dynamic_frame_compensator.h"
#include "analysis/identify/dynamic/dynamic_alone.h"
#include "analysis/identify/dynamic/undone.h"
#include "analysis/identify/dynamic_setup_of.h"
#include "analysis/identify/stored/array_stream.h"
#include "analysis/identify/streams/recording_stream.h"
#include "analysis/identify/taxel_stream.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"
#include "tests/analysis/identify/refusals.h"
#include "tests/analysis/support/creeping_film.h"

using namespace tactbench::analysis;
using tactbench::creeping::creeping_film;

namespace {

void check_same_reading(const Compensated& a, const Compensated& b) {
  CHECK(a.pressure_psi == b.pressure_psi);
  CHECK(a.uncertainty_psi == b.uncertainty_psi);
  CHECK((a.unknown == b.unknown && a.flat == b.flat && a.out_of_range == b.out_of_range));
}

struct Measured {
  double volts, seconds;
};
const std::vector<Measured> kMeasured{{1.0, 0.0}, {2.5, 2.0}, {2.2, 5.0}, {1.5, 1.0}, {2.0, 8.0}, {3.5, 3.0}};

template <class Own>
void check_steps(Own& own, DynamicTaxelCompensator& plain) {
  for (const auto& [volts, seconds] : kMeasured)
    check_same_reading(own.step(volts, seconds), plain.step(volts, seconds));
}

}  // namespace

TEST_CASE("streams of dynamic models: steps, conditioning, rests and unknown starts are the compensator's",
          "[dynamic]") {
  for (const double noisier : {1.0, 3.0}) {
    CAPTURE(noisier);
    const SensorModel model = creeping_film();
    const DynamicSetup setup = dynamic_setup_of(model, model.taxels, 1.0, noisier);
    DynamicTaxelCompensator plain(setup, 0);
    RecordingStream recording(model, model.taxels[0], noisier);
    check_steps(recording, plain);
    CHECK(recording.ascending() == plain.ascending());
    check_same_reading(recording.step(1.2, 1.0), plain.step(1.2, 1.0));
    CHECK_FALSE(plain.ascending());
    CHECK_FALSE(recording.ascending());
    recording.work(30.0);
    plain.work(30.0);
    check_steps(recording, plain);
    recording.reset();
    plain.reset();
    check_steps(recording, plain);
    recording.reset_unknown();
    plain.reset_unknown();
    const Compensated first = recording.step(2.0, 1.0);
    CHECK(first.unknown);
    check_same_reading(first, plain.step(2.0, 1.0));
    check_steps(recording, plain);

    plain.reset();
    TaxelStream taxel(model, model.taxels[0], noisier);
    check_steps(taxel, plain);
    taxel.work(30.0);
    plain.work(30.0);
    check_steps(taxel, plain);
    taxel.rest(20.0);
    plain.rest(20.0);
    check_steps(taxel, plain);
    taxel.reset();
    plain.reset();
    check_steps(taxel, plain);
  }
}

TEST_CASE("streams of dynamic models: outputs are given as they rise, and only fitted taxels have lag and creep",
          "[dynamic]") {
  const SensorModel rising = creeping_film(), falling = creeping_film(true);
  RecordingStream one(rising, rising.taxels[0]), other(falling, falling.taxels[0]);
  TaxelStream first(rising, rising.taxels[0]), second(falling, falling.taxels[0]);
  for (const auto& [volts, seconds] : kMeasured) {
    check_same_reading(one.step(volts, seconds), other.step(volts, seconds));
    check_same_reading(first.step(volts, seconds), second.step(volts, seconds));
  }
  SensorModel unfit = creeping_film();
  unfit.taxels[0].status = TaxelStatus::kUnfit;
  RecordingStream still(unfit, unfit.taxels[0]);
  TaxelStream quiet(unfit, unfit.taxels[0]);
  // Half of the first cell: 1 V / 2 behind the divider; time changes nothing.
  const double volts = 0.5 + 0.5 / (1.0 + 0.5 / 8.0);
  for (const double seconds : {0.0, 100.0}) {
    CHECK(still.step(volts, seconds).pressure_psi == Approx(20.0));
    CHECK(quiet.step(volts, seconds).pressure_psi == Approx(20.0));
    still.work(5.0);
    quiet.work(5.0);
  }
  quiet.rest(5.0);
  CHECK(quiet.step(volts, 0.0).pressure_psi == Approx(20.0));
}

TEST_CASE("streams of dynamic models: a taxel is read alone, whatever the ranges of those beside it", "[dynamic]") {
  SensorModel model = creeping_film();
  for (const double high : {60.0, 70.0}) {
    model.taxels.push_back(model.taxels[0]);
    model.taxels.back().taxel = static_cast<int>(model.taxels.size()) - 1;
    model.taxels.back().fit.model = std::make_shared<LinearisedModel>(
        Divider{0.5, 0.125}, std::make_shared<PreisachModel>(10.0, high, 0.0, std::vector<double>{1, 2, 4}));
  }
  // At the end of all cells, 7 V behind the divider, at the far end of each one's own range.
  const double full = 0.5 + 7.0 / (1.0 + 7.0 / 8.0) * 0.94;
  Histories histories;
  for (std::size_t t = 0; t < 3; ++t) {
    CAPTURE(t);
    RecordingStream recording(model, model.taxels[t]);
    TaxelStream stream(model, model.taxels[t]);
    CHECK(recording.step(full).pressure_psi > 45.0);
    CHECK(stream.step(full).pressure_psi > 45.0);
    TaxelHistories& own = histories.taxels.emplace_back();
    own.taxel = static_cast<int>(t);
    own.score = {{"a", {10, 30}, {0.5, 2.0}, {}, {0.0, 1.0}, {0.0, 1.0}}};
  }
  const Histories undone = creep_and_lag_undone(model, histories);
  for (std::size_t t = 0; t < 3; ++t) {
    CHECK(undone.taxels[t].score[0].y[0] == Approx(0.5));
    CHECK(undone.taxels[t].score[0].y[1] > 2.0);
    CHECK(undone.taxels[t].score[0].x[1] < 30.0);
  }
}

TEST_CASE("streams of dynamic models: numbers that make no compensator are refused", "[dynamic]") {
  SensorModel model = creeping_film();
  model.taxels[0].creep_scale = 11.0;
  CHECK(id_of_refusal([&] { const RecordingStream stream(model, model.taxels[0]); }) == "TB-MODEL-COMPENSATOR");
  CHECK(id_of_refusal([&] { const TaxelStream stream(model, model.taxels[0]); }) == "TB-MODEL-COMPENSATOR");
}

TEST_CASE("frames of dynamic models are the frame compensator's, with noise, lost frames, intervals and validity",
          "[dynamic]") {
  for (const bool falling : {false, true}) {
    const SensorModel model = creeping_film(falling);
    DynamicSetup setup = dynamic_setup_of(model, model.taxels, 0.001, 2.0);
    setup.longest_gap = 1;
    DynamicFrameCompensator<float> plain(setup);
    ArrayStream stream(model, 0.001, 2.0, 1);
    float pressure = 0.0F, uncertainty = 0.0F, other_pressure = 0.0F, other_uncertainty = 0.0F;
    std::uint16_t status = 0, other_status = 0;
    const ArrayStream::Output own{std::span(&pressure, 1), std::span(&uncertainty, 1), std::span(&status, 1)};
    const ArrayStream::Output other{std::span(&other_pressure, 1), std::span(&other_uncertainty, 1),
                                    std::span(&other_status, 1)};
    const auto same = [&] {
      CHECK((pressure == other_pressure && uncertainty == other_uncertainty && status == other_status));
    };
    for (int round = 0; round < 3; ++round) {
      stream.set_interval(2.0);
      plain.set_interval(2.0);
      for (const auto& [volts, seconds] : kMeasured) {
        const float measured = static_cast<float>(falling ? -volts : volts);
        stream.frame(std::span(&measured, 1), own);
        plain.frame(std::span(&measured, 1), other);
        same();
        CHECK(((status & kTaxelOutside) != 0) == (round == 1));
      }
      stream.set_outside_validity(round == 0);
      plain.set_outside_validity(round == 0);
      for (int lost = 0; lost <= round; ++lost) {
        stream.lost_frame(own);
        plain.lost_frame(other);
        same();
      }
    }
  }
}

TEST_CASE(
    "streams of models without time: the range goes from the loop's low end over the full scale, and six noises") {
  SensorModel model = creeping_film();
  model.dynamics.reset();
  ModelTaxel& taxel = model.taxels[0];
  taxel.fit.model = std::make_shared<PreisachModel>(10.0, 50.0, 0.5, std::vector<double>{1, 2, 4});
  taxel.fit.full_scale = 7.0;
  taxel.zero = 1.0;
  taxel.gain = 2.0;  // outputs from 2 to 16 V
  for (const auto& [noise, noisier, band] : {std::tuple(0.0, 1.0, 0.0), {0.125, 1.0, 0.75}, {0.125, 2.0, 1.5}}) {
    taxel.noise = noise;
    CAPTURE(noise, noisier);
    const auto out = [&, more = noisier](double volts) {
      TaxelStream stream(model, taxel, more);
      RecordingStream recording(model, taxel, more);
      const bool of_range = stream.step(volts).out_of_range;
      CHECK(recording.step(volts).out_of_range == of_range);
      return of_range;
    };
    CHECK_FALSE(out(16.0 + band));
    CHECK(out(16.0625 + band));
    CHECK_FALSE(out(2.0 - band));
    CHECK(out(1.9375 - band));
  }
}
