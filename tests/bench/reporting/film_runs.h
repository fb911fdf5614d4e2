// Runs of a small pressure film written directly to a store: known volts at each level, in counts of 0.1 mV.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "analysis/identify/stored/model_document.h"
#include "analysis/models/mpi.h"
#include "bench/config/config.h"
#include "bench/reporting/evaluation.h"
#include "bench/reporting/judgement.h"
#include "db/run_store.h"
#include "tests/support/process.h"

namespace tactbench::tests {

// 0.03 V/psi and a bow; on the way down up to 0.36 V more.
inline double film_volts(double psi, bool up) {
  return 0.2 + 0.03 * psi + 0.0003 * psi * psi + (up ? 0.0 : 0.0004 * psi * (60.0 - psi));
}

// With an inner loop from 20 to 60 psi.
inline const std::vector<double> kFilmInnerLoop = {0.0,  10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 50.0, 40.0, 30.0, 20.0,
                                                   30.0, 40.0, 50.0, 60.0, 50.0, 40.0, 30.0, 20.0, 10.0, 0.0};

struct FilmRun {
  std::string sensor = "S-1", origin = "simulated", started_utc = "2026-03-01T00:00:00Z", purpose = {};
  std::vector<double> levels = {0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 50.0, 40.0, 30.0, 20.0, 10.0, 0.0};
  std::vector<double> dwells_s = {2.0, 2.0};   // of each repeat
  std::vector<std::string> sequences = {"a"};  // all of the same levels
  std::string recipe =
      "schema = 1\nname = \"a\"\nunit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 10\nrepeats = 2\ndwell_s = 2\n";
  std::vector<std::pair<std::string, std::string>> set = {};  // of the simulated bench
  std::string calibration = R"({"calibrated":"2026-01-01","due":"2027-01-01"})";
  std::vector<double> temperatures_c = {};
  std::vector<std::string> tags = {};
  bool bench_too = false;       // the simulated bench's file, whatever the origin
  std::string bench_toml = {};  // in its place
  int columns = 1;
  // In addition to film_volts(): of that repeat, level by level.
  std::function<double(int taxel, int repeat, double psi)> error_v = [](int, int, double) { return 0.0; };
};

class FilmStore {
 public:
  FilmStore() {
    for (const char* serial : {"S-1", "S-2"})
      store.add_sensor({serial, "synthetic", "", db::sha256_hex(""), "", "", ""});
  }
  std::int64_t add(const FilmRun& made = {}) {
    db::RunRecord run;
    run.uuid = db::new_uuid();
    run.origin = made.origin;
    run.state = "prepared";
    run.sensor_serial = made.sensor;
    run.purpose = made.purpose.empty() ? fmt::format("run {}", ++made_) : made.purpose;
    run.operator_name = "nightly";
    run.started_utc = made.started_utc;
    if (made.origin == "simulated" || made.bench_too) run.bench_toml = read_file(bench::find_config("simulated.toml"));
    if (!made.bench_toml.empty()) run.bench_toml = made.bench_toml;
    std::string set;
    for (const auto& [key, value] : made.set) {
      std::string quoted;
      for (const char c : value) quoted += c == '"' ? std::string("\\\"") : std::string(1, c);
      set += fmt::format(R"({}{{"key":"{}","value":"{}"}})", set.empty() ? "" : ",", key, quoted);
    }
    run.overrides_json = "[" + set + "]";
    const auto count = static_cast<int>(made.levels.size());
    for (std::size_t s = 0; s < made.sequences.size(); ++s)
      run.sequences.push_back(
          {static_cast<int>(s), made.sequences[s], made.recipe, "", static_cast<int>(made.dwells_s.size()), count});
    run.devices = {{"tactile scanner", "synthetic", "", "", made.origin, R"({"volts_per_count":0.0001})"},
                   {"pressure reference", "synthetic", "R-1", "", made.origin, made.calibration}};
    const std::int64_t number = store.begin_run(run);
    std::int64_t now_ns = 0;
    for (const double celsius : made.temperatures_c)
      store.append_event(number, {now_ns, "environment", "temperature_c", fmt::format("{}", celsius)});
    for (std::size_t s = 0; s < made.sequences.size(); ++s)
      for (std::size_t repeat = 0; repeat < made.dwells_s.size(); ++repeat)
        add_repeat(number, static_cast<int>(s), static_cast<int>(repeat), made, now_ns);
    store.set_tags(number, made.tags, {});
    store.end_run(number, db::Outcome::kCompleted, "", db::SafeState::kVerified, made.started_utc);
    return number;
  }
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path(name); }
  [[nodiscard]] const TemporaryFolder& folder() const { return folder_; }

 private:
  void add_repeat(std::int64_t run, int sequence, int repeat, const FilmRun& made, std::int64_t& now_ns) {
    db::BranchRecord branch;
    branch.sequence = sequence;
    branch.repeat = repeat;
    const std::int64_t number = store.begin_branch(run, branch);
    bool up = true;
    for (std::size_t i = 0; i < made.levels.size(); ++i) {
      const double psi = made.levels[i];
      if (i > 0) up = psi > made.levels[i - 1];
      const auto held_ns = static_cast<std::int64_t>(1e9 * made.dwells_s[static_cast<std::size_t>(repeat)]);
      now_ns += held_ns;
      db::FrameRecord frame;
      frame.branch = number;
      frame.ordinal = static_cast<int>(i);
      frame.rows = frame.scans = 1;
      frame.columns = made.columns;
      frame.setpoint_psi = frame.feedback_psi = frame.reference_psi = psi;
      frame.time_ns = now_ns;
      frame.since_command_ns = held_ns;
      for (int taxel = 0; taxel < made.columns; ++taxel)
        frame.counts.push_back(
            static_cast<std::uint16_t>(std::lround(1e4 * (film_volts(psi, up) + made.error_v(taxel, repeat, psi)))));
      store.append_frame(run, frame);
    }
  }
  TemporaryFolder folder_;
  int made_ = 0;

 public:
  db::RunStore store = db::RunStore::open(folder_.path("film.db"), db::Durability::kNormal);
};

// Evaluations and models with given values, and a store of the runs that they judge.

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
