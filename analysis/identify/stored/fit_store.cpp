// A fit to and from the run store: in rows or as its document.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/stored/fit_rows.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_io.h"
#include "analysis/models/elam_hysteresis.h"
#include "db/run_store.h"

namespace tactbench::analysis {
namespace {

db::FitTaxelRecord to_record(const ModelTaxel& taxel, int number) {
  db::FitTaxelRecord record;
  record.taxel = number;
  record.status = to_string(taxel.status);
  record.noise_v = taxel.noise;
  const ElamModel* const elam = elam_of(taxel);
  if (elam == nullptr) return record;  // never came to a fit
  const ElamParameters& p = elam->parameters;
  record.parameters = {p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a};
  const auto up = elam->ascending.y(), down = elam->descending.y();
  record.ascending_v.assign(up.begin(), up.end());
  record.descending_v.assign(down.begin(), down.end());
  record.j_v2 = taxel.fit.j;
  record.mean_error_v = taxel.fit.mean_error;
  record.max_error_v = taxel.fit.max_error;
  record.full_scale_v = taxel.full_scale();
  record.at_bound = static_cast<int>(taxel.fit.at_bound);
  return record;
}

[[noreturn]] void malformed(std::int64_t run, const std::string& what) {
  throw AnalysisError(Cause::kStored, "TB-MODEL-STORED",
                      fmt::format("the stored fit of run {} cannot be read: {}", run, what),
                      fmt::format("fit the run again: tactbench fit {}", run));
}

ElamModel elam_from(const db::FitTaxelRecord& record, bool fitted, const SensorModel& fit) {
  const std::vector<double>&grid = fit.pressure_psi, &up = record.ascending_v, &down = record.descending_v,
        &p = record.parameters;
  if (p.size() != kElamParameterNames.size() || up.size() != grid.size() || down.size() != grid.size() ||
      grid.size() < 2)
    malformed(fit.run, fmt::format("taxel {} has {} and {} + {} knots on a grid of {}", record.taxel,
                                   counted(p.size(), "parameter"), up.size(), down.size(), grid.size()));
  if (fitted) {
    const auto finite = [](double value) { return std::isfinite(value); };
    if (!std::ranges::all_of(p, finite) || !finite(record.noise_v))
      malformed(fit.run, fmt::format("taxel {} has a parameter or a noise that is no number", record.taxel));
    if (up.front() != down.front() || up.back() != down.back())
      malformed(fit.run, fmt::format("the two patterns of taxel {} do not meet at their ends", record.taxel));
  }
  return {PatternCurve(grid, up, up.front(), up.back()),
          PatternCurve(grid, down, down.front(), down.back()),
          {p[0], p[1], p[2], p[3], p[4]},
          {fit.options.exact_outer}};
}

ModelTaxel from_record(const db::FitTaxelRecord& record, const SensorModel& fit) {
  ModelTaxel taxel;
  taxel.taxel = record.taxel;
  if (!status_from(record.status, taxel.status))
    malformed(fit.run, fmt::format("taxel {} has the status \"{}\"", record.taxel, record.status));
  if (record.noise_v < 0.0)
    malformed(fit.run, fmt::format("taxel {} has a noise of {} V", record.taxel, record.noise_v));
  taxel.noise = record.noise_v;
  if (record.parameters.empty() && !taxel.fitted()) return taxel;
  try {
    const auto elam = std::make_shared<ElamHysteresis>(elam_from(record, taxel.fitted(), fit));
    taxel.fit.model = elam;
    set_loop(taxel, fit.pressure_psi, elam->elam().ascending.y(), elam->elam().descending.y());
  } catch (const std::invalid_argument& error) {
    malformed(fit.run, fmt::format("taxel {}: {}", record.taxel, error.what()));
  }
  taxel.fit.j = record.j_v2;
  taxel.fit.mean_error = record.mean_error_v;
  taxel.fit.max_error = record.max_error_v;
  taxel.fit.at_bound = static_cast<unsigned>(record.at_bound);
  taxel.loop_low = taxel.y0();
  taxel.fit.full_scale = taxel.yu() - taxel.y0();
  return taxel;
}

// Names by taxel, where there are any.
nlohmann::json undetermined_json(const SensorModel& fit) {
  auto json = nlohmann::json::object();
  for (const ModelTaxel& taxel : fit.taxels)
    if (!taxel.fit.undetermined.empty()) json[std::to_string(taxel.taxel)] = taxel.fit.undetermined;
  return json;
}

void read_undetermined(const nlohmann::json& patterns, SensorModel& fit) {
  if (!patterns.contains("undetermined")) return;
  for (ModelTaxel& taxel : fit.taxels)
    taxel.fit.undetermined = patterns.at("undetermined").value(std::to_string(taxel.taxel), std::vector<std::string>());
}

// The mean taxel's at the end, as in the rows: also of an only taxel, which is its own mean.
std::vector<double> residuals_of(const SensorModel& fit) {
  std::vector<double> residuals;
  for (const ModelTaxel& taxel : fit.array()) residuals.push_back(taxel.residual_psi);
  residuals.push_back(fit.mean_taxel().residual_psi);
  return residuals;
}

// Fits of older programs have none.
void read_residuals(const nlohmann::json& patterns, SensorModel& fit) {
  if (!patterns.contains("residual_psi")) return;
  const std::vector<double> psi = patterns.at("residual_psi");
  const auto valid = [](double value) { return std::isfinite(value) && value >= 0.0; };
  if (psi.size() != fit.taxels.size() || !std::ranges::all_of(psi, valid))
    malformed(fit.run, "its residuals are not those of its taxels");
  for (std::size_t i = 0; i < psi.size(); ++i) fit.taxels[i].residual_psi = psi[i];
}

// What the fit's taxels come to. The names of figures in rows have their units.
nlohmann::json summary_of(const SensorModel& fit, bool in_rows) {
  std::map<std::string, int> taxels;
  double j = 0.0, mean = 0.0, worst = 0.0;
  for (const ModelTaxel& taxel : fit.array()) {
    ++taxels[to_string(taxel.status)];
    if (!taxel.fitted()) continue;
    j += taxel.fit.j;
    mean += taxel.fit.mean_error;
    worst = std::max(worst, taxel.fit.max_error);
  }
  const int fitted = taxels["fitted"];
  if (in_rows)
    return {{"j_v2", j}, {"mean_error_v", mean / std::max(fitted, 1)}, {"max_error_v", worst}, {"taxels", taxels}};
  return {{"j", j}, {"mean_error", mean / std::max(fitted, 1)}, {"max_error", worst}, {"fitted", fitted}};
}

bool goes_in_rows(const SensorModel& fit) {
  const IdentifyOptions& options = fit.options;
  return fit.model == kElamFit && fit.run != 0 && fit.origin != "imported" && fit.all_sequences && !options.free_run &&
         !options.genetic && !options.memory && !options.linearise && options.splits == 1 &&
         fit.parent_sha256.empty() &&
         fit.array().size() == static_cast<std::size_t>(fit.rows) * static_cast<std::size_t>(fit.columns);
}

void check_taxels(const SensorModel& fit, const std::vector<db::FitTaxelRecord>& taxels) {
  if (fit.rows <= 0 || fit.columns <= 0) malformed(fit.run, "it has no taxels");
  if (fit.pressure_psi.size() < 2) malformed(fit.run, "its grid has no two pressures");
  // One row for each and the mean: so many are there, or memory for a number that is not true is not taken.
  const std::int64_t count = static_cast<std::int64_t>(fit.rows) * fit.columns;
  if (count + 1 != static_cast<std::int64_t>(taxels.size()))
    malformed(fit.run, fmt::format("a taxel is missing: {} for {} x {} and their mean", counted(taxels.size(), "row"),
                                   fit.rows, fit.columns));
  std::vector<bool> seen(taxels.size(), false);  // the last: the mean taxel
  for (const db::FitTaxelRecord& taxel : taxels) {
    if (taxel.taxel != kMeanTaxel && (taxel.taxel < 0 || taxel.taxel >= count))
      malformed(fit.run, fmt::format("it holds a taxel {}", taxel.taxel));
    seen[taxel.taxel == kMeanTaxel ? seen.size() - 1 : static_cast<std::size_t>(taxel.taxel)] = true;
  }
  if (std::ranges::find(seen, false) != seen.end()) malformed(fit.run, "a taxel is missing");
}

}  // namespace

FitRows rows_of(const SensorModel& fit) {
  FitRows rows;
  db::FitRecord& record = rows.fit;
  record.run = fit.run;
  record.model = label_of(fit);
  const bool in_rows = goes_in_rows(fit);
  record.summary_json = json_line(summary_of(fit, in_rows));
  if (!in_rows) {
    if (record.model == kElamFit) record.model += ", in part";  // not what stands for the run
    nlohmann::json options = nlohmann::json::object();
    if (fit.options.linearise) options["linearise"] = true;
    if (fit.dynamics && fit.dynamics->rate.run != 0) {
      options["rate_run"] = fit.dynamics->rate.run;
      options["creep_run"] = fit.dynamics->creep.run;
    }
    record.options_json = json_line(options);
    record.patterns_json = to_text(fit);
    return rows;
  }
  nlohmann::json options = {{"exact_outer", fit.options.exact_outer}};
  if (fit.options.settle) options["settled"] = true;
  if (!fit.validity.mount.empty()) options["mount"] = fit.validity.mount;
  if (!fit.validity.interface_material.empty()) options["interface_material"] = fit.validity.interface_material;
  record.options_json = json_line(options);
  nlohmann::json patterns = nlohmann::json{{"rows", fit.rows},
                                           {"columns", fit.columns},
                                           {"pressure_psi", fit.pressure_psi},
                                           {"full_scale_v", fit.full_scale_v()},
                                           {"falling", fit.falling},
                                           {"origin", fit.origin},
                                           {"sensor_serial", fit.sensor_serial},
                                           {"scanner_serial", fit.scanner_serial}};
  const std::vector<double> residuals = residuals_of(fit);
  if (std::ranges::any_of(residuals, [](double psi) { return psi > 0.0; })) patterns["residual_psi"] = residuals;
  if (const nlohmann::json open = undetermined_json(fit); !open.empty()) patterns["undetermined"] = open;
  record.patterns_json = json_line(patterns);
  rows.taxels.push_back(to_record(fit.mean_taxel(), kMeanTaxel));
  for (const ModelTaxel& taxel : fit.array()) rows.taxels.push_back(to_record(taxel, taxel.taxel));
  return rows;
}

SensorModel model_from_rows(const FitRows& rows) {
  const db::FitRecord& record = rows.fit;
  SensorModel fit;
  fit.model = kElamFit;
  fit.run = record.run;
  fit.fit = record.fit;
  fit.source = fmt::format("run {}", record.run);
  fit.program_version = record.program_version;
  fit.input_unit = "psi";
  fit.output_unit = "V";
  try {
    const auto patterns = parse_json(record.patterns_json);
    patterns.at("rows").get_to(fit.rows);
    patterns.at("columns").get_to(fit.columns);
    patterns.at("pressure_psi").get_to(fit.pressure_psi);
    fit.falling = patterns.value("falling", false);  // fits of older versions: refused then
    patterns.at("origin").get_to(fit.origin);
    patterns.at("sensor_serial").get_to(fit.sensor_serial);
    patterns.at("scanner_serial").get_to(fit.scanner_serial);
    const auto options = parse_json(record.options_json);
    options.at("exact_outer").get_to(fit.options.exact_outer);
    fit.options.settle = options.value("settled", false);
    fit.validity.mount = options.value("mount", "");
    fit.validity.interface_material = options.value("interface_material", "");
  } catch (const nlohmann::json::exception& error) {
    malformed(record.run, error.what());
  }
  check_taxels(fit, rows.taxels);
  fit.validity.input = Range{fit.pressure_psi.front(), fit.pressure_psi.back()};
  fit.taxels.resize(rows.taxels.size());
  for (const db::FitTaxelRecord& taxel : rows.taxels)
    fit.taxels[taxel.taxel == kMeanTaxel ? fit.taxels.size() - 1 : static_cast<std::size_t>(taxel.taxel)] =
        from_record(taxel, fit);
  try {
    const nlohmann::json patterns = parse_json(record.patterns_json);
    read_residuals(patterns, fit);
    read_undetermined(patterns, fit);
  } catch (const nlohmann::json::exception& error) {
    malformed(record.run, error.what());
  }
  return fit;
}

std::int64_t store_fit(db::RunStore& store, const SensorModel& model, const std::string& program_version,
                       const std::string& utc, const std::string& made_by) {
  SensorModel own = model;
  own.program_version = program_version;
  FitRows rows = rows_of(own);
  rows.fit.program_version = program_version;
  rows.fit.created_utc = utc;
  if (!made_by.empty()) {
    auto options = parse_json(rows.fit.options_json);
    options["made_by"] = made_by;
    rows.fit.options_json = json_line(options);
  }
  return store.add_fit(rows.fit, rows.taxels);
}

std::optional<db::FitRecord> standing_fit(const db::RunStore& store, std::int64_t run) {
  std::optional<db::FitRecord> elam = store.latest_fit(run, kElamFit), dynamic = store.latest_fit(run, kDynamicModel);
  if (elam && dynamic) return elam->fit > dynamic->fit ? elam : dynamic;
  if (elam || dynamic) return elam ? elam : dynamic;
  return store.latest_fit(run);
}

SensorModel load_fit(const db::RunStore& store, std::int64_t run) {
  const std::optional<db::FitRecord> record = standing_fit(store, run);
  if (!record)
    throw AnalysisError("TB-ANALYSIS-NO-FIT", fmt::format("run {} has no stored fit", run),
                        fmt::format("make one: tactbench fit {}", run));
  return load_fit(store, *record);
}

SensorModel load_fit(const db::RunStore& store, const db::FitRecord& record) {
  FitRows rows{record, store.fit_taxels(record.fit)};
  if (rows.taxels.empty() && record.model != kElamFit) {
    try {
      SensorModel fit = document_from_text(record.patterns_json, fmt::format("fit {} of {}", record.fit, store.path()));
      fit.run = record.run;
      fit.fit = record.fit;
      fit.all_sequences = false;
      return fit;
    } catch (const AnalysisError& error) {
      throw AnalysisError(
          Cause::kStored, "TB-MODEL-STORED", error.what(),
          fmt::format("fit the run again: tactbench fit {}; tactbench db check lists what else is damaged",
                      record.run));
    }
  }
  return model_from_rows(rows);
}

}  // namespace tactbench::analysis
