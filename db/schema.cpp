#include "db/schema.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <tuple>

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

std::string digest_of(const SchemaObjects& objects) {
  std::string text;
  for (const auto& [key, object] : objects) {
    text += fmt::format("{}\n{}\n{}\n{}\n", object.type, key.first, object.table, object.sql);
  }
  return sha256_hex(text);
}

// digest_of() of each version, so that opening a store does not have to build a new schema in memory for comparison. If
// another version of SQLite writes the schema differently, the digests differ and one is built.
constexpr std::array<const char*, kSchemaVersion> kDigests = {
    "a06648b6bba521633f66580e42b22891042467e9b60edd5ed332d8573d0004aa",
    "30affbd5674cd25c8a90f43d34e2b841984dba5bcef582d9f7d8679bb7c05386",
    "f5e66b6349b14ff207393cb9ee1bbe0c34acfe085e02bdd67efae2baa003ebc2",
    "2b0b58f473e211b346661481a66b9ce3307bf22205cbcfca48fa7f1d613602be",
    "364cd20677978bd4791495b7cc36d08e8afd83e42db6288b57aaa7c8f58b27cd",
    "0ae9543947df6c6bbfcc9587e16920d50e197d455eddf58f45a0f060b7045a58",
    "b5ebb170ea73d03e9e8868299462a8a09cb289f9001925073a85ab4b899bfc90",
    "fc121268db46cb24f52699047bb2fbb899c2bdee85ef94b5d71e6d9b9f4bc0aa",
    "2de82b4a25763327c25c5aab7e168173986d6fed88ec9f265706cce6fc4d5ddf"};

SchemaObjects fresh_objects(std::int64_t version) {
  sqlite::Connection fresh(":memory:", sqlite::Access::kReadWrite);
  for (std::int64_t reached = 0; reached < version; ++reached) fresh.execute(migration(reached));
  return objects_of(fresh);
}

}  // namespace

void check_version(sqlite::Connection& connection) {
  const Snapshot snapshot(connection);
  const std::int64_t version = connection.integer("PRAGMA user_version");
  if (version > kSchemaVersion) {
    throw StoreError("TB-STORE-NEWER",
                     fmt::format("store {} has schema version {}, this program knows versions up to {}",
                                 connection.path(), version, kSchemaVersion),
                     "use the newer tactbench that wrote it; a store is not taken back to an older version");
  }
  const auto damaged = [&](const std::string& what) {
    throw StoreError("TB-STORE-OPEN", fmt::format("store {}: the file is damaged: {}", connection.path(), what),
                     kDamagedRemedy);
  };
  const std::int64_t pages = connection.integer("PRAGMA page_count");
  if (version < 0 || (version == 0 && connection.integer("SELECT count(*) FROM sqlite_master") > 0))
    damaged(fmt::format("its header names schema version {}, which no tactbench wrote", version));
  std::error_code unknown;
  const std::uintmax_t bytes = std::filesystem::file_size(connection.path(), unknown);
  if (unknown || static_cast<std::int64_t>(bytes) <= pages * std::int64_t{kPageSize}) return;
  damaged(fmt::format("its header states {} pages, and it has {} bytes", pages, bytes));
}

ForeignObjects foreign_objects(sqlite::Connection& connection) {
  const Snapshot snapshot(connection);  // another process may migrate meanwhile
  const std::int64_t version = connection.integer("PRAGMA user_version");
  const SchemaObjects there = objects_of(connection);
  ForeignObjects found;
  if (version >= 1 && version <= kSchemaVersion &&
      digest_of(there) == kDigests.at(static_cast<std::size_t>(version - 1)))
    return found;
  const SchemaObjects ours = fresh_objects(version);
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

void refuse_foreign(sqlite::Connection& connection, Foreign refused) {
  ForeignObjects found = foreign_objects(connection);
  std::vector<std::string> lines = std::move(found.changed);
  if (refused == Foreign::kRefuseAll) lines.insert(lines.end(), found.added.begin(), found.added.end());
  if (lines.empty()) return;
  constexpr std::size_t kShown = 5;
  const std::size_t more = lines.size() - std::min(lines.size(), kShown);
  lines.resize(lines.size() - more);
  throw StoreError(
      "TB-STORE-FOREIGN",
      fmt::format("store {}: {}{}", connection.path(), fmt::join(lines, "; "),
                  more > 0 ? fmt::format("; and {} more", more) : ""),
      "a store takes no tables, indexes, views or triggers of others: drop them, or take your last snapshot; keep your "
      "own in a file of yours that attaches a copy of the store (sqlite3 own.db \"ATTACH 'copy.db' AS runs\")");
}

void migrate(sqlite::Connection& connection) {
  if (connection.integer("PRAGMA user_version") == kSchemaVersion) return;
  sqlite::Transaction transaction(connection);
  check_version(connection);  // another process may have migrated it meanwhile
  for (std::int64_t version = connection.integer("PRAGMA user_version"); version < kSchemaVersion; ++version) {
    connection.execute(migration(version));
  }
  connection.execute(
      fmt::format("PRAGMA application_id = {}; PRAGMA user_version = {}", kApplicationId, kSchemaVersion));
  transaction.commit();
}

}  // namespace tactbench::db
