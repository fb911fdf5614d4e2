// Cost of the sequencer against its necessary parts alone: the same exchanges, and storing the same rows.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "bench/benchmarks/figure.h"
#include "db/record.h"

namespace tactbench::bench {

// One repeat of the descending sequence on the simulated rig in this process (turned clock), then its exchanges again
// without a sequencer, at the times of its trace, then its frames again into an empty store. The ratio is run /
// (exchanges + store). Best of `rounds`, each of the three on its own. Writes to `folder`.
std::vector<Figure> benchmark_sequence(int rounds, const std::string& folder);

// What the run of these frames did on the wires, in its order. A poll reads the regulator's feedback and the reference.
struct BareExchange {
  enum class Kind { kCommand, kPoll, kFrame };
  Kind kind = Kind::kPoll;
  std::int64_t time_ns = 0;  // as the frames'
  double psi = 0.0;          // of a command
  int scans = 0;             // of a frame
  bool operator==(const BareExchange&) const = default;
};
std::vector<BareExchange> bare_exchanges(const std::vector<db::FrameRecord>& frames);

// The best seconds of each; `steps` of one run.
struct SequenceTimes {
  double steps = 0.0, run_s = 0.0, exchanges_s = 0.0, store_s = 0.0;
};
std::vector<Figure> figures_of(const SequenceTimes& times);

}  // namespace tactbench::bench
