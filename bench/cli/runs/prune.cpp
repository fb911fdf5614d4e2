// db prune: removes frames of old nights.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "bench/cli/session.h"
#include "bench/common/utc.h"
#include "db/run_store.h"

namespace tactbench::bench {
namespace {

struct PruneOptions {
  std::string keep;
  bool yes = false, shrink = false;
};

// The UTC time before which a night is old: of 30d, 8w, or 2026-01-31.
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
  throw Error("TB-USAGE", fmt::format("'{}' names no nights to keep", rule), "--keep",
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
    } catch (const db::StoreError& error) {  // not as it was stored: damage is not tidied away
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
  tty::print("{}: {} of {} {}; figures, hashes, models and verdicts stay\n", rule, analysis::counted(frames, "frame"),
             analysis::counted(old.runs.size(), "run"),
             options.yes ? fmt::format("removed, {:.1f} MB of counts and traces", 1e-6 * static_cast<double>(bytes))
                         : "would go");
  for (const auto& [run, why] : old.kept) tty::print("  run {} stays whole: {}\n", run, one_line(why));
  if (!options.yes) {
    tty::print("nothing was changed: add --yes\n");
  } else if (options.shrink) {
    tty::print("{}: {:.1f} MB, before {:.1f} MB\n", session.db, 1e-6 * static_cast<double>(after),
               1e-6 * static_cast<double>(before));
  } else if (!old.runs.empty()) {
    tty::print("the file keeps its length, and later runs fill it; --shrink gives the space back\n");
  }
}

}  // namespace

void add_db_prune(CLI::App& db, Session& session) {
  auto options = std::make_shared<PruneOptions>();
  CLI::App* verb = db.add_subcommand("prune", "remove the frames of nights that are older than a rule");
  verb->footer(
      "Figures, content hashes, models and verdicts stay, and each run says when its frames went and by which rule. "
      "Never pruned: runs of hardware and imported ones, runs that are void, pinned (runs tag RUN pinned) or in an "
      "approved report, and runs on which a verdict rests together with one of these.");
  verb->add_option("--keep", options->keep,
                   "nights whose frames stay: of the last days or weeks (30d, 8w), or from a day on (2026-01-31)")
      ->required()
      ->type_name("RULE");
  verb->add_flag("--yes", options->yes, "do it; without, it is only said what would go");
  verb->add_flag(
      "--shrink", options->shrink,
      "give the file's free space back afterwards; needs as much again meanwhile, and no other program in the "
      "store");
  verb->callback([options, &session] {
    session.take_db_only_as_typed();
    prune(*options, session);
  });
}

}  // namespace tactbench::bench
