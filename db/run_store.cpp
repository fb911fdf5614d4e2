#include "db/run_store.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/random.h>
#include <unistd.h>

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
  look_at_file(path);
  refuse_network(path);
  auto database = std::make_unique<Database>(path, absolute(path), sqlite::Access::kReadWrite);
  sqlite::Connection& connection = database->connection;
  if (connection.is_read_only()) {
    throw StoreError("TB-STORE-OPEN", fmt::format("store {}: the file may not be written by this user", path),
                     "check owner and permissions of the file, or name another with --db");
  }
  bring_up_to_date(connection, database->path);
  if (switch_to_log(connection) != "wal") {
    throw StoreError("TB-STORE-OPEN",
                     fmt::format("store {}: this file system does not support a write-ahead log", path),
                     "keep the store on a local disk");
  }
  if (durability == Durability::kNormal) connection.execute("PRAGMA synchronous = NORMAL");
  return RunStore(std::move(database));
}

RunStore RunStore::open_read_only(const std::string& path) {
  if (look_at_file(path) != FileKind::kStore) {
    throw StoreError("TB-STORE-OPEN",
                     fmt::format("store {}: {}", path,
                                 std::filesystem::exists(path) ? "the file is empty" : "there is no such file"),
                     "name an existing store with --db; 'tactbench sensors add' or a run makes a new one");
  }
  const bool still = lies_still_on_network(path);
  const std::string file = absolute(path);
  const auto opened = [&](sqlite::Access access) {
    auto database = std::make_unique<Database>(path, file, access);
    check_version(database->connection);
    refuse_foreign(database->connection, Additions::kTolerate);
    if (database->connection.integer("PRAGMA user_version") < kSchemaVersion) {
      throw StoreError("TB-STORE-OPEN",
                       fmt::format("store {} has an older schema than this program's {}", path, kSchemaVersion),
                       "bring it up to date: tactbench db migrate");
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
  check_said("the serial", sensor.serial, kLongestName);
  check_said("the type's name", sensor.type, kLongestName);
  if (!sensor.scanner_serial.empty()) check_said("the scanner's serial", sensor.scanner_serial, kLongestName);
  check_words("the note", sensor.note, kLongestText);
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
                     "register it under a serial of its own: models are bound to sensor, type and scanner");
  }
  sqlite::Statement(connection,
                    "INSERT INTO sensors (serial, type, type_toml, type_sha256, scanner_serial, note, added_utc) "
                    "VALUES (?, ?, ?, ?, ?, ?, ?)")
      .bind(sensor.serial, sensor.type, sensor.type_toml, sensor.type_sha256, sensor.scanner_serial, sensor.note,
            sensor.added_utc)
      .run();
  transaction.commit();
}

namespace {

constexpr const char* kSensorColumns =
    "SELECT serial, type, type_toml, type_sha256, scanner_serial, note, added_utc FROM sensors";

SensorRecord sensor_of(const sqlite::Statement& row) {
  SensorRecord sensor;
  row.read(sensor.serial, sensor.type, sensor.type_toml, sensor.type_sha256, sensor.scanner_serial, sensor.note,
           sensor.added_utc);
  return sensor;
}

}  // namespace

std::optional<SensorRecord> RunStore::sensor(const std::string& serial) const {
  sqlite::Statement rows(database_->connection, std::string(kSensorColumns) + " WHERE serial = ?");
  rows.bind(serial);
  return rows.step() ? std::optional(sensor_of(rows)) : std::nullopt;
}

std::vector<SensorRecord> RunStore::sensors() const {
  sqlite::Statement rows(database_->connection, std::string(kSensorColumns) + " ORDER BY serial");
  std::vector<SensorRecord> sensors;
  while (rows.step()) sensors.push_back(sensor_of(rows));
  return sensors;
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

}  // namespace tactbench::db
