// Model documents: what is read can be written, read again, and put to every use without a crash.
#include <cstdint>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "analysis/error.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"

using namespace tactbench;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const analysis::SensorModel document = analysis::document_from_text(text, "fuzzed.json");
    if (analysis::document_from_text(analysis::to_text(document), "written.json").taxels.size() !=
        document.taxels.size())
      std::abort();
    for (const analysis::ModelTaxel& taxel : document.taxels) {
      if (taxel.fit.model == nullptr) continue;
      (void)taxel.fit.model->parameters();
      const std::vector<double> inputs = {0.0, 1.0, 30.0, 10.0, 60.0, 59.0, -1.0, 1e6};
      try {
        if (analysis::predict(*taxel.fit.model, inputs).size() != inputs.size()) std::abort();
      } catch (const std::invalid_argument&) {  // parameters so large that an output is not finite
      }
    }
    (void)analysis::frames_of(document);
  } catch (const analysis::AnalysisError& error) {
    if (!error.id().starts_with("TB-MODEL-") || error.remedy().empty()) std::abort();
  }
  return 0;
}
