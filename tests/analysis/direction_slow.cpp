// Direction from the output's own motion beside fixed dead bands, on taxels that the options were not searched on: the
// table in analysis/README.md.
#include <fmt/format.h>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/analysis/support/frames.h"

using namespace synthetic;

namespace {

constexpr int kTaxels = 16;
constexpr unsigned kOtherSensor = 23, kReversals = 101;

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

}  // namespace

TEST_CASE("direction: better than each fixed band over all, nowhere much worse than the best of them") {
  const std::vector<double> bands{0.0, 0.020, 0.050};
  std::vector<double> sums(bands.size());
  double own_sum = 0.0, worst = 0.0;
  std::string table = "noise, mV; psi a sample; fixed 0, 20, 50 mV; ours\n";
  for (const double noise : {0.0, 0.0015, 0.004, 0.012, 0.032})
    for (const double step : {2.0, 0.5, 0.1}) {
      Frames frames = random_reversals(kTaxels, step < 0.2 ? 16000 : 6000, noise, step, 0.0, kReversals, kOtherSensor);
      frames.setup.options.drift_share = 0.0;  // outputs are the fit's
      const double own = own_error(frames);
      double best = 1e9;
      table += fmt::format("{:4.1f} {:4.1f} ", 1e3 * noise, step);
      for (std::size_t k = 0; k < bands.size(); ++k) {
        const double fixed = fixed_band_error(frames, bands[k]);
        sums[k] += fixed;
        best = std::min(best, fixed);
        table += fmt::format(" {:6.3f}", fixed);
      }
      table += fmt::format("  {:6.3f}  {:+.0f} %\n", own, 100.0 * (own / std::max(best, 1e-3) - 1.0));
      own_sum += own;
      worst = std::max(worst, own / std::max(best, 0.01));
    }
  WARN(table << "sums " << sums[0] << ' ' << sums[1] << ' ' << sums[2] << " ours " << own_sum << ", worst " << worst);
  for (const double sum : sums) CHECK(own_sum < 0.5 * sum);
  CHECK(worst < 1.25);
}
