#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "analysis/json_fields.h"
#include "analysis/statistics/figures/rig_figures.h"
#include "bench/cli/rig/run.h"
#include "bench/cli/session.h"
#include "bench/common/overrides.h"
#include "bench/common/utc.h"
#include "bench/config/config_calibration.h"
#include "bench/guard/trip.h"
#include "bench/instruments/check.h"
#include "bench/nightly/subject_trend.h"
#include "bench/reporting/evaluation.h"

namespace tactbench::bench {

namespace {

struct DevicesOptions {
  std::vector<std::string> modbus, set;
  std::string operator_name;
};

BenchConfig bench_of(const DevicesOptions& options, const Session& session) {
  return read_bench(find_config(session.bench_file()), split_overrides(options.set).bench);
}

void scan(const DevicesOptions& options, const Session& session) {
  const std::vector<ScanEntry> entries = scan_devices(options.modbus);
  if (session.json) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const ScanEntry& entry : entries) {
      list.push_back({JSON_FIELDS(entry, kind, where, what)});
    }
    print_json("devices.scan", {{"devices", list}});
    return;
  }
  analysis::doc::Table table;
  for (const ScanEntry& entry : entries)
    table.rows.push_back({{one_line(entry.kind), one_line(entry.where), one_line(entry.what)}});
  if (!entries.empty()) print_table(std::move(table));
  if (options.modbus.empty()) tty::print("Modbus hosts are queried only when given: --modbus HOST[:PORT]\n");
}

void check(const DevicesOptions& options, Session& session) {
  const BenchConfig config = bench_of(options, session);
  Rig rig(config);
  for (const std::string& place : placeholders_of(config)) tty::print(stderr, "warning: not filled in: {}\n", place);
  const std::vector<DeviceCheck> checks = check_devices(rig, utc_now().substr(0, 10));
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  analysis::doc::Table table;
  for (const DeviceCheck& device : checks) {
    if (device.state == DeviceCheck::State::kAbsent || device.state == DeviceCheck::State::kWrong)
      session.code = ExitCode::kDevice;
    list.push_back({{"role", device.role},
                    {"state", to_string(device.state)},
                    JSON_FIELDS(device, found, reading, notes, remedy)});
    analysis::doc::Phrase text(one_line(device.found, kMaxTextLength));
    const auto add = [&](const std::string& line) {
      if (!line.empty()) text.add("\n" + one_line(line, kMaxTextLength));
    };
    add(device.reading);
    for (const std::string& note : device.notes)
      if (session.all || device.state != DeviceCheck::State::kOk || note.starts_with("WARNING")) add("- " + note);
    add(device.remedy.empty() ? "" : "to do: " + device.remedy);
    table.rows.push_back({{to_string(device.state), one_line(device.role), std::move(text)}});
  }
  if (session.json) return print_json("devices.check", {{"bench", config.id}, {"devices", list}});
  tty::print("bench '{}' ({})\n", config.id, config.file);
  print_table(std::move(table));
  if (!session.all) tty::print("fail-safe layers and certificates: --all\n");
}

// Talks to no instrument: a person has inspected the rig.
void reset(const DevicesOptions& options, const Session& session) {
  check_operator(options.operator_name);
  const BenchConfig config = bench_of(options, session);
  const TripFile file(config.id);
  const std::optional<Trip> trip = file.read();
  if (trip) file.reset(*trip, options.operator_name);
  if (session.json) {
    nlohmann::ordered_json json = {{"bench", config.id}, {"tripped", trip.has_value()}};
    if (trip) json.update({{"utc", trip->utc}, {"id", trip->id}, {"what", trip->what}, {"run", trip->run}});
    print_json("devices.reset", json);
  } else if (trip) {
    tty::print("bench '{}' tripped at {} ({}): {}\nreset by {}; logged in {}\n", config.id, trip->utc, trip->id,
               trip->what, options.operator_name, file.log_path());
  } else {
    tty::print("bench '{}' is not tripped\n", config.id);
  }
}

}  // namespace

