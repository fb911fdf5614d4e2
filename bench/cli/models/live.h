// Output of `live` for a compensated frame: summary, one text line, JSON, and CSV rows.
#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "analysis/pressure_unit.h"
#include "bench/instruments/live.h"

namespace tactbench::bench {

struct TaxelFlags {
  int flat = 0, unknown = 0, out_of_range = 0, dead = 0, lost = 0, outside = 0;
};

struct FrameSummary {
  double mean_psi = 0.0, highest_psi = 0.0;  // of the taxels that are not dead
  std::size_t highest = 0;                   // the first taxel with the highest pressure
  TaxelFlags flags;
};
FrameSummary summed(const LiveFrame& frame);

// CSV: one row per taxel, and the header line.
inline constexpr const char* kFramesHead = "frame,time_s,taxel,pressure_psi,uncertainty_psi,status\n";
std::string frame_rows(const LiveFrame& frame);

// The members from "other_scanner" on.
nlohmann::ordered_json live_json(const LiveSummary& summary, const FrameSummary& last);

}  // namespace tactbench::bench
