// Counts in, counts of pressure out: the words of a model (quantise.h) run by the header that a device compiles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "analysis/export/quantise.h"

namespace tactbench::analysis {

struct FixedReading {
  std::uint16_t pressure = 0, status = 0;  // FixedModel::pressure(); TB_VALID and the others of tb_fixed.h
};

// The whole array, as on the device. Spans are one entry a taxel; throws std::invalid_argument where one is not.
class FixedFrames {
 public:
  explicit FixedFrames(std::shared_ptr<const FixedModel> model);  // histories unknown
  void frame(std::span<const std::uint16_t> counts, std::span<std::uint16_t> pressures,
             std::span<std::uint16_t> status);
  void lost_frame(std::span<std::uint16_t> pressures, std::span<std::uint16_t> status);
  std::size_t tare(std::span<const std::uint16_t> counts);  // how many taxels were too far off
  [[nodiscard]] const FixedModel& model() const { return *model_; }

 private:
  std::shared_ptr<const FixedModel> model_;
  tb_dynamic_model dynamic_;
  tb_elam_model elam_;
  tb_frames frames_ = {};
  std::vector<tb_dynamic_taxel> dynamic_taxels_;
  std::vector<tb_elam_taxel> elam_taxels_;
};

// One taxel of it, with the same numbers.
class FixedTaxel {
 public:
  FixedTaxel(std::shared_ptr<const FixedModel> model, std::size_t place);
  FixedReading step(std::uint16_t count);
  FixedReading lost();
  bool tare(std::uint16_t count);  // false: too far off
  [[nodiscard]] const FixedModel& model() const { return *model_; }

 private:
  int renews();
  std::shared_ptr<const FixedModel> model_;
  std::uint32_t place_;
  tb_dynamic_model dynamic_;
  tb_elam_model elam_;
  std::uint32_t frame_ = 0, gap_ = 0;  // frames; lost in a row
  tb_dynamic_taxel dynamic_taxel_ = {};
  tb_elam_taxel elam_taxel_ = {};
};

// The count of an output, clamped to 0 to 65535.
std::uint16_t count_of(const FixedModel& model, double output);

}  // namespace tactbench::analysis
