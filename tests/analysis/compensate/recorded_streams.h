// Outputs of an array along ways between turns, with halts and noise, in plain arithmetic so that they are the same
// everywhere; what compensators read of them, as sums to compare with recorded ones.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "analysis/compensate/compensator.h"

namespace recorded {

// Pseudo-random numbers from 0 to 1.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : state_(seed) {
    for (int i = 0; i < 3; ++i) (void)(*this)();
  }
  double operator()() {
    state_ = state_ * 6364136223846793005U + 1442695040888963407U;
    return static_cast<double>(state_ >> 11U) / 9007199254740992.0;
  }

 private:
  std::uint64_t state_;
};

// Shares of the full output: to targets fast and slowly, held there for a while, now and then beyond the ends.
inline std::vector<double> output_shares(std::uint64_t seed, std::size_t count, double noise) {
  Numbers number(seed);
  std::vector<double> shares;
  double at = 0.0;
  while (shares.size() < count) {
    const double target = number() * 1.2 - 0.1, speed = number();
    const double step = speed < 0.3 ? 2.0 : speed < 0.7 ? 0.07 : 0.011;
    const auto halt = static_cast<std::size_t>(number() < 0.4 ? 65.0 * number() : 2.0);
    const auto add = [&](double share) {
      shares.push_back(share + noise * (number() + number() + number() - 1.5) * 2.0);
    };
    while (std::abs(target - at) > step) add(at += target > at ? step : -step);
    at = target;
    for (std::size_t i = 0; i <= halt; ++i) add(at);
  }
  shares.resize(count);
  return shares;
}

// From one level to another and slow drifts there, of up to about a noise a sample: the output counts as still most of
// the time. Many levels are near the ends.
inline std::vector<double> drifting_shares(std::uint64_t seed, std::size_t count, double noise) {
  Numbers number(seed);
  std::vector<double> shares;
  while (shares.size() < count) {
    const double kind = number(), level = number();
    double at = kind < 0.25 ? 0.05 * level : kind < 0.5 ? 1.0 - 0.05 * level : level;
    const auto stretches = static_cast<int>(1.0 + 4.0 * number());
    for (int k = 0; k < stretches; ++k) {
      const double drift = k == 0 ? 0.0 : noise * 2.4 * (number() - 0.5);
      const auto length = static_cast<std::size_t>(k == 0 ? 55.0 * number() : 3.0 + 30.0 * number());
      for (std::size_t i = 0; i < length; ++i) {
        at += drift;
        shares.push_back(at + noise * 0.5 * (number() + number() + number() - 1.5));
      }
    }
  }
  shares.resize(count);
  return shares;
}

enum class Kind {
  kNoise,  // fast and slow ways, halts, noise
  kRound,  // the same in round numbers, where limits are met exactly
  kDrift,  // slow drifts and many unknown starts
  kOpen    // the same where nothing is flat and histories are known only when they have met
};

inline bool drifts(Kind kind) { return kind == Kind::kDrift || kind == Kind::kOpen; }

// The noises and pressures at which a compensator decides.
inline void set_limits(Kind kind, tactbench::analysis::CompensatorOptions& options) {
  if (kind == Kind::kRound) {
    options.jump_in_noises = 4.0;
    options.lead_in_noises = 0.0;
    options.band_in_noises = 4.0;
    options.rest_in_noises = 3.0;
    options.hold_in_noises = 2.0;
  } else if (kind == Kind::kDrift) {
    options.flat_in_noises = 0.75;
    options.longest_mean = 12;
    options.known_psi = 1.5;
  } else if (kind == Kind::kOpen) {
    options.flat_in_noises = 0.0;
    options.longest_mean = 3;
    options.known_psi = 0.0;
  }
}

// In steps of 1 / `steps`, so that limits are met exactly.
inline std::vector<double> in_steps(std::vector<double> shares, double steps) {
  for (double& share : shares) share = std::round(share * steps) / steps;
  return shares;
}

// Sums in which each value has a weight of its own.
struct Sums {
  double pressure = 0.0, uncertainty = 0.0;
  long marks = 0;
};

