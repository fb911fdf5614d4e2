#include "db/schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "db/run_store.h"

namespace tactbench::db {

namespace {

// Several queries of one state of the file.
class Snapshot {
 public:
  explicit Snapshot(sqlite::Connection& connection) : connection_(connection), own_(!connection.in_transaction()) {
    if (own_) connection_.execute("BEGIN");
  }
  ~Snapshot() {
    try {
      if (own_ && connection_.in_transaction()) connection_.execute("ROLLBACK");
    } catch (const StoreError&) {  // nothing was changed
    }
  }
  Snapshot(const Snapshot&) = delete;
  Snapshot& operator=(const Snapshot&) = delete;

 private:
  sqlite::Connection& connection_;
  bool own_;
};

struct SchemaObject {
  std::string type, table, sql;
  bool operator==(const SchemaObject&) const = default;
};
using SchemaObjects = std::map<std::pair<std::string, std::string>, SchemaObject>;  // by name and kind

// Skips the tables of ANALYSE: they hold statistics, and only SQLite itself can make tables with such names.
SchemaObjects objects_of(sqlite::Connection& connection) {
  sqlite::Statement rows(connection,
                         "SELECT type, name, tbl_name, coalesce(sql, '') FROM main.sqlite_master "
                         "WHERE NOT (type = 'table' AND name GLOB 'sqlite_stat[134]') ORDER BY name, type");
  SchemaObjects objects;
  while (rows.step()) {
    SchemaObject object;
    std::string name;
    rows.read(object.type, name, object.table, object.sql);
    objects[{name, object.type}] = object;
  }
  return objects;
}

SchemaObjects objects_after(const Migrations& migrations) {
  sqlite::Connection fresh(":memory:", sqlite::Access::kReadWrite);
  for (const std::string& sql : migrations) fresh.execute(sql);
  return objects_of(fresh);
}

SchemaObjects objects_of_version(const Migrations& known, std::int64_t version) {
  static const SchemaObjects own = objects_after(own_migrations());  // asked for whenever a store is opened
  if (&known == &own_migrations() && version == kSchemaVersion) return own;
  return objects_after({known.begin(), known.begin() + std::min<std::int64_t>(version, std::ssize(known))});
}

[[noreturn]] void refuse_other_schema(const std::string& path, const std::string& difference) {
  throw StoreError("TB-STORE-OTHER-SCHEMA",
                   fmt::format("store {} is not of this program's schema: {}", path, difference),
                   "read it with the build of tactbench that wrote it (its runs state version and commit), or make its "
                   "runs again; where somebody changed the file, take your last snapshot");
}

}  // namespace

const Migrations& own_migrations() {
  static const Migrations own = {schema_1()};
  return own;
}

void check_version(sqlite::Connection& connection, const Migrations& known) {
  const Snapshot snapshot(connection);
  const std::int64_t version = connection.integer("PRAGMA user_version");
  if (version > std::ssize(known))
    refuse_other_schema(connection.path(),
                        fmt::format("it has schema {}, this program knows schemas up to {}", version, known.size()));
  const auto damaged = [&](const std::string& what) {
    throw StoreError("TB-STORE-OPEN", fmt::format("store {}: the file is damaged: {}", connection.path(), what),
                     kDamagedRemedy);
  };
  const std::int64_t pages = connection.integer("PRAGMA page_count");
  if (version < 0 || (version == 0 && connection.integer("SELECT count(*) FROM sqlite_master") > 0))
    damaged(fmt::format("its header names schema version {}, which no tactbench wrote", version));
  // With a log the count is the log's, and a file that was to become shorter may still have its old length.
  std::error_code unknown;
  const std::uintmax_t logged = std::filesystem::file_size(connection.path() + "-wal", unknown);
  if (!unknown && logged > 0) return;
  const std::uintmax_t bytes = std::filesystem::file_size(connection.path(), unknown);
  if (unknown || static_cast<std::int64_t>(bytes) <= pages * std::int64_t{kPageSize}) return;
  damaged(fmt::format("its header states {} pages, and it has {} bytes", pages, bytes));
}

ForeignObjects foreign_objects(sqlite::Connection& connection, const Migrations& known) {
  const Snapshot snapshot(connection);  // another process may migrate meanwhile
  const SchemaObjects ours = objects_of_version(known, connection.integer("PRAGMA user_version"));
  const SchemaObjects there = objects_of(connection);
  ForeignObjects found;
  for (const auto& [key, object] : ours) {
    const auto& [name, type] = key;
    const auto own = there.find(key);
    if (own == there.end())
      found.changed.push_back(fmt::format("{} '{}' is missing", type, name));
    else if (own->second != object)
      found.changed.push_back(fmt::format("{} '{}' is not as tactbench makes it", type, name));
  }
  for (const auto& [key, object] : there) {
    if (ours.contains(key)) continue;
    const auto& [name, type] = key;
    // A view in place of a table is more than an addition.
    const auto first = ours.lower_bound({name, ""});
    const bool disguised = first != ours.end() && first->first.first == name;
    (disguised ? found.changed : found.added)
        .push_back(fmt::format("{} '{}'{} is not of tactbench", type, name,
                               type == "trigger" || type == "index" ? fmt::format(" on '{}'", object.table) : ""));
  }
  return found;
}

void refuse_foreign(sqlite::Connection& connection, Additions additions, const Migrations& known) {
  const ForeignObjects found = foreign_objects(connection, known);
  const auto listed = [](std::vector<std::string> lines) {
    constexpr std::size_t kShown = 5;
    const std::size_t more = lines.size() - std::min(lines.size(), kShown);
    lines.resize(lines.size() - more);
    return fmt::format("{}{}", fmt::join(lines, "; "), more > 0 ? fmt::format("; and {} more", more) : "");
  };
  if (!found.changed.empty()) refuse_other_schema(connection.path(), listed(found.changed));
  if (additions == Additions::kTolerate || found.added.empty()) return;
  throw StoreError(
      "TB-STORE-FOREIGN", fmt::format("store {}: {}", connection.path(), listed(found.added)),
      "a store takes no tables, indexes, views or triggers of others: drop them, or take your last snapshot; keep your "
      "own in a file of yours that attaches a copy of the store (sqlite3 own.db \"ATTACH 'copy.db' AS runs\")");
}

void migrate(sqlite::Connection& connection, const Migrations& known) {
  const auto last = static_cast<std::int64_t>(known.size());
  if (connection.integer("PRAGMA user_version") == last) return;
  sqlite::Transaction transaction(connection);
  check_version(connection, known);  // another process may have migrated it meanwhile
  for (std::int64_t version = connection.integer("PRAGMA user_version"); version < last; ++version)
    connection.execute(known.at(static_cast<std::size_t>(version)));
  connection.execute(fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", kApplicationId, last));
  transaction.commit();
}

}  // namespace tactbench::db
