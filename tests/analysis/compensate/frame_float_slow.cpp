// How far float frames part from the plain form when a decision falls within a rounding of its limit: the figures in
// analysis/README.md.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/analysis/compensate/frames.h"

using namespace synthetic;

TEST_CASE("float frames: some observable samples differ from the plain form, with no larger error against the truth") {
  constexpr int kFrameTaxels = 64;
  std::string table =
      "noise, mV; psi a sample; observable; off by > 0.001 psi, %; > 0.01; > 0.1; worst, psi; mean error of plain and "
      "float\n";
  double all = 0.0, parted = 0.0, far = 0.0;
  for (const double noise : {0.0, 0.0015, 0.004, 0.012, 0.032})
    for (const double step : {2.0, 0.5, 0.1}) {
      const Frames frames = random_reversals(kFrameTaxels, 6000, noise, step, 0.0, 101, 23);
      FrameCompensator<float> fast(frames.setup);
      std::vector<TaxelCompensator> plain = plain_of(frames, false);
      Results<float> results(kFrameTaxels);
      double observable = 0.0, thousandth = 0.0, hundredth = 0.0, tenth = 0.0, worst = 0.0, own = 0.0, true_plain = 0.0;
      for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
        fast.frame(frames.at(f), results.output());
        for (std::size_t t = 0; t < kFrameTaxels; ++t) {
          const Compensated one = plain[t].step(frames.at(f)[t] * frames.setup.volts_per_count);
          if (one.flat || (results.status[t] & kTaxelFlat) != 0) continue;
          const double off = std::abs(one.pressure_psi - static_cast<double>(results.pressure[t]));
          ++observable;
          thousandth += off > 0.001 ? 1.0 : 0.0;
          hundredth += off > 0.01 ? 1.0 : 0.0;
          tenth += off > 0.1 ? 1.0 : 0.0;
          worst = std::max(worst, off);
          own += std::abs(static_cast<double>(results.pressure[t]) - frames.pressure[f]);
          true_plain += std::abs(one.pressure_psi - frames.pressure[f]);
        }
      }
      const double percent = 100.0 / observable;
      table += fmt::format("{:4.1f} {:4.1f} {:8.0f} {:9.5f} {:9.5f} {:9.5f} {:8.5f} {:8.5f} {:8.5f}\n", 1e3 * noise,
                           step, observable, thousandth * percent, hundredth * percent, tenth * percent, worst,
                           true_plain / observable, own / observable);
      CHECK(own < 1.01 * true_plain + 1e-4 * observable);
      all += observable;
      parted += thousandth;
      far += tenth;
    }
  WARN(table << "all: " << 100.0 * parted / all << " % by more than 0.001 psi, " << 100.0 * far / all
             << " % by more than 0.1");
  CHECK(parted < 0.08 * all);
  CHECK(far < 0.01 * all);
}
