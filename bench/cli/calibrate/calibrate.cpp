#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/stored/model_document.h"
#include "bench/cli/calibrate/calibration.h"

namespace tactbench::bench {

void add_calibrate(CLI::App& app, Session& session) {
  auto options = std::make_shared<CalibrateOptions>();
  ProfileOptions& profile = session.profile;
  CLI::App* verb = app.add_subcommand(
      "calibrate",
      "from a serial number to a verdict and a report\n"
      "Registers the sensor if it is new, measures it twice, the second time to judge by and to count its uncertainty, "
      "fits, judges, writes the report, and prints PASS, FAIL or INCONCLUSIVE.");
  verb->footer(
      "Exit code: 0 pass or conditional pass, 1 fail, 6 inconclusive or conditional fail; otherwise as of the stage "
      "that failed, which names the commands that continue.");
  verb->add_option("serial", options->serial, "the sensor's serial number")->required();
  profile.add_operator(*verb, options->operator_name);
  CLI::Option* recipe = profile
                            .add(*verb, "--recipe", ProfileKey::kRecipe, options->recipes,
                                 "recipes of the run that the models are made from: files or names of shipped ones")
                            ->take_all()
                            ->default_str("production");
  CLI::Option* held_out =
      verb->add_option("--held-out-recipe", options->held_out_recipes,
                       "recipes of the run that readings are judged on and their U is counted on, by kind of history")
          ->take_all()
          ->default_str("verification");
  verb->add_option("--minutes", options->minutes,
                   "of process time for both runs: the longest shipped form that fits, in place of recipes of your own")
      ->check(CLI::PositiveNumber)
      ->excludes(recipe)
      ->excludes(held_out);
  profile.add(*verb, "--limits", ProfileKey::kLimits, options->limits, "limits file that judges")
      ->capture_default_str();
  profile.add(*verb, "--lab", ProfileKey::kLab, options->lab,
              "laboratory file: facts for the report that no instrument knows");
  std::vector<std::string> models = {analysis::kDynamicModel};
  std::ranges::copy(analysis::model_names(), std::back_inserter(models));
  verb->add_option("--model", options->model,
                   "kind of model; elam is the paper's [dynamic; elam of what that does not take]")
      ->check(CLI::IsMember(models));
  verb->add_option("--type", options->type, "sensor type file, for a sensor that is new")->capture_default_str();
  verb->add_option("--run", options->run, "make the models from this completed run of the sensor, measure none")
      ->check(CLI::PositiveNumber);
  verb->add_option("--held-out", options->held_out, "judge on this completed run of the sensor, measure none")
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

}  // namespace tactbench::bench
