// What the page costs: its own process with 8 viewers at 20 Hz, and the run beside it.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "bench/benchmarks/figure.h"

namespace tactbench::bench {

struct PageSizes {
  int viewers = 8;
  double pace = 48.0;         // about 20 frames a second of one scan in 2.4 s
  int repeats = 10;           // of a run beside viewers, and of one alone
  double pace_of_pair = 0.0;  // of both; 0: no limit
  std::chrono::milliseconds before_run{500};
  std::size_t least_pictures = 10;
};
// `rounds`: pairs of runs, without the page and with it. Makes its stores in `folder`. Throws std::runtime_error when
// the viewers see too little. `program`: the file of the program; empty: that of this process.
std::vector<Figure> benchmark_page(int rounds, const std::string& folder, const PageSizes& sizes = {},
                                   const std::string& program = {});

// The events of a stream, each with the empty line behind it; the last one as far as it came.
std::vector<std::string_view> events_of(std::string_view stream);

// Of each picture that came after `begun`, from the storing of its frame (the first one has position 1) to the viewer.
std::vector<double> delays_ms_of(const std::map<std::int64_t, std::chrono::steady_clock::time_point>& pictures,
                                 const std::vector<std::chrono::steady_clock::time_point>& stored,
                                 std::chrono::steady_clock::time_point begun);

// What was measured while the page served a run.
struct PageServed {
  double took_s = 0.0, frames = 0.0;
  double page_s = 0.0, bare_writes_s = 0.0;  // of a processor
  double resident_mb = 0.0;
  std::vector<double> delays_ms;  // of each picture, from the frame's storing to the viewer
};
// A run's frames from the first step to the last.
struct PageRunTimes {
  double wall_s = 0.0, processor_s = 0.0;  // processor: of the sequencer's thread
  double frames = 0.0;
};
struct PageRunPair {
  PageRunTimes alone, seen;
};
void add_figures(FigureList& figures, const PageServed& served);
void add_figures(FigureList& figures, const std::vector<PageRunPair>& pairs);

}  // namespace tactbench::bench
