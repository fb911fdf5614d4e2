#include "db/store_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <set>
#include <sstream>
#include <string_view>
#include <utility>

#include "db/schema.h"
#include "db/store_error.h"

namespace tactbench::db {

namespace fs = std::filesystem;

namespace {

struct Magic {
  std::uint64_t number;
  const char* name;
};

// statfs(2), linux/magic.h
constexpr std::array kNetwork = {
    Magic{0x6969, "NFS"},        Magic{0x517b, "SMB"},          Magic{0xff534d42, "CIFS"},   Magic{0xfe534d42, "SMB"},
    Magic{0x01021997, "9P"},     Magic{0x73757245, "Coda"},     Magic{0x5346414f, "AFS"},    Magic{0x6b414653, "AFS"},
    Magic{0x564c, "NCP"},        Magic{0x00c36400, "Ceph"},     Magic{0x01161970, "GFS2"},   Magic{0x7461636f, "OCFS2"},
    Magic{0x0bd00bd0, "Lustre"}, Magic{0x20030528, "OrangeFS"}, Magic{0x19830326, "BeeGFS"}, Magic{0x47504653, "GPFS"},
    Magic{0xaad7aaea, "PanFS"},  Magic{0x786f4256, "vboxsf"},   Magic{0xbacbacbc, "vmhgfs"},
};
constexpr std::uint64_t kFuse = 0x65735546;

// The type, in the mount table, of the file system that holds `path`.
std::string mount_type_of(const std::string& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0) return {};
  const std::string device = fmt::format("{}:{}", major(status.st_dev), minor(status.st_dev));
  std::ifstream mounts("/proc/self/mountinfo");
  for (std::string line; std::getline(mounts, line);) {
    // id parent major:minor root mount-point options [optional...] - type source options
    const std::size_t second = line.find(' ', line.find(' ') + 1);
    const std::size_t dash = line.find(" - ");
    if (second == std::string::npos || dash == std::string::npos) continue;
    if (line.substr(second + 1, line.find(' ', second + 1) - second - 1) != device) continue;
    return line.substr(dash + 3, line.find(' ', dash + 3) - dash - 3);
  }
  return {};
}

using Header = std::array<char, 100>;  // sqlite.org/fileformat2.html, 1.3

std::uint32_t number_at(const Header& header, std::size_t at, std::size_t bytes) {
  std::uint32_t number = 0;  // big-endian
  for (std::size_t i = at; i < at + bytes; ++i) number = (number << 8) | static_cast<std::uint8_t>(header.at(i));
  return number;
}

// Header fields with one value in every store. SQLite accepts most other values, and then reads or writes the file
// differently.
struct HeaderField {
  std::size_t at, bytes;
  std::uint32_t value;
  const char* name;
};
constexpr std::array kHeaderFields = {
    HeaderField{16, 2, kPageSize, "page size"},
    HeaderField{20, 1, 0, "bytes left free in each page"},
    HeaderField{21, 1, 64, "largest payload fraction"},
    HeaderField{22, 1, 32, "smallest payload fraction"},
    HeaderField{23, 1, 32, "leaf payload fraction"},
    HeaderField{44, 4, 4, "schema format"},
    HeaderField{48, 4, 0, "cache size"},
    HeaderField{52, 4, 0, "largest root page"},
    HeaderField{56, 4, 1, "text encoding"},
    HeaderField{64, 4, 0, "incremental vacuum"},
};

std::string wrong_in_header(const Header& header) {
  for (const HeaderField& field : kHeaderFields) {
    const std::uint32_t value = number_at(header, field.at, field.bytes);
    if (value == field.value) continue;
    return fmt::format("in its header the {} is {}, but {} in every store", field.name, value, field.value);
  }
  const std::uint32_t write = number_at(header, 18, 1), read = number_at(header, 19, 1);
  if (write != read || (read != 1 && read != 2))  // 2: with a write-ahead log
    return fmt::format("in its header the format's versions are {} and {}", write, read);
  const std::uint32_t pages = number_at(header, 28, 4), first_free = number_at(header, 32, 4),
                      free = number_at(header, 36, 4);
  if ((first_free == 0) != (free == 0) || first_free > pages || (free > 0 && free >= pages))
    return fmt::format("in its header {} of {} pages are free, from page {} on", free, pages, first_free);
  return {};
}

std::string folder_of(const std::string& path) { return fs::absolute(path).parent_path().string(); }

}  // namespace

std::optional<std::string> network_file_system(std::uint64_t magic, const std::string& mount_type) {
  for (const Magic& entry : kNetwork) {
    if (entry.number == magic) return entry.name;
  }
  if (magic != kFuse) return std::nullopt;
  // Local file systems that run through FUSE; any other may be on a network, which FUSE does not report.
  if (mount_type == "fuseblk" || mount_type == "fuse.fuse-overlayfs") return std::nullopt;
  return mount_type.empty() ? "FUSE" : mount_type;
}

