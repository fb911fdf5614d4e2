// A pressure instrument as a witness (docs/rules.md, "The safe state"): which of its readings can be true, and whether
// it follows the pressure.
#pragma once

#include <limits>
#include <optional>
#include <string>

#include "bench/config/config.h"
#include "devices/clock.h"

namespace tactbench::bench {

// The range, inclusive, that a sound instrument can read: from the span's live zero (at least 0 psi) to the span's end,
// widened on both sides by the larger of safe_psi and U + 1 % of the span.
struct TrueRange {
  double low_psi = -std::numeric_limits<double>::infinity(), high_psi = std::numeric_limits<double>::infinity();
  [[nodiscard]] bool holds(double psi) const { return psi >= low_psi && psi <= high_psi; }  // NaN is outside
};
TrueRange feedback_range(const BenchConfig& config);
TrueRange reference_range(const BenchConfig& config);

class PressureWitness {
 public:
  explicit PressureWitness(const TrueRange& range) : range_(range) {}
  void see(double psi, devices::Nanoseconds time);
  // After each reading of the other instrument: an instrument whose reading stays bit-identical while the other moves
  // by more than 5 psi is frozen.
  void see_other(const PressureWitness& other);

  [[nodiscard]] double psi() const { return psi_; }
  [[nodiscard]] devices::Nanoseconds time() const { return time_; }  // of the newest reading; negative: none
  [[nodiscard]] bool possible() const { return range_.holds(psi_); }
  [[nodiscard]] bool ever_possible() const { return ever_possible_; }
  // For how long its readings have been impossible, in s; 0: the newest is possible.
  [[nodiscard]] double impossible_s() const;
  // Why the newest reading proves nothing; empty: it can be trusted.
  [[nodiscard]] std::string doubt() const;

 private:
  TrueRange range_;
  double psi_ = 0.0;
  devices::Nanoseconds time_{-1};
  std::optional<devices::Nanoseconds> impossible_since_;
  bool ever_possible_ = false, is_frozen_ = false;
  bool changed_ = true;     // since the other was last read
  double other_psi_ = 0.0;  // the other's first reading after this one last changed
};

}  // namespace tactbench::bench
