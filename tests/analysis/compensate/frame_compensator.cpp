// The frame compensator beside TaxelCompensator, and what it promises a robot.
#include "analysis/compensate/frame_compensator.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

#include "analysis/compensate/compensator.h"
#include "tests/analysis/compensate/frames.h"

using namespace synthetic;

TEST_CASE("double frames equal the plain form on random reversals, noise 0 to 32 mV, known and unknown start") {
  for (const double noise : {0.0, 0.0015, 0.004, 0.012, 0.032})
    for (const bool unknown : {false, true}) {
      const Frames frames = random_reversals(24, 400, noise, 0.7, unknown ? 25.0 : 0.0);
      FrameSetup setup = frames.setup;
      setup.start_unknown = unknown;
      FrameCompensator<double> fast(setup);
      std::vector<TaxelCompensator> plain = plain_of(frames, unknown);
      Results<double> results(24);
      double worst = 0.0, short_of = 0.0;
      int missed = 0, flat = 0;
      for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
        fast.frame(frames.at(f), results.output());
        for (std::size_t t = 0; t < 24; ++t) {
          const Compensated one = plain[t].step(frames.at(f)[t] * setup.volts_per_count);
          worst = std::max(worst, std::abs(one.pressure_psi - results.pressure[t]));
          CHECK(one.unknown == ((results.status[t] & kTaxelUnknown) != 0));
          CHECK(one.out_of_range == ((results.status[t] & kTaxelOutOfRange) != 0));
          flat += one.flat ? 1 : 0;
          missed += one.flat && (results.status[t] & kTaxelFlat) == 0 ? 1 : 0;
          short_of = std::max(short_of, one.uncertainty_psi - results.uncertainty[t]);
        }
      }
      INFO("noise " << noise << " V, unknown start " << unknown << ": flat " << flat << ", missed " << missed
                    << ", uncertainty short by " << short_of << " psi");
      CHECK(worst < 1e-9);
      CHECK(missed <= 0.05 * flat + 2);  // at the limit of 2 psi
    }
}

TEST_CASE("float frames equal the plain form within 0.001 psi where the pressure is observable") {
  // Steps well above the noise: no decision lies within a rounding of its limit.
  for (const double noise : {0.0, 0.0015}) {
    const Frames frames = random_reversals(64, 1500, noise, 2.0);
    FrameCompensator<float> fast(frames.setup);
    std::vector<TaxelCompensator> plain = plain_of(frames, false);
    Results<float> results(64);
    double worst = 0.0;
    int observable = 0;
    for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
      fast.frame(frames.at(f), results.output());
      for (std::size_t t = 0; t < 64; ++t) {
        const Compensated one = plain[t].step(frames.at(f)[t] * frames.setup.volts_per_count);
        if (one.flat || (results.status[t] & kTaxelFlat) != 0) continue;
        ++observable;
        worst = std::max(worst, std::abs(one.pressure_psi - static_cast<double>(results.pressure[t])));
      }
    }
    INFO("noise " << noise << " V, " << observable << " observable samples");
    CHECK(observable > 50000);
    CHECK(worst < (noise > 0.0 ? 0.001 : 0.002));  // 24 bits of output where a count is 0.7 psi
  }
}

TEST_CASE("unknown start: two of the uncertainty hold the truth, and a known state is right") {
  // Histories before the first frame: random reversals that the compensator never saw.
  std::mt19937 random(4);
  std::uniform_real_distribution<double> uniform(0.0, 60.0);
  int unknown = 0, covered = 0, known = 0, right = 0, ended = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Frames frames = random_reversals(16, 250, 0.0015, 1.0, uniform(random), static_cast<unsigned>(trial));
    FrameSetup setup = frames.setup;
    setup.start_unknown = true;
    setup.options.drift_share = 0.0;  // outputs are the fit's
    FrameCompensator<float> fast(setup);
    Results<float> results(16);
    for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
      fast.frame(frames.at(f), results.output());
      for (std::size_t t = 0; t < 16; ++t) {
        const double off = std::abs(static_cast<double>(results.pressure[t]) - frames.pressure[f]);
        const double sigma = static_cast<double>(results.uncertainty[t]);
        if ((results.status[t] & kTaxelUnknown) != 0) {
          ++unknown;
          covered += off <= 2.0 * sigma ? 1 : 0;
        } else if ((results.status[t] & kTaxelFlat) == 0) {
          ++known;
          right += off <= 1.0 ? 1 : 0;
        }
      }
    }
    for (const std::uint16_t bits : results.status) ended += (bits & kTaxelUnknown) == 0 ? 1 : 0;
  }
  INFO(unknown << " unknown, " << covered << " covered; " << known << " known, " << right << " within 1 psi; of 960 "
               << ended << " ended known");
  CHECK(unknown > 5000);
  CHECK(covered > 0.90 * unknown);
  CHECK(right > 0.97 * known);
  CHECK(ended > 800);
}

