// Converts a sensor's model to the integer words of analysis/export/fixed, which a microcontroller is given, and runs
// these words as the microcontroller does (`--as fixed`).
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

// They are C.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wold-style-cast"
#pragma GCC diagnostic ignored "-Wzero-as-null-pointer-constant"
#include "analysis/export/fixed/tb_dynamic.h"
#include "analysis/export/fixed/tb_elam.h"
#pragma GCC diagnostic pop
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

struct FixedOptions {
  double per_count = 0.0;      // output a count of the device's converter
  double frame_rate_hz = 0.0;  // of the dynamic model: 5 to 10 000; ELAM does not look at it
  int scans = 1;               // that are averaged into a count
  double noise = 0.0;          // least standard deviation of a count, of the output
  double conditioned_s = 0.0;  // dynamic: how long the pressure went over its range before each start
};

struct FixedModel {
  bool dynamic = false;
  std::size_t taxels = 0;
  double x_low = 0.0, per_pressure = 0.0;  // input at pressure 0, and of one count of pressure
  unsigned highest = 0;                    // count of pressure at the highest input
  FixedOptions options;
  std::vector<tb_dynamic_words> dynamic_words;
  std::vector<tb_elam_words> elam_words;
  std::vector<std::uint16_t> x, table;  // ELAM's knots; Everett's tables or ELAM's patterns

  // With pointers into this; that of the other kind is empty.
  [[nodiscard]] tb_dynamic_model dynamic_model() const;
  [[nodiscard]] tb_elam_model elam_model() const;
  [[nodiscard]] std::uint32_t hash() const;
  [[nodiscard]] double pressure(unsigned count) const { return x_low + per_pressure * count; }

  tb_dynamic_model of_dynamic = {};  // all but what the vectors hold
  tb_elam_model of_elam = {};
};

// Of the array's taxels, the unfitted ones dead. Shifts are one set a model, from the largest value over its taxels.
// Throws AnalysisError TB-MODEL-FIXED, which names the taxel, the word and its value where one does not fit.
FixedModel quantised(const SensorModel& model, const FixedOptions& options);

// Counts in, counts of pressure out: the words of a model (quantise.h) run by the header that a device compiles.
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
