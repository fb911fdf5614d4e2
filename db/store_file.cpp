#include "db/store_file.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <sys/vfs.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "db/run_store.h"
#include "db/schema.h"

namespace tactbench::db {

namespace fs = std::filesystem;

namespace {

struct Magic {
  std::uint64_t number;
  const char* name;
};

// statfs(2), linux/magic.h
constexpr std::array kNetwork = {
    Magic{0x6969, "NFS"},        Magic{0x517b, "SMB"},          Magic{0xff534d42, "CIFS"}, Magic{0xfe534d42, "SMB"},
    Magic{0x01021997, "9P"},     Magic{0x73757245, "Coda"},     Magic{0x5346414f, "AFS"},  Magic{0x6b414653, "AFS"},
    Magic{0x564c, "NCP"},        Magic{0x00c36400, "Ceph"},     Magic{0x01161970, "GFS2"}, Magic{0x7461636f, "OCFS2"},
    Magic{0x0bd00bd0, "Lustre"}, Magic{0x20030528, "OrangeFS"},
};
constexpr std::uint64_t kFuse = 0x65735546;

// The type in the mount table of the file system that `path` lies on.
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

std::string folder_of(const std::string& path) { return fs::absolute(path).parent_path().string(); }

}  // namespace

std::optional<std::string> network_file_system(std::uint64_t magic, const std::string& mount_type) {
  for (const Magic& entry : kNetwork) {
    if (entry.number == magic) return entry.name;
  }
  if (magic != kFuse) return std::nullopt;
  // Local file systems that run through FUSE; any other may be a network's, and none says so.
  if (mount_type == "fuseblk" || mount_type == "fuse.fuse-overlayfs") return std::nullopt;
  return mount_type.empty() ? "FUSE" : mount_type;
}

void refuse_network(const std::string& path) {
  const std::string there = fs::exists(path) ? path : folder_of(path);
  struct statfs status {};
  if (statfs(there.c_str(), &status) != 0) return;  // opening it will tell why
  // Some magic numbers fill 32 bits and come sign-extended.
  const auto magic = static_cast<std::uint64_t>(status.f_type) & 0xffffffffU;
  const auto network = network_file_system(magic, magic == kFuse ? mount_type_of(there) : std::string());
  if (!network) return;
  throw StoreError("TB-STORE-NETWORK",
                   fmt::format("store {} lies on a network file system ({}), where SQLite's locks and shared memory do "
                               "not hold and a store can be damaged",
                               path, *network),
                   "keep the store on a local disk (--db FILE); copy a finished store over the network instead");
}

FileKind look_at_file(const std::string& path) {
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
  std::array<char, 100> header{};  // sqlite.org/fileformat2.html, 1.3
  stream.read(header.data(), header.size());
  if (stream.gcount() == 0) return FileKind::kEmpty;
  constexpr std::string_view kMagic("SQLite format 3\0", 16);
  if (stream.gcount() < 100 || std::string_view(header.data(), kMagic.size()) != kMagic) {
    refuse("not a store of tactbench, nor any SQLite database", "name another file with --db");
  }
  std::uint32_t application = 0;  // big-endian at byte 68
  for (std::size_t i = 68; i < 72; ++i) application = (application << 8) | static_cast<std::uint8_t>(header.at(i));
  if (application != kApplicationId) {
    refuse(fmt::format("an SQLite database of another program (application id {:#010x}, ours is {:#010x})", application,
                       kApplicationId),
           "name another file with --db; this one was left as it is");
  }
  return FileKind::kStore;
}

}  // namespace tactbench::db
