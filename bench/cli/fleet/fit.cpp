// fleet fit: models anew for the sensors of a fleet that need them, each kept as the child of the fit it replaces.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/counted.h"
#include "analysis/error.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/stored/model_document.h"
#include "bench/cli/fleet/fleet.h"
#include "bench/cli/models/fit_models.h"
#include "bench/cli/runs/from_fleet.h"
#include "bench/common/build_info.h"
#include "bench/common/shard.h"
#include "db/fleet/find.h"
#include "db/fleet/push.h"

namespace tactbench::bench {

namespace {

namespace fleet = db::fleet;

struct FleetFitOptions {
  std::string to, model = "elam", origin = "hardware", where, shard;
  bool dry_run = false;
};

struct FleetRun {
  std::int64_t run = 0;
  std::string recipes;  // their names and hashes
};

struct FleetFit {
  std::int64_t run = 0;
  std::string model, sha256, program_version, recipes;
};

// What is to be done for a sensor, and why.
struct Task {
  std::string sensor;
  std::int64_t run = 0;            // to fit; 0: nothing is done
  std::optional<FleetFit> parent;  // of the same model
  std::string why;
};

constexpr const char* kRecipesOfRun =
    "coalesce((SELECT string_agg(q.name || ' ' || q.recipe_sha256, ',' ORDER BY q.sequence) FROM fleet.sequences q "
    "WHERE "
    "q.run = r.run), '')";

std::map<std::string, std::vector<FleetRun>> runs_of_sensors(fleet::Link& link, const FleetFitOptions& options) {
  const std::vector<std::int64_t> chosen = fleet::find_runs(link, options.origin, options.where);
  std::map<std::string, std::vector<FleetRun>> runs;
  for (const fleet::TextRow& row : link.query(
           fmt::format("SELECT r.sensor_serial, r.run, {} FROM fleet.every_run r WHERE r.run = ANY($1::bigint[]) AND "
                       "NOT r.void AND r.outcome = 'completed' AND r.frames > 0 AND r.sensor_serial IS NOT NULL "
                       "ORDER BY r.started_utc, r.run",
                       kRecipesOfRun),
           {fleet::number_array(chosen)}))
    runs[row[0]].push_back({std::stoll(row[1]), row[2]});
  return runs;
}

// By sensor, oldest first; of every row that a run has had.
std::map<std::string, std::vector<FleetFit>> fits_of_sensors(fleet::Link& link, const std::string& origin) {
  std::map<std::string, std::vector<FleetFit>> fits;
  for (const fleet::TextRow& row : link.query(
           fmt::format("SELECT r.sensor_serial, f.run, f.model, f.sha256, f.program_version, {} FROM fleet.fits f "
                       "JOIN fleet.runs r ON r.run = f.run WHERE r.origin = $1 AND r.sensor_serial IS NOT NULL "
                       "ORDER BY f.created_utc, f.fit",
                       kRecipesOfRun),
           {origin}))
    fits[row[0]].push_back({std::stoll(row[1]), row[2], row[3], row[4], row[5]});
  return fits;
}

Task task_of(const std::string& sensor, const std::vector<FleetRun>& runs, const std::vector<FleetFit>& fits,
             const std::string& model) {
  Task task{sensor, 0, {}, {}};
  for (const FleetFit& fit : fits)
    if (fit.model == model) task.parent = fit;
  if (fits.empty()) {
    task.why = "left out: it has no model yet, so that no run of it is known to be one for models";
    return task;
  }
  // A newer run of the same recipes takes the place of the run that was fitted.
  const FleetFit& known = task.parent ? *task.parent : fits.back();
  const auto newest =
      std::find_if(runs.rbegin(), runs.rend(), [&](const FleetRun& run) { return run.recipes == known.recipes; });
  if (newest == runs.rend()) {
    task.why = "left out: none of its runs that were chosen has the recipes of its models";
  } else if (!task.parent) {
    task.run = newest->run;
    task.why = fmt::format("it has no model {} yet", model);
  } else if (newest->run != known.run) {
    task.run = newest->run;
    task.why = fmt::format("run {} is newer than run {}, which was fitted", newest->run, known.run);
  } else if (known.program_version != build_info().version) {
    task.run = newest->run;
    task.why = fmt::format("its model is by version {}", known.program_version);
  } else {
    task.why = "up to date";
  }
  return task;
}

// The options of the parent; of a model that has none yet, the defaults.
analysis::IdentifyOptions options_like(fleet::Link& link, const std::optional<FleetFit>& parent) {
  if (!parent) return {};
  const std::vector<fleet::TextRow> rows =
      link.query("SELECT patterns_json FROM fleet.fits f WHERE f.run = $1 AND f.sha256 = $2",
                 {std::to_string(parent->run), parent->sha256});
  return analysis::document_from_text(rows.at(0)[0], "the parent's document").options;
}

class FleetFitting {
 public:
  FleetFitting(const FleetFitOptions& options, Session& session)
      : options_(options),
        session_(session),
        shard_(options.shard.empty() ? Shard{} : shard_from(options.shard)),
        from_(session, options.to) {}

  void run() {
    const auto runs = runs_of_sensors(from_.link(), options_);
    const auto fits = fits_of_sensors(from_.link(), options_.origin);
    for (const auto& [sensor, own] : runs) {
      if (!shard_.holds(std::string_view(sensor))) continue;
      const auto known = fits.find(sensor);
      const Task task =
          task_of(sensor, own, known == fits.end() ? std::vector<FleetFit>() : known->second, options_.model);
      if (task.run == 0)
        tell(task, task.why.starts_with("left out") ? &left_out_ : &up_to_date_, {});
      else if (options_.dry_run)
        tell(task, &made_, {});
      else
        fit(task);
    }
    print();
  }

