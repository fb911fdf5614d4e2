// One cell of the fault matrix: a run in this process in which one thing breaks at one point, and everything that must
// hold afterwards: the plant's truth compared with what the run reports of it, the stored row, its frames, and that it
// can be resumed.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/rig/rig.h"
#include "bench/simulation/faults.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"

namespace tactbench::tests {

enum class Bench { kChamber, kPress };

enum class Point {
  // chamber: 0 - 60 - 20 - 60 - 0 psi, twice
  kOpening,
  kBaseline,
  kConditioning,
  kRising,   // between two frames of the first branch
  kTurning,  // the first step back from 60 psi
  kFalling,
  kLastBranch,
  kVent,  // the way out after SIGTERM at 60 psi
  // press: 5 - 30 - 5 N, twice
  kHoming,
  kApproach,
  kPressing,  // at 15 N, z going in
  kReleasing,
  kRetract,
  kRetreat,  // the way out after SIGTERM at 30 N
};
const std::vector<Point>& points_of(Bench bench);
const char* keyword_of(Point point);

struct Breakage {
  std::string name;
  std::function<void(bench::Rig&, const std::string& store)> strike;
  std::vector<sequences::Override> bench = {};  // of the bench file, for the run and for the resumed one
  std::optional<bench::PlannedFault> plan;      // the same as a plan of the plant, where it has to wait for a force
  std::function<void()> mend = [] {};  // before the run is resumed; the plant of the resumed run is whole anyway
  // The plant may stay loaded for good, because no way leads to the actuator; then the run has to say so.
  bool beyond_reach = false;
  std::string bench_file = "simulated.toml";
  // No step may begin while it holds, and the next one begins from the safe state. Null: nothing of the kind.
  std::function<bool()> holds = nullptr;
  // The store cannot be written until mended: the row is closed by the next start.
  bool store_gone = false;
};
// A fault of the plant, from the given moment until the end of the process; `times` as in PlannedFault.
Breakage breakage(bench::FaultKind kind, std::optional<double> value = std::nullopt, long times = 0);
inline Breakage once(bench::FaultKind kind) { return breakage(kind, std::nullopt, 1); }
inline Breakage holding(bench::FaultKind kind) {
  Breakage made = breakage(kind);
  made.beyond_reach = true;
  return made;
}
// Several at once, under a name of their own.
Breakage together(const std::string& name, const std::vector<Breakage>& all);
// The same on a bench of other settings.
Breakage on_bench(const std::string& what, const std::vector<sequences::Override>& settings, Breakage breakage);

// Runs it, checks everything, and returns the cell of the table: "failed 3 SCANNER-LOST, verified, resumed".
std::string cell_of(Bench bench, Point point, const Breakage& breakage);

// All points of the bench, or only these. Writes the row for the table and compares it with the one in
// tests/faults/README.md.
void check_row(Bench bench, const Breakage& breakage, const std::vector<Point>& only = {});
// The same on the bench with a pressure controller on a serial line.
Breakage on_serial_bench(Breakage breakage);

// A row whose cells were made otherwise.
void check_row(const std::string& table, const std::string& name, const std::vector<std::string>& cells);

}  // namespace tactbench::tests
