// Evaluations and models with given values, and a store of the runs that they judge.
#pragma once

#include <fmt/format.h>

#include <memory>
#include <string>
#include <vector>

#include "analysis/identify/stored/model_document.h"
#include "analysis/models/mpi.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/judgement.h"
#include "tests/bench/reporting/film_runs.h"

namespace tactbench::tests {

inline std::string film_limits_text(double mean_psi, const std::string& rule = "simple",
                                    const std::string& name = "a") {
  return fmt::format(
      "schema = 1\nname = \"{}\"\nrule = \"{}\"\nmean_compensation_error_psi = {}\nworst_taxel_error_psi = 60\n"
      "distance_of_mean_percent_fs = 100\nunfit_taxels = 1\n",
      name, rule, mean_psi);
}

inline analysis::Limits film_limits(double mean_psi, const std::string& rule = "simple",
                                    const std::string& name = "a") {
  return bench::parse_limits(film_limits_text(mean_psi, rule, name), "a.toml");
}

// One taxel of 0.0625 V/psi.
inline analysis::SensorModel film_line_model(double v_per_psi = 0.0625) {
  analysis::SensorModel model;
  model.model = "mpi";
  model.run = 1;
  model.origin = "simulated";
  model.sensor_serial = "S-1";
  model.input_unit = "psi";
  model.output_unit = "V";
  model.sequences = {"a"};
  model.rows = model.columns = 1;
  analysis::ModelTaxel& taxel = model.taxels.emplace_back();
  taxel.status = analysis::TaxelStatus::kFitted;
  taxel.fit.model =
      std::make_unique<analysis::MpiModel>(analysis::MpiParameters{v_per_psi, 0.0, 0.0, 0.0, 0.7}, 0.0, 60.0, 0.0);
  taxel.fit.j = 2.5;
  taxel.fit.mean_error = 0.02;
  taxel.fit.max_error = 0.06;
  taxel.fit.full_scale = 4.0;
  model.pressure_psi = {0.0, 15.0, 30.0, 45.0, 60.0};
  analysis::set_loop(taxel, model.pressure_psi);
  return model;
}

inline bench::NamedEvaluation film_evaluation(std::int64_t run, double mean_psi) {
  analysis::Evaluation evaluation;
  evaluation.run = run;
  evaluation.model_run = 1;
  evaluation.frames = 26;
  evaluation.worst_taxel = 0;
  evaluation.mean_error_psi = mean_psi;
  evaluation.worst_taxel_mean_error_psi = mean_psi + 1.0;
  evaluation.comp_distance_of_mean = 0.25;
  evaluation.levels.resize(1);
  return {fmt::format("run {}", run), evaluation};
}

// "run criterion value limit: verdict; "
inline std::string film_row_text(const std::vector<analysis::JudgedFigure>& rows) {
  std::string text;
  for (const analysis::JudgedFigure& row : rows)
    text += fmt::format("{} {} {:g} of {:g}: {}; ", row.run, to_string(row.criterion), row.value, row.limit,
                        to_string(row.verdict));
  return text;
}

// Of the mean error's rows.
inline std::string film_mean_text(const std::vector<analysis::JudgedFigure>& rows) {
  std::vector<analysis::JudgedFigure> mean;
  for (const analysis::JudgedFigure& row : rows)
    if (row.criterion == analysis::Criterion::kMeanError) mean.push_back(row);
  return film_row_text(mean);
}
inline std::string film_mean_text(const std::vector<db::VerdictRecord>& rows) {
  return film_mean_text(analysis::figures_of(rows));
}

class JudgedStore : public FilmStore {
 public:
  explicit JudgedStore(int runs) {
    for (int i = 0; i < runs; ++i) (void)add();
  }
  void declare_void(std::int64_t run) { store.void_run(run, "gauge closed", "me", "2026-03-02T00:00:00Z"); }
  std::int64_t keep(const analysis::SensorModel& model) {
    return analysis::store_fit(store, model, "1", "2026-03-01T02:00:00Z");
  }
  // One row of the mean error.
  void judge(std::int64_t run, std::int64_t fit, double value, const std::string& verdict,
             const std::string& limits = film_limits_text(1.0)) {
    db::VerdictRecord row;
    row.value = value;
    row.limit = 1.0;
    row.verdict = verdict;
    row.limits_toml = limits;
    row.limits_sha256 = db::sha256_hex(limits);
    store.replace_verdicts(run, fit, {row});
  }
  [[nodiscard]] analysis::Evidence evidence(const std::vector<bench::NamedEvaluation>& evaluations,
                                            bool void_too = false,
                                            const std::vector<analysis::InstrumentNote>& notes = {},
                                            const analysis::SensorModel& models = film_line_model()) const {
    analysis::Runs runs(store);
    return bench::gather_evidence(runs, models, evaluations, film_limits(1.0), void_too, notes);
  }
  // Rows, numbers, limits, and each of those that were lost.
  [[nodiscard]] std::string kept(const analysis::SensorModel& model, bool void_too = false) const {
    analysis::Runs runs(store);
    const bench::StoredVerdicts stored = bench::stored_verdicts(runs, model, void_too);
    std::string text = film_row_text(stored.figures) + "|";
    for (const std::int64_t run : stored.runs) text += fmt::format(" {}", run);
    text += "|" + (stored.limits_toml.empty() ? "" : bench::parse_limits(stored.limits_toml, "x").name);
    for (std::size_t i = 0; i < stored.lost.size(); ++i) text += "|lost";
    return text;
  }
};

}  // namespace tactbench::tests
