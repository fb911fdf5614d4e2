// Exports a run's frames, or an imported run's series, as CSV.
#pragma once

#include <iosfwd>

#include "db/run_store.h"

namespace tactbench::bench {

inline constexpr const char* kSeriesHead = "sequence,name,taxel,position,input,output\n";

// First lines about the run, which begin with '#'; then the names of the columns, which end in their unit; then one
// line per scan: the values of its frame, raw counts and, if the scanner's volts per count are stored, volts. Times
// have all their digits, volts seven; a value that was not measured is empty. Written frame by frame, because a long
// run does not fit in memory.
void frames_csv(const db::RunStore& store, const db::RunRecord& run, std::ostream& stream);
void series_csv(const db::RunStore& store, const db::RunRecord& run, std::ostream& stream);

// The branch of a frame; `branches` as the store gives them. Throws Error TB-STORE-SQL when there is none.
const db::BranchRecord& branch_in(const std::vector<db::BranchRecord>& branches, std::int64_t key);

}  // namespace tactbench::bench
