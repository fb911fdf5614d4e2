#include "analysis/report/gather.h"

#include <fmt/format.h>

#include <algorithm>

#include "analysis/statistics/levels.h"

namespace tactbench::analysis {
namespace {

Dataset dataset_of(const db::RunStore& store, std::int64_t run, const ArrayFit& fit) {
  Dataset dataset = load_dataset(store, run);
  return fit.taxels.empty() ? dataset : as_modelled(std::move(dataset), fit);
}

void check_sensor(const db::RunRecord& run, const db::RunRecord& further) {
  if (run.origin != further.origin)
    throw AnalysisError("TB-ANALYSIS-ORIGIN",
                        fmt::format("run {} is {}, run {} is {}", run.run, run.origin, further.run, further.origin),
                        "origins never mix: name runs of one origin");
  if (run.sensor_serial == further.sensor_serial) return;
  throw AnalysisError("TB-ANALYSIS-OTHER-SENSOR",
                      fmt::format("run {} is of sensor {}, run {} of {}", run.run, run.sensor_serial, further.run,
                                  further.sensor_serial),
                      "a report is of one sensor: see --compare and --batch for several");
}

}  // namespace

std::vector<int> counted_taxels(const ArrayFit& fit, const Health& health) {
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

void gather_run(ReportInput& input, const db::RunStore& store, std::int64_t run,
                const std::vector<std::int64_t>& further) {
  input.run = store.run(run);
  input.sensor = store.sensor(input.run.sensor_serial);
  input.frame_count = store.frame_count(run);
  input.approvals = store.reports(run);
  input.history = load_history(store, input.run);
  const Dataset dataset = dataset_of(store, run, input.fit);
  input.health = health_of(dataset, input.fit, !input.history.presses);
  if (!input.history.seating_v.empty() && !input.history.earlier_seating_v.empty() &&
      input.history.seating_v.size() == static_cast<std::size_t>(dataset.taxels())) {
    input.health.swaps_assessed = true;
    // A taxel that does not follow the pressure would hide that its line changed places.
    std::vector<double> seating = input.history.seating_v;
    for (const TaxelHealth& finding : input.health.findings)
      if (finding.excluded) seating[static_cast<std::size_t>(finding.taxel)] = kNan;
    input.health.swaps = swapped_lines(dataset.rows, dataset.columns, seating, input.history.earlier_seating_v);
  }
  const std::vector<int> taxels = counted_taxels(input.fit, input.health);
  if (!input.history.presses && !taxels.empty()) input.behaviour = behaviour_of(dataset, taxels);
  for (const std::int64_t number : further) {
    input.further.push_back(store.run(number));
    check_sensor(input.run, input.further.back());
    const Dataset other = dataset_of(store, number, input.fit);
    if (taxels.empty() || other.taxels() != dataset.taxels()) continue;
    for (Creep& creep : creep_of(other, taxels)) input.behaviour.creep.push_back(std::move(creep));
  }
}

}  // namespace tactbench::analysis
