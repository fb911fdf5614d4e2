#include "db/store_snapshot.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "db/run_store_database.h"
#include "db/store_file.h"

namespace tactbench::db {

namespace fs = std::filesystem;

namespace {

// The copy grows under another name, which is locked, and gets its own when it is complete: a program that dies leaves
// no file of that name, and the next copy takes over what it left.
class TakenName {
 public:
  explicit TakenName(std::string path) : path_(std::move(path)), partial_(path_ + ".partial") {
    if (fs::exists(path_)) refuse(EEXIST);
    file_ = ::open(partial_.c_str(), O_CREAT | O_RDWR | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (file_ < 0) refuse(errno);
    // Another one is at work, or was until now and has given the file its name.
    if (::flock(file_, LOCK_EX | LOCK_NB) != 0 || fs::exists(path_) || ::ftruncate(file_, 0) != 0) {
      ::close(file_);
      refuse(EEXIST);
    }
    drop_logs();
  }
  ~TakenName() {
    if (!kept_) {
      drop_logs();
      ::unlink(partial_.c_str());
    }
    ::close(file_);
  }
  TakenName(const TakenName&) = delete;
  TakenName& operator=(const TakenName&) = delete;

  [[nodiscard]] const std::string& partial() const { return partial_; }
  void keep() {
    if (::renameat2(AT_FDCWD, partial_.c_str(), AT_FDCWD, path_.c_str(), RENAME_NOREPLACE) != 0) refuse(errno);
    kept_ = true;
  }

 private:
  void drop_logs() const {
    for (const char* ending : {"-journal", "-wal", "-shm"}) ::unlink((partial_ + ending).c_str());
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
  int file_ = -1;
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
    target.execute("PRAGMA journal_mode = MEMORY");
    source.copy_to(target);
  }
  name.keep();
}

namespace {

std::string free_name(const std::string& wanted) {
  std::string name = wanted;
  for (int i = 2; fs::exists(name); ++i) name = fmt::format("{}.{}", wanted, i);
  return name;
}

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

void RunStore::snapshot(const std::string& path) const { copy_store(database_->connection, path); }

void RunStore::require_in_place() const { database_->connection.require_in_place(); }

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
    ::unlink((saved + ending).c_str());  // left by that look
    if (whole && is_open_here(lost.string() + ending)) ::unlink((lost.string() + ending).c_str());
  }
  if (whole) return saved;
  fs::remove(saved);
  throw StoreError("TB-STORE-GONE", "the remaining file is not complete", "restore your last snapshot");
}

std::string backup_path(const std::string& path, int version) {
  return free_name(fmt::format("{}.schema-{}.backup", path, version));
}

void migrate_store(sqlite::Connection& connection, const std::string& path, const Migrations& known) {
  check_version(connection, known);
  refuse_foreign(connection, Additions::kRefuse, known);
  const auto version = static_cast<std::size_t>(connection.integer("PRAGMA user_version"));
  if (version > 0 && version < known.size()) copy_store(connection, backup_path(path, static_cast<int>(version)));
  // The first migration runs before WAL, so that the application id is in the file itself and never only in the log.
  connection.execute("PRAGMA page_size = 4096; PRAGMA synchronous = FULL");
  migrate(connection, known);
}

int schema_version_of(const std::string& path) {
  if (check_store_file(path) != FileKind::kStore) {
    throw StoreError(
        "TB-STORE-OPEN",
        fmt::format("store {}: {}", path, fs::exists(path) ? "the file is empty" : "there is no such file"),
        "name an existing store");
  }
  refuse_network(path);
  // A journal next to it: the creation or migration was interrupted, and SQLite rolls it back.
  const bool half = fs::exists(path + "-journal");
  sqlite::Connection connection(fs::absolute(path).string(),
                                half ? sqlite::Access::kReadWrite : sqlite::Access::kReadOnly);
  check_version(connection);
  return static_cast<int>(connection.integer("PRAGMA user_version"));
}

}  // namespace tactbench::db
