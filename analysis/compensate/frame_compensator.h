// Frames of raw counts in, pressures out: TaxelCompensator's algorithm for a whole array, streaming, without allocation
// after construction and with no dependency but the C++ standard library. FrameCompensator<double> agrees with
// TaxelCompensator to 1e-9 psi; the model's residual in its uncertainty is that of the middle of a taxel's present
// linear piece, at most half a piece off. FrameCompensator<float> is the fast one: where a decision falls within a
// rounding of its limit it may go another way. It is no further from the truth then (figures in analysis/README.md).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>

#include "analysis/compensate/dispatch.h"
#include "analysis/compensate/frame_setup.h"

namespace tactbench::analysis {

// Status of a taxel in a frame. Frozen: bits are added, never moved.
enum TaxelBits : std::uint16_t {
  kTaxelValid = 1,       // computed from this frame's sample, within the model's range and validity
  kTaxelFlat = 2,        // the slope hides more pressure behind the noise than flat_psi: see the uncertainty
  kTaxelOutOfRange = 4,  // output outside the external loop by more than the dead band: pressure clamped, its
                         // uncertainty means nothing (0 where the curve ends flat), not valid
  kTaxelDead = 8,        // not usable by its setup: lowest pressure, uncertainty the whole span
  kTaxelOutside = 16,    // conditions outside the model's validity, as set by the caller: not valid
  kTaxelUnknown = 32,    // history not known yet: midway between its extremes, see the uncertainty
  kTaxelLost = 64,       // no sample (frame lost, or not a finite number): the last pressure again, not valid
};

template <class Real>
class FrameCompensator {
 public:
  // One entry a taxel each, as long as taxels().
  struct Output {
    std::span<Real> pressure_psi;
    std::span<Real> uncertainty_psi;  // standard uncertainty
    std::span<std::uint16_t> status;  // TaxelBits
  };

  // Allocates all memory. Throws std::invalid_argument that names the taxel and its error.
  explicit FrameCompensator(const FrameSetup& setup);
  ~FrameCompensator();
  FrameCompensator(FrameCompensator&&) noexcept;
  FrameCompensator& operator=(FrameCompensator&&) noexcept;

  [[nodiscard]] std::size_t taxels() const;
  // One frame. Throws std::invalid_argument when a span's length is not taxels(); the state is then as before. Bounded:
  // no more than one turn, or two curves of an unknown history, a taxel.
  void frame(std::span<const std::uint16_t> counts, const Output& output);
  // The same in volts. A taxel whose voltage is not a finite number, or beyond 1e12 counts, is marked kTaxelLost, its
  // state is as before.
  void frame(std::span<const Real> volts, const Output& output);
  // A frame was lost: every taxel is marked kTaxelLost. After longest_gap of them in a row all histories are unknown.
  void lost_frame(const Output& output);

  void reset();          // all at rest at the lowest pressure
  void reset_unknown();  // start from any state
  // `counts` is the unloaded sensor: its outputs become those of the lowest pressure, and all are at rest there. A
  // taxel that would move by more than tare_share of its span is left as it was. Returns the number of such taxels.
  std::size_t tare(std::span<const std::uint16_t> counts);
  // The caller compares temperature, rate, mount and so on with the model's validity box.
  void set_outside_validity(bool outside);

  void set_dispatch(Dispatch dispatch);  // for tests; the best one that the processor has is the default
  [[nodiscard]] Dispatch dispatch() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

extern template class FrameCompensator<float>;
extern template class FrameCompensator<double>;

}  // namespace tactbench::analysis
