#include "bench/common/private_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "bench/common/error.h"
#include "db/run_store.h"

namespace tactbench::bench {
namespace {

namespace fs = std::filesystem;

// Together with prefix and suffix they fit into the name of a socket (107 bytes).
constexpr std::size_t kPlainName = 48, kShortened = 24, kHashDigits = 20;
constexpr mode_t kOthersRead = 077, kOthersWrite = 022;
constexpr std::string_view kScratchEnding = ".XXXXXX";  // of a folder that is locked

bool is_allowed_in_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-' || c == '_';
}

[[noreturn]] void refuse_folder(const std::string& path, const std::string& why) {
  throw Error("TB-FOLDER-UNSAFE", "the folder cannot be trusted: " + why, path);
}

// The status of what is there; does not follow a link.
struct stat file_status_of(const std::string& path) {
  struct stat found {};
  if (::lstat(path.c_str(), &found) != 0) refuse_folder(path, std::strerror(errno));
  if (S_ISLNK(found.st_mode)) refuse_folder(path, "it is a link");
  if (!S_ISDIR(found.st_mode)) refuse_folder(path, "it is not a folder");
  if (found.st_uid != ::geteuid())
    refuse_folder(path, fmt::format("it belongs to user {}, not to {}", found.st_uid, ::geteuid()));
  return found;
}

int open_folder(const std::string& path) {
  return ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
}

// A folder whose process died holds no lock; the maker of a new folder checks it again after locking.
void remove_abandoned(const fs::path& base, const std::string& prefix) {
  std::error_code failed;
  fs::directory_iterator entry(base, failed);
  for (; !failed && entry != fs::directory_iterator(); entry.increment(failed)) {
    const std::string name = entry->path().filename().string();
    if (name.size() != prefix.size() + kScratchEnding.size() || !name.starts_with(prefix + kScratchEnding.front()))
      continue;
    const int folder = open_folder(entry->path().string());
    if (folder < 0) continue;
    struct stat found {};
    const bool ours = ::fstat(folder, &found) == 0 && found.st_uid == ::geteuid() && (found.st_mode & 0777) == S_IRWXU;
    std::error_code ignored;
    if (ours && ::flock(folder, LOCK_EX | LOCK_NB) == 0) fs::remove_all(entry->path(), ignored);
    ::close(folder);
  }
}

// Whether `path` is still the open folder.
bool is_there(const std::string& path, int folder) {
  struct stat opened {};
  struct stat found {};
  return ::fstat(folder, &opened) == 0 && ::lstat(path.c_str(), &found) == 0 && opened.st_ino == found.st_ino &&
         opened.st_dev == found.st_dev;
}

}  // namespace

std::string file_name(const std::string& text) {
  const bool plain = !text.empty() && text.size() <= kPlainName && text.front() != '.' &&
                     std::all_of(text.begin(), text.end(), is_allowed_in_name);
  if (plain) return text;
  std::string clean = text.substr(0, kShortened);
  std::replace_if(
      clean.begin(), clean.end(), [](char c) { return !is_allowed_in_name(c); }, '_');
  if (!clean.empty() && clean.front() == '.') clean.front() = '_';
  return clean + "~" + db::sha256_hex(text).substr(0, kHashDigits);
}

void check_private_folder(const std::string& path) {
  const struct stat found = file_status_of(path);
  if ((found.st_mode & kOthersRead) != 0)
    refuse_folder(path, fmt::format("other users may enter it (mode {:04o}; it must be 0700)", found.st_mode & 07777));
}

void make_private_folder(const std::string& path) {
  if (::mkdir(path.c_str(), 0700) == 0) return;
  if (errno != EEXIST) refuse_folder(path, fmt::format("it cannot be made: {}", std::strerror(errno)));
  const struct stat found = file_status_of(path);
  if ((found.st_mode & kOthersWrite) != 0)
    refuse_folder(path, fmt::format("other users may write to it (mode {:04o})", found.st_mode & 07777));
  if ((found.st_mode & kOthersRead) == 0) return;
  const int folder = open_folder(path);
  if (folder < 0 || ::fchmod(folder, 0700) != 0) {
    const std::string why = std::strerror(errno);
    if (folder >= 0) ::close(folder);
    refuse_folder(path, "it cannot be closed to others: " + why);
  }
  ::close(folder);
}

bool is_group_folder(const std::string& path) {
  struct stat found {};
  if (::lstat(path.c_str(), &found) != 0 && errno == ENOENT) return false;
  if (!S_ISDIR(found.st_mode)) refuse_folder(path, "it is not a folder");
  if (found.st_uid != 0 || (found.st_mode & S_ISGID) == 0)
    refuse_folder(path, "it does not belong to root and a group");
  if ((found.st_mode & S_IWOTH) != 0) refuse_folder(path, "all can write to it");
  return true;
}

int open_private_file(const std::string& path, int flags) {
  struct stat folder {};
  const bool shared = ::stat(fs::path(path).parent_path().c_str(), &folder) == 0 && folder.st_uid == 0 &&
                      (folder.st_mode & (S_ISGID | S_IWGRP)) == (S_ISGID | S_IWGRP) && (folder.st_mode & S_IWOTH) == 0;
  const int safely = (flags & ~O_TRUNC) | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK | O_NOCTTY;
  const int file = ::open(path.c_str(), safely, 0600);
  if (file < 0) return -1;
  struct stat found {};
  const bool ours = ::fstat(file, &found) == 0 && S_ISREG(found.st_mode) && (shared || found.st_uid == ::geteuid()) &&
                    found.st_nlink == 1;  // not a second name (hard link) of another file
  if (ours && shared && found.st_uid == ::geteuid()) (void)!::fchmod(file, 0660);
  if (ours && ((flags & O_TRUNC) == 0 || ::ftruncate(file, 0) == 0)) return file;
  ::close(file);
  errno = EPERM;
  return -1;
}

std::string temporary_folder() {
  std::error_code unknown;
  const fs::path folder = fs::temp_directory_path(unknown);
  return unknown ? "/tmp" : folder.string();
}

ScratchFolder::ScratchFolder(const std::string& prefix) {
  const fs::path base = temporary_folder();
  remove_abandoned(base, prefix);
  for (;;) {
    path_ = (base / prefix).string().append(kScratchEnding);
    if (::mkdtemp(path_.data()) == nullptr)
      refuse_folder(base.string(), fmt::format("no folder can be made in it: {}", std::strerror(errno)));
    lock_ = open_folder(path_);
    if (lock_ < 0 && errno != ENOENT) refuse_folder(path_, std::strerror(errno));
    while (lock_ >= 0 && ::flock(lock_, LOCK_EX) != 0 && errno == EINTR) {
    }
    if (lock_ >= 0 && is_there(path_, lock_)) return;
    if (lock_ >= 0) ::close(lock_);  // another process removed it before it was locked
  }
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  ::close(lock_);
}

std::string file_text(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  file.exceptions(std::ios::badbit);
  std::string text;
  std::array<char, std::size_t{1} << 14> block;
  while (file.read(block.data(), block.size()), file.gcount() > 0)
    text.append(block.data(), static_cast<std::size_t>(file.gcount()));
  return text;
}

}  // namespace tactbench::bench