 private:
  void fit(const Task& task) {
    try {
      from_.take({task.run}, fleet::Frames::kWith);
      FitModelsOptions fit;
      fit.source = std::to_string(task.run);
      fit.models = {options_.model};
      fit.identify = options_like(from_.link(), task.parent);
      const JudgedFit made = fit_and_judge(fit, session_);
      db::sqlite::Connection store(std::filesystem::absolute(session_.db).string(), db::sqlite::Access::kReadOnly);
      (void)fleet::add_fit(from_.link(), task.run, store, made.model.fit, task.parent ? task.parent->sha256 : "");
      tell(task, &made_,
           made.evaluations.empty() ? std::optional<double>() : made.evaluations.front().evaluation.mean_error_psi);
    } catch (const analysis::AnalysisError& error) {
      Task failed = task;
      failed.why = fmt::format("FAILED: {} [{}]", error.what(), error.id());
      session_.code = ExitCode::kInconclusive;
      tell(failed, &failed_, {});
    }
  }

  void tell(const Task& task, std::size_t* count, std::optional<double> error_psi) {
    ++*count;
    nlohmann::ordered_json json = {{"sensor", task.sensor},
                                   {"run", task.run},
                                   {"why", task.why},
                                   {"parent_sha256", task.parent ? task.parent->sha256 : ""}};
    if (error_psi) json["own_error_psi"] = *error_psi;
    sensors_.push_back(json);
    if (session_.json || (session_.quiet && count != &failed_)) return;
    if (count == &up_to_date_) return;
    const std::string parent = task.parent ? fmt::format(", child of {}", task.parent->sha256.substr(0, 12)) : "";
    tty::print("{}{}{}{}\n", cell(task.sensor, 20),
               count == &made_ ? fmt::format("run {}: {}; ", task.run, options_.model) : "", one_line(task.why),
               count == &made_
                   ? parent + (error_psi ? fmt::format("; {} on its own run", session_.unit().text(*error_psi, 3)) : "")
                   : "");
  }

  void print() const {
    if (session_.json) {
      print_json("fleet.fit", {{"fleet", from_.where()},
                               {"model", options_.model},
                               {"origin", options_.origin},
                               {"dry_run", options_.dry_run},
                               {"shard", shard_.text()},
                               {"fitted", made_},
                               {"up_to_date", up_to_date_},
                               {"left_out", left_out_},
                               {"failed", failed_},
                               {"sensors", sensors_}});
      return;
    }
    tty::print("{} runs: {} {}fitted, {} up to date, {} left out, {} failed\n", options_.origin,
               analysis::counted(made_, "sensor"), options_.dry_run ? "to be " : "", up_to_date_, left_out_, failed_);
  }

  const FleetFitOptions& options_;
  Session& session_;
  Shard shard_;
  FromFleet from_;
  nlohmann::ordered_json sensors_ = nlohmann::ordered_json::array();
  std::size_t made_ = 0, up_to_date_ = 0, left_out_ = 0, failed_ = 0;
};

void fit_fleet(const FleetFitOptions& options, Session& session) {
  const auto known = analysis::model_names();
  if (std::ranges::find(known, options.model) == known.end())
    throw Error(
        ExitCode::kUsage, "TB-USAGE", fmt::format("the fleet fits no model '{}'", options.model), "--model",
        options.model == analysis::kDynamicModel
            ? "which runs its lag and creep come from is a person's choice: tactbench fit on the bench, then push"
            : "elam, gpi, mpi, poly, preisach or monotone");
  FleetFitting(options, session).run();
}

}  // namespace

void add_fleet_fit(CLI::App& group, Session& session) {
  auto options = std::make_shared<FleetFitOptions>();
  CLI::App* verb = group.add_subcommand(
      "fit", "fit the sensors of the fleet whose runs changed or whose model is by another version of the program");
  add_fleet_option(*verb, "--to", options->to, session);
  verb->add_option("--model", options->model, "elam, gpi, mpi, poly, preisach or monotone")->capture_default_str();
  add_origin(*verb, options->origin);
  verb->add_option("--where", options->where,
                   "only runs that fulfil this condition in SQL over the columns of fleet.every_run: \"sensor_type = "
                   "'array-16'\"");
  verb->add_option(
      "--shard", options->shard,
      "K/N: the K-th of N parts of the sensors, chosen by their serials; the N parts may be carried out at "
      "the same time");
  verb->add_flag("--dry-run", options->dry_run, "say what would be fitted and why, and fit nothing");
  verb->footer(
      "A sensor is fitted on its newest completed run of the recipes that its model was made from, with the options of "
      "that "
      "model. The new fit is a row of its own that names the hash of the one it replaces; nothing is replaced in "
      "place.\n"
      "Exit codes: 0 all were fitted or are up to date, 6 one could not be fitted, 3 and 5 as for push.");
  add_units(*verb, session);
  verb->add_flag("--json", session.json, "one JSON document on standard output");
  verb->add_flag("-q,--quiet", session.quiet, "only results");
  verb->callback([options, &session] { fit_fleet(*options, session); });
}

}  // namespace tactbench::bench