void add_devices(CLI::App& app, Session& session) {
  auto options = std::make_shared<DevicesOptions>();
  CLI::App* verb =
      app.add_subcommand("devices", "the bench's instruments: scan, check, test, reset, calibrate-reference");
  verb->require_subcommand(1);
  CLI::App* scan_verb = verb->add_subcommand("scan", "list serial ports, HID devices, NI-DAQmx devices, Modbus hosts");
  scan_verb->add_option("--modbus", options->modbus, "HOST or HOST:PORT to query; may be repeated")->take_all();
  scan_verb->callback([options, &session] { scan(*options, session); });
  CLI::App* check_verb =
      verb->add_subcommand("check",
                           "open each instrument read-only, identify it, read zero\n"
                           "Exit code 3 when one is absent or wrong, 0 with the word warning for one "
                           "that is overdue for calibration.");
  check_verb->callback([options, &session] { check(*options, session); });
  CLI::App* reset_verb = verb->add_subcommand("reset", "show a trip that refuses runs, and remove it");
  reset_verb->add_option("--operator", options->operator_name, "name of the person who has inspected the rig; logged")
      ->required();
  reset_verb->callback([options, &session] { reset(*options, session); });
  for (CLI::App* each : {check_verb, reset_verb})
    each->add_option("--set", options->set, "override table.key=value of the bench file")->take_all();
  add_subverbs(*verb, session);
}

namespace {

struct RigCheckOptions {
  RunOptions run;
  std::vector<std::string> standard_recipes = {"production"};
  bool press = false;
};

// One run of the store that must have completed; its number.
std::int64_t run_of_check(const RigCheckOptions& options, const std::vector<std::string>& recipes,
                          const std::string& purpose, Session& session) {
  RunOptions own = options.run;
  own.recipes = recipes;
  own.purpose = purpose;
  return carry_out_run(own, session).run;
}

std::string judged_word(const SubjectTrend& followed) {
  if (std::ranges::none_of(followed.figures, [](const TrendFigure& figure) { return figure.chart.band.has_value(); }))
    return "no baseline";  // or one of fewer than three runs
  if (!outside_band_lines(followed).empty()) return "outside";
  return shift_lines(followed).empty() ? "within" : "shifted";
}

// The combined result of the two control charts: the check standard is a sensor used for nothing else.
std::string conclusion(const std::string& rig, const std::string& standard) {
  const bool rig_moved = rig == "outside" || rig == "shifted",
             standard_moved = standard == "outside" || standard == "shifted";
  if (rig == "no baseline" || standard == "no baseline")
    return fmt::format(
        "not judged: accept a baseline of at least {} checks (tactbench trend accept RUNS --reason --by)",
        analysis::kMinStartUpRuns);
  if (rig_moved && standard_moved)
    return "the rig changed, and with it the figures of the check standard: do not calibrate sensors on it";
  if (rig_moved)
    return "the rig changed, but the figures of the check standard did not: check the rig; earlier calibrations remain "
           "valid";
  if (standard_moved)
    return "the check standard changed on an unchanged rig: the standard itself changed, or the rig in a way that its "
           "figures do not show";
  return "rig and check standard are unchanged: a change of another sensor is due to that sensor";
}

struct CheckedSubject {
  std::string title;
  std::int64_t run = 0;
  SubjectTrend followed;
};

CheckedSubject checked(db::Models& store, const std::string& title, const std::string& subject, std::int64_t run,
                       const std::map<std::string, double>& figures) {
  store.replace_figures(run, subject, figures);
  return {title, run, trend_of_subject(store, subject)};
}

void show_checked(const CheckedSubject& subject) {
  tty::print("{}, run {} ({}): {}\n", subject.title, subject.run, subject.followed.subject,
             judged_word(subject.followed));
  analysis::doc::Table table{.columns = {{"figure"}, {"value", true}, {"baseline"}, {}}};
  for (const TrendFigure& figure : subject.followed.figures)
    table.rows.push_back(
        {{one_line(figure.name), fmt::format("{:.4g}", figure.values.back()),
          figure.chart.band ? fmt::format("{:.4g} to {:.4g}", figure.chart.band->low, figure.chart.band->high) : "",
          figure.missing   ? "MISSING"
          : figure.outside ? "OUTSIDE"
          : figure.shifted ? "shifted"
                           : ""}});
  print_table(std::move(table));
}

nlohmann::ordered_json checked_json(const CheckedSubject& subject) {
  nlohmann::ordered_json figures;
  for (const TrendFigure& figure : subject.followed.figures) figures[figure.name] = figure.values.back();
  return {{"what", subject.title},
          {"subject", subject.followed.subject},
          {"run", subject.run},
          {"state", judged_word(subject.followed)},
          {"figures", figures},
          {"outside", outside_band_lines(subject.followed)},
          {"shifted", shift_lines(subject.followed)}};
}

void check_rig(const RigCheckOptions& options, Session& session) {
  const std::int64_t steps = run_of_check(options, {"rig-check"}, "devices test: steps and holds", session);
  const std::int64_t standard =
      run_of_check(options, options.standard_recipes, "devices test: the check standard", session);
  std::int64_t pressed = 0;
  if (options.press) pressed = run_of_check(options, {"ring"}, "devices test: force and stage", session);
  db::RunStore store = db::RunStore::open(session.db);
  const analysis::StoredRun stepped = analysis::read_run(store, store.run(steps));
  const db::RunRecord& record = stepped.record;
  const std::string rig = fmt::format("rig/{}", record.bench_id);
  std::vector<CheckedSubject> subjects = {
      checked(store, "chamber", rig + "/chamber", steps, analysis::chamber_figures(stepped))};
  if (options.press)
    subjects.push_back(checked(store, "force and stage", rig + "/press", pressed,
                               analysis::press_figures(analysis::read_run(store, store.run(pressed)))));
  analysis::Runs runs(store);
  const analysis::SensorModel fit = fit_run(store, runs.dataset(standard));
  const std::string standard_subject =
      record_sensor_trend(store, runs.record(standard), fit, evaluate_runs(runs, fit, {}).front().evaluation);
  subjects.push_back({"check standard", standard, trend_of_subject(store, standard_subject)});
  std::string rig_word = judged_word(subjects.front().followed);
  if (options.press && rig_word == "within") rig_word = judged_word(subjects[1].followed);
  const std::string standard_word = judged_word(subjects.back().followed);
  const std::string said = conclusion(rig_word, standard_word);
  for (const std::string& word : {rig_word, standard_word}) {
    if (word == "outside") session.code = ExitCode::kCriterionFailed;
    if (word == "shifted" && session.code == ExitCode::kPass) session.code = ExitCode::kInconclusive;
  }
  if (session.json) {
    auto json = nlohmann::ordered_json::array();
    for (const CheckedSubject& subject : subjects) json.push_back(checked_json(subject));
    print_json("rig.check",
               {{"bench", record.bench_id}, {"origin", record.origin}, {"checks", json}, {"conclusion", said}});
    return;
  }
  if (record.origin == "simulated") tty::print("SIMULATED DATA\n");
  for (CheckedSubject& subject : subjects) {
    subject.followed = in_unit(std::move(subject.followed), session.unit());
    show_checked(subject);
  }
  tty::print("{}\n", said);
}

}  // namespace

