#include "tests/bench/cli/models/known_model.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "analysis/models/model_json.h"

namespace tactbench::tests {

void write_model(const TemporaryFolder& folder, const std::string& name, const SensorModel& document) {
  auto json = nlohmann::ordered_json::parse(analysis::to_text(document));
  std::vector<double> inputs = document.pressure_psi;
  for (const ModelTaxel& own : document.taxels) {
    if (!inputs.empty() || own.fit.model == nullptr) continue;
    if (!own.ascending.x().empty()) inputs.assign(own.ascending.x().begin(), own.ascending.x().end());
    for (int step = 0; step <= 30 && own.ascending.x().empty(); ++step)
      inputs.push_back(std::lerp(own.fit.model->x_low(), own.fit.model->x_high(), step / 30.0));
  }
  for (std::size_t i = 0; i < document.taxels.size(); ++i) {
    const ModelTaxel& own = document.taxels[i];
    if (own.fit.model == nullptr || !own.ascending.x().empty()) continue;
    ModelTaxel walked;
    walked.zero = own.zero;
    walked.gain = own.gain;
    walked.fit.model = analysis::model_from_json(analysis::model_json(*own.fit.model));
    std::vector<double> up = inputs, down = inputs;
    try {
      analysis::set_loop(walked, inputs);
      up.assign(walked.ascending.y().begin(), walked.ascending.y().end());
      down.assign(walked.descending.y().begin(), walked.descending.y().end());
    } catch (const std::invalid_argument&) {
    }
    json["taxels"][i]["loop"] = {{"ascending", up}, {"descending", down}};
  }
  if (!inputs.empty()) json["loop_inputs"] = inputs;
  write_file(folder.path(name), json.dump());
}

}  // namespace tactbench::tests
