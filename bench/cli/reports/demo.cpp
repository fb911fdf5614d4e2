#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_fields.h"
#include "bench/cli/judgement_output.h"
#include "bench/cli/rig/page.h"
#include "bench/cli/session.h"
#include "bench/common/output_file.h"
#include "bench/common/overrides.h"
#include "bench/common/stop_request.h"
#include "bench/common/utc.h"
#include "bench/config/config.h"
#include "bench/reporting/evaluation.h"
#include "bench/run/characterize.h"
#include "bench/run/control/locks.h"
#include "bench/run/recipe_check.h"
#include "db/run_store.h"
#include "sequences/recipe.h"

namespace tactbench::bench {

namespace doc = analysis::doc;

namespace {

struct DemoOptions {
  std::uint64_t seed = 1, sensor_seed = 1;
  std::string specimen = "paper", model = analysis::kDynamicModel, output;
  bool timing = false, page = false;
  double rate = 0.0;  // process seconds in a real one; 0: as fast as it goes
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

// The six runs: one from which the models are made, and five others. Two of them have other trajectories: a long one,
// which shows the errors, and short histories of several kinds, from which U of a reading is computed.
struct DemoRun {
  std::string title;
  std::vector<const char*> recipes;
  std::vector<std::string> set;
  std::uint64_t seed_offset;
};

const std::vector<DemoRun>& demo_runs() {
  static const std::vector<const char*> table_1 = {"descending", "ascending"};
  static const std::vector<DemoRun> runs = {
      {"characterization", table_1, {}, 0},
      {"same trajectory again", table_1, {"recipe.repeats=1"}, 1},
      {"random reversals", {"random-reversal"}, {}, 4},
      {"re-mounted",
       table_1,
       {"recipe.repeats=1", "simulation.mount_seed=1", "simulation.effects.remount_variation=0.03"},
       2},
      {"one month later, +5 °C",
       table_1,
       {"recipe.repeats=1", "simulation.temperature_c=28", "simulation.age_months=1",
        "simulation.effects.gain_drift_per_month=0.01", "simulation.effects.zero_drift_v_per_month=0.01"},
       3},
      {"verification", {"verification"}, {"recipe.dwell_s=2"}, 5},
  };
  return runs;
}

constexpr std::size_t kReversals = 2, kDrifted = 4;  // of these, random reversals and the month later

// Settings of the shipped bench that the demo changes.
std::vector<std::string> settings(const DemoOptions& options) {
  if (options.specimen == "paper") return {};  // as shipped
  return {"simulation.specimen=" + options.specimen};
}

std::int64_t carry_out(const DemoRun& demo, const DemoOptions& options, const db::SensorRecord& sensor,
                       db::RunStore& store, const Session& session) {
  std::vector<std::string> set = settings(options);
  set.insert(set.end(), demo.set.begin(), demo.set.end());
  const SplitOverrides overrides = split_overrides(set);
  RunRequest request;
  request.bench = read_bench(find_config("simulated.toml"), overrides.bench,
                             {options.seed + demo.seed_offset, options.sensor_seed});
  request.recipes = read_recipes({demo.recipes.begin(), demo.recipes.end()}, overrides.recipe);
  request.overrides = overrides.all;
  request.sensor = sensor;
  request.sensor_type = parse_sensor_type(sensor.type_toml, "sensor type");
  request.operator_name = "demo";
  request.purpose = "demo: " + demo.title;
  request.label = demo.title;
  request.attended = false;
  request.pace = options.rate;
  Progress progress(Progress::mode_for(session.quiet));
  const RunResult result = characterize(request, store, progress);
  if (result.error) throw *result.error;
  if (!session.json && !session.quiet) {
    const std::string safe = result.safe_text.in(session.unit());
    tty::print("run {}: {}, {} frames, {}\n", result.run, demo.title, result.frames, safe.substr(0, safe.find(" (")));
  }
  return result.run;
}

// The run of a month later is expected to fail; the demo explains it. Empty if it passes.
std::string on_purpose(const analysis::Judgement& judgement, std::int64_t drifted) {
  const std::vector<std::int64_t>& deciding = judgement.decided_by;
  if (judgement.overall != analysis::Verdict::kFail || std::ranges::find(deciding, drifted) == deciding.end())
    return {};
  return fmt::format("run {} is meant to fail: the same sensor a month later and 5 °C warmer, with the models of run 1",
                     drifted);
}

// Between two stages, so that nothing is left half-written.
void end_if_asked(const StopRequest& signals, std::int64_t run) {
  const int signal = signals.signal();
  if (signal == 0) return;
  throw Error("TB-DEMO-STOPPED",
              fmt::format("the demo was ended by {} before its report was written", signal_text(signal)),
              fmt::format("run {}", run))
      .by_signal(signal);
}

void demo(const DemoOptions& options, Session& session) {
  if (!options.output.empty()) check_output(options.output, kPageFile, session.replace);
  Stopwatch watch;
  const StopRequest signals;  // also between the runs
  const BenchConfig bench = read_bench(find_config("simulated.toml"), split_overrides(settings(options)).bench);
  db::RunStore store = open_for_running(session.db, bench);
  if (options.page) start_background_page(session.db, bench.id, "demo");
  const SensorType type = read_sensor_type(find_config("sensor.toml"));
  static constexpr std::array kInSerial = {"", "HARSH-", "FOAM-"};
  const auto kind = static_cast<std::size_t>(bench.simulation->plant.specimen.kind);
  const std::string serial = fmt::format("SIM-{}{:04}", kInSerial.at(kind), options.sensor_seed);
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
  const auto lap = [&](const std::string& stage) {
    watch.lap(stage);
    end_if_asked(signals, numbers.front());
  };
  analysis::Runs runs(store);
  const bool elam = options.model == analysis::kElamFit;
  const analysis::SensorModel fit =
      elam ? fit_run(store, runs.dataset(numbers.front())) : fit_run_dynamic(store, runs, numbers.front());
  lap("identification");
  const std::vector<NamedEvaluation> evaluations =
      evaluate_runs(runs, fit, {numbers.begin() + 1, numbers.end()}, titles);
  lap("compensation");
  const analysis::Dataset& fitted = runs.dataset(numbers.front());
  std::map<std::string, double> errors = {{options.model, evaluations[kReversals].evaluation.mean_error_psi}};
  const auto compare = [&](const std::string& name, const analysis::SensorModel& other) {
    errors[name] = analysis::evaluate(runs.dataset(numbers[kReversals]), other).mean_error_psi;
  };
  if (!elam) compare(analysis::kElamFit, analysis::fit_array(fitted));
  compare("monotone", analysis::fit_models_without_residuals("monotone", analysis::histories_of(fitted), {}, {}));
  lap("other models");
  record_fit_trend(store, fit, evaluations.front().evaluation);
  const JudgementRecord judged = judge_and_store(store, runs, fit, evaluations, "limits.toml");
  const analysis::Judgement& judgement = judged.judgement;
  std::string number;
  ReportExtras extras;
  extras.unit = session.page_unit();
  const std::string path =
      write_report(runs, fit, evaluations, judged, options.output, &number, extras, session.replace);
  watch.lap("report");
  const std::string origin = runs.record(numbers.front()).origin;
  if (session.json) {
    nlohmann::ordered_json json = {{"origin", origin},
                                   JSON_FIELDS(options, specimen, model),
                                   {"runs", numbers},
                                   {"report", path},
                                   {"report_number", number}};
    json["evaluations"] = nlohmann::ordered_json::array();
    for (const NamedEvaluation& named : evaluations) json["evaluations"].push_back(evaluation_json(named));
    json["mean_error_psi"] = errors;  // on the random reversals
    json["verdicts"] = verdicts_json(judgement.figures, origin);
    json["judgement"] = judgement_json(judgement, origin);
    json["on_purpose"] = on_purpose(judgement, numbers[kDrifted]);
    for (const auto& [stage, seconds] : watch.laps()) json["timing_s"][stage] = seconds;
    print_json("demo", json);
    return;
  }
  const std::string purpose = on_purpose(judgement, numbers[kDrifted]);
  doc::Document out;
  if (!session.quiet) {
    out = judgement_document(judgement, origin, session.unit(), session.all);
    std::string models;
    for (const auto& [name, psi] : errors)
      models += fmt::format("{}{} {}", models.empty() ? "" : ", ",
                            name == "monotone" ? "one curve without direction" : name, session.unit().fixed(psi, 2));
    out.add(figures_table(evaluations, judgement, session.unit()));
    out.add(doc::Paragraph{
        {fmt::format("{} taxels; hysteresis of their mean {:.1f} % FS at most, {:.1f} % on average (paper: 25.3, 10.0)",
                     fit.array().size(), 100.0 * evaluations[0].evaluation.hysteresis_max_fs,
                     100.0 * evaluations[0].evaluation.hysteresis_mean_fs)}});
    out.add(doc::Paragraph{{fmt::format("mean error on random reversals, {}: {}", session.unit().symbol(), models)}});
  } else {
    out.add(doc::Paragraph{{headline(judgement, origin, session.unit())}});
  }
  if (!purpose.empty()) out.add(doc::Paragraph{{purpose}});
  print_document(out, session.unit());
  if (options.timing) {
    double total = 0.0;
    doc::Table table{.columns = {{"stage"}, {"wall time", true}}};
    for (const auto& [stage, seconds] : watch.laps()) {
      table.rows.push_back({{stage, fmt::format("{:.2f} s", seconds)}});
      total += seconds;
    }
    table.rows.push_back({{"all", fmt::format("{:.2f} s", total)}});
    print_table(std::move(table));
  }
  tty::print("report {}: {}\n", number, path);
}

}  // namespace

void add_demo(CLI::App& app, Session& session) {
  auto options = std::make_shared<DemoOptions>();
  CLI::App* verb = app.add_subcommand("demo", "the paper's characterization on the simulated rig, with a report");
  verb->footer(
      "Exit code 0 when it completed, whatever the verdict on the simulated sensor; Ctrl-C once ends it (130).");
  verb->add_option("--seed", options->seed, "noise")->capture_default_str();
  verb->add_option("--sensor-seed", options->sensor_seed, "seed of the simulated array")->capture_default_str();
  verb->add_option("--specimen", options->specimen, "the paper's simulated sensor, a harsh one, or a foam")
      ->type_name("TEXT:{paper,harsh,foam}")
      ->capture_default_str();
  verb->add_option("--model", options->model, "kind of model; elam is the paper's")
      ->check(CLI::IsMember({analysis::kDynamicModel, analysis::kElamFit}))
      ->capture_default_str();
  verb->add_option("-o,--output", options->output, "report file (default: reports/run-N.html next to the store)");
  add_replace(*verb, session);
  verb->add_flag("--page", options->page,
                 "also start `tactbench page`, to watch: its address is printed; with --rate 150 it takes a minute");
  verb->add_option("--rate", options->rate, "limit of process seconds per real second (default: none)")
      ->check(CLI::Range(1.0, 1e6));
  verb->add_flag("--timing", options->timing, "print the time of each stage");
  add_all(*verb, session);
  verb->callback([options, &session] {
    session.use_db_only_if_typed();
    demo(*options, session);
  });
}

}  // namespace tactbench::bench
