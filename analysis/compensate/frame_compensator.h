// Compensates frames of the array: outputs in, pressures out; one streaming compensator per taxel, without allocation
// after construction.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "analysis/compensate/compensator.h"

namespace tactbench::analysis {

// Status of a taxel in a frame. Frozen: bits are added, never moved.
enum TaxelBits : std::uint16_t {
  kTaxelValid = 1,       // computed from this frame's sample, within the model's range and validity
  kTaxelFlat = 2,        // the slope hides much pressure behind the noise: see the uncertainty
  kTaxelOutOfRange = 4,  // output outside the external loop by more than the drift of taxels: pressure clamped, or the
                         // last one again; its uncertainty means nothing, not valid
  kTaxelDead = 8,        // not usable by its model: lowest pressure, uncertainty the whole span
  kTaxelOutside = 16,    // conditions outside the model's validity, as set by the caller: not valid
  kTaxelUnknown = 32,    // history not known yet: midway between its extremes, see the uncertainty
  kTaxelLost = 64,       // no sample (frame lost, or not a finite number): the last pressure again, not valid
};

class FrameCompensator {
 public:
  // One entry per taxel each, as long as taxels().
  struct Output {
    std::span<float> pressure_psi;
    std::span<float> uncertainty_psi;  // standard uncertainty
    std::span<std::uint16_t> status;   // TaxelBits
  };
  struct Setup {
    std::vector<std::unique_ptr<Compensator>> taxels;  // null: dead
    double x_low = 0.0, x_high = 1.0;
    bool in_time = false;  // they remove lag or creep, and need the time
    int max_gap = 10;      // frames lost in a row after which all histories are unknown
  };
  explicit FrameCompensator(Setup setup) : setup_(std::move(setup)) {}

  [[nodiscard]] std::size_t taxels() const { return setup_.taxels.size(); }
  // The next frame needs the time since the one before.
  [[nodiscard]] bool needs_time() const { return setup_.in_time && begun_; }
  // One frame, as measured, `seconds` after the one before (NaN: not known). Throws std::invalid_argument when a span's
  // length is not taxels(), seconds are negative or infinite, or not known to a model that needs them; the state is
  // then as before. The first frame is a start: its seconds are not used.
  void frame(std::span<const float> outputs, double seconds, const Output& output);
  void lost_frame(double seconds, const Output& output);
  void start(Start how);
  void work(double seconds);  // as Compensator's
  // `outputs` are those of the unloaded sensor. Returns how many taxels were too far off (Compensator::tare).
  std::size_t tare(std::span<const float> outputs);
  // The caller compares temperature, rate, mount and so on with the model's validity.
  void set_outside_validity(bool outside) { outside_ = outside; }

 private:
  double checked(std::size_t outputs, double seconds, const Output& output);
  void put(std::size_t taxel, const Compensated& now, int bits, const Output& output) const;

  Setup setup_;
  bool outside_ = false, begun_ = false;
  int gap_ = 0;
};

}  // namespace tactbench::analysis
