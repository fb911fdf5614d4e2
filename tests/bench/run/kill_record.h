// What a kill campaign reads of a run from its store, over a connection of the campaign's own: which frames are
// committed, and whether its final data are complete.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include "analysis/dataset.h"
#include "db/run_store.h"
#include "db/sqlite.h"

namespace tactbench::tests {

// One line a committed frame, in the order written: its place, its link of the hash chain, a digest of its content.
inline std::vector<std::string> committed_frames(const std::string& db_path, std::int64_t run) {
  db::sqlite::Connection connection(db_path, db::sqlite::Access::kReadOnly);
  db::sqlite::Statement rows(
      connection,
      "SELECT f.frame, b.sequence, b.\"repeat\", b.ordinal, b.attempt, f.ordinal, "
      "lower(hex(f.chain)), hex(f.counts), f.time_ns, f.reference_psi, f.setpoint_psi FROM frames "
      "f JOIN branches b USING (branch) WHERE b.run = ? ORDER BY f.frame");
  rows.bind(run);
  std::vector<std::string> lines;
  while (rows.step()) {
    std::int64_t frame = 0, time_ns = 0;
    int sequence = 0, repeat = 0, branch = 0, attempt = 0, ordinal = 0;
    double reference = 0.0, setpoint = 0.0;
    std::string chain, counts;
    rows.read(frame, sequence, repeat, branch, attempt, ordinal, chain, counts, time_ns, reference, setpoint);
    lines.push_back(fmt::format("{} {}/{}/{}/{}/{} {} {} {} {} {}", frame, sequence, repeat, branch, attempt, ordinal,
                                chain, db::sha256_hex(counts), time_ns, reference, setpoint));
  }
  return lines;
}

struct FinalSet {
  std::int64_t branches = 0, voids = 0, doubled = 0;
  std::vector<std::string> faults;  // what is wrong with it, for people; empty: nothing
  std::vector<double> volts;        // mean of the array, repeat after repeat, step after step
};

// `frames_a_repeat` and `repeats` are what the recipe makes.
inline FinalSet judge_final_set(const db::RunStore& store, std::int64_t run, int frames_a_repeat, int repeats) {
  FinalSet set;
  const db::RunRecord row = store.run(run);
  const auto wrong = [&](bool is_wrong, const std::string& what) {
    if (is_wrong) set.faults.push_back(fmt::format("run {}: {}", run, what));
  };
  wrong(row.outcome != db::Outcome::kCompleted, fmt::format("outcome {}: {}", to_string(row.outcome), row.reason));
  wrong(row.safe_state != db::SafeState::kVerified, "its safe state is not verified");
  wrong(row.content_sha256 != store.content_hash(run), "its content hash does not recompute");
  std::map<std::int64_t, db::BranchRecord> branches;
  std::map<std::tuple<int, int, int>, std::vector<int>> attempts;
  std::map<std::tuple<int, int, int>, int> valid;
  for (const db::BranchRecord& branch : store.branches(run)) {
    branches[branch.branch] = branch;
    const std::tuple key(branch.sequence, branch.repeat, branch.ordinal);
    attempts[key].push_back(branch.attempt);
    valid[key] += branch.is_void ? 0 : 1;
    ++set.branches;
    set.voids += branch.is_void ? 1 : 0;
    wrong(branch.is_void && branch.void_reason.empty(), "a void branch has no reason");
  }
  for (auto& [key, numbers] : attempts) {
    std::vector<int> counted(numbers.size());
    std::iota(counted.begin(), counted.end(), 0);
    wrong(numbers != counted, "attempts are missing or out of order");
    wrong(valid[key] != 1, fmt::format("a branch is valid {} times", valid[key]));
  }
  std::map<std::tuple<int, int, int>, int> places;
  for (const db::FrameRecord& frame : store.frames(run)) {
    const db::BranchRecord& branch = branches.at(frame.branch);
    if (!branch.is_void) ++places[{branch.sequence, branch.repeat, frame.ordinal}];
  }
  for (const auto& [place, count] : places) set.doubled += count - 1;
  wrong(places.size() != static_cast<std::size_t>(frames_a_repeat * repeats),
        fmt::format("its final set has {} frames", places.size()));
  const analysis::Dataset data = analysis::load_dataset(store, run);
  wrong(data.sequences.at(0).repeats.size() != static_cast<std::size_t>(repeats), "not all repeats are complete");
  const auto taxels = static_cast<std::ptrdiff_t>(data.taxels());
  for (const analysis::Repeat& repeat : data.sequences.at(0).repeats) {
    for (auto at = repeat.volts.begin(); at != repeat.volts.end(); at += taxels) {
      set.volts.push_back(std::accumulate(at, at + taxels, 0.0) / static_cast<double>(taxels));
    }
  }
  return set;
}

}  // namespace tactbench::tests
