// Runs copied from another store with all rows that belong to them. Rows are copied unchanged, by the columns that the
// file itself names; only the keys become those of this store.
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>

#include "db/hash_chain.h"
#include "db/run_store_database.h"
#include "db/store_file.h"

namespace tactbench::db {

namespace {

class AttachedStore {
 public:
  AttachedStore(sqlite::Connection& connection, const std::string& path) : connection_(connection) {
    sqlite::Statement(connection, "ATTACH ? AS source").bind(path).run();
  }
  ~AttachedStore() {
    try {
      connection_.execute("DROP TABLE IF EXISTS temp.copied_fits; DETACH source");
    } catch (const StoreError&) {  // the connection is broken: closing it detaches
    }
  }
  AttachedStore(const AttachedStore&) = delete;
  AttachedStore& operator=(const AttachedStore&) = delete;

 private:
  sqlite::Connection& connection_;
};

using Replaced = std::map<std::string, std::string>;  // column -> expression; empty: the store assigns it

void take_rows(sqlite::Connection& connection, const std::string& table, const Replaced& replaced,
               const std::string& condition) {
  std::string columns, values;
  sqlite::Statement names(connection, "SELECT name FROM pragma_table_info(?, 'main')");
  names.bind(table);
  while (names.step()) {
    std::string name;
    names.read(name);
    const auto own = replaced.find(name);
    if (own != replaced.end() && own->second.empty()) continue;
    const char* comma = columns.empty() ? "" : ", ";
    columns += fmt::format("{}\"{}\"", comma, name);
    values += fmt::format("{}{}", comma, own == replaced.end() ? fmt::format("t.\"{}\"", name) : own->second);
  }
  connection.execute(fmt::format("INSERT INTO main.{0} ({1}) SELECT {2} FROM source.{0} t WHERE {3} ORDER BY t.rowid",
                                 table, columns, values, condition));
}

// Offset from a key of the source to its new key, which follows the keys of this store.
std::int64_t offset_of(sqlite::Connection& connection, const std::string& table, const std::string& key,
                       const std::string& condition) {
  return connection.integer(
      fmt::format("SELECT coalesce((SELECT max({1}) FROM main.{0}), 0) + 1 - "
                  "coalesce((SELECT min(t.{1}) FROM source.{0} t WHERE {2}), 1)",
                  table, key, condition));
}

void take_sensor(sqlite::Connection& connection, std::int64_t run) {
  const std::string serial = fmt::format("serial = (SELECT sensor_serial FROM source.runs WHERE run = {})", run);
  if (connection.integer(fmt::format("SELECT count(*) FROM main.sensors WHERE {}", serial)) == 0) {
    take_rows(connection, "sensors", {}, fmt::format("t.{}", serial));
    return;
  }
  const std::int64_t same = connection.integer(
      fmt::format("SELECT count(*) FROM main.sensors m JOIN source.sensors s USING (serial, type_sha256, "
                  "scanner_serial) WHERE m.{}",
                  serial));
  if (same == 1) return;
  throw StoreError(
      "TB-STORE-CONFLICT",
      fmt::format("the sensor of run {} is registered in {} with another type file or scanner", run, connection.path()),
      "copy into another store");
}

std::int64_t take_run(sqlite::Connection& connection, std::int64_t run) {
  const std::string of_run = fmt::format("t.run = {}", run);
  // Checked above, but it may have been resumed since.
  if (connection.integer(
          fmt::format("SELECT count(*) FROM source.runs t WHERE {} AND outcome <> 'incomplete'", of_run)) == 0) {
    throw StoreError("TB-STORE-CONFLICT", fmt::format("run {} is being resumed", run), "wait for its end, or stop it");
  }
  const std::int64_t there = connection.integer(
      fmt::format("SELECT coalesce((SELECT run FROM main.runs WHERE uuid = (SELECT uuid FROM source.runs "
                  "WHERE run = {})), 0)",
                  run));
  if (there != 0) {
    throw StoreError("TB-STORE-EXISTS",
                     fmt::format("run {} is in {} already, as run {}", run, connection.path(), there), "leave it out");
  }
  take_sensor(connection, run);
  const std::int64_t branches = offset_of(connection, "branches", "branch", of_run);
  const std::int64_t fits = offset_of(connection, "fits", "fit", of_run);
  take_rows(connection, "runs", {{"run", ""}}, of_run);
  const std::int64_t number = connection.last_row();
  const std::string own = std::to_string(number);
  for (const char* table : {"sequences", "devices", "series", "pruned"})
    take_rows(connection, table, {{"run", own}}, of_run);
  const std::string branch = fmt::format("t.branch + {}", branches);
  take_rows(connection, "branches", {{"run", own}, {"branch", branch}}, of_run);
  take_rows(connection, "frames",
            {{"frame", fmt::format("t.frame + {}", frames_above(number) - frames_above(run))}, {"branch", branch}},
            fmt::format("t.frame > {} AND t.frame < {}", frames_above(run), frames_below(run)));
  take_rows(connection, "events", {{"run", own}, {"event", ""}}, of_run);
  take_rows(connection, "checks", {{"run", own}, {"check_row", ""}}, of_run);
  take_rows(connection, "figures", {{"run", own}}, of_run);
  take_rows(connection, "reports", {{"run", own}, {"report_row", ""}}, of_run);
  const std::string fit = fmt::format("t.fit + {}", fits);
  take_rows(connection, "fits", {{"run", own}, {"fit", fit}}, of_run);
  connection.execute(
      fmt::format("INSERT INTO temp.copied_fits SELECT t.fit, {} FROM source.fits t WHERE {}", fit, of_run));
  return number;
}

}  // namespace

std::vector<std::int64_t> RunStore::copy_runs_from(const RunStore& other, const std::vector<std::int64_t>& runs) {
  sqlite::Connection& connection = database_->connection;
  for (const std::int64_t run : runs) {
    if (other.run(run).outcome == Outcome::kIncomplete) {
      throw StoreError("TB-STORE-CONFLICT", fmt::format("store {}: run {} has not ended", other.path(), run),
                       "wait for its end, or stop it");
    }
    const std::vector<std::string> wrong = other.check_seals(run);
    if (wrong.empty()) continue;
    throw StoreError(
        "TB-STORE-CONFLICT",
        fmt::format("store {}: run {} has changed since it was stored: {}", other.path(), run, wrong.front()),
        "nothing was copied; tactbench verify RUN shows more; restore the last snapshot");
  }
  refuse_network(other.path());  // the other store is opened again here, with locks
  const AttachedStore attached(connection, std::filesystem::absolute(other.path()).string());
  connection.execute("CREATE TEMP TABLE copied_fits (old INTEGER PRIMARY KEY, new INTEGER NOT NULL)");
  sqlite::Transaction transaction(connection);
  std::vector<std::int64_t> numbers;
  for (const std::int64_t run : runs) numbers.push_back(take_run(connection, run));
  for (std::size_t i = 0; i < runs.size(); ++i) {
    // A verdict often rests on a fit of another run; it refers to that fit if that run was copied, too.
    take_rows(connection, "verdicts",
              {{"verdict_row", ""},
               {"run", std::to_string(numbers[i])},
               {"fit", "(SELECT new FROM temp.copied_fits WHERE old = t.fit)"}},
              fmt::format("t.run = {}", runs[i]));
    for (const char* kind : kSealed) seal(numbers[i], kind);  // with the keys assigned here
    const ContentCheck check = check_content(numbers[i]);
    if (check.holds()) continue;
    throw StoreError(
        "TB-STORE-CONFLICT",
        fmt::format("store {}: run {} has changed since it was stored: {}", other.path(), runs[i], check.difference),
        "nothing was copied; tactbench verify RUN shows more; restore the last snapshot");
  }
  transaction.commit();
  return numbers;
}

void RunStore::number_next_run(std::int64_t number) {
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  connection.execute("DELETE FROM sqlite_sequence WHERE name = 'runs'");
  sqlite::Statement(connection, "INSERT INTO sqlite_sequence (name, seq) VALUES ('runs', ?)").bind(number - 1).run();
  transaction.commit();
}

void RunStore::link_verdicts(std::int64_t run, const std::vector<std::int64_t>& fits) {
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  std::vector<std::int64_t> keys;
  {
    sqlite::Statement rows(connection, "SELECT rowid FROM verdicts WHERE run = ? ORDER BY rowid");
    rows.bind(run);
    while (rows.step()) keys.push_back(rows.value<std::int64_t>());
  }
  sqlite::Statement link(connection, "UPDATE verdicts SET fit = ? WHERE rowid = ?");
  for (std::size_t i = 0; i < std::min(keys.size(), fits.size()); ++i)
    if (fits[i] != 0) link.bind(fits[i], keys[i]).run();
  seal(run, "verdicts");
  transaction.commit();
}

// Removal of frames by a rule. What is kept in their place lets the rest of the run be checked: the first link of its
// hash chain against its row, sequences and devices, and the last frame's against the content hash and all that
// follows.

namespace {

constexpr const char *kPin = "pinned", *const kNightTag = "nightly";

bool has_tag(const RunRecord& run, const char* tag) { return std::ranges::find(run.tags, tag) != run.tags.end(); }

// Why nothing of this run is ever removed; empty: there is no such reason.
std::string why_whole(sqlite::Connection& connection, const RunRecord& run) {
  if (run.origin != "simulated") return fmt::format("{}, not simulated", run.origin);
  if (run.is_void()) return "void";
  if (has_tag(run, kPin)) return "pinned";
  sqlite::Statement reported(connection, "SELECT number FROM reports WHERE run = ? ORDER BY report_row DESC LIMIT 1");
  const auto number = reported.bind(run.run).first<std::string>();
  return number ? fmt::format("in the approved report {}", *number) : std::string();
}

}  // namespace

std::string RunStore::why_not_pruned(std::int64_t number) const {
  sqlite::Connection& connection = database_->connection;
  const RunRecord run = database_->run(number);
  if (run.outcome == Outcome::kIncomplete) return "not ended";
  if (std::string whole = why_whole(connection, run); !whole.empty()) return whole;
  if (!has_tag(run, kNightTag)) return "not of a night";
  if (pruned(number)) return "removed already";
  if (frame_count(number) == 0) return "without frames";
  // A verdict rests on the frames of the judged run and of the run that the models are from.
  sqlite::Statement others(connection,
                           "SELECT f.run FROM verdicts v JOIN fits f ON f.fit = v.fit WHERE v.run = ?1 AND f.run <> ?1 "
                           "UNION SELECT v.run FROM verdicts v JOIN fits f ON f.fit = v.fit "
                           "WHERE f.run = ?1 AND v.run <> ?1");
  others.bind(number);
  while (others.step()) {
    const auto other = others.value<std::int64_t>();
    if (const std::string whole = why_whole(connection, database_->run(other)); !whole.empty())
      return fmt::format("run {} is {}, and a verdict is based on both", other, whole);
  }
  return {};
}

std::optional<PrunedRecord> RunStore::pruned(std::int64_t run) const {
  const auto found = sqlite::read_all<PrunedRecord>(database_->connection, "pruned WHERE run = ?", run);
  return found.empty() ? std::nullopt : std::optional(found.front());
}

PrunedRecord RunStore::prune_frames(std::int64_t run, const std::string& rule, const std::string& utc) {
  check_nonblank_text("the rule", rule, kMaxTextLength);
  const auto refuse = [&](const std::string& what, const std::string& remedy) {
    throw StoreError("TB-STORE-CONFLICT",
                     fmt::format("store {}: the frames of run {} cannot be removed: {}", path(), run, what), remedy);
  };
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  if (const std::string why = why_not_pruned(run); !why.empty()) refuse(why, "leave it out");
  const ContentCheck content = check_content(run);
  if (!content.holds())
    refuse(fmt::format("it has changed since it was stored: {}", content.difference),
           fmt::format("tactbench verify {} shows what differs", run));
  PrunedRecord pruned;
  pruned.run = run;
  pruned.frames = content.frames;
  pruned.header = database_->header_digest(run);
  pruned.frames_sha256 = frames_hash(*this, run);
  pruned.rule = rule;
  pruned.pruned_utc = utc;
  {
    sqlite::Statement last(connection,
                           "SELECT chain, (SELECT sum(length(counts) + length(trace)) FROM frames WHERE frame > ?1 AND "
                           "frame < ?2) FROM frames WHERE frame > ?1 AND frame < ?2 ORDER BY frame DESC LIMIT 1");
    if (last.bind(frames_above(run), frames_below(run)).step()) last.read(pruned.chain, pruned.bytes);
  }
  sqlite::Statement(connection, "DELETE FROM frames WHERE frame > ? AND frame < ?")
      .bind(frames_above(run), frames_below(run))
      .run();
  sqlite::Statement(connection, sqlite::insert_into("pruned", PrunedRecord::kColumns)).bind(pruned.row()).run();
  transaction.commit();
  return pruned;
}

void RunStore::shrink() { database_->connection.execute("VACUUM; PRAGMA wal_checkpoint(TRUNCATE)"); }

// Models, verdicts, approvals and voids come after a run's end and are not part of its content. Each kind has a row in
// seals, renewed with every change: the number of its rows, and their SHA-256.

Digest HashChain::fits(const std::vector<FitRecord>& fits) {
  begin("fits");
  for (const FitRecord& fit : fits) {
    add(fit.fit);
    add(fit.row());
  }
  return finish();
}

Digest HashChain::verdicts(const std::vector<VerdictRecord>& verdicts) {
  begin("verdicts");
  for (const VerdictRecord& v : verdicts) {
    add(v.fit);
    add(v.row());
  }
  return finish();
}

Digest HashChain::approvals(const std::vector<ReportRecord>& reports) {
  begin("approvals");
  for (const ReportRecord& r : reports) {
    add(r.row());
    if (!r.reason.empty()) add("reason: " + r.reason);  // no number begins so
    for (const ReportRecord::Evidence& one : r.evidence) add("evidence: " + one.content_sha256);
  }
  return finish();
}

Digest HashChain::voided(const RunRecord& run) {
  begin("void");
  add(std::tie(run.void_reason, run.void_by, run.void_utc));
  return finish();
}

RunStore::Sealed RunStore::sealed_now(std::int64_t run, const std::string& kind) const {
  HashChain& hasher = database_->hasher;
  if (kind == "fits") {
    const std::vector<FitRecord> rows = fits(run);
    return {static_cast<std::int64_t>(rows.size()), hex(hasher.fits(rows))};
  }
  if (kind == "verdicts") {
    const std::vector<VerdictRecord> rows = verdicts(run);
    return {static_cast<std::int64_t>(rows.size()), hex(hasher.verdicts(rows))};
  }
  if (kind == "approvals") {
    const std::vector<ReportRecord> rows = reports(run);
    return {static_cast<std::int64_t>(rows.size()), hex(hasher.approvals(rows))};
  }
  const RunRecord record = database_->run(run);
  return {record.is_void() ? 1 : 0, hex(hasher.voided(record))};
}

void RunStore::seal(std::int64_t run, const std::string& kind) {
  const Sealed now = sealed_now(run, kind);
  sqlite::Statement(database_->connection,
                    "INSERT INTO seals (run, kind, count, sha256) VALUES (?, ?, ?, ?) "
                    "ON CONFLICT (run, kind) DO UPDATE SET count = excluded.count, sha256 = excluded.sha256")
      .bind(run, kind, now.count, now.sha256)
      .run();
}

std::vector<std::string> RunStore::check_seals(std::int64_t run) const {
  std::vector<std::string> wrong;
  for (const char* kind : kSealed) {
    const Sealed now = sealed_now(run, kind);
    Sealed stored;
    sqlite::Statement row(database_->connection, "SELECT count, sha256 FROM seals WHERE run = ? AND kind = ?");
    const bool there = row.bind(run, kind).step();
    if (there) row.read(stored.count, stored.sha256);
    if (!there) {
      wrong.push_back(
          fmt::format("{}: the count and hash of what was stored are missing; {} there now", kind, now.count));
    } else if (stored.count != now.count) {
      wrong.push_back(fmt::format("{}: {} were stored, {} there now", kind, stored.count, now.count));
    } else if (stored.sha256 != now.sha256 && !(stored.count == 0 && stored.sha256.empty())) {
      wrong.push_back(fmt::format("{}: changed since they were stored", kind));
    }
  }
  return wrong;
}

}  // namespace tactbench::db
