// Follows a live run until it ends: in a terminal one block that is redrawn in place, otherwise plain lines. Read-only.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "bench/common/screen.h"
#include "bench/common/stop_request.h"
#include "bench/monitor/heat_map.h"
#include "bench/monitor/run_view.h"

namespace tactbench::bench {

struct WatchRunOptions {
  bool terminal = false;
  Shades shades = Shades::kCharacters;
  analysis::PressureUnit unit = analysis::PressureUnit::kPsi;
  std::chrono::milliseconds every{500};         // between two requests to the run
  std::chrono::milliseconds line_every{10000};  // plain lines: between two lines of one phase
};

// The lines with the array below them, for a screen of that size. If it is too small, first events are left out, then
// the map is drawn coarser, and below five lines the map is left out.
std::vector<PaintedLine> watch_block(const std::vector<std::string>& lines, const std::optional<ArrayView>& array,
                                     Shades shades, ScreenSize size);

// Returns the run as its store holds it after its end; none: `stop` came first. Throws StoreError when the store of the
// ended run cannot be read.
std::optional<StoredRun> watch_run(const LiveRun& first, const WatchRunOptions& options, const StopRequest& stop);

}  // namespace tactbench::bench
