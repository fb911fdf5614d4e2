// db migrate: the schema of the store's file. db prune: prune.cpp.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "bench/cli/session.h"
#include "db/run_store.h"

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
  CLI::App* group = app.add_subcommand("db", "migrate or prune the store's file");
  group->require_subcommand(1);
  CLI::App* migrate = group->add_subcommand("migrate", "bring an older store to this program's schema; keeps a backup");
  migrate->callback([&session] { migrate_db(session); });
  add_db_prune(*group, session);
}

}  // namespace tactbench::bench
