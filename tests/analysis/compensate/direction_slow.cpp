// Direction from the output's own motion beside fixed dead bands, on taxels that the options were not searched on: the
// table in analysis/README.md, whose plant is the fitted ELAM itself, and the same on taxels of the simulated sensor,
// fitted on the paper's two sequences first, which no ELAM follows.
#include <fmt/format.h>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/identify/elam/identify.h"
#include "analysis/models/elam_hysteresis.h"
#include "tests/analysis/compensate/frames.h"
#include "tests/analysis/support/specimen_taxels.h"

using namespace synthetic;

namespace {

constexpr std::size_t kTaxels = 16;
constexpr unsigned kOtherSensor = 23, kReversals = 101;

// Random reversals at the pace of the fit, 2 psi in 2.4 s.
Frames specimen_frames(std::size_t count, double noise_v, double step_psi) {
  Frames frames;
  frames.setup.volts_per_count = 5.0 / 65536.0;
  frames.setup.start_unknown = false;
  for (const FitData& data : specimen_taxels(kOtherSensor, kTaxels, 0.0005)) {
    const ModelFit fit = identify_elam(data, IdentifyOptions{});
    const ElamModel& model = dynamic_cast<const ElamHysteresis&>(*fit.model).elam();
    const auto up = model.ascending.y(), down = model.descending.y(), x = model.ascending.x();
    frames.setup.pressure_psi.assign(x.begin(), x.end());
    frames.setup.taxels.push_back(
        {true, {up.begin(), up.end()}, {down.begin(), down.end()}, model.parameters, noise_v, false});
    frames.models.push_back(model);
  }
  std::mt19937 random(kReversals);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> level(0.0, 60.0);
  std::vector<double> turns{0.0};
  while (levels_of(turns, step_psi).size() < count) turns.push_back(level(random));
  std::vector<double> levels = levels_of(turns, step_psi);
  levels.resize(count);
  SpecimenWalk walk(kOtherSensor);
  for (const double pressure : levels) {
    const std::vector<double>& volts = walk.go(pressure, 0.2 * step_psi, step_psi);
    frames.pressure.push_back(pressure);
    for (std::size_t t = 0; t < kTaxels; ++t) {
      const double counts = (volts[t * (256 / kTaxels)] + noise_v * normal(random)) / frames.setup.volts_per_count;
      frames.counts.push_back(static_cast<std::uint16_t>(std::clamp(std::lround(counts), 0L, 65535L)));
    }
  }
  return frames;
}

// What is usually written: a turn is a sample further behind the extreme than the band; till then the old curve holds.
double fixed_band_error(const Frames& frames, double band_v) {
  double sum = 0.0;
  for (std::size_t t = 0; t < frames.models.size(); ++t) {
    const ElamModel& model = frames.models[t];
    ElamCurve curve(model, true, model.x0(), model.y0());
    double extreme = model.y0();
    for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
      const double volts = frames.at(f)[t] * frames.setup.volts_per_count;
      const double ahead = curve.ascending() ? volts - extreme : extreme - volts;
      if (ahead < -band_v) curve = ElamCurve(model, !curve.ascending(), curve.input(extreme), extreme);
      if (ahead >= 0.0 || ahead < -band_v) extreme = volts;
      sum += std::abs(curve.input(volts) - frames.pressure[f]);
    }
  }
  return sum / static_cast<double>(frames.counts.size());
}

double own_error(const Frames& frames) {
  FrameCompensator<double> compensator(frames.setup);
  Results<double> results(frames.models.size());
  double sum = 0.0;
  for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
    compensator.frame(frames.at(f), results.output());
    for (const double pressure : results.pressure) sum += std::abs(pressure - frames.pressure[f]);
  }
  return sum / static_cast<double>(frames.counts.size());
}

struct Cells {
  std::vector<double> fixed = std::vector<double>(3, 0.0);  // sums of the errors with bands of 0, 20, 50 mV
  double own = 0.0, worst = 0.0;                            // worst: beside the best band of a cell
};

// `frames_of(count, noise, step)` makes the frames of a cell.
template <class FramesOf>
Cells compare_with_bands(const char* plant, const FramesOf& frames_of) {
  constexpr std::array<double, 3> kBands{0.0, 0.020, 0.050};
  Cells cells;
  std::string table = fmt::format("{}: noise, mV; psi a sample; fixed 0, 20, 50 mV; ours\n", plant);
  for (const double noise : {0.0, 0.0015, 0.004, 0.012, 0.032})
    for (const double step : {2.0, 0.5, 0.1}) {
      Frames frames = frames_of(step < 0.2 ? 16000 : 6000, noise, step);
      frames.setup.options.drift_share = 0.0;  // outputs are the fit's
      const double own = own_error(frames);
      double best = 1e9;
      table += fmt::format("{:4.1f} {:4.1f} ", 1e3 * noise, step);
      for (std::size_t k = 0; k < kBands.size(); ++k) {
        const double fixed = fixed_band_error(frames, kBands[k]);
        cells.fixed[k] += fixed;
        best = std::min(best, fixed);
        table += fmt::format(" {:6.3f}", fixed);
      }
      table += fmt::format("  {:6.3f}  {:+.0f} %\n", own, 100.0 * (own / std::max(best, 1e-3) - 1.0));
      cells.own += own;
      cells.worst = std::max(cells.worst, own / std::max(best, 0.01));
    }
  WARN(table << "sums " << cells.fixed[0] << ' ' << cells.fixed[1] << ' ' << cells.fixed[2] << " ours " << cells.own
             << ", worst " << cells.worst);
  return cells;
}

}  // namespace

TEST_CASE("direction: better than each fixed band over all, nowhere much worse than the best of them") {
  const Cells cells = compare_with_bands("the fitted ELAM itself", [](std::size_t count, double noise, double step) {
    return random_reversals(static_cast<int>(kTaxels), count, noise, step, 0.0, kReversals, kOtherSensor);
  });
  for (const double sum : cells.fixed) CHECK(cells.own < 0.5 * sum);
  CHECK(cells.worst < 1.25);
}

TEST_CASE("direction: on the simulated sensor, which no ELAM follows, better than each fixed band over all") {
  const Cells cells = compare_with_bands("simulated sensor", specimen_frames);
  for (const double sum : cells.fixed) CHECK(cells.own < sum);
}
