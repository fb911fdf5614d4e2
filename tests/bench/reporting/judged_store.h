// Evaluations and models that are known by hand, and a store of the runs that they judge.
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
inline std::string film_row_words(const std::vector<db::VerdictRecord>& rows) {
  std::string text;
  for (const db::VerdictRecord& row : rows)
    text += fmt::format("{} {} {:g} of {:g}: {}; ", row.run, row.criterion, row.value, row.limit, row.verdict);
  return text;
}

// Of the mean error's rows.
inline std::string film_mean_words(const std::vector<db::VerdictRecord>& rows) {
  std::vector<db::VerdictRecord> mean;
  for (const db::VerdictRecord& row : rows)
    if (row.criterion == "mean_compensation_error") mean.push_back(row);
  return film_row_words(mean);
}

// Of a judgement: "not judged" where it is none, and the run that each remark names.
inline std::string film_notes(const bench::Judgement& judgement) {
  std::string text = judgement.notes.not_judged.empty() ? "" : "not judged";
  for (const std::string& remark : judgement.notes.remarks)
    text += fmt::format(" {}", std::stoi(remark.substr(remark.find_first_of("0123456789"))));
  return text;
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
    row.criterion = "mean_compensation_error";
    row.scope = "array";
    row.value = value;
    row.limit = 1.0;
    row.unit = "psi";
    row.rule = "simple";
    row.verdict = verdict;
    row.limits_toml = limits;
    row.limits_sha256 = db::sha256_hex(limits);
    store.replace_verdicts(run, fit, {row});
  }
  [[nodiscard]] bench::Judgement judged(const std::vector<bench::NamedEvaluation>& evaluations,
                                        const analysis::Limits& limits, bool void_too = false,
                                        const bench::StoredJudgement& stored = {}) const {
    analysis::Runs runs(store);
    return bench::judge_runs(runs, film_line_model(), evaluations, limits, void_too, stored);
  }
  // Rows, numbers, limits, and each of those that were lost.
  [[nodiscard]] std::string kept(const analysis::SensorModel& model, bool void_too = false) const {
    analysis::Runs runs(store);
    const bench::StoredJudgement stored = bench::stored_judgement(runs, model, void_too);
    std::string text = film_row_words(stored.verdicts) + "|";
    for (const std::int64_t run : stored.runs) text += fmt::format(" {}", run);
    text += "|" + (stored.limits_toml.empty() ? "" : bench::parse_limits(stored.limits_toml, "x").name);
    for (std::size_t i = 0; i < stored.lost.size(); ++i) text += "|lost";
    return text;
  }
};

}  // namespace tactbench::tests
