// The program's own folders and files (trips, records, scratch), closed to other users, or to all but the members of a
// group. Existing ones are checked before use, and no link is followed.
#pragma once

#include <filesystem>
#include <string>

namespace tactbench::bench {

// Makes free text usable in the name of a file, socket or lock. Short text of letters, digits, '.', '-' and '_' stays
// as it is; any other becomes its allowed beginning, '~' and a part of its SHA-256, so that two texts do not share a
// name.
std::string file_name(const std::string& text);

// Throws Error TB-FOLDER-UNSAFE unless `path` is a folder (not a link) of this user and closed to all others.
void check_private_folder(const std::string& path);

// Makes `path` with mode 0700 if it does not exist, else checks it: this user's folder is closed to others if they can
// read it, and refused if they can write to it. Its parent must exist. Throws Error TB-FOLDER-UNSAFE.
void make_private_folder(const std::string& path);

// Whether `path` is a folder that root made for a group, whose members trust each other's files in it. Throws Error
// TB-FOLDER-UNSAFE when `path` is not a folder or is writable by all.
bool is_group_folder(const std::string& path);

// open(2) of this user's regular file without following a link; refuses a file with a second name (hard link). Not
// inherited by child processes. New files get mode 0600. In a group's folder the file may be any member's, and new ones
// get 0660. On failure -1 and errno; the file is then not truncated.
int open_private_file(const std::string& path, int flags);

// Folder of temporary files: $TMPDIR, or /tmp when that names no folder.
std::string temporary_folder();

// A temporary folder with an unpredictable name, removed with the object. The process holds a lock on it; the next
// ScratchFolder with this prefix removes this user's folders that no living process holds. Throws Error
// TB-FOLDER-UNSAFE.
class ScratchFolder {
 public:
  explicit ScratchFolder(const std::string& prefix);  // "tactbench-nightly"
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
  int lock_ = -1;
};

// Reads a whole file as text, for files that belong to the program.
// All bytes of the file; empty when it cannot be opened. Throws std::ios_base::failure where reading fails.
std::string file_text(const std::filesystem::path& path);

}  // namespace tactbench::bench
