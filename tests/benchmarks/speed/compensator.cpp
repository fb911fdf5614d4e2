// Frames of 256 taxels through compensators, of ELAM and of the dynamic Preisach model, with constant, moving and
// turning outputs, compared with a plain loop over as many numbers.
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

#include "analysis/compensate/compensator.h"
#include "analysis/models/elam.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"
#include "tests/benchmarks/speed/ratios.h"
#include "tests/benchmarks/speed/synthetic_array.h"

namespace tactbench::speed {
namespace {

using namespace analysis;

constexpr std::size_t kTaxels = 256, kFrames = 4000;
constexpr double kNoise = 0.004;                                // V
constexpr double kTurns[] = {0.0, 60.0, 10.0, 50.0, 0.0, 0.0};  // psi, of moving frames

struct Array {
  std::vector<std::shared_ptr<const HysteresisModel>> models;
  bool in_time = false;
  [[nodiscard]] FrameCompensator frames() const {
    FrameCompensator::Setup setup;
    setup.x_high = 60.0;
    setup.in_time = in_time;
    CompensatorSetup own;
    own.noise = kNoise;
    own.residual.assign(40, 0.5);
    if (in_time) {
      own.time = std::make_shared<PassedTime>();
      own.time->dynamics.creep_share = {0.015, 0.012, 0.01};
      own.lag_share = 0.07;
      own.options.top_share = 0.02;
    }
    for (const auto& model : models) setup.taxels.push_back(make_compensator(*model, own));
    return FrameCompensator(std::move(setup));
  }
};

const Array& array_of_elam() {
  static const Array made = [] {
    Array array;
    std::mt19937 random(5);
    for (std::size_t t = 0; t < kTaxels; ++t)
      array.models.push_back(std::make_shared<ElamHysteresis>(taxel_like_the_paper(random)));
    return array;
  }();
  return made;
}

// Films of Preisach densities that fall off from the diagonal, in 20 intervals, behind a divider of about 4 V.
const Array& array_in_time() {
  static const Array made = [] {
    Array array{{}, true};
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform;
    constexpr std::size_t n = 20;
    for (std::size_t t = 0; t < kTaxels; ++t) {
      std::vector<double> weights;
      double sum = 0.0;
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = 0; j <= i; ++j) {
          weights.push_back((0.2 + uniform(random)) * std::exp(-8.0 * static_cast<double>(i - j) / n));
          sum += weights.back();
        }
      for (double& weight : weights) weight *= 20.0 / sum;
      array.models.push_back(
          std::make_shared<LinearisedModel>(Divider{0.02, 1.0 / (3.9 + 0.3 * uniform(random))},
                                            std::make_shared<PreisachModel>(0.0, 60.0, 0.0, weights)));
    }
    return array;
  }();
  return made;
}

// Frames x taxels. `turning`: drawn anew for each, so that two thirds of the taxels turn in each frame. Others go
// along kTurns in phase, or stand at 30 psi, with noise.
enum class Way { kStanding, kMoving, kTurning };
std::vector<float> volts_of(const Array& array, Way way) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0.0, kNoise);
  std::uniform_real_distribution<double> level(0.0, 60.0);
  std::vector<std::unique_ptr<ModelState>> states;
  for (const auto& model : array.models) states.push_back(model->state());
  std::vector<float> volts;
  for (std::size_t f = 0; f < kFrames; ++f) {
    const double phase = 4.0 * static_cast<double>(f) / kFrames;
    const auto leg = static_cast<std::size_t>(phase);
    const double moving = kTurns[leg] + (kTurns[leg + 1] - kTurns[leg]) * (phase - static_cast<double>(leg));
    for (const auto& state : states) {
      const double x = way == Way::kStanding ? 30.0 : way == Way::kMoving ? moving : level(random);
      if (way != Way::kTurning) state->go(x);
      volts.push_back(static_cast<float>(state->output_at(x) + noise(random)));
    }
  }
  return volts;
}

void time_frames(benchmark::State& state, const Array& array, Way way) {
  const std::vector<float> volts = volts_of(array, way);
  FrameCompensator compensator = array.frames();
  std::vector<float> pressure(kTaxels), uncertainty(kTaxels);
  std::vector<std::uint16_t> status(kTaxels);
  std::size_t f = 0;
  for (auto _ : state) {
    compensator.frame(std::span(volts).subspan(f * kTaxels, kTaxels), 0.01, {pressure, uncertainty, status});
    benchmark::DoNotOptimize(pressure.data());
    f = f + 1 == kFrames ? 0 : f + 1;
  }
}

void plain_loop(benchmark::State& state) {
  const std::vector<float> volts = volts_of(array_of_elam(), Way::kMoving);
  std::vector<float> to(kTaxels);
  std::size_t f = 0;
  for (auto _ : state) {
    for (std::size_t t = 0; t < kTaxels; ++t) to[t] = volts[f * kTaxels + t] * 1e-3F;
    benchmark::DoNotOptimize(to.data());
    benchmark::ClobberMemory();
    f = f + 1 == kFrames ? 0 : f + 1;
  }
}

const bool frames_registered = [] {
  const auto add = [](const std::string& name, auto act) {
    benchmark::RegisterBenchmark(("compensate/" + name).c_str(), act)->Unit(benchmark::kMicrosecond);
  };
  add("plain_loop", plain_loop);
  for (const auto& [name, way] : {std::pair{"constant_input", Way::kStanding},
                                  {"changing_input", Way::kMoving},
                                  {"reversing_input", Way::kTurning}})
    for (const bool in_time : {false, true})
      add(std::string(in_time ? "dynamic_" : "elam_") + name,
          [=](benchmark::State& state) { time_frames(state, in_time ? array_in_time() : array_of_elam(), way); });
  return true;
}();

}  // namespace
}  // namespace tactbench::speed
