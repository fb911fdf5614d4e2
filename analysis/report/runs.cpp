#include "analysis/report/runs.h"

#include <utility>

namespace tactbench::analysis {

const db::RunRecord& Runs::record(std::int64_t run) {
  const auto known = records_.find(run);
  return known != records_.end() ? known->second : records_.emplace(run, store_.run(run)).first->second;
}

// All results at once, while the frames are in memory.
const Runs::Results& Runs::results_of_run(std::int64_t run) {
  const auto known = results_.find(run);
  if (known != results_.end()) return known->second;
  const StoredRun stored = read_run(store_, record(run));
  Results results;
  results.dataset.set_from([&] { return load_dataset(stored); });
  results.press_runs.set_from([&] { return load_press_runs(stored); });
  results.history.set_from([&] { return load_history(stored); });
  results.temperatures_c.set_from([&] { return temperatures_of(stored); });
  return results_.emplace(run, std::move(results)).first->second;
}

const Dataset& Runs::dataset(std::int64_t run) { return results_of_run(run).dataset.get(); }
const std::vector<PressRun>& Runs::press_runs(std::int64_t run) { return results_of_run(run).press_runs.get(); }
const RunHistory& Runs::history(std::int64_t run) { return results_of_run(run).history.get(); }
const std::vector<double>& Runs::temperatures_c(std::int64_t run) { return results_of_run(run).temperatures_c.get(); }

}  // namespace tactbench::analysis
