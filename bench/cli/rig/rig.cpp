#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/statistics/figures/rig_figures.h"
#include "bench/cli/rig/run.h"
#include "bench/cli/session.h"
#include "bench/nightly/followed_units.h"
#include "bench/reporting/evaluation.h"

namespace tactbench::bench {
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

std::string judged_word(const Followed& followed) {
  if (std::ranges::none_of(followed.figures,
                           [](const FollowedFigure& figure) { return figure.chart.band.has_value(); }))
    return "no baseline";  // or one of fewer than three runs
  if (!outside_lines(followed).empty()) return "outside";
  return shift_lines(followed).empty() ? "within" : "shifted";
}

// The combined result of the two control charts: the check standard is a sensor used for nothing else.
std::string conclusion(const std::string& rig, const std::string& standard) {
  const bool rig_moved = rig == "outside" || rig == "shifted",
             standard_moved = standard == "outside" || standard == "shifted";
  if (rig == "no baseline" || standard == "no baseline")
    return fmt::format(
        "not judged: accept a baseline of at least {} checks (tactbench trend accept RUNS --reason --by)",
        analysis::kLeastStartUp);
  if (rig_moved && standard_moved)
    return "the rig changed, and the standard's figures with it: do not calibrate sensors on it";
  if (rig_moved)
    return "the rig changed, the standard's figures did not: check the rig; calibrations so far remain valid";
  if (standard_moved)
    return "the standard changed on an unchanged rig: the standard itself, or a change that the rig's own figures do "
           "not show";
  return "rig and standard are unchanged: a change of another sensor is its own";
}

struct CheckedSubject {
  std::string title;
  std::int64_t run = 0;
  Followed followed;
};

CheckedSubject checked(db::RunStore& store, const std::string& title, const std::string& subject, std::int64_t run,
                       const std::map<std::string, double>& figures) {
  store.replace_figures(run, subject, figures);
  return {title, run, follow_alone(store, subject)};
}

void show_checked(const CheckedSubject& subject) {
  tty::print("{}, run {} ({}): {}\n", subject.title, subject.run, subject.followed.subject,
             judged_word(subject.followed));
  analysis::doc::Table table{.columns = {{"figure"}, {"value", true}, {"baseline"}, {}}};
  for (const FollowedFigure& figure : subject.followed.figures)
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
  for (const FollowedFigure& figure : subject.followed.figures) figures[figure.name] = figure.values.back();
  return {{"what", subject.title},
          {"subject", subject.followed.subject},
          {"run", subject.run},
          {"state", judged_word(subject.followed)},
          {"figures", figures},
          {"outside", outside_lines(subject.followed)},
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
      follow_sensor(store, runs.record(standard), fit, evaluate_runs(runs, fit, {}).front().evaluation);
  subjects.push_back({"check standard", standard, follow_alone(store, standard_subject)});
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
  verb->add_option("--standard", options->run.sensor, "serial of the sensor that is used only for these checks")
      ->required();
  session.profile.add_operator(*verb, options->run.operator_name);
  verb->add_option("--recipe", options->standard_recipes, "that characterizes the standard; always the same")
      ->capture_default_str();
  verb->add_flag("--press", options->press, "also three presses of the ring (asks for it to be mounted)");
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
