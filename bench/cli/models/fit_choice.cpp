#include "bench/cli/models/fit_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/stored/model_document.h"

namespace tactbench::bench {

std::string why_elam(const FitModelsOptions& options, const analysis::Histories& fitted) {
  if (!options.elam_since.empty() || fitted.origin != "imported") return options.elam_since;
  return fmt::format("{} is {}", fitted.source,
                     names_run(options.source) ? "imported" : "a table; --model dynamic takes one with time_s");
}

bool without_inner_branches(const analysis::SensorModel& dynamic) {
  return std::ranges::all_of(dynamic.taxels, [](const analysis::ModelTaxel& taxel) {
    return !taxel.fitted() || !taxel.fit.undetermined.empty();
  });
}

// Shares of the time as on the demonstration's runs, 256 taxels, two cores; they only divide the time left.
std::vector<WorkStage> fit_stages(const std::vector<std::string>& models) {
  const std::map<std::string, double> shares = {
      {analysis::kElamFit, 1.0},      {"gpi", 85.0}, {"mpi", 4.0}, {"poly", 4.0}, {"preisach", 5.0}, {"monotone", 0.5},
      {analysis::kDynamicModel, 10.0}};
  const std::vector<std::string> either = {analysis::kDynamicModel, analysis::kElamFit};
  std::vector<WorkStage> stages = {{"reading the data", 1.0}};
  for (const std::string& model : models.empty() ? either : models)
    stages.push_back({model, shares.contains(model) ? shares.at(model) : 1.0});
  stages.push_back({kFiguresStage, 1.0, false});
  return stages;
}

}  // namespace tactbench::bench
