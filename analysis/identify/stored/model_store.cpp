// Models to and from the run store. ELAM in the paper's mode has rows of its own (fit_store.cpp); every other fit is
// kept as its document.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

#include "analysis/identify/elam/identify.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_io.h"
#include "analysis/models/elam_hysteresis.h"
#include "analysis/whole_file.h"

namespace tactbench::analysis {
namespace {

constexpr std::size_t kLargestModel = 256'000'000;  // bytes of JSON: 64 x 64 taxels of Preisach have about 20 million

ModelDocument document_of(const ArrayFit& fit, const db::RunRecord& run, const std::string& program_version) {
  ModelDocument document;
  document.model = "elam";
  document.options.exact_outer = fit.mean_taxel.fit.model.options.exact_outer;
  document.source = fmt::format("run {}", fit.run);
  document.origin = fit.origin;
  document.content_sha256 = run.content_sha256;
  for (const db::SequenceRecord& sequence : run.sequences) document.sequences.push_back(sequence.name);
  document.sensor_serial = fit.sensor_serial;
  document.scanner_serial = fit.scanner_serial;
  document.falling = fit.falling;
  document.input_unit = "psi";
  document.output_unit = "V";
  document.program_version = program_version;
  document.rows = fit.rows;
  document.columns = fit.columns;
  document.validity.input = Range{fit.pressure_psi.front(), fit.pressure_psi.back()};
  const auto add = [&](const TaxelFit& taxel, int number) {
    ModelTaxel& own = document.taxels.emplace_back();
    own.taxel = number;
    own.status = to_string(taxel.status);
    own.noise = taxel.noise_v;
    if (taxel.status != TaxelStatus::kFitted) return;
    own.fit.model = std::make_unique<ElamHysteresis>(taxel.fit.model);
    own.fit.j = taxel.fit.j_v2;
    own.fit.mean_error = taxel.fit.mean_error_v;
    own.fit.max_error = taxel.fit.max_error_v;
    own.loop_low = taxel.fit.model.y0();
    own.fit.full_scale = taxel.fit.model.yu() - taxel.fit.model.y0();
  };
  for (std::size_t i = 0; i < fit.taxels.size(); ++i) add(fit.taxels[i], static_cast<int>(i));
  add(fit.mean_taxel, kMeanTaxel);
  return document;
}

std::vector<double> moved(std::span<const double> outputs, const ModelTaxel& taxel) {
  std::vector<double> result;
  for (const double y : outputs) result.push_back(taxel.zero + taxel.gain * y);
  return result;
}

std::optional<std::int64_t> number_from(std::string_view text) {
  std::int64_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

ModelDocument from_record(const db::RunStore& store, const db::FitRecord& record) {
  if (record.model == kElamFit) {
    ModelDocument document = document_of(load_fit(store, record), store.run(record.run), record.program_version);
    document.scans = std::max(1, store.scans_of_first_frame(record.run));
    return document;
  }
  const std::string name = fmt::format("fit {} of {}", record.fit, store.path());
  try {
    return document_from_text(record.patterns_json, name);
  } catch (const AnalysisError& error) {
    throw AnalysisError(
        Cause::kStored, "TB-MODEL-STORED", error.what(),
        fmt::format("fit the run again: tactbench fit {}; tactbench db check tells what else is damaged", record.run));
  }
}

}  // namespace

FrameSetup frame_setup_of(const ModelDocument& document, double volts_per_count) {
  const auto refuse = [&](const std::string& why) -> AnalysisError {
    return {Cause::kUsage, "TB-MODEL-COMPENSATOR",
            fmt::format("{} of {} cannot compensate frames: {}", label_of(document), document.source, why),
            "fit ELAM on a run of the array: tactbench fit RUN"};
  };
  FrameSetup setup;
  setup.volts_per_count = volts_per_count;
  for (const ModelTaxel& taxel : document.taxels) {
    if (taxel.taxel == kMeanTaxel) continue;
    TaxelSetup& own = setup.taxels.emplace_back();
    if (taxel.fit.model == nullptr) continue;
    const auto* model = dynamic_cast<const ElamHysteresis*>(taxel.fit.model.get());
    if (model == nullptr || !model->is_paper()) throw refuse("only ELAM as in the paper is streamed");
    const auto grid = model->elam().ascending.x();
    if (setup.pressure_psi.empty()) setup.pressure_psi.assign(grid.begin(), grid.end());
    if (!std::ranges::equal(setup.pressure_psi, grid)) throw refuse("its taxels do not share one grid");
    own.usable = true;
    own.ascending_v = moved(model->elam().ascending.y(), taxel);
    own.descending_v = moved(model->elam().descending.y(), taxel);
    own.parameters = model->elam().parameters;
    own.noise_v = taxel.noise;
    own.falling = document.falling;
    setup.elam = model->elam().options;
  }
  if (setup.taxels.size() != static_cast<std::size_t>(document.rows) * static_cast<std::size_t>(document.columns))
    throw refuse("it is not of a whole array");
  return setup;
}

std::string label_of(const ModelDocument& document) {
  std::string label = document.model;
  if (document.options.free_run) label += ", free run";
  if (document.options.genetic && document.model == kElamFit) label += ", genetic";
  if (document.options.memory) label += ", memory";
  if (document.options.exact_outer) label += ", exact outer";
  if (document.options.splits > 1) label += fmt::format(", {} splits", document.options.splits);
  return label;
}

ModelDocument load_model(const std::string& model, const db::RunStore* store) {
  const auto colon = model.find(':');
  const auto run = number_from(std::string_view(model).substr(0, colon));
  if (!run) {
    return document_from_text(whole_file(model, {kLargestModel}, "TB-MODEL-OPEN",
                                         "MODEL is the path of a .json file, or RUN or RUN:FIT of the store (--db)"),
                              model);
  }
  if (store == nullptr)
    throw AnalysisError(Cause::kUsage, "TB-MODEL-OPEN", fmt::format("{} names a run, and no store is given", model),
                        "add --db FILE");
  if (colon != std::string::npos) {
    const auto fit = number_from(std::string_view(model).substr(colon + 1));
    if (fit && store->fit(*fit).run == *run) return from_record(*store, store->fit(*fit));
    throw AnalysisError(Cause::kUsage, "TB-MODEL-OPEN",
                        fmt::format("run {} has no fit \"{}\"", *run, model.substr(colon + 1)),
                        "tactbench runs show RUN lists its fits");
  }
  std::optional<db::FitRecord> record = store->latest_fit(*run, kElamFit);
  if (!record) record = store->latest_fit(*run);
  if (!record)
    throw AnalysisError("TB-ANALYSIS-NO-FIT", fmt::format("run {} has no stored fit", *run),
                        fmt::format("make one: tactbench fit {}", *run));
  return from_record(*store, *record);
}

std::int64_t store_model(db::RunStore& store, std::int64_t run, const ModelDocument& document, const std::string& utc) {
  db::FitRecord record;
  record.run = run;
  record.model = label_of(document);
  if (record.model == kElamFit) record.model += ", compared";  // has no rows of its own
  record.options_json = "{}";
  double j = 0.0, mean = 0.0, worst = 0.0;
  int fitted = 0;
  for (const ModelTaxel& taxel : document.taxels) {
    if (taxel.fit.model == nullptr || taxel.taxel == kMeanTaxel) continue;
    ++fitted;
    j += taxel.fit.j;
    mean += taxel.fit.mean_error;
    worst = std::max(worst, taxel.fit.max_error);
  }
  record.summary_json = json_line(
      nlohmann::json{{"j", j}, {"mean_error", mean / std::max(fitted, 1)}, {"max_error", worst}, {"fitted", fitted}});
  record.program_version = document.program_version;
  record.created_utc = utc;
  record.patterns_json = to_text(document);
  return store.add_fit(record, {});
}

}  // namespace tactbench::analysis
