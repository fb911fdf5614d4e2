// What a handle of the C API holds: one compensator of one kind and precision.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>
#include <optional>
#include <stdexcept>
#include <type_traits>
#include <utility>
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

// Makes a compensator of one kind from the caller's structs, whose own sizes are at least those of version 1,
// `setup_size` and `taxel_size`. No byte beyond a caller's struct is read: members that it does not have are 0.
// wrong(setup): what is wrong with its sizes and pointers, as (code, text), TB_COMPENSATOR_OK for nothing.
// missing(taxel): what a usable one lacks, or null. made(setup, taxels): the C++ setup. whole, single: the handle's
// member for each precision.
template <class Setup, class Taxel, class Wrong, class Missing, class Made, class Whole, class Single>
int create_handle(const Setup* given, std::size_t setup_size, const Taxel* taxels, std::size_t taxel_size,
                  const Wrong& wrong, const Missing& missing, const Made& made,
                  std::optional<Whole> tb_compensator::*whole, std::optional<Single> tb_compensator::*single,
                  tb_compensator** handle, char* message, std::size_t message_size) {
  const auto refused = [&](int code, const char* why) { return refuse(code, why, message, message_size); };
  (void)refused(0, "");
  if (handle == nullptr) return refused(TB_COMPENSATOR_NULL, "handle is null");
  *handle = nullptr;
  if (given == nullptr || taxels == nullptr) return refused(TB_COMPENSATOR_NULL, "setup or taxels is null");
  if (given->struct_size < setup_size) return refused(TB_COMPENSATOR_SIZE, "setup.struct_size is below version 1's");
  constexpr std::size_t kLargest = 65536;  // no version's struct has so many bytes
  if (given->struct_size > kLargest || taxels->struct_size > kLargest)
    return refused(TB_COMPENSATOR_SIZE, "a struct_size is no struct's");
  Setup setup{};
  std::memcpy(&setup, given, std::min(given->struct_size, sizeof(Setup)));
  if (const auto [code, why] = wrong(setup); code != TB_COMPENSATOR_OK) return refused(code, why);
  const std::size_t step = taxels->struct_size;
  if (step < taxel_size || step % alignof(Taxel) != 0)
    return refused(TB_COMPENSATOR_SIZE, "taxel.struct_size is below version 1's");
  try {
    std::vector<Taxel> own(setup.taxels);
    for (std::size_t i = 0; i < own.size(); ++i) {
      std::memcpy(&own[i], reinterpret_cast<const char*>(taxels) + i * step, std::min(step, sizeof(Taxel)));
      if (own[i].struct_size != step) return refused(TB_COMPENSATOR_SIZE, "the taxels' struct_size differ");
      const char* const lacks = (own[i].flags & TB_TAXEL_USABLE) != 0 ? missing(own[i]) : nullptr;
      if (lacks != nullptr) return refused(TB_COMPENSATOR_NULL, lacks);
    }
    const auto ready = made(setup, own);
    auto compensator = std::make_unique<tb_compensator>();
    compensator->status_spare.resize(setup.taxels);
    if ((setup.flags & TB_COMPENSATOR_DOUBLE) != 0) {
      ((*compensator).*whole).emplace(ready);
      compensator->whole_spare.resize(2 * setup.taxels);
    } else {
      ((*compensator).*single).emplace(ready);
      compensator->single_spare.resize(2 * setup.taxels);
    }
    *handle = compensator.release();
    return TB_COMPENSATOR_OK;
  } catch (const std::bad_alloc&) {
    return refused(TB_COMPENSATOR_MEMORY, "not enough memory");
  } catch (const std::exception& fault) {
    return refused(TB_COMPENSATOR_VALUE, fault.what());
  }
}

inline double or_default(double value, double standard) { return value != 0.0 ? value : standard; }

}  // namespace tactbench::analysis
