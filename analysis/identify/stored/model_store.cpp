// MODEL of the command line, and what streaming an array's frames takes of it.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "analysis/identify/residuals.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_io.h"
#include "analysis/whole_file.h"
#include "db/run_store.h"

namespace tactbench::analysis {
namespace {

std::optional<std::int64_t> number_from(std::string_view text) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

// A fit with what its run says of it: rows do not hold that.
SensorModel load_whole(const db::RunStore& store, const db::FitRecord& record) {
  SensorModel fit = load_fit(store, record);
  if (!fit.sequences.empty()) return fit;
  const db::RunRecord run = store.run(record.run);
  fit.content_sha256 = run.content_sha256;
  for (const db::SequenceRecord& sequence : run.sequences) fit.sequences.push_back(sequence.name);
  fit.scans = std::max(1, store.scans_of_first_frame(record.run));
  return fit;
}

std::vector<double> values_of(std::span<const double> values) { return {values.begin(), values.end()}; }

}  // namespace

FrameSetup frame_setup_of(const SensorModel& document, double volts_per_count) {
  const auto refuse = [&](const std::string& why) -> AnalysisError {
    return {Cause::kUsage, "TB-MODEL-COMPENSATOR",
            fmt::format("{} of {} cannot compensate frames: {}", label_of(document), document.source, why),
            "fit ELAM on a run of the array: tactbench fit RUN --model elam"};
  };
  FrameSetup setup;
  setup.volts_per_count = volts_per_count;
  for (const ModelTaxel& taxel : document.taxels) {
    if (taxel.taxel == kMeanTaxel) continue;
    TaxelSetup& own = setup.taxels.emplace_back();
    if (!taxel.fitted()) continue;
    const ElamModel* const elam = paper_elam_of(taxel);
    if (elam == nullptr) throw refuse("only ELAM as in the paper is streamed");
    if (setup.pressure_psi.empty()) setup.pressure_psi = values_of(taxel.ascending.x());
    if (!std::ranges::equal(setup.pressure_psi, taxel.ascending.x())) throw refuse("its taxels do not share one grid");
    own.usable = true;
    own.ascending_v = values_of(taxel.ascending.y());
    own.descending_v = values_of(taxel.descending.y());
    own.parameters = elam->parameters;
    own.noise_v = taxel.noise;
    own.falling = document.falling;
    own.residual_psi = residual_by_level(taxel);
    setup.elam = elam->options;
  }
  if (setup.taxels.size() != static_cast<std::size_t>(document.rows) * static_cast<std::size_t>(document.columns))
    throw refuse("it is not of a whole array");
  return setup;
}

std::string label_of(const SensorModel& document) {
  std::string label = document.model;
  if (document.options.free_run) label += ", free run";
  if (document.options.genetic && document.model == kElamFit) label += ", genetic";
  if (document.options.linearise && !document.dynamics) label += ", linearised";
  if (document.options.memory) label += ", memory";
  if (document.options.exact_outer) label += ", exact outer";
  if (document.options.splits > 1) label += fmt::format(", {} splits", document.options.splits);
  return label;
}

SensorModel load_model(const std::string& model, const db::RunStore* store) {
  const auto colon = model.find(':');
  const auto run = number_from(std::string_view(model).substr(0, colon));
  if (!run) {
    return document_from_text(whole_file(model, {kLongestJson}, "TB-MODEL-OPEN",
                                         "MODEL is the path of a .json file, or RUN or RUN:FIT of the store (--db)"),
                              model);
  }
  if (store == nullptr)
    throw AnalysisError(Cause::kUsage, "TB-MODEL-OPEN", fmt::format("{} names a run, and no store is given", model),
                        "add --db FILE");
  if (colon != std::string::npos) {
    const auto fit = number_from(std::string_view(model).substr(colon + 1));
    if (fit && store->fit(*fit).run == *run) return load_whole(*store, store->fit(*fit));
    throw AnalysisError(Cause::kUsage, "TB-MODEL-OPEN",
                        fmt::format("run {} has no fit \"{}\"", *run, model.substr(colon + 1)),
                        "tactbench runs show RUN lists its fits");
  }
  const std::optional<db::FitRecord> record = standing_fit(*store, *run);
  if (!record)
    throw AnalysisError("TB-ANALYSIS-NO-FIT", fmt::format("run {} has no stored fit", *run),
                        fmt::format("make one: tactbench fit {}", *run));
  return load_whole(*store, *record);
}

}  // namespace tactbench::analysis
