// db check, snapshot, migrate: integrity of the store's file, a copy of it, its schema. db prune: prune.cpp.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "bench/cli/session.h"
#include "db/run_store.h"

namespace tactbench::bench {

namespace {

void check_db(const std::string& file, Session& session) {
  const std::string path = file.empty() ? session.db : file;
  const db::RunStore store = db::RunStore::open_read_only(path);
  const std::vector<std::string> structure = store.check_structure();
  auto list = nlohmann::ordered_json::array();
  int sound = 0, differ = 0, open = 0, pruned = 0;
  if (!session.json) {
    for (const std::string& line : structure) tty::print("  file    {}\n", line);
  }
  for (const db::RunRecord& run : store.runs()) {
    const db::ContentCheck content = store.check_content(run.run);
    const std::vector<std::string> beside = store.check_seals(run.run);
    const bool ended = run.outcome != db::Outcome::kIncomplete, holds = content.holds() && beside.empty();
    ++(!holds ? differ : ended ? sound : open);
    pruned += content.pruned ? 1 : 0;
    list.push_back({{"run", run.run},
                    {"ended", ended},
                    {"holds", holds},
                    {"pruned", content.pruned.has_value()},
                    {"frames", content.frames},
                    {"difference", content.difference},
                    {"beside", beside}});
    if (session.json) continue;
    if (!content.holds()) tty::print("  run {:<4}{}\n", run.run, content.difference);
    for (const std::string& line : beside) tty::print("  run {:<4}{}\n", run.run, line);
  }
  const bool well = structure.empty() && differ == 0;
  if (!well) session.code = ExitCode::kStore;
  if (session.json) {
    print_json("db.check", {{"store", path}, {"holds", well}, {"structure", structure}, {"runs", list}});
    return;
  }
  tty::print("{}: structure {}; {}, {} not, {} not ended (no hash yet)\n", path,
             structure.empty() ? "sound" : "DAMAGED",
             analysis::counted(sound, "run as it was stored", "runs as they were stored"), differ, open);
  if (pruned > 0)
    tty::print("of {} the frames were removed by a rule (db prune): they were not checked\n",
               analysis::counted(pruned, "run"));
  if (!well)
    tty::print("keep a copy of the file and use the last snapshot; tactbench verify RUN shows more about a run\n");
}

void snapshot_db(const std::string& file, const Session& session) {
  const db::RunStore store = db::RunStore::open_read_only(session.db);
  store.snapshot(file);
  const auto bytes = std::filesystem::file_size(file);
  if (session.json) {
    print_json("db.snapshot", {{"store", session.db}, {"snapshot", file}, {"bytes", bytes}});
  } else {
    tty::print("{}: snapshot of {}, {} bytes\n", file, session.db, bytes);
  }
}

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
    tty::print("{}: its making was cut off; it is an empty store of schema {} now\n", session.db, db::kSchemaVersion);
  } else if (backup.empty()) {
    tty::print("{} already has this program's schema {}: nothing was done\n", session.db, before);
  } else {
    tty::print("{}: schema {} migrated to {}; the old store is kept in {}\n", session.db, before, db::kSchemaVersion,
               backup);
  }
}

}  // namespace

void add_db(CLI::App& app, Session& session) {
  CLI::App* group = app.add_subcommand("db", "check, copy, migrate or prune the store's file");
  group->require_subcommand(1);
  auto file = std::make_shared<std::string>();
  CLI::App* check = group->add_subcommand("check",
                                          "check the file's structure, every run's content hash, and the hashes of its "
                                          "fits, verdicts, approvals and voids (exit 5 on damage)");
  check->add_option("file", *file, "the store (default: --db)");
  add_common(*check, session);
  check->callback([file, &session] { check_db(*file, session); });
  CLI::App* snapshot = group->add_subcommand("snapshot", "copy the store into a new file, also while a run is written");
  snapshot->add_option("file", *file, "the copy; a file that exists is not overwritten")->required();
  add_common(*snapshot, session);
  snapshot->callback([file, &session] { snapshot_db(*file, session); });
  CLI::App* migrate = group->add_subcommand("migrate", "bring an older store to this program's schema; keeps a backup");
  add_common(*migrate, session);
  migrate->callback([&session] { migrate_db(session); });
  add_db_prune(*group, session);
}

}  // namespace tactbench::bench
