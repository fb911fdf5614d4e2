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

// Status of a taxel in a frame. The bits are fixed: new ones may be added, none is moved.
enum TaxelBits : std::uint16_t {
  kTaxelValid = 1,       // computed from this frame's sample, within the model's range and validity
  kTaxelFlat = 2,        // small slope: the noise corresponds to much pressure, see the uncertainty
  kTaxelOutOfRange = 4,  // output outside the external loop by more than drift explains: pressure clamped or repeated;
                         // uncertainty meaningless, not valid
  kTaxelDead = 8,        // not usable by its model: lowest pressure, uncertainty the whole span
  kTaxelOutside = 16,    // conditions outside the model's validity, as set by the caller: not valid
  kTaxelUnknown = 32,    // history not known yet: pressure midway between the extremes, see the uncertainty
  kTaxelLost = 64,       // no sample (frame lost, or not a finite number): the last pressure is repeated, not valid
};

class FrameCompensator {
 public:
  // One entry per taxel; each span has taxels() entries.
  struct Output {
    std::span<float> pressure_psi;
    std::span<float> uncertainty_psi;  // standard uncertainty
    std::span<std::uint16_t> status;   // TaxelBits
  };
  struct Setup {
    std::vector<std::unique_ptr<Compensator>> taxels;  // null: dead
    double x_low = 0.0, x_high = 1.0;
    bool in_time = false;  // the compensators remove lag or creep, and need the time
    int max_gap = 10;      // number of consecutive lost frames after which all histories are unknown
  };
  explicit FrameCompensator(Setup setup) : setup_(std::move(setup)) {}

  [[nodiscard]] std::size_t taxels() const { return setup_.taxels.size(); }
  // Whether the next frame needs the time since the previous one.
  [[nodiscard]] bool needs_time() const { return setup_.in_time && begun_; }
  // One measured frame, `seconds` after the previous one (NaN: not known). Throws std::invalid_argument when a span's
  // length is not taxels(), seconds are negative or infinite, or not known to a model that needs them; the state is
  // then unchanged. The seconds of the first frame are not used.
  void frame(std::span<const float> outputs, double seconds, const Output& output);
  void lost_frame(double seconds, const Output& output);
  void start(Start how);
  void work(double seconds);  // as Compensator::work()
  // `outputs` are those of the unloaded sensor. Returns the number of taxels that were refused (Compensator::tare).
  std::size_t tare(std::span<const float> outputs);
  // Set by the caller after comparing temperature, rate, mount and other conditions with the model's validity.
  void set_outside_validity(bool outside) { outside_ = outside; }

 private:
  double checked(std::size_t outputs, double seconds, const Output& output);
  void put(std::size_t taxel, const Compensated& now, int bits, const Output& output) const;

  Setup setup_;
  bool outside_ = false, begun_ = false;
  int gap_ = 0;
};

}  // namespace tactbench::analysis
