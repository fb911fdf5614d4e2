#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "analysis/compensate/frame_compensator.h"
#include "analysis/identify/elam/lanes.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/models/elam_hysteresis.h"
#include "bench/benchmarks/synthetic_array.h"
#include "bench/selfcheck/selfcheck.h"

namespace tactbench::bench {

namespace {

using namespace analysis;

constexpr int kLevelRows = 3, kLevelColumns = 4;

// The parameters of all taxels of a small array with noise, as bytes.
std::string fitted_on(Dispatch level, const Dataset& dataset) {
  struct Unforced {
    ~Unforced() { unforce_lane_dispatch(); }
  } unforced;
  force_lane_dispatch(level);
  std::string bytes;
  const SensorModel fit = fit_array(dataset);
  for (const ModelTaxel& taxel : fit.array()) {
    const ElamModel* const elam = elam_of(taxel);
    const ElamParameters p = elam != nullptr ? elam->parameters : ElamParameters{};
    for (const double value : {p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a, taxel.fit.j})
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  return bytes;
}

struct StreamedArray {
  FrameSetup setup;
  std::vector<ElamModel> models;
};
StreamedArray streamed_array(double noise_v, double volts_per_count) {
  StreamedArray array;
  std::mt19937 random(5);
  array.setup.volts_per_count = volts_per_count;
  array.setup.start_unknown = false;
  for (int t = 0; t < kLevelRows * kLevelColumns; ++t) {
    const ElamModel model = taxel_like_the_paper(random);
    const auto x = model.ascending.x(), up = model.ascending.y(), down = model.descending.y();
    array.setup.pressure_psi.assign(x.begin(), x.end());
    array.setup.taxels.push_back(
        {true, {up.begin(), up.end()}, {down.begin(), down.end()}, model.parameters, noise_v, false});
    array.models.push_back(model);
  }
  return array;
}

// Turns at random between 2 and 58 psi, `step` psi a frame.
std::vector<double> streamed_pressures(std::size_t turns, double step) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> uniform(2.0, 58.0);
  std::vector<double> pressures{0.0};
  for (std::size_t i = 0; i < turns; ++i) {
    const double to = uniform(random);
    while (std::abs(to - pressures.back()) > step)
      pressures.push_back(pressures.back() + (to > pressures.back() ? step : -step));
  }
  return pressures;
}

template <class Real>
struct StreamedFrame {
  std::vector<Real> pressure, uncertainty;
  std::vector<std::uint16_t> status;
  explicit StreamedFrame(std::size_t taxels) : pressure(taxels), uncertainty(taxels), status(taxels) {}
  typename FrameCompensator<Real>::Output output() { return {pressure, uncertainty, status}; }
  bool operator==(const StreamedFrame&) const = default;
};

SelfcheckAnswer same_frames() {
  const StreamedArray array = streamed_array(0.004, 5.0 / 65536.0);
  const std::size_t taxels = array.models.size();
  std::vector<ElamHysteresis> plants;
  std::vector<std::unique_ptr<ModelState>> states;
  for (const ElamModel& model : array.models) plants.emplace_back(model);
  for (const ElamHysteresis& plant : plants) states.push_back(plant.state());
  FrameCompensator<float> one(array.setup), other(array.setup);
  one.set_dispatch(Dispatch::kBase);
  StreamedFrame<float> a(taxels), b(taxels);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.004);
  std::vector<std::uint16_t> counts(taxels);
  std::size_t frames = 0, different = 0;
  for (const double pressure : streamed_pressures(60, 0.7)) {
    for (std::size_t t = 0; t < taxels; ++t) {
      states[t]->go(pressure);
      const double volts = states[t]->output_at(pressure) + noise(random);
      counts[t] = static_cast<std::uint16_t>(std::clamp(std::lround(volts / array.setup.volts_per_count), 0L, 65535L));
    }
    one.frame(counts, a.output());
    other.frame(counts, b.output());
    different += a == b ? 0U : 1U;
    ++frames;
  }
  return {different == 0 && frames > 1000, fmt::format("{} of {} frames differ", different, frames)};
}

}  // namespace

SelfcheckLines check_dispatch_levels() {
  SelfcheckLines lines;
  const Dataset dataset = synthetic_dataset(kLevelRows, kLevelColumns, 1);
  const std::string base = fitted_on(Dispatch::kBase, dataset);
  for (const Dispatch level : dispatches()) {
    if (level == Dispatch::kBase) continue;
    lines.push_back(selfchecked(
        "dispatch", fmt::format("identification of {} taxels, base against {}", dataset.taxels(), to_string(level)),
        "the same bits", [&]() -> SelfcheckAnswer {
          const bool same = fitted_on(level, dataset) == base;
          return {same, same ? "the same bits" : "other bits"};
        }));
  }
  lines.push_back(selfchecked("dispatch",
                              fmt::format("compensated frames, base against {}", to_string(best_dispatch())),
                              "0 frames differ", same_frames));
  return lines;
}

SelfcheckLines check_compensator() {
  return {selfchecked("compensator", "pressures from the direct formula's outputs, random reversals",
                      "within 1e-06 psi where the pressure is observable, at least 9 samples in 10",
                      []() -> SelfcheckAnswer {
                        // Outputs without noise, in volts: no dead band, and no allowance for drift.
                        StreamedArray array = streamed_array(0.0, 1e-12);
                        array.setup.options.drift_share = 0.0;
                        const std::size_t taxels = array.models.size();
                        std::vector<ElamHysteresis> plants;
                        std::vector<std::unique_ptr<ModelState>> states;
                        for (const ElamModel& model : array.models) plants.emplace_back(model);
                        for (const ElamHysteresis& plant : plants) states.push_back(plant.state());
                        FrameCompensator<double> compensator(array.setup);
                        StreamedFrame<double> frame(taxels);
                        std::vector<double> volts(taxels);
                        double worst = 0.0;
                        std::size_t observable = 0, samples = 0;
                        for (const double pressure : streamed_pressures(60, 0.5)) {
                          for (std::size_t t = 0; t < taxels; ++t) {
                            states[t]->go(pressure);
                            volts[t] = states[t]->output_at(pressure);
                          }
                          compensator.frame(volts, frame.output());
                          for (std::size_t t = 0; t < taxels; ++t) {
                            ++samples;
                            if (frame.status[t] != kTaxelValid) continue;
                            ++observable;
                            worst = std::max(worst, std::abs(frame.pressure[t] - pressure));
                          }
                        }
                        return {worst <= 1e-6 && 10 * observable >= 9 * samples,
                                fmt::format("within {:.2g} psi, {} of {} samples", worst, observable, samples)};
                      })};
}

}  // namespace tactbench::bench
