#include "db/run_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/crypto.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <thread>

#include "db/database.h"
#include "db/sqlite.h"
#include "db/store_file.h"

namespace tactbench::db {

namespace fs = std::filesystem;

namespace {

std::string absolute(const std::string& path) { return fs::absolute(path).string(); }

// SQLite does not wait for another process here despite the busy timeout: two processes that create one store at once
// would collide.
std::string switch_to_log(sqlite::Connection& connection) {
  using RealClock = std::chrono::steady_clock;
  const auto deadline = RealClock::now() + std::chrono::milliseconds(sqlite::kBusyTimeoutMs);
  for (;;) {
    try {
      return connection.text("PRAGMA journal_mode = WAL");
    } catch (const StoreError& error) {
      if (error.id() != "TB-STORE-LOCKED" || RealClock::now() > deadline) throw;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  }
}

}  // namespace

RunStore::RunStore(std::unique_ptr<Database> database)
    : RunWriter(*database), Models(*database), Remarks(*database), database_(std::move(database)) {}
RunStore::RunStore(RunStore&&) noexcept = default;
RunStore& RunStore::operator=(RunStore&&) noexcept = default;
RunStore::~RunStore() = default;

RunStore RunStore::open(const std::string& path, Durability durability) {
  check_store_file(path);
  refuse_network(path);
  auto database = std::make_unique<Database>(path, absolute(path), sqlite::Access::kReadWrite);
  sqlite::Connection& connection = database->connection;
  if (connection.is_read_only()) {
    throw StoreError("TB-STORE-OPEN", fmt::format("store {}: the file may not be written by this user", path),
                     "check owner and permissions of the file, or name another with --db");
  }
  migrate_store(connection, database->path);
  if (switch_to_log(connection) != "wal") {
    throw StoreError("TB-STORE-OPEN",
                     fmt::format("store {}: this file system does not support a write-ahead log", path),
                     "keep the store on a local disk");
  }
  if (durability == Durability::kNormal) connection.execute("PRAGMA synchronous = NORMAL");
  return RunStore(std::move(database));
}

RunStore RunStore::open_read_only(const std::string& path) {
  if (check_store_file(path) != FileKind::kStore) {
    throw StoreError(
        "TB-STORE-OPEN",
        fmt::format("store {}: {}", path, fs::exists(path) ? "the file is empty" : "there is no such file"),
        "name an existing store with --db; 'tactbench sensors add' or a run makes a new one");
  }
  const bool still = is_readable_on_network(path);
  const std::string file = absolute(path);
  const auto opened = [&](sqlite::Access access) {
    auto database = std::make_unique<Database>(path, file, access);
    check_version(database->connection);
    refuse_foreign(database->connection, Additions::kTolerate);
    if (database->connection.integer("PRAGMA user_version") < kSchemaVersion) {
      throw StoreError("TB-STORE-OPEN",
                       fmt::format("store {} has an older schema than this program's {}", path, kSchemaVersion),
                       "migrate it: tactbench db migrate");
    }
    return RunStore(std::move(database));
  };
  if (still) return opened(sqlite::Access::kImmutable);
  try {
    return opened(sqlite::Access::kReadOnly);
  } catch (const StoreError&) {
    // Without a log, and where none can be made, the file cannot change: archive folders, read-only disks.
    if (fs::exists(file + "-wal")) throw;
    if (faccessat(AT_FDCWD, fs::path(file).parent_path().c_str(), W_OK, AT_EACCESS) == 0) throw;
    return opened(sqlite::Access::kImmutable);
  }
}

void RunStore::snapshot(const std::string& path) const { copy_store(database_->connection, path); }

void RunStore::require_in_place() const { database_->connection.require_in_place(); }

namespace {

// Whether this process has that very file open, by whatever name.
bool is_open_here(const std::string& path) {
  std::error_code failed;
  for (const fs::directory_entry& open : fs::directory_iterator("/proc/self/fd", failed))
    if (fs::equivalent(open.path(), path, failed)) return true;
  return false;
}

bool is_whole(const std::string& path) {
  try {
    return RunStore::open_read_only(path).check_structure().empty();
  } catch (const StoreError&) {
    return false;
  }
}

}  // namespace

std::string RunStore::rescue() const {
  const fs::path lost = database_->connection.path();
  std::string saved = free_name(lost.string() + ".rescued");
  try {
    snapshot(saved);
  } catch (const StoreError&) {  // its folder is gone, too, or full
    saved = free_name((fs::temp_directory_path() / lost.filename()).string() + ".rescued");
    snapshot(saved);
  }
  const bool whole = is_whole(saved);
  for (const char* ending : {"-wal", "-shm"}) {
    ::unlink((saved + ending).c_str());  // made by that check
    if (whole && is_open_here(lost.string() + ending)) ::unlink((lost.string() + ending).c_str());
  }
  if (whole) return saved;
  fs::remove(saved);
  throw StoreError("TB-STORE-GONE", "the remaining file is not complete", "restore your last snapshot");
}

void RunStore::shrink() { database_->connection.execute("VACUUM; PRAGMA wal_checkpoint(TRUNCATE)"); }

// Runs copied from another store with all rows that belong to them. Rows are copied unchanged, by the columns that the
// file itself names; only the keys become those of this store.

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

std::vector<std::int64_t> RunStore::copy_runs_from(const RunReader& other, const std::vector<std::int64_t>& runs) {
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
  const AttachedStore attached(connection, fs::absolute(other.path()).string());
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
    for (const char* kind : kSealed) database_->seal(numbers[i], kind);  // with the keys assigned here
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

// Nights.

std::int64_t RunStore::add_night(const NightRecord& night) {
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  sqlite::Statement(connection, sqlite::insert_into("nights", NightRecord::kColumns)).bind(night.row()).run();
  const std::int64_t number = connection.last_row();
  sqlite::Statement row(
      connection,
      sqlite::insert_into("night_results", fmt::format("night, {}", NightResultRecord::kColumns), "first_run"));
  for (const NightResultRecord& result : night.results) row.bind(number, result.row()).run();
  transaction.commit();
  return number;
}

std::vector<NightRecord> RunStore::nights() const {
  std::vector<NightRecord> nights;
  sqlite::Statement rows(database_->connection,
                         fmt::format("SELECT night, {} FROM nights ORDER BY night", NightRecord::kColumns));
  while (rows.step()) {
    NightRecord& night = nights.emplace_back();
    rows.read(night.night, night.row());
  }
  for (NightRecord& night : nights)
    night.results = sqlite::read_all<NightResultRecord>(database_->connection,
                                                        "night_results WHERE night = ? ORDER BY position", night.night);
  return nights;
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
  const RunRecord run = this->run(number);
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
    if (const std::string whole = why_whole(connection, this->run(other)); !whole.empty())
      return fmt::format("run {} is {}, and a verdict is based on both", other, whole);
  }
  return {};
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
  pruned.header = database_->hasher.header(this->run(run));
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

std::string new_uuid() {
  std::array<std::uint8_t, 16> bytes{};
  if (getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    throw StoreError("TB-STORE-SQL", "the system provides no random numbers for a UUID", "check the system");
  }
  bytes[6] = static_cast<std::uint8_t>((bytes[6] & 0x0f) | 0x40);  // version 4
  bytes[8] = static_cast<std::uint8_t>((bytes[8] & 0x3f) | 0x80);  // variant 10
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (i == 4 || i == 6 || i == 8 || i == 10) text += '-';
    text += fmt::format("{:02x}", bytes[i]);
  }
  return text;
}

std::vector<std::pair<std::string, std::string>> library_versions() {
  sqlite::Connection memory(":memory:", sqlite::Access::kReadWrite);
  return {{"SQLite", memory.text("SELECT sqlite_version()")}, {"OpenSSL", OpenSSL_version(OPENSSL_VERSION_STRING)}};
}

}  // namespace tactbench::db
