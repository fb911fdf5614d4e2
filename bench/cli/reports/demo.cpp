#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/statistics/conformity/overall_verdict.h"
#include "bench/cli/judgement_words.h"
#include "bench/cli/models/model_table.h"
#include "bench/cli/session.h"
#include "bench/common/output_file.h"
#include "bench/common/overrides.h"
#include "bench/common/utc.h"
#include "bench/config/config.h"
#include "bench/reporting/evaluation.h"
#include "bench/run/characterize.h"
#include "bench/run/control/locks.h"
#include "db/run_store.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

namespace {

struct DemoOptions {
  std::uint64_t seed = 1, sensor_seed = 1;
  std::string output;
  bool timing = false;
};

class Stopwatch {
 public:
  void lap(const std::string& stage) {
    const auto now = std::chrono::steady_clock::now();
    laps_.emplace_back(stage, std::chrono::duration<double>(now - last_).count());
    last_ = now;
  }
  [[nodiscard]] const std::vector<std::pair<std::string, double>>& laps() const { return laps_; }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
  std::vector<std::pair<std::string, double>> laps_;
};

// The four runs: what the models are made from, and three that they never saw.
struct DemoRun {
  std::string title;
  std::vector<std::string> set;
  std::uint64_t seed_offset;
};

const std::vector<DemoRun>& demo_runs() {
  static const std::vector<DemoRun> runs = {
      {"characterization", {}, 0},
      {"held-out run", {"recipe.repeats=1"}, 1},
      {"re-mounted", {"recipe.repeats=1", "simulation.mount_seed=1", "simulation.effects.remount_variation=0.03"}, 2},
      {"one month later, +5 °C",
       {"recipe.repeats=1", "simulation.temperature_c=28", "simulation.age_months=1",
        "simulation.effects.gain_drift_per_month=0.01", "simulation.effects.zero_drift_v_per_month=0.01"},
       3},
  };
  return runs;
}

std::int64_t carry_out(const DemoRun& demo, const DemoOptions& options, const db::SensorRecord& sensor,
                       db::RunStore& store, const Session& session) {
  const SplitOverrides overrides = split_overrides(demo.set);
  RunRequest request;
  request.bench = read_bench(find_config("simulated.toml"), overrides.bench,
                             {options.seed + demo.seed_offset, options.sensor_seed});
  for (const char* name : {"descending", "ascending"}) {
    request.recipes.push_back(sequences::read_recipe(find_recipe(name), overrides.recipe));
  }
  request.overrides = overrides.all;
  request.sensor = sensor;
  request.sensor_type = parse_sensor_type(sensor.type_toml, "sensor type");
  request.operator_name = "demo";
  request.purpose = "demo: " + demo.title;
  request.label = demo.title;
  Progress progress(Progress::mode_for(session.quiet));
  const RunResult result = characterize(request, store, progress);
  if (result.error) throw *result.error;
  if (!session.json) {
    tty::print("run {}: {}, {} frames, {}\n", result.run, demo.title, result.frames, result.safe_text);
  }
  return result.run;
}

// The last run is there to fail: who sees the demo should see that, too. Empty where it passes.
std::string on_purpose(const Judgement& judgement, std::int64_t drifted) {
  const std::vector<std::int64_t> deciding = analysis::deciding_runs(judgement.verdicts);
  if (analysis::overall_verdict(judgement.verdicts) != analysis::Verdict::kFail ||
      std::ranges::find(deciding, drifted) == deciding.end())
    return {};
  return fmt::format(
      "run {} fails on purpose: it is the same sensor a month later and 5 °C warmer, which models made before cannot "
      "know; table and report show how that comes to light. The demo went as it should: exit code 0",
      drifted);
}

void demo(const DemoOptions& options, Session& session) {
  if (!options.output.empty()) check_output(options.output, kPageFile, session.replace);
  Stopwatch watch;
  const BenchConfig bench = read_bench(find_config("simulated.toml"), {});
  db::RunStore store = open_for_running(session.db, bench);
  const SensorType type = read_sensor_type(find_config("sensor.toml"));
  const std::string serial = fmt::format("SIM-{:04}", options.sensor_seed);
  std::optional<db::SensorRecord> sensor = store.sensor(serial);
  if (!sensor) {
    sensor = db::SensorRecord{serial,
                              type.name,
                              type.text,
                              db::sha256_hex(type.text),
                              SimulationConfig().scanner_serial,
                              "simulated array of the demo",
                              utc_now()};
    store.add_sensor(*sensor);
  }
  std::vector<std::int64_t> numbers;
  std::vector<std::string> titles;
  for (const DemoRun& run : demo_runs()) {
    numbers.push_back(carry_out(run, options, *sensor, store, session));
    watch.lap(run.title);
    if (numbers.size() > 1) titles.push_back(run.title);
  }
  analysis::Runs runs(store);
  const analysis::ArrayFit fit = fit_run(store, runs.dataset(numbers.front()));
  watch.lap("identification");
  const std::vector<NamedEvaluation> evaluations =
      evaluate_runs(runs, fit, {numbers.begin() + 1, numbers.end()}, titles);
  watch.lap("compensation");
  // The other models on the mean taxel only, to keep the demo's time.
  const auto mean_taxel = [&](std::int64_t run) {
    return analysis::mean_taxel_of(analysis::histories_of(runs.dataset(run)));
  };
  const analysis::Histories fitted = mean_taxel(numbers[0]), held_out = mean_taxel(numbers[1]);
  const std::vector<ScoreTarget> targets = {{"the held-out run, mean taxel", &held_out, {}}};
  const auto names = analysis::model_names();
  const std::vector<ModelRow> models = model_rows({names.begin(), names.end()}, fitted, {}, {}, targets);
  watch.lap("other models, mean taxel");
  (void)follow_sensor(store, runs.record(numbers.front()), fit, evaluations.front().evaluation);
  const Judgement judgement = judge_and_store(store, runs, fit, evaluations, "limits.toml");
  std::string number;
  const std::string path =
      write_report(runs, fit, evaluations, judgement, options.output, &number, {}, session.replace);
  watch.lap("report");
  const std::string origin = runs.record(numbers.front()).origin;
  if (session.json) {
    nlohmann::ordered_json json = {{"origin", origin}, {"runs", numbers}, {"report", path}, {"report_number", number}};
    json["evaluations"] = nlohmann::ordered_json::array();
    for (const NamedEvaluation& named : evaluations) json["evaluations"].push_back(evaluation_json(named));
    json["models"] = nlohmann::ordered_json::array();
    for (const ModelRow& row : models) json["models"].push_back(model_row_json(row, targets));
    json["verdicts"] = verdicts_json(judgement.verdicts, origin);
    json["judgement"] = judgement_json(judgement, origin);
    json["on_purpose"] = on_purpose(judgement, numbers.back());
    for (const auto& [stage, seconds] : watch.laps()) json["timing_s"][stage] = seconds;
    print_json("demo", json);
    return;
  }
  tty::print(
      "\nSIMULATED DATA. Hysteresis of the mean taxel, raw: {:.1f} % FS max, {:.1f} % mean (paper: 25.3, 10.0)\n\n{}\n",
      100.0 * evaluations[0].evaluation.hysteresis_max_fs, 100.0 * evaluations[0].evaluation.hysteresis_mean_fs,
      figures_table(evaluations));
  tty::print("{}\n", scores_table(models, targets, "psi"));
  tty::print("verdicts on the runs that no model has seen:\n{}{}\n", verdict_table(judgement.verdicts, origin),
             judgement_text(judgement, origin));
  if (options.timing) {
    double total = 0.0;
    for (const auto& [stage, seconds] : watch.laps()) {
      tty::print("{:<26}{:>8.2f} s\n", stage, seconds);
      total += seconds;
    }
    tty::print("{:<26}{:>8.2f} s\n\n", "all", total);
  }
  tty::print("report {}: {}\n", number, path);
  if (const std::string text = on_purpose(judgement, numbers.back()); !text.empty()) tty::print("{}\n", text);
}

}  // namespace

void add_demo(CLI::App& app, Session& session) {
  auto options = std::make_shared<DemoOptions>();
  CLI::App* verb = app.add_subcommand(
      "demo", "the paper's whole characterization on the simulated rig, models, held-out runs, verdicts and report");
  verb->footer("Exit code 0 when it was carried out, whatever the verdict on its simulated sensor.");
  verb->add_option("--seed", options->seed, "noise")->capture_default_str();
  verb->add_option("--sensor-seed", options->sensor_seed, "makes the array")->capture_default_str();
  verb->add_option("-o,--output", options->output, "report file (default: reports/run-N.html beside the store)");
  add_replace(*verb, session);
  verb->add_flag("--timing", options->timing, "print the time of each stage");
  add_common(*verb, session);
  verb->callback([options, &session] { demo(*options, session); });
}

}  // namespace tactbench::bench