namespace {

std::function<void(const std::string&)>& listener() {
  static std::function<void(const std::string&)> handler;
  return handler;
}

std::optional<std::string> network_below(const std::string& path) {
  const std::string there = fs::exists(path) ? path : folder_of(path);
  struct statfs status {};
  if (statfs(there.c_str(), &status) != 0) return std::nullopt;  // opening it reports the reason
  // Some magic numbers fill 32 bits and come sign-extended.
  const auto magic = static_cast<std::uint64_t>(status.f_type) & 0xffffffffU;
  return network_file_system(magic, magic == kFuse ? mount_type_of(there) : std::string());
}

}  // namespace

void refuse_network(const std::string& path) {
  const auto network = network_below(path);
  if (!network) return;
  throw StoreError("TB-STORE-NETWORK",
                   fmt::format("store {} is on a network file system ({}), where SQLite's locks and shared memory do "
                               "not hold and a store can be damaged",
                               path, *network),
                   "keep the store on a local disk (--db FILE); copy a finished store over the network instead");
}

bool is_readable_on_network(const std::string& path) {
  const auto network = network_below(path);
  if (!network) return false;
  std::error_code missing;
  if (fs::file_size(path + "-wal", missing) > 0 && !missing) {
    throw StoreError(
        "TB-STORE-NETWORK",
        fmt::format("store {} is on a network file system ({}), and its log ({}-wal) holds rows that are not in "
                    "the file yet",
                    path, *network, path),
        "let its writer end, then copy file and log to a local disk and read them there");
  }
  static std::set<std::string> warned;
  if (const auto& handler = listener(); handler && warned.insert(path).second) {
    handler(
        fmt::format("store {} is on a network file system ({}): it is read directly and must not be written meanwhile; "
                    "copy it to a local disk to work with it",
                    path, *network));
  }
  return true;
}

void set_warning_handler(std::function<void(const std::string&)> handler) { listener() = std::move(handler); }

std::string writer_of(const std::string& path) {
  std::set<std::string> inodes;
  for (const char* file : {"", "-shm"}) {  // with a write-ahead log the locks lie on its index
    struct stat status {};
    if (stat((path + file).c_str(), &status) == 0) inodes.insert(std::to_string(status.st_ino));
  }
  std::ifstream locks("/proc/locks");
  for (std::string line; std::getline(locks, line);) {
    // number: kind ADVISORY READ|WRITE pid major:minor:inode from to; "->" before the kind: waits for it
    std::istringstream words(line);
    std::string number, kind, strictness, access, pid, file;
    words >> number >> kind >> strictness >> access >> pid >> file;
    if (access != "WRITE" || !inodes.contains(file.substr(file.rfind(':') + 1))) continue;
    std::string name;
    std::getline(std::ifstream("/proc/" + pid + "/comm"), name);
    if (!name.empty()) return fmt::format("{} (pid {})", name, pid);
  }
  return {};
}

FileKind check_store_file(const std::string& path) {
  const auto refuse = [&](const std::string& what, const std::string& remedy) {
    throw StoreError("TB-STORE-OPEN", fmt::format("store {}: {}", path, what), remedy);
  };
  if (path.empty()) refuse("the name is empty", "name a file with --db");
  std::error_code failed;
  const std::string folder = folder_of(path);
  if (!fs::is_directory(folder, failed)) {
    refuse(fmt::format("the folder {} does not exist", folder), fmt::format("make it (mkdir -p '{}')", folder));
  }
  if (!fs::exists(path, failed)) return FileKind::kMissing;
  if (!fs::is_regular_file(path, failed)) refuse("not a regular file", "name a file with --db");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) refuse(std::strerror(errno), "check owner and permissions of the file");
  if (fs::file_size(path, failed) == 0) return FileKind::kEmpty;  // also files of /proc: reading may block forever
  Header header{};
  stream.read(header.data(), header.size());
  if (stream.gcount() == 0) return FileKind::kEmpty;
  constexpr std::string_view kMagic("SQLite format 3\0", 16);
  if (stream.gcount() < 100 || std::string_view(header.data(), kMagic.size()) != kMagic) {
    refuse("neither a store of tactbench nor another SQLite database", "name another file with --db");
  }
  const std::uint32_t application = number_at(header, 68, 4);
  if (application != kApplicationId) {
    refuse(fmt::format("an SQLite database of another program (application id {:#010x}, ours is {:#010x})", application,
                       kApplicationId),
           "name another file with --db; this one was not changed");
  }
  const std::string wrong = wrong_in_header(header);
  if (!wrong.empty()) {
    refuse(fmt::format("the file is damaged: {}", wrong), kDamagedRemedy);
  }
  return FileKind::kStore;
}

namespace {

// The copy grows under another name, which is locked, and gets its own when it is complete: a program that dies leaves
// no file of that name, and the next copy takes over what it left.
class TakenName {
 public:
  explicit TakenName(std::string path) : path_(std::move(path)), partial_(path_ + ".partial") {
    if (fs::exists(path_)) refuse(EEXIST);
    file_ = ::open(partial_.c_str(), O_CREAT | O_RDWR | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (file_ < 0) refuse(errno);
    // Another process is making this copy, or has just finished it.
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

std::string free_name(const std::string& wanted) {
  std::string name = wanted;
  for (int i = 2; fs::exists(name); ++i) name = fmt::format("{}.{}", wanted, i);
  return name;
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
