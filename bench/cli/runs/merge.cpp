#include "bench/cli/runs/merge.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "bench/nightly/merge_stores.h"

namespace tactbench::bench {
namespace {

nlohmann::ordered_json merged_json(const MergedStores& merged, const MergeOptions& options, const Session& session) {
  auto nights = nlohmann::ordered_json::array();
  for (const MergedNight& night : merged.nights) {
    nlohmann::ordered_json own = {JSON_FIELDS(night.record, begun_utc, program), {"there", night.there}};
    own.update(night_json(night.suite, night.results));
    nights.push_back(own);
  }
  return {{"store", session.db},
          {"parts", options.parts},
          JSON_FIELDS(merged, runs, there, fits, baselines),
          {"nights", nights}};
}

}  // namespace

void merge_and_report(const MergeOptions& options, Session& session) {
  db::RunStore store = db::RunStore::open(session.db, db::Durability::kNormal);
  const MergedStores merged = merge_stores(options.parts, store);
  const bool files = !(options.files.html.empty() && options.files.junit.empty() && options.files.metrics.empty());
  if (files && merged.nights.empty())
    throw Error("TB-MERGE-NIGHT", "these stores brought no night, and files of one were asked for", session.db);
  for (const MergedNight& night : merged.nights) {
    session.code = std::max(session.code, code_of_night(night.suite, night.results), [](ExitCode a, ExitCode b) {
      const auto rank = [](ExitCode code) {
        return code == ExitCode::kCriterionFailed ? 2 : code == ExitCode::kInconclusive ? 1 : 0;
      };
      return rank(a) < rank(b);
    });
  }
  if (files) {
    const MergedNight& night = merged.nights.back();
    write_night_lists(options.files, night.suite, night.results, session);
    write_night_page(options.files, night.suite,
                     {night.record.begun_utc, night.record.program, night.results, night.followed}, session);
  }
  if (session.json) return print_json("runs.merge", merged_json(merged, options, session));
  std::size_t taken = 0;
  for (const MergedNight& night : merged.nights) {
    if (night.there) continue;
    ++taken;
    tty::print("SIMULATED DATA. night of {}, {}: {}\n", night.record.begun_utc, one_line(night.record.suite),
               analysis::counted(night.suite.scenarios.size(), "scenario"));
    print_night(night.suite, night.results);
  }
  const auto more = [](std::size_t count, const char* what) {
    return count == 0 ? std::string() : fmt::format(", {}", analysis::counted(count, what));
  };
  tty::print("{}: {} taken from {}{}{}{}{}\n", session.db, analysis::counted(merged.runs, "run"),
             analysis::counted(options.parts.size(), "store"), more(taken, "night"), more(merged.baselines, "baseline"),
             more(merged.fits, "fit"), merged.there == 0 ? "" : fmt::format("; {} there already", merged.there));
}

void add_run_merge(CLI::App& runs, Session& session) {
  auto options = std::make_shared<MergeOptions>();
  CLI::App* verb = runs.add_subcommand("merge", "take from several stores what this one (--db) does not have");
  verb->footer(
      "A night of which these stores hold all parts (nightly --shard K/N) becomes the night of one machine: the same "
      "numbers of runs, figures and comparisons. Merging again changes nothing. Exit codes as of nightly: 1 a scenario "
      "is red, 6 one moved.");
  verb->add_option("stores", options->parts, "the stores, which stay as they are")->required()->take_all();
  add_night_files(*verb, options->files);
  add_replace(*verb, session);
  verb->callback([options, &session] {
    if (!session.typed("--db"))
      throw Error("TB-USAGE", "the store that they are taken into is not named", "--db",
                  "--db FILE; it is made if it does not exist");
    merge_and_report(*options, session);
  });
}

}  // namespace tactbench::bench
