#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/identify/elam/identify.h"
#include "analysis/identify/histories.h"
#include "analysis/identify/stored/fit_rows.h"
#include "analysis/json_io.h"

namespace tactbench::analysis {
namespace {

db::FitTaxelRecord to_record(const TaxelFit& taxel, int number) {
  db::FitTaxelRecord record;
  record.taxel = number;
  record.status = to_string(taxel.status);
  record.noise_v = taxel.noise_v;
  if (taxel.fit.model.ascending.x().empty()) return record;  // never came to a fit
  const ElamParameters& p = taxel.fit.model.parameters;
  record.parameters = {p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a};
  const auto up = taxel.fit.model.ascending.y(), down = taxel.fit.model.descending.y();
  record.ascending_v.assign(up.begin(), up.end());
  record.descending_v.assign(down.begin(), down.end());
  record.j_v2 = taxel.fit.j_v2;
  record.mean_error_v = taxel.fit.mean_error_v;
  record.max_error_v = taxel.fit.max_error_v;
  record.full_scale_v = taxel.fit.full_scale_v;
  record.at_bound = static_cast<int>(taxel.fit.at_bound);
  return record;
}

[[noreturn]] void malformed(std::int64_t run, const std::string& what) {
  throw AnalysisError(Cause::kStored, "TB-MODEL-STORED",
                      fmt::format("the stored fit of run {} cannot be read: {}", run, what),
                      fmt::format("fit the run again: tactbench fit {}", run));
}

TaxelFit from_record(const db::FitTaxelRecord& record, const std::vector<double>& grid, const ElamOptions& options,
                     std::int64_t run) {
  TaxelFit taxel;
  bool known = false;
  for (const TaxelStatus status :
       {TaxelStatus::kFitted, TaxelStatus::kDead, TaxelStatus::kStuck, TaxelStatus::kSaturated, TaxelStatus::kUnfit}) {
    if (record.status != to_string(status)) continue;
    taxel.status = status;
    known = true;
  }
  if (!known) malformed(run, fmt::format("taxel {} has the status \"{}\"", record.taxel, record.status));
  if (record.noise_v < 0.0) malformed(run, fmt::format("taxel {} has a noise of {} V", record.taxel, record.noise_v));
  taxel.noise_v = record.noise_v;
  if (record.parameters.empty() && taxel.status != TaxelStatus::kFitted) return taxel;
  if (record.parameters.size() != kElamParameterNames.size() || record.ascending_v.size() != grid.size() ||
      record.descending_v.size() != grid.size() || grid.size() < 2)
    malformed(run, fmt::format("taxel {} has {} and {} + {} knots on a grid of {}", record.taxel,
                               counted(record.parameters.size(), "parameter"), record.ascending_v.size(),
                               record.descending_v.size(), grid.size()));
  const std::vector<double>&up = record.ascending_v, &down = record.descending_v, &p = record.parameters;
  if (taxel.status == TaxelStatus::kFitted) {
    const auto finite = [](double value) { return std::isfinite(value); };
    if (!std::ranges::all_of(p, finite) || !finite(record.noise_v))
      malformed(run, fmt::format("taxel {} has a parameter or a noise that is no number", record.taxel));
    if (up.front() != down.front() || up.back() != down.back())
      malformed(run, fmt::format("the two patterns of taxel {} do not meet at their ends", record.taxel));
  }
  try {
    taxel.fit.model = {PatternCurve(grid, up, up.front(), up.back()),
                       PatternCurve(grid, down, down.front(), down.back()),
                       {p[0], p[1], p[2], p[3], p[4]},
                       options};
  } catch (const std::invalid_argument& error) {
    malformed(run, fmt::format("taxel {}: {}", record.taxel, error.what()));
  }
  taxel.fit.j_v2 = record.j_v2;
  taxel.fit.mean_error_v = record.mean_error_v;
  taxel.fit.max_error_v = record.max_error_v;
  taxel.fit.full_scale_v = record.full_scale_v;
  taxel.fit.at_bound = static_cast<unsigned>(record.at_bound);
  return taxel;
}

nlohmann::json summary_of(const ArrayFit& fit) {
  std::map<std::string, int> taxels;
  double j = 0.0, mean = 0.0, worst = 0.0;
  for (const TaxelFit& taxel : fit.taxels) {
    ++taxels[to_string(taxel.status)];
    if (taxel.status != TaxelStatus::kFitted) continue;
    j += taxel.fit.j_v2;
    mean += taxel.fit.mean_error_v;
    worst = std::max(worst, taxel.fit.max_error_v);
  }
  const int fitted = taxels["fitted"];
  return {{"j_v2", j}, {"mean_error_v", mean / std::max(fitted, 1)}, {"max_error_v", worst}, {"taxels", taxels}};
}

}  // namespace

FitRows rows_of(const ArrayFit& fit) {
  FitRows rows;
  db::FitRecord& record = rows.fit;
  record.run = fit.run;
  record.model = kElamFit;
  record.options_json = json_line(nlohmann::json{{"exact_outer", fit.mean_taxel.fit.model.options.exact_outer}});
  record.summary_json = json_line(summary_of(fit));
  record.patterns_json = json_line(nlohmann::json{{"rows", fit.rows},
                                                  {"columns", fit.columns},
                                                  {"pressure_psi", fit.pressure_psi},
                                                  {"full_scale_v", fit.full_scale_v},
                                                  {"falling", fit.falling},
                                                  {"origin", fit.origin},
                                                  {"sensor_serial", fit.sensor_serial},
                                                  {"scanner_serial", fit.scanner_serial}});
  rows.taxels.push_back(to_record(fit.mean_taxel, kMeanTaxel));
  for (std::size_t i = 0; i < fit.taxels.size(); ++i) {
    rows.taxels.push_back(to_record(fit.taxels[i], static_cast<int>(i)));
  }
  return rows;
}

std::int64_t store_fit(db::RunStore& store, const ArrayFit& fit, const std::string& program_version,
                       const std::string& utc, const std::string& made_by) {
  FitRows rows = rows_of(fit);
  rows.fit.program_version = program_version;
  rows.fit.created_utc = utc;
  if (!made_by.empty()) {
    auto options = parse_json(rows.fit.options_json);
    options["made_by"] = made_by;
    rows.fit.options_json = json_line(options);
  }
  return store.add_fit(rows.fit, rows.taxels);
}

ArrayFit load_fit(const db::RunStore& store, std::int64_t run) {
  const std::optional<db::FitRecord> record = store.latest_fit(run, kElamFit);
  if (!record)
    throw AnalysisError("TB-ANALYSIS-NO-FIT", fmt::format("run {} has no stored ELAM fit", run),
                        fmt::format("make one: tactbench fit {}", run));
  return load_fit(store, *record);
}

ArrayFit load_fit(const db::RunStore& store, const db::FitRecord& record) {
  const std::int64_t run = record.run;
  ArrayFit fit;
  ElamOptions options;
  fit.run = run;
  try {
    const auto patterns = parse_json(record.patterns_json);
    patterns.at("rows").get_to(fit.rows);
    patterns.at("columns").get_to(fit.columns);
    patterns.at("pressure_psi").get_to(fit.pressure_psi);
    patterns.at("full_scale_v").get_to(fit.full_scale_v);
    fit.falling = patterns.value("falling", false);  // fits of older versions: refused then
    patterns.at("origin").get_to(fit.origin);
    patterns.at("sensor_serial").get_to(fit.sensor_serial);
    patterns.at("scanner_serial").get_to(fit.scanner_serial);
    parse_json(record.options_json).at("exact_outer").get_to(options.exact_outer);
  } catch (const nlohmann::json::exception& error) {
    malformed(run, error.what());
  }
  const std::vector<db::FitTaxelRecord> taxels = store.fit_taxels(record.fit);
  if (fit.rows <= 0 || fit.columns <= 0) malformed(run, "it has no taxels");
  if (fit.pressure_psi.size() < 2) malformed(run, "its grid has no two pressures");
  // One row for each and the mean: so many are there, or memory for a number that is not true is not taken.
  if (static_cast<std::int64_t>(fit.rows) * fit.columns + 1 != static_cast<std::int64_t>(taxels.size()))
    malformed(run, fmt::format("a taxel is missing: {} for {} x {} and their mean", counted(taxels.size(), "row"),
                               fit.rows, fit.columns));
  const auto count = static_cast<std::size_t>(fit.rows) * static_cast<std::size_t>(fit.columns);
  fit.taxels.resize(count);
  std::vector<bool> seen(count + 1, false);  // the last: the mean taxel
  for (const db::FitTaxelRecord& taxel : taxels) {
    const bool mean = taxel.taxel == kMeanTaxel;
    if (!mean && (taxel.taxel < 0 || static_cast<std::size_t>(taxel.taxel) >= count))
      malformed(run, fmt::format("it holds a taxel {}", taxel.taxel));
    const std::size_t index = mean ? count : static_cast<std::size_t>(taxel.taxel);
    (mean ? fit.mean_taxel : fit.taxels[index]) = from_record(taxel, fit.pressure_psi, options, run);
    seen[index] = true;
  }
  if (std::ranges::find(seen, false) != seen.end()) malformed(run, "a taxel is missing");
  return fit;
}

}  // namespace tactbench::analysis
