#include "analysis/report/results.h"

#include <algorithm>

namespace tactbench::analysis {
namespace {

// Omits models of taxels that this run omits, so that every column of a table has the same taxels.
SensorModel of_taxels_in_use(SensorModel previous, const SensorModel& fit) {
  for (std::size_t i = 0; i < std::min(previous.array().size(), fit.array().size()); ++i)
    if (!fit.taxels[i].fitted()) previous.taxels[i].status = fit.taxels[i].status;
  return previous;
}

}  // namespace

AsFound as_found_with(const Dataset& dataset, const SensorModel& fit, const SensorModel& previous,
                      const std::string& previous_name, int threads) {
  const SensorModel in_use = of_taxels_in_use(previous, fit);
  return {previous_name, evaluate(dataset, in_use, threads), static_cast<int>(in_use.fitted().size()), {}, {}};
}

}  // namespace tactbench::analysis
