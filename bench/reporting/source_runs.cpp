#include "bench/reporting/source_runs.h"

#include <algorithm>

namespace tactbench::bench {

std::optional<std::int64_t> run_of_source(const db::RunStore& store, const analysis::SensorDynamics::Source& source) {
  const std::vector<db::RunRecord> runs = store.runs();
  const auto numbered = std::ranges::find(runs, source.run, &db::RunRecord::run);
  if (numbered != runs.end() && (source.content_sha256.empty() || numbered->content_sha256 == source.content_sha256))
    return source.run;
  if (source.content_sha256.empty()) return std::nullopt;
  const auto same = std::ranges::find(runs, source.content_sha256, &db::RunRecord::content_sha256);
  if (same == runs.end()) return std::nullopt;
  return same->run;
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
