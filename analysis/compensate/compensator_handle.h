// What a handle of the C API holds: one compensator of one kind and precision.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <optional>
#include <type_traits>
#include <vector>

#include "analysis/compensate/compensator_c.h"
#include "analysis/compensate/dynamic_frame_compensator.h"
#include "analysis/compensate/frame_compensator.h"

struct tb_compensator {
  std::optional<tactbench::analysis::FrameCompensator<float>> single;
  std::optional<tactbench::analysis::FrameCompensator<double>> whole;
  std::optional<tactbench::analysis::DynamicFrameCompensator<float>> dynamic_single;
  std::optional<tactbench::analysis::DynamicFrameCompensator<double>> dynamic_whole;
  // Buffers for results that the caller does not request, and the results of a lost frame.
  std::vector<float> single_spare;
  std::vector<double> whole_spare;
  std::vector<std::uint16_t> status_spare;  // as many as taxels

  template <class Real>
  [[nodiscard]] bool is() const {
    if constexpr (std::is_same_v<Real, float>)
      return single.has_value() || dynamic_single.has_value();
    else
      return whole.has_value() || dynamic_whole.has_value();
  }
  template <class Real>
  std::vector<Real>& spare() {
    if constexpr (std::is_same_v<Real, float>)
      return single_spare;
    else
      return whole_spare;
  }
  // Calls `act` with the compensator of this precision, which has to be the handle's.
  template <class Real, class Act>
  auto with_real(const Act& act) {
    if constexpr (std::is_same_v<Real, float>)
      return single ? act(*single) : act(*dynamic_single);
    else
      return whole ? act(*whole) : act(*dynamic_whole);
  }
  template <class Act>
  auto with(const Act& act) {
    return is<float>() ? with_real<float>(act) : with_real<double>(act);
  }
};

namespace tactbench::analysis {

// The text of a refusal, cut to the caller's buffer; gives `code` back.
inline int refuse(int code, const char* why, char* message, std::size_t size) {
  if (message != nullptr && size > 0) {
    const std::size_t length = std::min(std::strlen(why), size - 1);
    std::memcpy(message, why, length);
    message[length] = 0;
  }
  return code;
}

inline double or_default(double value, double standard) { return value != 0.0 ? value : standard; }

}  // namespace tactbench::analysis
