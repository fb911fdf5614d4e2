// Names, folders and files that nobody else can have made or chosen: what the program keeps of its own beside what
// people name (trips, records, scratch). Whatever lies there already is looked at before it is used, and no link is
// followed.
#pragma once

#include <string>

namespace tactbench::bench {

// Free text as a part of the name of a file, a socket or a lock. Short text of letters, digits, '.', '-' and '_' stays
// as it is; of any other its clean beginning, '~' and a part of its SHA-256 remain, so that two texts never share a
// name.
std::string file_name(const std::string& text);

// Throws Error TB-FOLDER-UNSAFE unless `path` is a folder, no link, of this user, and closed to all others.
void check_private_folder(const std::string& path);

// Makes `path` with mode 0700 where nothing lies there, and checks it otherwise; one of this user that others can read
// is closed to them, one that they can write to is refused. Its parents have to exist. Throws Error TB-FOLDER-UNSAFE.
void make_private_folder(const std::string& path);

// Whether `path` is a folder that root made for a group: of whichever member its files are, its group trusts them.
// Throws Error TB-FOLDER-UNSAFE for what lies there and is none, or can be written to by all.
bool is_group_folder(const std::string& path);

// open(2) of a regular file of this user that has no other name, through no link, not inherited by programs; new ones
// with mode 0600. In a group's folder it may be any member's, and new ones get 0660. -1 and errno where that cannot be;
// nothing is cut short then.
int open_own_file(const std::string& path, int flags);

// Where temporary files go: $TMPDIR, or /tmp where that names no folder.
std::string temporary_folder();

// A folder below the system's temporary one under a name that nobody can foretell; goes with the object. The process
// holds a lock on it, and whoever makes the next folder of this prefix removes those of this user that no living
// process holds. Throws Error TB-FOLDER-UNSAFE.
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

}  // namespace tactbench::bench
