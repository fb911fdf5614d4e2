#include "bench/reporting/source_runs.h"

#include <algorithm>

namespace tactbench::bench {

std::optional<std::int64_t> run_of_source(const db::RunStore& store, const analysis::SensorDynamics::Source& source) {
  if (source.content_sha256.empty()) {
    const std::vector<db::RunRecord> runs = store.runs();
    const bool there = std::ranges::find(runs, source.run, &db::RunRecord::run) != runs.end();
    return there ? std::optional(source.run) : std::nullopt;
  }
  const std::vector<db::RunRecord> same = store.runs({.content_sha256 = source.content_sha256});
  if (same.empty()) return std::nullopt;
  return std::ranges::find(same, source.run, &db::RunRecord::run) != same.end() ? source.run : same.front().run;
}

std::vector<std::int64_t> source_runs(const db::RunStore& store, const analysis::SensorModel& fit) {
  std::vector<std::int64_t> numbers;
  if (fit.run != 0) numbers.push_back(fit.run);
  if (!fit.dynamics) return numbers;
  for (const analysis::SensorDynamics::Source& source : {fit.dynamics->rate, fit.dynamics->creep}) {
    const std::optional<std::int64_t> run = run_of_source(store, source);
    if (run && std::ranges::find(numbers, *run) == numbers.end()) numbers.push_back(*run);
  }
  return numbers;
}

}  // namespace tactbench::bench
