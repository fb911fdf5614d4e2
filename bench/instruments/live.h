// The verb `live`: with a model, acquires frames of the tactile array and compensates them as they arrive; without one,
// shows the values of all instruments. Touches no actuator.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>

#include "analysis/export/quantise.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/pressure_unit.h"
#include "bench/config/config.h"

namespace tactbench::bench {

struct LiveOptions {
  long frames = 0;           // 0: until Ctrl-C or a request to terminate
  double interval_s = 0.01;  // between two requests
  int scans = 1;             // averaged into a frame
  // By the integers of a device: without uncertainty. Its counts, frame rate and scans are the array's.
  std::optional<analysis::FixedOptions> fixed = {};
};

struct LiveFrame {
  long number = 0;  // from 0
  double time_s = 0.0;
  std::span<const float> pressure_psi, uncertainty_psi;
  std::span<const std::uint16_t> status;
  double latency_us = 0.0;  // from the request to the compensated values, real time
};

struct LiveSummary {
  long frames = 0, lost = 0;
  bool other_scanner = false;        // than the one the model is of
  std::vector<std::string> outside;  // the model's validity, one line each; any: all values are flagged
  double median_us = 0.0, p99_us = 0.0, worst_us = 0.0, compensation_median_us = 0.0;
};

// Calls `show` with every frame until it returns false. A frame that times out or comes corrupt is lost; ten in a row,
// or a lost scanner, throw the scanner's Fault. Throws Error TB-LIVE-SHAPE when array and model differ in rows or
// columns, AnalysisError TB-MODEL-COMPENSATOR when the model is not of a whole array, TB-MODEL-FIXED when it does not
// fit a device's integers.
LiveSummary live_frames(const BenchConfig& config, const analysis::SensorModel& model, const LiveOptions& options,
                        const std::function<bool(const LiveFrame&)>& show);

// Live values of a bench's instruments in the terminal, read-only: `live` without a model.
struct WatchOptions {
  double interval_s = 0.5;
  long count = 0;         // 0: until Ctrl-C or a request to terminate
  bool terminal = false;  // redraw in place; else one block of lines a reading
  analysis::PressureUnit unit = analysis::PressureUnit::kPsi;
};

// A failing instrument shows its fault and is tried again at the next reading.
void watch_devices(const BenchConfig& config, const WatchOptions& options);

}  // namespace tactbench::bench
