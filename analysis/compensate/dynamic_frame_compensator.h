// Frames of raw counts in, pressures out: DynamicTaxelCompensator's algorithm for a whole array, streaming, without
// allocation after construction and with no dependency but the C++ standard library. Where a taxel's output stays on
// one linear piece of its branch the work is vectors; pieces, turns and unknown histories are attended one by one.
#pragma once

#include <memory>
#include <span>

#include "analysis/compensate/dynamic_setup.h"
#include "analysis/compensate/frame_compensator.h"

namespace tactbench::analysis {

template <class Real>
class DynamicFrameCompensator {
 public:
  using Output = typename FrameCompensator<Real>::Output;

  // Copies all that it needs and allocates all memory. Throws std::invalid_argument that names the taxel and its error.
  explicit DynamicFrameCompensator(const DynamicSetup& setup);
  ~DynamicFrameCompensator();
  DynamicFrameCompensator(DynamicFrameCompensator&&) noexcept;
  DynamicFrameCompensator& operator=(DynamicFrameCompensator&&) noexcept;

  [[nodiscard]] std::size_t taxels() const;
  // Seconds from one frame to the next, from now on; until it is called creep and lag are taken as at rest. Throws
  // std::invalid_argument when it is negative or not finite.
  void set_interval(double seconds);
  // As FrameCompensator's.
  void frame(std::span<const std::uint16_t> counts, const Output& output);
  void frame(std::span<const Real> volts, const Output& output);
  void lost_frame(const Output& output);
  void reset();
  void reset_unknown();
  std::size_t tare(std::span<const std::uint16_t> counts);
  void set_outside_validity(bool outside);
  void set_dispatch(Dispatch dispatch);
  [[nodiscard]] Dispatch dispatch() const;
  [[nodiscard]] std::size_t bytes_per_taxel() const;  // of all memory, whole blocks

 private:
  struct State;
  std::unique_ptr<State> state_;
};

extern template class DynamicFrameCompensator<float>;
extern template class DynamicFrameCompensator<double>;

}  // namespace tactbench::analysis
