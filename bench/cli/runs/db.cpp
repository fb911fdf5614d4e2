// `db migrate`, `db prune`, `runs merge`.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "analysis/counted.h"
#include "analysis/json_fields.h"
#include "bench/cli/night/nightly.h"
#include "bench/cli/session.h"
#include "bench/common/utc.h"
#include "bench/nightly/night_store.h"
#include "db/run_store.h"
#include "db/store_file.h"

namespace tactbench::bench {

namespace {

void migrate_db(const Session& session) {
  const int before = db::schema_version_of(session.db);
  std::string backup;
  if (before > 0 && before < db::kSchemaVersion) backup = db::backup_path(session.db, before);
  const db::RunStore store = db::RunStore::open(session.db);  // makes the backup first
  if (session.json) {
    print_json(
        "db.migrate",
        {{"store", session.db}, {"schema_before", before}, {"schema_now", db::kSchemaVersion}, {"backup", backup}});
  } else if (before == 0) {
    tty::print("{}: its creation was interrupted; it is now an empty store of schema {}\n", session.db,
               db::kSchemaVersion);
  } else if (backup.empty()) {
    tty::print("{} already has this program's schema {}: nothing was done\n", session.db, before);
  } else {
    tty::print("{}: schema {} migrated to {}; the old store is kept in {}\n", session.db, before, db::kSchemaVersion,
               backup);
  }
}

}  // namespace

void add_db(CLI::App& app, Session& session) {
  CLI::App* group = app.add_subcommand("db", "migrate or prune the store's file");
  group->require_subcommand(1);
  CLI::App* migrate =
      group->add_subcommand("migrate", "migrate an older store to this program's schema; keeps a backup");
  migrate->callback([&session] { migrate_db(session); });
  add_subverbs(*group, session);
}

// db prune: removes frames of old nights.

namespace {

struct PruneOptions {
  std::string keep;
  bool yes = false, shrink = false;
};

// The UTC time before which a night is old, from 30d, 8w, or 2026-01-31.
std::string begin_of_kept(const std::string& rule) {
  int count = 0;
  const char* const end = rule.data() + rule.size();
  const auto [after, fault] = std::from_chars(rule.data(), end, count);
  if (fault == std::errc() && after + 1 == end && (*after == 'd' || *after == 'w') && count >= 1 && count <= 36500)
    return utc_days_ago(*after == 'w' ? 7 * count : count);
  const std::string pattern = "dddd-dd-dd";
  bool date = rule.size() == pattern.size();
  for (std::size_t i = 0; date && i < pattern.size(); ++i)
    date = pattern[i] == 'd' ? rule[i] >= '0' && rule[i] <= '9' : rule[i] == '-';
  if (date) return rule;
  throw Error("TB-USAGE", fmt::format("'{}' does not say which nights to keep", rule), "--keep",
              "days or weeks back from now (30d, 8w), or the first day to keep (2026-01-31, UTC)");
}

struct Old {
  std::vector<std::int64_t> runs;                          // their frames go
  std::vector<std::pair<std::int64_t, std::string>> kept;  // and why
};

Old old_runs(const db::RunStore& store, const std::string& begin) {
  Old old;
  for (const db::RunRecord& run : store.runs()) {
    if (run.started_utc >= begin || std::ranges::find(run.tags, "nightly") == run.tags.end()) continue;
    if (store.pruned(run.run)) continue;
    const std::string why = store.why_not_pruned(run.run);
    if (why.empty())
      old.runs.push_back(run.run);
    else if (why != "without frames")
      old.kept.emplace_back(run.run, why);
  }
  return old;
}

void prune(const PruneOptions& options, const Session& session) {
  const std::string begin = begin_of_kept(options.keep);
  db::RunStore store = options.yes ? db::RunStore::open(session.db) : db::RunStore::open_read_only(session.db);
  Old old = old_runs(store, begin);
  std::int64_t frames = 0, bytes = 0;
  const std::string rule = fmt::format("nights before {} (--keep {})", begin, options.keep);
  std::erase_if(old.runs, [&](std::int64_t run) {
    if (!options.yes) {
      frames += store.frame_count(run);
      return false;
    }
    try {
      const db::PrunedRecord gone = store.prune_frames(run, rule, utc_now());
      frames += gone.frames;
      bytes += gone.bytes;
      return false;
    } catch (const db::StoreError& error) {  // changed since it was stored: damaged runs are not pruned
      if (error.id() != "TB-STORE-CONFLICT") throw;
      old.kept.emplace_back(run, error.what());
      return true;
    }
  });
  const auto before = std::filesystem::file_size(session.db);
  if (options.yes && options.shrink) store.shrink();
  const auto after = std::filesystem::file_size(session.db);
  if (session.json) {
    auto kept = nlohmann::ordered_json::array();
    for (const auto& [run, why] : old.kept) kept.push_back({{"run", run}, {"why", why}});
    return print_json("db.prune", {{"store", session.db},
                                   {"begin_of_kept", begin},
                                   {"done", options.yes},
                                   {"runs", old.runs},
                                   {"frames", frames},
                                   {"bytes", bytes},
                                   {"kept", kept},
                                   {"file_bytes_before", before},
                                   {"file_bytes", after}});
  }
  tty::print("{}: {} of {} {}; figures, hashes, models and verdicts are kept\n", rule,
             analysis::counted(frames, "frame"), analysis::counted(old.runs.size(), "run"),
             options.yes ? fmt::format("removed, {:.1f} MB of counts and traces", 1e-6 * static_cast<double>(bytes))
                         : "would go");
  for (const auto& [run, why] : old.kept) tty::print("  run {} stays whole: {}\n", run, one_line(why));
  if (!options.yes) {
    tty::print("nothing was changed: add --yes\n");
  } else if (options.shrink) {
    tty::print("{}: {:.1f} MB, before {:.1f} MB\n", session.db, 1e-6 * static_cast<double>(after),
               1e-6 * static_cast<double>(before));
  } else if (!old.runs.empty()) {
    tty::print("the file keeps its size for later runs; --shrink frees the space\n");
  }
}

}  // namespace

void add_db_prune(CLI::App& db, Session& session) {
  auto options = std::make_shared<PruneOptions>();
  CLI::App* verb = db.add_subcommand("prune", "remove the frames of nights older than a given age");
  verb->footer(
      "Figures, content hashes, models and verdicts are kept, and each run records when its frames were removed and by "
      "which rule. "
      "Never pruned: runs of hardware and imported ones, runs that are void, pinned (runs tag RUN pinned) or in an "
      "approved report, and runs on which a verdict is based together with one of these.");
  verb->add_option("--keep", options->keep,
                   "nights whose frames are kept: of the last days or weeks (30d, 8w), or from a day on (2026-01-31)")
      ->required()
      ->type_name("RULE");
  verb->add_flag("--yes", options->yes, "carry it out; without this only a list of what would be removed is printed");
  verb->add_flag("--shrink", options->shrink,
                 "free the unused space of the file afterwards; temporarily needs as much again, and no other program "
                 "may use the store");
  verb->callback([options, &session] {
    session.use_db_only_if_typed();
    prune(*options, session);
  });
}

namespace {

struct MergeOptions {
  std::vector<std::string> parts;
  NightFiles files;  // files of the last night
};

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

// Merges into session.db; prints the result and sets session.code as `nightly` does. Throws as merge_stores(), and
// Error TB-MERGE-NIGHT when files of a night are requested and the stores contain no night.
void merge_and_report(const MergeOptions& options, Session& session) {
  db::RunStore store = db::RunStore::open(session.db, db::Durability::kNormal);
  const MergedStores merged = merge_stores(options.parts, store);
  const bool files = !(options.files.html.empty() && options.files.junit.empty() && options.files.metrics.empty());
  if (files && merged.nights.empty())
    throw Error("TB-MERGE-NIGHT", "these stores contain no night, but files of a night were requested", session.db);
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

}  // namespace

void add_run_merge(CLI::App& runs, Session& session) {
  auto options = std::make_shared<MergeOptions>();
  CLI::App* verb = runs.add_subcommand("merge", "copy from several stores what this one (--db) does not have");
  verb->footer(
      "If these stores have all parts of a night (nightly --shard K/N), the result equals the night of one machine: "
      "the same run numbers, figures and comparisons. Merging again changes nothing. Exit codes as of nightly: 1 a "
      "scenario "
      "is red, 6 one moved.");
  verb->add_option("stores", options->parts, "the stores to read; they are not changed")->required()->take_all();
  add_night_files(*verb, options->files);
  add_replace(*verb, session);
  verb->callback([options, &session] {
    if (!session.typed("--db"))
      throw Error("TB-USAGE", "the store to merge into is not named", "--db",
                  "--db FILE; it is made if it does not exist");
    merge_and_report(*options, session);
  });
}

}  // namespace tactbench::bench
