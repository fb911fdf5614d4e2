// Live values of a bench's instruments in the terminal, read-only: `live` without a model.
#pragma once

#include "analysis/pressure_unit.h"
#include "bench/config/config.h"

namespace tactbench::bench {

struct WatchOptions {
  double interval_s = 0.5;
  long count = 0;         // 0: until Ctrl-C or a request to terminate
  bool terminal = false;  // redraw in place; else one block of lines a reading
  analysis::PressureUnit unit = analysis::PressureUnit::kPsi;
};

// A failing instrument shows its fault and is tried again at the next reading.
void watch_devices(const BenchConfig& config, const WatchOptions& options);

}  // namespace tactbench::bench
