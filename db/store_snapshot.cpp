#include "db/store_snapshot.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "db/run_store_database.h"
#include "db/store_file.h"

namespace tactbench::db {

namespace fs = std::filesystem;

namespace {

// Reserves the name with an empty file, so that no other file can be overwritten; on failure the name is released.
class TakenName {
 public:
  explicit TakenName(std::string path) : path_(std::move(path)), partial_(path_ + ".partial") {
    const int file = ::open(path_.c_str(), O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    if (file < 0) refuse(errno);
    ::close(file);
    drop_partial();  // left by a program that died
  }
  ~TakenName() {
    if (kept_) return;
    drop_partial();
    ::unlink(path_.c_str());
  }
  TakenName(const TakenName&) = delete;
  TakenName& operator=(const TakenName&) = delete;

  [[nodiscard]] const std::string& partial() const { return partial_; }
  void keep() {
    if (::rename(partial_.c_str(), path_.c_str()) != 0) refuse(errno);
    kept_ = true;
  }

 private:
  void drop_partial() const {
    for (const char* ending : {"", "-journal", "-wal", "-shm"}) ::unlink((partial_ + ending).c_str());
  }
  [[noreturn]] void refuse(int error) const {
    if (error == EEXIST) {
      throw StoreError("TB-STORE-EXISTS", fmt::format("{} exists already and is not overwritten", path_),
                       "name a file that does not exist yet");
    }
    throw StoreError(error == ENOSPC || error == EDQUOT ? "TB-STORE-FULL" : "TB-STORE-OPEN",
                     fmt::format("{} cannot be made: {}", path_, std::strerror(error)),
                     "check the folder, its permissions and the free space of its disk");
  }

  std::string path_, partial_;
  bool kept_ = false;
};

}  // namespace

void copy_store(const sqlite::Connection& source, const std::string& path) {
  if (path.empty()) {
    throw StoreError("TB-STORE-OPEN", "the copy has no name", "name a file that does not exist yet");
  }
  refuse_network(path);
  TakenName name(fs::absolute(path).string());
  {
    sqlite::Connection target(name.partial(), sqlite::Access::kReadWrite);
    source.copy_to(target);
  }
  name.keep();
}

void RunStore::snapshot(const std::string& path) const { copy_store(database_->connection, path); }

std::string backup_path(const std::string& path, int version) {
  std::string backup = fmt::format("{}.schema-{}.backup", path, version);
  for (int i = 2; fs::exists(backup); ++i) backup = fmt::format("{}.schema-{}.backup.{}", path, version, i);
  return backup;
}

void bring_up_to_date(sqlite::Connection& connection, const std::string& path, const Migrations& known) {
  check_version(connection, known);
  refuse_foreign(connection, Additions::kRefuse, known);
  const auto version = static_cast<std::size_t>(connection.integer("PRAGMA user_version"));
  if (version > 0 && version < known.size()) copy_store(connection, backup_path(path, static_cast<int>(version)));
  // The first migration runs before WAL, so that the application id is in the file itself and never only in the log.
  connection.execute("PRAGMA page_size = 4096; PRAGMA synchronous = FULL");
  migrate(connection, known);
}

int schema_version_of(const std::string& path) {
  if (look_at_file(path) != FileKind::kStore) {
    throw StoreError(
        "TB-STORE-OPEN",
        fmt::format("store {}: {}", path, fs::exists(path) ? "the file is empty" : "there is no such file"),
        "name an existing store");
  }
  refuse_network(path);
  // With a journal beside it, a store whose making or migration was cut off: SQLite takes the half back.
  const bool half = fs::exists(path + "-journal");
  sqlite::Connection connection(fs::absolute(path).string(),
                                half ? sqlite::Access::kReadWrite : sqlite::Access::kReadOnly);
  check_version(connection);
  return static_cast<int>(connection.integer("PRAGMA user_version"));
}

}  // namespace tactbench::db