TEST_CASE("the uncertainty is honest: two of it hold most errors, and it grows where the curve is flat") {
  Frames frames = random_reversals(32, 4000, 0.004, 0.5);
  frames.setup.options.drift_share = 0.0;  // outputs are the fit's
  FrameCompensator<float> fast(frames.setup);
  Results<float> results(32);
  double steep = 0.0, flat = 0.0;
  int within = 0, all = 0, steeps = 0, flats = 0;
  for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
    fast.frame(frames.at(f), results.output());
    for (std::size_t t = 0; t < 32; ++t) {
      const double off = std::abs(static_cast<double>(results.pressure[t]) - frames.pressure[f]);
      ++all;
      within += off <= 2.0 * static_cast<double>(results.uncertainty[t]) ? 1 : 0;
      const bool is_flat = (results.status[t] & kTaxelFlat) != 0;
      (is_flat ? flat : steep) += static_cast<double>(results.uncertainty[t]);
      ++(is_flat ? flats : steeps);
    }
  }
  INFO(100.0 * within / all << " % within two; mean " << steep / steeps << " psi, flat " << flat / flats << " psi");
  CHECK(within > 0.80 * all);
  CHECK(flat / flats > 3.0 * steep / steeps);
}

TEST_CASE("a voltage of NaN or infinity marks its taxel as lost and leaves its state alone") {
  const Frames frames = random_reversals(20, 300, 0.002, 1.0);
  FrameCompensator<double> broken(frames.setup), whole(frames.setup), without(frames.setup);
  Results<double> a(20), b(20), c(20);
  std::vector<double> volts(20);
  for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
    for (std::size_t t = 0; t < 20; ++t) volts[t] = frames.at(f)[t] * frames.setup.volts_per_count;
    const bool breaks = f % 10 == 5;
    const double before = a.pressure[7];
    whole.frame(std::span<const double>(volts), b.output());
    if (!breaks) without.frame(std::span<const double>(volts), c.output());
    if (breaks) volts[7] = f % 20 == 5 ? std::nan("") : std::numeric_limits<double>::infinity();
    broken.frame(std::span<const double>(volts), a.output());
    CHECK(a.pressure[8] == b.pressure[8]);
    CHECK(a.status[8] == b.status[8]);
    CHECK(a.pressure[7] == (breaks ? before : c.pressure[7]));
    CHECK(a.status[7] == (breaks ? std::uint16_t{kTaxelLost} : c.status[7]));
  }
}

TEST_CASE("a sensor with falling output gives the same pressures as its mirrored rising one") {
  const Frames frames = random_reversals(16, 200, 0.001, 1.0);
  FrameSetup mirrored = frames.setup;
  const double top = 65535.0 * mirrored.volts_per_count;
  for (TaxelSetup& taxel : mirrored.taxels) {
    taxel.falling = true;
    for (double& volts : taxel.ascending_v) volts -= top;
    for (double& volts : taxel.descending_v) volts -= top;
  }
  FrameCompensator<double> rising(frames.setup), falling(mirrored);
  Results<double> a(16), b(16);
  for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
    std::vector<std::uint16_t> counts(frames.at(f).begin(), frames.at(f).end());
    rising.frame(counts, a.output());
    for (std::uint16_t& count : counts) count = static_cast<std::uint16_t>(65535 - count);
    falling.frame(counts, b.output());
    for (std::size_t t = 0; t < 16; ++t) REQUIRE(a.pressure[t] == Approx(b.pressure[t]).margin(1e-6));
  }
}
