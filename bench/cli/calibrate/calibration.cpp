#include "bench/cli/calibrate/calibration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "analysis/counted.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/stored/model_document.h"
#include "analysis/json_fields.h"
#include "bench/cli/judgement_output.h"
#include "bench/cli/models/fit_models.h"
#include "bench/cli/reports/report.h"
#include "bench/cli/rig/run.h"
#include "bench/cli/runs/sensors.h"
#include "bench/cli/session.h"
#include "bench/common/overrides.h"
#include "bench/config/config_laboratory.h"
#include "bench/reporting/sensor_state.h"
#include "bench/run/recipe_check.h"
#include "bench/run/time_estimate.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace doc = analysis::doc;

namespace {

// Recipes for the models and for the held-out run, one pair per form; `minutes` chooses among these forms. Longest
// first.
struct CalibrationForm {
  std::vector<std::string> recipes, held_out_recipes;
};

using sequences::Recipe;

[[noreturn]] void refuse(const std::string& what, const std::string& where, const std::string& remedy) {
  throw Error("TB-USAGE", what, where, remedy);
}

// Quotes the text as one word for a shell.
std::string command_word(const std::string& text) {
  constexpr const char* kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./:=,+%@";
  if (!text.empty() && text.find_first_not_of(kPlain) == std::string::npos) return text;
  std::string quoted = "'";
  for (const char letter : text) quoted += letter == '\'' ? std::string("'\\''") : std::string(1, letter);
  return quoted + "'";
}

bool of_recipe(const std::string& setting) { return setting.starts_with("recipe."); }

using Letter = std::array<std::string_view, 5>;  // lines of equal length

const std::map<char, Letter>& letters() {
  static const std::map<char, Letter> all = {
      {'A', {" ### ", "#   #", "#####", "#   #", "#   #"}}, {'C', {" ####", "#    ", "#    ", "#    ", " ####"}},
      {'E', {"#####", "#    ", "#### ", "#    ", "#####"}}, {'F', {"#####", "#    ", "#### ", "#    ", "#    "}},
      {'I', {"###", " # ", " # ", " # ", "###"}},           {'L', {"#    ", "#    ", "#    ", "#    ", "#####"}},
      {'N', {"#   #", "##  #", "# # #", "#  ##", "#   #"}}, {'O', {" ### ", "#   #", "#   #", "#   #", " ### "}},
      {'P', {"#### ", "#   #", "#### ", "#    ", "#    "}}, {'S', {" ####", "#    ", " ### ", "    #", "#### "}},
      {'U', {"#   #", "#   #", "#   #", "#   #", " ### "}}, {'V', {"#   #", "#   #", "#   #", " # # ", "  #  "}}};
  return all;
}

// `word` in five lines of block letters, each line after `margin` and with a line end, without trailing blanks. Letters
// A C E F I L N O P S U V in either case; throws std::invalid_argument for any other.
std::string block_letters(const std::string& word, const std::string& margin) {
  std::string text;
  for (std::size_t row = 0; row < Letter().size(); ++row) {
    std::string line = margin;
    for (const char letter : word) {
      const auto found =
          letters().find(letter >= 'a' && letter <= 'z' ? static_cast<char>(letter - 'a' + 'A') : letter);
      if (found == letters().end()) throw std::invalid_argument("no large letter for '" + std::string(1, letter) + "'");
      if (line.size() > margin.size()) line += ' ';
      line += found->second.at(row);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
  }
  return text;
}

const std::vector<CalibrationForm>& calibration_forms() {
  static const std::vector<CalibrationForm> forms = {{{"production"}, {"verification"}},
                                                     {{"production-short"}, {"verification-short"}}};
  return forms;
}

std::string fit_line(const CalibrationResult& result) {
  const analysis::SensorModel& model = result.fit.model;
  const analysis::Evaluation& judged = result.fit.evaluations.back().evaluation;
  return fmt::format(
      "{} on run {}: {} of {} fitted; on run {} mean |error| {}, worst taxel {}", analysis::label_of(model), model.run,
      model.fitted().size(), analysis::counted(model.array().size(), "taxel"), judged.run,
      result.unit.text(judged.mean_error_psi, 2), result.unit.text(judged.worst_taxel_mean_error_psi, 2));
}

std::string place(const BadTaxel& taxel) {
  return fmt::format("row {}, column {} ({})", taxel.row, taxel.column, taxel.why);
}

std::string bad_taxels_text(const std::vector<BadTaxel>& taxels) {
  constexpr std::size_t kNamed = 12;
  if (taxels.empty()) return "none";
  std::vector<std::string> places;
  for (std::size_t i = 0; i < std::min(kNamed, taxels.size()); ++i) places.push_back(place(taxels[i]));
  return fmt::format("{}{}", fmt::join(places, "; "),
                     taxels.size() > kNamed ? fmt::format("; and {} more, in the report", taxels.size() - kNamed) : "");
}

doc::Document verdict_document(const CalibrationResult& result, const Session& session) {
  doc::Document out;
  out.add(judgement_document(result.judgement, result.origin, result.unit, session.all));
  if (session.quiet) out.blocks.resize(1);
  out.add(doc::Paragraph{
      {fmt::format("sensor {}, limits '{}', bad taxels: {}", one_line(result.sensor), one_line(result.limits),
                   bad_taxels_text(bad_taxels(result.fit, result.judgement, result.unit)))}});
  if (!result.drift.empty()) out.add(doc::Paragraph{{"drifted since its previous models: ", result.drift}});
  return out;
}

class Calibration {
 public:
  Calibration(const CalibrateOptions& options, Session& session)
      : options_(options), session_(session), form_{options.recipes, options.held_out_recipes} {}

  void carry_out() {
    check();
    print_stage(1, "sensor", sensor());
    with_resume_command([this] { print_stage(2, "measure", measured()); });
    with_resume_command([this] { print_stage(3, "held out", held_out()); });
    with_resume_command([this] { print_stage(4, "fit", fitted()); });
    with_resume_command([this] { print_stage(5, "report", reported()); });
    if (!result_.registered) {
      const SensorState found =
          sensor_state(db::RunStore::open_read_only(session_.db), result_.sensor, analysis::Laboratory());
      if (found.drift) result_.drift = drift_text(found);
    }
    if (session_.json) return print_json("calibrate", calibration_json(result_));
    if (const std::string word = verdict_banner(result_.judgement); !word.empty() && !session_.quiet)
      tty::print("\n{}\n", block_letters(word, "  "));
    print_document(verdict_document(result_, session_), result_.unit);
    if (session_.quiet) tty::print("report {}: {}\n", result_.report_number, result_.report_path);
  }

 private:
  void print_stage(int stage, const char* name, const std::string& text) const {
    if (session_.json || session_.quiet) return;
    analysis::doc::Table line;
    line.rows.push_back({{fmt::format("{}/5", stage), fmt::format("{:\u00A0<8}", name), text}});
    print_table(std::move(line));
    std::fflush(stdout);  // so that a log shows the stages immediately
  }

  // All checks that are possible before a device is touched.
  void check() {
    check_operator(options_.operator_name);
    (void)metadata_tags(options_.metadata);
    const SplitOverrides overrides = split_overrides(options_.set);
    bench_ = read_bench(find_config(options_.bench), overrides.bench, options_.seeds);
    if (options_.minutes > 0.0) choose_form(overrides.recipe);
    const std::vector<Recipe> recipes = checked_recipes(form_.recipes, overrides.recipe),
                              judging = checked_recipes(form_.held_out_recipes, {});
    const analysis::Limits limits = read_limits(find_config(options_.limits));
    if (!options_.lab.empty()) (void)read_laboratory(find_config(options_.lab));
    result_.limits = limits.name;
    result_.unit = session_.unit();
    report_only_ = limits.rule == analysis::DecisionRule::kReportOnly;
    if (options_.held_out != 0 && options_.run == 0)
      refuse("--held-out names a run to judge on, but --run names no run for the models", "--held-out",
             "add --run RUN");
    const bool exists = std::filesystem::exists(session_.db);
    if (options_.run != 0 || exists) {
      const db::RunStore store = db::RunStore::open_read_only(session_.db);
      sensor_ = store.sensor(options_.serial);
      if (options_.run != 0) check_run(store.run(options_.run), "--run");
      if (options_.held_out != 0) check_run(store.run(options_.held_out), "--held-out");
    }
    if (options_.held_out == 0 && !report_only_) check_judged(recipes, judging, limits);
    if (!sensor_ && bench_.origin == devices::Origin::kHardware && !std::filesystem::exists(options_.type))
      throw Error("TB-SENSOR-UNKNOWN",
                  fmt::format("sensor '{}' is new, and its sensor type file '{}' does not exist", options_.serial,
                              options_.type),
                  "--type " + options_.type, "name its sensor type file: --type FILE; or correct the serial number");
    print_total(recipes, judging, overrides.recipe);
  }

  [[nodiscard]] TimeBand time_of(const std::vector<Recipe>& recipes, const std::vector<sequences::Override>& overrides,
                                 bool learn = true) const {
    TimeEstimate time(recipes, sequences::compile(recipes), time_model(bench_));
    if (learn && std::filesystem::exists(session_.db))
      time.learn(db::RunStore::open_read_only(session_.db), bench_.id, overrides, false);
    return time.total();
  }

  // The longest shipped form that fits by the time model. Times of past runs are not used, so that the same options
  // always select the same form.
  void choose_form(const std::vector<sequences::Override>& overrides) {
    double least = 0.0;
    for (const CalibrationForm& form : calibration_forms()) {
      least = (time_of(checked_recipes(form.recipes, overrides), overrides, false).p50_s +
               time_of(checked_recipes(form.held_out_recipes, {}), {}, false).p50_s) /
              60.0;
      form_ = form;
      if (least <= options_.minutes) return;
    }
    throw Error("TB-CALIBRATE-MINUTES",
                fmt::format("no shipped version of the calibration takes {:g} minutes or less: the shortest, {} and "
                            "{}, takes about {:.0f}",
                            options_.minutes, fmt::join(form_.recipes, ", "), fmt::join(form_.held_out_recipes, ", "),
                            std::ceil(least)),
                "--minutes",
                fmt::format("--minutes {:.0f}; or your own recipes: --recipe, --held-out-recipe", std::ceil(least)));
  }

  void print_total(const std::vector<Recipe>& recipes, const std::vector<Recipe>& judging,
                   const std::vector<sequences::Override>& overrides) const {
    if (session_.json || session_.quiet || options_.held_out != 0) return;
    TimeBand total = time_of(judging, {});
    std::string what = fmt::format("{}", fmt::join(form_.held_out_recipes, ", "));
    if (options_.run == 0) {
      const TimeBand first = time_of(recipes, overrides);
      total = {total.p10_s + first.p10_s, total.p50_s + first.p50_s, total.p90_s + first.p90_s, 0, 0};
      what = fmt::format("{}; {}", fmt::join(form_.recipes, ", "), what);
    }
    tty::print("in all about {:.0f} min of {}process time ({:.0f} to {:.0f}): {}\n", total.p50_s / 60.0,
               bench_.origin == devices::Origin::kSimulated ? "simulated " : "", total.p10_s / 60.0, total.p90_s / 60.0,
               what);
  }

  [[nodiscard]] std::vector<Recipe> checked_recipes(const std::vector<std::string>& names,
                                                    const std::vector<sequences::Override>& overrides) const {
    std::vector<Recipe> recipes = read_recipes(names, overrides);
    check_recipes(recipes, bench_);
    if (needs_press(recipes))
      refuse(fmt::format("models cannot be made from recipes that press objects: {}", fmt::join(names, ", ")),
             "calibrate", "name recipes with loops of pressure, such as production or random-reversal");
    return recipes;
  }

  // Reports requirements whose verdict can only be inconclusive.
  void check_judged(const std::vector<Recipe>& recipes, const std::vector<Recipe>& judging,
                    const analysis::Limits& limits) const {
    const NotJudged open =
        not_judged(sequences::compile(judging), sequences::compile(recipes), limits, session_.unit());
    if (open.nothing)
      throw Error("TB-CALIBRATE-LEVELS",
                  fmt::format("no level and no [[mpe]] of limits '{}' can be judged on {}: {}", limits.name,
                              fmt::join(form_.held_out_recipes, ", "), fmt::join(open.why, "; ")),
                  "--held-out-recipe");
    if (open.why.empty()) return;
    tty::print(stderr,
               "warning: limits '{}' on {}: {}: no sensor can pass; name other limits or another "
               "--held-out-recipe (tactbench plan RECIPE --limits {} checks them)\n",
               limits.name, fmt::join(form_.held_out_recipes, ", "), fmt::join(open.why, "; "), options_.limits);
  }

  void check_run(const db::RunRecord& run, const char* option) const {
    if (run.sensor_serial != options_.serial)
      refuse(fmt::format("run {} belongs to sensor '{}', not to '{}'", run.run, run.sensor_serial, options_.serial),
             option, "name a run of this sensor: tactbench runs list --sensor " + options_.serial);
    if (run.outcome != db::Outcome::kCompleted)
      refuse(fmt::format("run {} did not complete: {}", run.run, db::to_string(run.outcome)), option,
             fmt::format("tactbench resume {} completes it; or name another run", run.run));
  }

  std::string sensor() {
    result_.sensor = options_.serial;
    result_.registered = !sensor_;
    if (!sensor_) sensor_ = register_sensor(session_.db, {options_.serial, options_.type, "", ""});
    return fmt::format("{} ({}) {} {}", one_line(sensor_->serial), one_line(sensor_->type),
                       result_.registered ? "is new, registered in" : "is registered in", session_.db);
  }

  std::string measured() {
    if (options_.run != 0) {
      result_.run = options_.run;
      return fmt::format("run {} is used unchanged", options_.run);
    }
    RunOptions run = run_options("measure", "calibrate: measured for the models");
    run.recipes = form_.recipes;
    run.set = options_.set;
    return carried_out(run, result_.run);
  }

  std::string held_out() {
    if (options_.held_out != 0) {
      result_.held_out = options_.held_out;
      return fmt::format("run {} is used unchanged", options_.held_out);
    }
    RunOptions run =
        run_options("held out", fmt::format("calibrate: held out, to judge the models of run {}", result_.run));
    run.recipes = form_.held_out_recipes;
    std::ranges::copy_if(options_.set, std::back_inserter(run.set), [](const std::string& s) { return !of_recipe(s); });
    if (bench_.simulation) run.seeds.seed = bench_.simulation->plant.seed + 1;  // other noise
    return carried_out(run, result_.held_out);
  }

  [[nodiscard]] RunOptions run_options(const char* label, std::string purpose) {
    RunOptions run;
    run.bench = options_.bench;
    run.sensor = options_.serial;
    run.operator_name = options_.operator_name;
    run.purpose = std::move(purpose);
    run.on_event = options_.on_event;
    run.assume_yes = options_.assume_yes;
    run.no_seating = options_.no_seating;
    run.seeds = options_.seeds;
    run.metadata = options_.metadata;
    run.label = label;
    run.on_begun = [this](std::int64_t number) { begun_ = number; };
    return run;
  }

  std::string carried_out(const RunOptions& run, std::int64_t& number) {
    const RunResult result = carry_out_run(run, session_);
    number = std::exchange(begun_, 0);
    return fmt::format("{}: {}", fmt::join(run.recipes, ", "), run_line(result, session_.unit()));
  }

  std::string fitted() {
    FitModelsOptions fit;
    fit.source = std::to_string(result_.run);
    if (!options_.model.empty()) fit.models = {options_.model};
    fit.held_out = {result_.held_out};
    fit.limits = options_.limits;
    fit.lab = options_.lab;
    result_.fit = fit_and_judge(fit, session_);
    result_.origin = result_.fit.model.origin;
    return fit_line(result_);
  }

  std::string reported() {
    ReportOptions report;
    report.runs = {result_.run};
    report.lab = options_.lab;
    if (report_only_) {  // which stores no verdict that the report could find
      report.held_out = {result_.held_out};
      report.limits = options_.limits;
    }
    WrittenReport written = write_reports(report, session_);
    result_.judgement = std::move(written.judgements.front());
    result_.report_number = written.report.number;
    result_.report_path = written.path;
    return fmt::format("{}: {}", written.report.number, written.path);
  }

  // Carries out a stage; adds the command to continue to its errors.
  template <class Work>
  void with_resume_command(const Work& work) {
    try {
      work();
    } catch (...) {
      const Error error = as_error(std::current_exception());
      const std::string way = resume_command(error);
      if (way.empty()) throw;
      std::string remedy = error.remedy();
      if (remedy.ends_with('.')) remedy.pop_back();
      remedy += (remedy.empty() ? "" : "; ") + way;
      throw error.with_remedy(remedy).with_rig_state(rig_state(error), true);
    }
  }

  // A stage after the runs touches no device, but the runs did.
  [[nodiscard]] std::string rig_state(const Error& error) const {
    const bool measured = (options_.run == 0 && result_.run != 0) || (options_.held_out == 0 && result_.held_out != 0);
    return error.rig_state().empty() && measured ? "each completed run ended in its proved safe state"
                                                 : error.rig_state();
  }

  [[nodiscard]] std::string resume_command(const Error& error) {
    // Bad seating, or a hopeless run, which is not worth completing.
    const bool measure_again = error.code() == ExitCode::kCriterionFailed;
    const bool resumed = begun_ != 0 && !measure_again;
    std::int64_t run = result_.run, held_out = result_.held_out;
    if (resumed) (run == 0 ? run : held_out) = begun_;
    if (run == 0 && begun_ == 0) return {};
    const std::string again = resume_command_line(options_, session_, run, held_out);
    return resumed ? fmt::format("to continue: tactbench resume {} --db {}, then {}", begun_, command_word(session_.db),
                                 again)
                   : "to continue: " + again;
  }

  const CalibrateOptions& options_;
  Session& session_;
  CalibrationForm form_;
  BenchConfig bench_;
  std::optional<db::SensorRecord> sensor_;
  bool report_only_ = false;
  std::int64_t begun_ = 0;  // a run in the store that did not complete
  CalibrationResult result_;
};

}  // namespace

std::string resume_command_line(const CalibrateOptions& options, Session& session, std::int64_t run,
                                std::int64_t held_out) {
  const CalibrateOptions standard;
  const OperatorProfile& profile = session.profile.values();
  std::string text = "tactbench calibrate " + command_word(options.serial);
  const auto add = [&](const char* option, const std::vector<std::string>& values,
                       const std::vector<std::string>& otherwise) {
    if (values == otherwise) return;
    for (const std::string& value : values) text += fmt::format(" {} {}", option, command_word(value));
  };
  const auto otherwise = [&](ProfileKey key, const std::vector<std::string>& built_in) {
    const auto given = profile.find(key);
    return given == profile.end() ? built_in : given->second.values;
  };
  add("--bench", {options.bench}, otherwise(ProfileKey::kBench, {}));
  add("--db", {session.db}, otherwise(ProfileKey::kDb, {Session().db}));
  add("--operator", {options.operator_name}, otherwise(ProfileKey::kOperator, {}));
  add("--recipe", options.recipes, otherwise(ProfileKey::kRecipe, standard.recipes));
  add("--held-out-recipe", options.held_out_recipes, standard.held_out_recipes);
  if (options.minutes > 0.0) text += fmt::format(" --minutes {:g}", options.minutes);
  add("--limits", {options.limits}, otherwise(ProfileKey::kLimits, {standard.limits}));
  add("--lab", {options.lab}, otherwise(ProfileKey::kLab, {standard.lab}));
  add("--model", {options.model}, {standard.model});
  add("--lot", {options.metadata.lot}, {""});
  add("--order", {options.metadata.order}, {""});
  add("--meta", options.metadata.pairs, {});
  add("--set", options.set, standard.set);
  if (options.seeds.seed) text += fmt::format(" --seed {}", *options.seeds.seed);
  if (options.seeds.sensor_seed) text += fmt::format(" --sensor-seed {}", *options.seeds.sensor_seed);
  if (run != 0) text += fmt::format(" --run {}", run);
  if (held_out != 0) text += fmt::format(" --held-out {}", held_out);
  return text;
}

void calibrate(const CalibrateOptions& options, Session& session) { Calibration(options, session).carry_out(); }

void add_calibrate(CLI::App& app, Session& session) {
  auto options = std::make_shared<CalibrateOptions>();
  ProfileOptions& profile = session.profile;
  CLI::App* verb = app.add_subcommand(
      "calibrate",
      "from a serial number to a verdict and a report\n"
      "Registers the sensor if it is new, measures it twice (the second run serves to judge and to compute the "
      "uncertainty), fits, judges, writes the report, and prints PASS, FAIL or INCONCLUSIVE.");
  verb->footer(
      "Exit code: 0 pass or conditional pass, 1 fail, 6 inconclusive or conditional fail; otherwise that of the failed "
      "stage, whose error names the commands to continue.");
  verb->add_option("serial", options->serial, "the sensor's serial number")->required();
  profile.add_operator(*verb, options->operator_name);
  CLI::Option* recipe = profile
                            .add(*verb, "--recipe", ProfileKey::kRecipe, options->recipes,
                                 "recipes of the run from which the models are made: files or names of shipped ones")
                            ->take_all()
                            ->default_str("production");
  CLI::Option* held_out =
      verb->add_option("--held-out-recipe", options->held_out_recipes,
                       "recipes of the run on which readings are judged and their U is computed, by kind of history")
          ->take_all()
          ->default_str("verification");
  verb->add_option(
          "--minutes", options->minutes,
          "process time of both runs: selects the longest shipped version that fits, instead of your own recipes")
      ->check(CLI::PositiveNumber)
      ->excludes(recipe)
      ->excludes(held_out);
  profile.add(*verb, "--limits", ProfileKey::kLimits, options->limits, "limits file to judge by")
      ->capture_default_str();
  profile.add(*verb, "--lab", ProfileKey::kLab, options->lab,
              "laboratory file: facts for the report that no instrument knows");
  std::vector<std::string> models = analysis::model_names();
  models.insert(models.begin(), analysis::kDynamicModel);
  verb->add_option("--model", options->model,
                   "kind of model; elam is the paper's [dynamic; elam for data that it does not accept]")
      ->check(CLI::IsMember(models));
  verb->add_option("--type", options->type, "sensor type file, for a new sensor")->capture_default_str();
  verb->add_option("--run", options->run, "make the models from this completed run of the sensor instead of measuring")
      ->check(CLI::PositiveNumber);
  verb->add_option("--held-out", options->held_out, "judge on this completed run of the sensor instead of measuring")
      ->check(CLI::PositiveNumber);
  add_metadata_options(*verb, options->metadata);
  verb->add_option("--set", options->set,
                   "override table.key=value of the bench file, or recipe.key=value of the recipes of --recipe")
      ->take_all();
  verb->add_option("--seed", options->seeds.seed,
                   "simulation: seed of noise and faults; the held-out run has the next");
  verb->add_option("--sensor-seed", options->seeds.sensor_seed, "simulation: seed of the array");
  verb->add_option("--on-event", options->on_event,
                   "shell command for the events done, failed, waiting of both runs (see run --help)");
  verb->add_flag("--yes", options->assume_yes, "answer operator prompts with yes");
  verb->add_flag("--no-seating", options->no_seating, "skip the seating check");
  add_all(*verb, session);
  for (const char* const name : {"--run", "--held-out", "--held-out-recipe", "--meta", "--on-event", "--no-seating"})
    verb->get_option(name)->group(kRareOptions);
  verb->callback([options, &session] {
    options->bench = session.bench_file();
    calibrate(*options, session);
  });
}

using analysis::Verdict;

std::vector<BadTaxel> bad_taxels(const JudgedFit& fit, const analysis::Judgement& judgement,
                                 analysis::PressureUnit unit) {
  std::vector<BadTaxel> bad;
  for (const LeftOut& taxel : left_out_of(fit.model)) bad.push_back({taxel.row, taxel.column, taxel.status});
  const bool worst_is_bad = std::ranges::any_of(judgement.figures, [](const analysis::JudgedFigure& row) {
    return row.criterion == analysis::Criterion::kWorstTaxelError &&
           (row.verdict == Verdict::kFail || row.verdict == Verdict::kConditionalFail);
  });
  const analysis::Evaluation& judged = fit.evaluations.back().evaluation;
  if (worst_is_bad && judged.worst_taxel >= 0)
    bad.push_back({judged.worst_taxel / fit.model.columns, judged.worst_taxel % fit.model.columns,
                   fmt::format("mean |error| {}, the largest", unit.text(judged.worst_taxel_mean_error_psi, 2))});
  return bad;
}

nlohmann::ordered_json calibration_json(const CalibrationResult& result) {
  const std::optional<Verdict> verdict = result.judgement.overall;
  auto bad = nlohmann::ordered_json::array(), evaluations = nlohmann::ordered_json::array();
  for (const BadTaxel& taxel : bad_taxels(result.fit, result.judgement))
    bad.push_back({JSON_FIELDS(taxel, row, column, why)});
  for (const NamedEvaluation& named : result.fit.evaluations) evaluations.push_back(evaluation_json(named));
  return {JSON_FIELDS(result, sensor, registered, origin, run, held_out),
          {"model", analysis::label_of(result.fit.model)},
          {"limits", result.limits},
          {"verdict", analysis::verdict_text(verdict)},
          {"shown", verdict ? shown_verdict(*verdict, result.origin) : std::string("no verdict")},
          {"statement", headline(result.judgement, result.origin, analysis::PressureUnit::kPsi)},
          {"bad_taxels", bad},
          {"drift", result.drift.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(result.drift)},
          {"evaluations", evaluations},
          {"verdicts", verdicts_json(result.judgement.figures, result.origin)},
          {"judgement", judgement_json(result.judgement, result.origin)},
          {"report", {{"number", result.report_number}, {"path", result.report_path}}}};
}

}  // namespace tactbench::bench
