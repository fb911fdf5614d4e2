// Fits to and from the run store and MODEL of the command line.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "analysis/identify/dynamic/dynamic_fit.h"
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

// Whether reports and compensation of the whole array may rest on it where no fit is named.
bool stands_for_run(const SensorModel& fit, const std::string& label) {
  if (fit.dynamics) return label == kDynamicModel;
  return label == kElamFit && fit.origin != "imported" && fit.all_sequences && fit.parent_sha256.empty() &&
         fit.array().size() == static_cast<std::size_t>(fit.rows) * static_cast<std::size_t>(fit.columns);
}

// Each taxel of the array in its place.
bool is_whole(const SensorModel& fit) {
  const std::span<const ModelTaxel> array = fit.array();
  if (fit.rows <= 0 || fit.columns <= 0 || std::ssize(array) != std::int64_t{fit.rows} * fit.columns) return false;
  for (std::size_t i = 0; i < array.size(); ++i)
    if (array[i].taxel != static_cast<int>(i)) return false;
  return true;
}

[[noreturn]] void malformed(const db::FitRecord& record, const std::string& what) {
  throw AnalysisError(
      "TB-MODEL-STORED", fmt::format("fit {} of run {} cannot be read: {}", record.fit, record.run, what),
      fmt::format("fit the run again: tactbench fit {}; tactbench verify lists what else is damaged", record.run));
}

}  // namespace

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

std::int64_t store_fit(db::RunStore& store, const SensorModel& model, const std::string& program_version,
                       const std::string& utc, const std::string& made_by) {
  SensorModel own = model;
  own.program_version = program_version;
  if (own.content_sha256.empty()) own.content_sha256 = store.run(own.run).content_sha256;
  db::FitRecord record;
  record.run = own.run;
  record.model = label_of(own);
  record.stands = stands_for_run(own, record.model);
  record.fitted = static_cast<int>(own.fitted().size());
  record.document = to_line(own);
  record.made_by = made_by;
  record.program_version = program_version;
  record.created_utc = utc;
  return store.add_fit(record);
}

SensorModel document_of(const db::FitRecord& record) {
  try {
    SensorModel fit = document_from_text(record.document, "what is stored");
    if (record.stands && !is_whole(fit)) malformed(record, "a taxel is missing");
    return fit;
  } catch (const AnalysisError& error) {
    if (error.id() == "TB-MODEL-STORED") throw;
    malformed(record, error.what());
  }
}

SensorModel load_fit(const db::FitRecord& record) {
  SensorModel fit = document_of(record);
  fit.run = record.run;
  fit.fit = record.fit;
  fit.all_sequences = record.stands;
  if (fit.origin != "imported") fit.source = fmt::format("run {}", record.run);
  return fit;
}

SensorModel load_fit(const db::RunStore& store, std::int64_t run) {
  const std::optional<db::FitRecord> record = store.standing_fit(run);
  if (!record)
    throw AnalysisError("TB-ANALYSIS-NO-FIT", fmt::format("run {} has no stored fit", run),
                        fmt::format("make one: tactbench fit {}", run));
  return load_fit(*record);
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
    throw AnalysisError("TB-MODEL-OPEN", fmt::format("{} names a run, and no store is given", model), "add --db FILE");
  if (colon != std::string::npos) {
    const auto fit = number_from(std::string_view(model).substr(colon + 1));
    if (fit && store->fit(*fit).run == *run) return load_fit(store->fit(*fit));
    throw AnalysisError("TB-MODEL-OPEN", fmt::format("run {} has no fit \"{}\"", *run, model.substr(colon + 1)),
                        "tactbench runs show RUN lists its fits");
  }
  return load_fit(*store, *run);
}

}  // namespace tactbench::analysis
