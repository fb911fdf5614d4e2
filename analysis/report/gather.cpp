#include "analysis/report/gather.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {
namespace {

Dataset seen_by(const SensorModel& fit, const Dataset& dataset) {
  return fit.taxels.empty() ? dataset : as_modelled(dataset, fit);
}

void check_sensor(const db::RunRecord& run, const db::RunRecord& further) {
  if (run.origin != further.origin)
    throw AnalysisError("TB-ANALYSIS-ORIGIN",
                        fmt::format("run {} is {}, run {} is {}", run.run, run.origin, further.run, further.origin),
                        "origins never mix: name runs of one origin");
  if (run.sensor_serial == further.sensor_serial) return;
  throw AnalysisError("TB-ANALYSIS-OTHER-SENSOR",
                      fmt::format("run {} is of sensor {}, run {} of {}", run.run, or_not_stated(run.sensor_serial),
                                  further.run, or_not_stated(further.sensor_serial)),
                      "a report is of one sensor: see --compare and --batch for several");
}

// Trajectories are distinguished by their sequence's name.
void add_applied(ReportInput& input, const Dataset& dataset, bool verification) {
  for (const SequenceData& sequence : dataset.sequences) {
    const bool known = std::ranges::find(input.applied, sequence.name, &AppliedPressures::title) != input.applied.end();
    if (known || sequence.repeats.empty() || sequence.repeats.front().steps.empty()) continue;
    AppliedPressures own{sequence.name, verification, sequence.repeats.size(), {}, {}};
    const std::vector<Sample>& steps = sequence.repeats.front().steps;
    for (const Sample& step : steps) {
      own.time_s.push_back(step.time_s - steps.front().time_s);
      own.pressure_psi.push_back(step.reference_psi);
    }
    input.applied.push_back(std::move(own));
  }
}

}  // namespace

std::vector<int> counted_taxels(const SensorModel& fit, const Health& health) {
  std::vector<bool> out(static_cast<std::size_t>(health.rows * health.columns), false);
  for (const TaxelHealth& finding : health.findings)
    if (finding.excluded) out[static_cast<std::size_t>(finding.taxel)] = true;
  std::vector<int> taxels;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const bool counts = fit.taxels.empty() ? !out[i] : fit.taxels[i].status == TaxelStatus::kFitted;
    if (counts) taxels.push_back(static_cast<int>(i));
  }
  return taxels;
}

void gather_run(ReportInput& input, Runs& runs, std::int64_t run, const std::vector<std::int64_t>& further) {
  const db::RunStore& store = runs.store();
  input.run = runs.record(run);
  input.sensor = store.sensor(input.run.sensor_serial);
  input.approvals = store.reports(run);
  input.history = runs.history(run);
  input.frame_count = input.history.frames + input.history.void_frames;
  add_earlier_seating(input.history, store, input.run);
  const Dataset dataset = seen_by(input.fit, runs.dataset(run));
  input.health = health_of(dataset, input.fit, !input.history.presses);
  if (!input.history.seating_v.empty() && !input.history.earlier_seating_v.empty() &&
      input.history.seating_v.size() == static_cast<std::size_t>(dataset.taxels())) {
    input.health.swaps_assessed = true;
    // A taxel that does not follow the pressure would hide a swapped line.
    std::vector<double> seating = input.history.seating_v;
    for (const TaxelHealth& finding : input.health.findings)
      if (finding.excluded) seating[static_cast<std::size_t>(finding.taxel)] = kNan;
    input.health.swaps = swapped_lines(dataset.rows, dataset.columns, seating, input.history.earlier_seating_v);
  }
  const std::vector<int> taxels = counted_taxels(input.fit, input.health);
  if (!input.history.presses && !taxels.empty()) input.behaviour = behaviour_of(dataset, taxels);
  if (!input.history.presses) {
    add_applied(input, dataset, false);
    for (const HeldOut& held_out : input.held_out) add_applied(input, runs.dataset(held_out.run.run), true);
  }
  for (const std::int64_t number : further) {
    input.further.push_back(runs.record(number));
    check_sensor(input.run, input.further.back());
    const Dataset other = seen_by(input.fit, runs.dataset(number));
    if (taxels.empty() || other.taxels() != dataset.taxels()) continue;
    for (Creep& creep : creep_of(other, taxels)) input.behaviour.creep.push_back(std::move(creep));
  }
}

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
  results.history.set_from([&] { return load_run_log(stored); });
  results.temperatures_c.set_from([&] { return temperatures_of(stored); });
  return results_.emplace(run, std::move(results)).first->second;
}

const Dataset& Runs::dataset(std::int64_t run) { return results_of_run(run).dataset.get(); }
const std::vector<PressRun>& Runs::press_runs(std::int64_t run) { return results_of_run(run).press_runs.get(); }
const RunLog& Runs::history(std::int64_t run) { return results_of_run(run).history.get(); }
const std::vector<double>& Runs::temperatures_c(std::int64_t run) { return results_of_run(run).temperatures_c.get(); }

}  // namespace tactbench::analysis