void add_rig_check(CLI::App& devices, Session& session) {
  auto options = std::make_shared<RigCheckOptions>();
  CLI::App* verb = devices.add_subcommand(
      "test",
      "measure the rig itself and compare it with its baseline\n"
      "Steps and holds of the chamber, reference against feedback, and a check-standard sensor; with --press also the "
      "force sensor's zero and the stage's repeatability.");
  verb->add_option("--standard", options->run.sensor,
                   "serial number of the check standard: a sensor used only for these checks")
      ->required();
  session.profile.add_operator(*verb, options->run.operator_name);
  verb->add_option("--recipe", options->standard_recipes,
                   "recipe that characterizes the check standard; always the same")
      ->capture_default_str();
  verb->add_flag("--press", options->press, "also press the ring three times (asks to mount it)");
  verb->add_flag("--yes", options->run.assume_yes, "answer operator prompts with yes");
  verb->add_option("--set", options->run.set, "override table.key=value of the bench file, or recipe.key=value")
      ->take_all();
  verb->add_option("--seed", options->run.seeds.seed, "simulation: seed of noise and faults");
  verb->add_option("--sensor-seed", options->run.seeds.sensor_seed, "simulation: seed of the array");
  verb->callback([options, &session] {
    options->run.bench = session.bench_file();
    check_rig(*options, session);
  });
}

}  // namespace tactbench::bench
