// Converts a sensor's model to the integer words of analysis/export/fixed, which a microcontroller is given and
// `--as fixed` runs.
#pragma once

#include <cstddef>
#include <cstdint>
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

}  // namespace tactbench::analysis