class Summed {
 public:
  explicit Summed(std::size_t values_each) : each_(values_each) {}
  void add(double pressure, double uncertainty, int marks) {
    if (count_ % each_ == 0) sums_.emplace_back();
    const double weight = 1.0 + static_cast<double>(count_ * 37 % 101) / 101.0;
    sums_.back().pressure += weight * pressure;
    sums_.back().uncertainty += weight * std::min(uncertainty, 1e3);
    sums_.back().marks += static_cast<long>(1 + count_ % 97) * marks;
    ++count_;
  }
  void add(const tactbench::analysis::Compensated& one) {
    add(one.pressure_psi, one.uncertainty_psi, (one.flat ? 1 : 0) + (one.out_of_range ? 2 : 0) + (one.unknown ? 4 : 0));
  }
  [[nodiscard]] const std::vector<Sums>& sums() const { return sums_; }

 private:
  std::size_t each_ = 1, count_ = 0;
  std::vector<Sums> sums_;
};

// Against the first of `was`; what is to be recorded is added to `lines`.
inline void check_sums(const std::string& name, const Summed& now, std::span<const Sums> was, std::string& lines,
                       double margin = 1e-6) {
  CAPTURE(name);
  for (std::size_t i = 0; i < now.sums().size(); ++i) {
    const Sums& sums = now.sums()[i];
    lines += fmt::format("{{{:.7f}, {:.7f}, {}}},\n", sums.pressure, sums.uncertainty, sums.marks);
    if (i >= was.size()) continue;
    CAPTURE(i);
    CHECK(sums.pressure == Approx(was[i].pressure).epsilon(0.0).margin(margin));
    CHECK(sums.uncertainty == Approx(was[i].uncertainty).epsilon(0.0).margin(margin));
    CHECK(sums.marks == was[i].marks);
  }
}

inline void check_recorded(const Summed& now, const std::vector<Sums>& was, double margin = 1e-6) {
  std::string lines;
  check_sums("", now, was, lines, margin);
  INFO("now:\n" << lines);
  CHECK(now.sums().size() == was.size());
}

// Frames with lost ones, lost values, tares and new starts among them. `outputs`: volts of each taxel; `before(f)` is
// called at the beginning of each frame.
template <class Frames, class Setup, class Before>
Summed sums_of_frames(const Setup& setup, Kind kind, const std::vector<std::vector<double>>& outputs,
                      double counts_per_volt, const Before& before) {
  const bool in_round_numbers = kind == Kind::kRound;
  Frames frames(setup);
  const std::size_t taxels = outputs.size();
  std::vector<double> volts(taxels), psi(taxels), doubt(taxels);
  std::vector<std::uint16_t> status(taxels), counts(taxels);
  const typename Frames::Output output{psi, doubt, status};
  Summed summed(taxels * 150);
  for (std::size_t f = 0; f < outputs.front().size(); ++f) {
    for (std::size_t t = 0; t < taxels; ++t) {
      volts[t] = outputs[t][f];
      counts[t] = static_cast<std::uint16_t>(std::lround(std::max(0.0, volts[t]) * counts_per_volt));
      if (setup.taxels[t].falling) volts[t] = -volts[t];
    }
    before(frames, f);
    if (f == 150 || f == 300 || f == 600 || (drifts(kind) && f % 90 == 45)) frames.reset_unknown();
    if (f == 210) frames.reset();
    if (f == 450 && !in_round_numbers) CHECK(frames.tare(counts) < taxels);
    if (f == 580 || f == 590) frames.set_outside_validity(f == 580);
    if (f % 97 == 11) volts[(f / 97) * 2] = std::nan("");
    if (f % 83 == 40 || (f > 700 && f < 705))
      frames.lost_frame(output);
    else if (f % 7 == 3 && !in_round_numbers)
      frames.frame(std::span<const std::uint16_t>(counts), output);
    else
      frames.frame(std::span<const double>(volts), output);
    for (std::size_t t = 0; t < taxels; ++t) summed.add(psi[t], doubt[t], status[t]);
  }
  return summed;
}

}  // namespace recorded
