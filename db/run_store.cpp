#include "db/run_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <thread>

#include "db/run_store_database.h"
#include "db/store_file.h"
#include "db/store_snapshot.h"

namespace tactbench::db {

namespace {

std::string absolute(const std::string& path) { return std::filesystem::absolute(path).string(); }

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

RunStore::RunStore(std::unique_ptr<Database> database) : database_(std::move(database)) {}
RunStore::RunStore(RunStore&&) noexcept = default;
RunStore& RunStore::operator=(RunStore&&) noexcept = default;
RunStore::~RunStore() = default;

const std::string& RunStore::path() const { return database_->path; }

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
    throw StoreError("TB-STORE-OPEN",
                     fmt::format("store {}: {}", path,
                                 std::filesystem::exists(path) ? "the file is empty" : "there is no such file"),
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
    if (std::filesystem::exists(file + "-wal")) throw;
    if (faccessat(AT_FDCWD, std::filesystem::path(file).parent_path().c_str(), W_OK, AT_EACCESS) == 0) throw;
    return opened(sqlite::Access::kImmutable);
  }
}

void RunStore::add_sensor(const SensorRecord& sensor) {
  check_nonblank_text("the serial", sensor.serial, kMaxNameLength);
  check_nonblank_text("the type's name", sensor.type, kMaxNameLength);
  if (!sensor.scanner_serial.empty())
    check_nonblank_text("the scanner's serial", sensor.scanner_serial, kMaxNameLength);
  check_text("the note", sensor.note, kMaxTextLength);
  sqlite::Connection& connection = database_->connection;
  sqlite::Transaction transaction(connection);
  if (const auto known = this->sensor(sensor.serial)) {
    const bool same_type = known->type_sha256 == sensor.type_sha256;
    if (same_type && known->scanner_serial == sensor.scanner_serial) return;
    throw StoreError("TB-STORE-CONFLICT",
                     same_type ? fmt::format("store {}: sensor '{}' is registered with scanner '{}', not '{}'", path(),
                                             sensor.serial, known->scanner_serial, sensor.scanner_serial)
                               : fmt::format("store {}: sensor '{}' is registered with another type file ('{}')",
                                             path(), sensor.serial, known->type),
                     "register it under another serial: models are bound to sensor, type and scanner");
  }
  sqlite::Statement(connection, sqlite::insert_into("sensors", SensorRecord::kColumns)).bind(sensor.row()).run();
  transaction.commit();
}

std::optional<SensorRecord> RunStore::sensor(const std::string& serial) const {
  const auto found = sqlite::read_all<SensorRecord>(database_->connection, "sensors WHERE serial = ?", serial);
  return found.empty() ? std::nullopt : std::optional(found.front());
}

std::vector<SensorRecord> RunStore::sensors() const {
  return sqlite::read_all<SensorRecord>(database_->connection, "sensors ORDER BY serial");
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

// Integrity of the store: the chain of a run recomputed link by link, and SQLite's own checks of its file.

namespace {

// A text stored with its hash can be checked separately.
std::string text_that_changed(const RunRecord& run) {
  const auto changed = [](const std::string& text, const std::string& sha256) {
    return sha256.size() == 64 && sha256_hex(text) != sha256;
  };
  if (changed(run.bench_toml, run.bench_sha256)) return "the bench file kept with the run, or its hash";
  if (changed(run.sensor_toml, run.sensor_sha256)) return "the sensor file kept with the run, or its hash";
  for (const SequenceRecord& sequence : run.sequences) {
    if (!changed(sequence.recipe_toml, sequence.recipe_sha256)) continue;
    return fmt::format("the recipe of sequence {} ('{}') kept with the run, or its hash", sequence.sequence,
                       sequence.name);
  }
  return {};
}

// A frame's place in the run, as text for people.
std::string place_of(std::int64_t position, const RunRecord& run, const BranchRecord* branch, const FrameRecord& f) {
  if (branch == nullptr) return fmt::format("frame {} (of no branch of this run)", position);
  const auto sequence = std::ranges::find(run.sequences, branch->sequence, &SequenceRecord::sequence);
  return fmt::format("frame {} (sequence {} '{}', repeat {}, branch {}, attempt {}, step {})", position,
                     branch->sequence, sequence == run.sequences.end() ? "" : sequence->name, branch->repeat,
                     branch->ordinal, branch->attempt, f.ordinal);
}

// Where the frames were removed, the links kept in their place are checked against what is there.
void check_without_frames(ContentCheck& check, const RunRecord& run, const RunEnd& end, std::int64_t there,
                          HashChain& hasher) {
  const PrunedRecord& pruned = *check.pruned;
  check.frames = pruned.frames;
  check.computed_sha256 = hex(hasher.close(pruned.chain, pruned.frames, end));
  if (there > 0) {
    check.difference = fmt::format("{} frames are there although all were removed on {}", there, pruned.pruned_utc);
  } else if (hasher.header(run) != pruned.header) {
    const std::string text = text_that_changed(run);
    check.difference = text.empty() ? "the run's row, a sequence, a device, or the link kept of them" : text;
  } else if (check.computed_sha256 != check.stored_sha256) {
    check.difference =
        "an event, a branch, a check, a series, the outcome, its reason, the safe state, the link and number of frames "
        "kept of those that were removed, or the stored hash itself";
  }
}

}  // namespace

ContentCheck RunStore::check_content(std::int64_t number) const {
  Database& database = *database_;
  const RunRecord run = database.run(number);
  const RunEnd end = database.end_of(run);

  ContentCheck check;
  check.stored_sha256 = run.content_sha256;
  check.pruned = pruned(number);
  if (check.pruned) {
    check_without_frames(check, run, end, frame_count(number), database.hasher);
    return check;
  }
  Digest chain = database.hasher.header(run);
  std::int64_t broken = 0;  // position of the first frame whose link differs from the stored one
  std::int64_t mended =
      0;  // of a later one whose link agrees: then only links were changed, not the rows that they cover
  std::string broken_place, gap;
  sqlite::Statement links(database.connection,
                          "SELECT frame, chain FROM frames WHERE frame > ? AND frame < ? ORDER BY frame");
  links.bind(frames_above(number), frames_below(number));
  database.for_each_frame(number, [&](const FrameRecord& frame) {
    std::int64_t key = 0;
    Digest stored{};
    if (links.step()) links.read(key, stored);
    const auto branch = std::lower_bound(end.branches.begin(), end.branches.end(), frame.branch,
                                         [](const BranchRecord& b, std::int64_t id) { return b.branch < id; });
    const bool known = branch != end.branches.end() && branch->branch == frame.branch;
    chain = database.hasher.frame(chain, known ? *branch : BranchRecord{}, frame);
    const std::int64_t position = key - frames_above(number);
    ++check.frames;
    if (gap.empty() && broken == 0 && position != check.frames) {
      gap = fmt::format("frame {} is missing", check.frames);
    }
    if (chain == stored) {
      if (broken != 0 && mended == 0) mended = position;
    } else if (broken == 0) {
      broken = position;
      broken_place = place_of(position, run, known ? &*branch : nullptr, frame);
    }
  });
  check.computed_sha256 = hex(database.hasher.close(chain, check.frames, end));

  const bool ended = run.outcome != Outcome::kIncomplete;
  const bool same = ended ? check.computed_sha256 == check.stored_sha256 : check.stored_sha256.empty();
  if (!gap.empty()) {
    check.difference = gap;
  } else if (broken != 0 && (mended != 0 || (ended && same))) {
    check.difference = fmt::format("the link kept with {}; the frame itself is unchanged", broken_place);
  } else if (broken == 1) {
    const std::string text = text_that_changed(run);
    check.difference =
        text.empty() ? fmt::format("the run's row, a sequence, a device, or {} with its branch", broken_place) : text;
  } else if (broken != 0) {
    check.difference = fmt::format("{}: its row or its branch's place", broken_place);
  } else if (!same) {
    const std::string text = check.frames == 0 ? text_that_changed(run) : std::string();
    check.difference =
        !text.empty() ? text
                      : fmt::format(
                            "{}an event, a branch, a check, a series, the number of frames (now {}), the "
                            "outcome, its reason, the safe state, or the stored hash itself",
                            check.frames == 0 ? "the run's row, a sequence, a device, "
                                              : "everything up to the last frame is unchanged; what follows is not:  ",
                            check.frames);
  }
  return check;
}

std::vector<std::string> RunStore::check_structure() const {
  std::vector<std::string> wrong;
  {
    sqlite::Statement rows(database_->connection, "PRAGMA integrity_check");
    while (rows.step()) {
      if (const auto line = rows.value<std::string>(); line != "ok") wrong.push_back(line);
    }
  }
  for (ForeignObjects found = foreign_objects(database_->connection);
       const auto* lines : {&found.changed, &found.added})
    wrong.insert(wrong.end(), lines->begin(), lines->end());
  for (const char* table : {"runs", "baselines", "nights"}) {
    const std::int64_t there = database_->connection.integer(fmt::format("SELECT count(*) FROM {}", table));
    const std::int64_t made = database_->connection.integer(
        fmt::format("SELECT coalesce((SELECT max(seq) FROM sqlite_sequence WHERE name = '{}'), 0)", table));
    if (there < made)
      wrong.push_back(
          fmt::format("{}: {} were stored but {} are there, although none is ever deleted", table, made, there));
  }
  sqlite::Statement rows(database_->connection,
                         "SELECT \"table\", rowid, parent FROM pragma_foreign_key_check ORDER BY 1, 2 LIMIT 100");
  while (rows.step()) {
    wrong.push_back(fmt::format("row {} of {} names a row of {} that is not there", rows.value<std::int64_t>(1),
                                rows.value<std::string>(0), rows.value<std::string>(2)));
  }
  return wrong;
}

}  // namespace tactbench::db
