// fleet slurm: a night in parts, as a job array of Slurm.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "bench/cli/fleet/fleet.h"
#include "bench/cli/night/nightly_options.h"
#include "bench/cli/runs/merge.h"
#include "bench/common/stop_request.h"
#include "bench/config/config.h"
#include "bench/fleet/slurm_array.h"

namespace tactbench::bench {
namespace {

struct SlurmVerb {
  std::vector<std::string> words;  // nightly SUITE ...
  std::string folder;              // empty: beside the store
  int shards = 0;
  bool no_submit = false;
  SlurmOptions slurm;
};

// The words after --, read as those of `nightly`. Prints its help where that is asked for.
NightlyOptions nightly_of(const std::vector<std::string>& words, Session& session) {
  NightlyOptions options;
  if (words.front() != "nightly")
    throw Error(ExitCode::kUsage, "TB-USAGE",
                fmt::format("'{}' is not carried out in parts under Slurm", words.front()), "fleet slurm",
                "tactbench fleet slurm --shards N -- nightly SUITE --db FILE ...");
  CLI::App night("the words of a night", "nightly");
  add_nightly_options(night, options, session);
  std::vector<std::string> backwards(words.rbegin(), words.rend() - 1);
  try {
    night.parse(backwards);
  } catch (const CLI::ParseError& error) {
    throw Error(ExitCode::kUsage, "TB-USAGE", fmt::format("after --: {}", error.what()), "fleet slurm",
                "see tactbench nightly --help");
  }
  options.keeps = night.count("--db") > 0;
  const auto refuse = [](const std::string& what, const std::string& remedy) {
    throw Error(ExitCode::kUsage, "TB-USAGE", what, "fleet slurm", remedy);
  };
  if (!options.keeps) refuse("the night is kept in a store, and none is named", "add --db FILE after nightly");
  if (!options.shard.empty()) refuse("--shard is given by fleet slurm itself", "leave it out");
  if (options.list || !options.stores.empty() || !options.result.empty() || options.stop_on_red)
    refuse("--list, --stores and --stop-on-red are of a night on one machine", "leave them out");
  return options;
}

ShardedNight sharded(const NightlyOptions& options, int shards) {
  ShardedNight night;
  night.suite = selected(read_suite(find_recipe(options.suite)), options.selection);
  night.selection_json = to_json(options.selection);
  night.shards = shards;
  night.jobs = options.jobs;
  night.words = {"nightly", options.suite,
                 "--jobs",  std::to_string(options.jobs),
                 "--limit", fmt::format("{}", options.limit_s),
                 "--seeds", std::to_string(options.selection.seeds)};
  if (!options.selection.only.empty()) night.words.insert(night.words.end(), {"--only", options.selection.only});
  if (options.selection.seed)
    night.words.insert(night.words.end(), {"--seed", std::to_string(*options.selection.seed)});
  return night;
}

void slurm(const SlurmVerb& verb, Session& session) {
  const NightlyOptions options = nightly_of(verb.words, session);
  const ShardedNight night = sharded(options, verb.shards);
  const std::size_t scenarios = night.suite.scenarios.size();
  if (scenarios < static_cast<std::size_t>(verb.shards))
    throw Error(ExitCode::kUsage, "TB-USAGE",
                fmt::format("{} cannot be done in {} parts", analysis::counted(scenarios, "scenario"), verb.shards),
                "--shards", fmt::format("at most {}", scenarios));
  const ShardFolder folder(verb.folder.empty() ? session.db + ".parts" : verb.folder, night);
  std::vector<std::string> stores;
  for (int shard = 1; shard <= verb.shards; ++shard) stores.push_back(folder.store_of(shard));
  if (verb.no_submit) {
    if (session.json)
      return print_json("fleet.slurm", {{"script", folder.script()}, {"shards", verb.shards}, {"stores", stores}});
    tty::print(
        "{}: one of {} parts of {}; for instance\n  parallel sh {} ::: $(seq {})\n  tactbench runs merge {} --db {}\n",
        folder.script(), verb.shards, analysis::counted(scenarios, "scenario"), folder.script(), verb.shards,
        (std::filesystem::path(folder.script()).parent_path() / "shard-*.db").string(), session.db);
    return;
  }
  const StopRequest signals;
  SlurmOptions how = verb.slurm;
  how.signals = &signals;
  const std::vector<int> failed = carry_out_under_slurm(folder, verb.shards, how, [&](const std::string& line) {
    if (!session.quiet) tty::print(stderr, "{}\n", one_line(line));
  });
  if (!failed.empty()) {
    std::vector<std::string> whys;
    for (const int shard : failed)
      whys.push_back(fmt::format("part {} ({}): {}", shard, folder.log_of(shard), folder.why_failed(shard)));
    throw Error(ExitCode::kInconclusive, "TB-FLEET-SHARDS",
                fmt::format("{} of {} failed; nothing was put together. {}", failed.size(),
                            analysis::counted(verb.shards, "part"), fmt::join(whys, ". ")),
                folder.script(), "mend the cause; the same command then carries out these parts alone");
  }
  merge_and_report({stores, options.files}, session);
  folder.set_merged();
}

}  // namespace

void add_fleet_slurm(CLI::App& fleet, Session& session) {
  auto verb = std::make_shared<SlurmVerb>();
  CLI::App* slurm_verb = fleet.add_subcommand(
      "slurm", "carry out a night in parts as a job array of Slurm, and put them together into one store");
  slurm_verb->footer(
      "Example: tactbench fleet slurm --shards 8 -- nightly nightly --seeds 20 --db night.db --html night.html\n"
      "Waits for the parts, submits failed ones again, then does as runs merge. Started again with the same words it "
      "goes on where it was: only what is missing is submitted. The parts' stores stay in the folder until the next "
      "night. Exit codes as of nightly; 6 also when parts failed.");
  slurm_verb->add_option("--shards", verb->shards, "number of parts; each should take a minute or more")
      ->required()
      ->check(CLI::Range(1, kMostShards));
  slurm_verb->add_option("--folder", verb->folder,
                         "of the parts' script, stores and logs; seen under this name by every node [the --db of the "
                         "night with .parts added]");
  slurm_verb->add_option("--at-once", verb->slurm.at_once, "parts at once, at most [as Slurm decides]")
      ->check(CLI::PositiveNumber);
  slurm_verb->add_option("--tries", verb->slurm.tries, "how often a part is submitted before it counts as failed")
      ->check(CLI::Range(1, 20))
      ->capture_default_str();
  slurm_verb->add_option("--sbatch", verb->slurm.sbatch, "an option for sbatch, e.g. --sbatch=--partition=long")
      ->allow_extra_args(false);
  slurm_verb->add_flag("--no-submit", verb->no_submit,
                       "write the script of a part and say how to use it without Slurm");
  slurm_verb->add_option("words", verb->words, "after --: nightly and its words, with --db FILE")->required();
  add_manner(*slurm_verb, session);
  slurm_verb->callback([verb, &session] { slurm(*verb, session); });
}

}  // namespace tactbench::bench
