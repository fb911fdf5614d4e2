// Names, modes and words of the program's own folders and files, each at its edges.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/error.h"
#include "bench/common/private_files.h"
#include "tests/bench/common/file_mode.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"
#include "tests/support/variable.h"

using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

constexpr uid_t kAnotherUser = 65534;
constexpr gid_t kAnyGroup = 54321;

template <class Work>
std::string folder_refusal(const Work& work) {
  const auto error = refusal_by(work);
  if (!error) return "not refused";
  CHECK(error->id() == "TB-FOLDER-UNSAFE");
  CHECK(error->code() == ExitCode::kUsage);
  return error->where();
}

// Opens and closes; true where it could be opened.
bool opens(const std::string& path, int flags) {
  const int file = open_own_file(path, flags);
  if (file < 0) {
    CHECK(errno == EPERM);
    return false;
  }
  close(file);
  return true;
}

}  // namespace

TEST_CASE("private file names: which characters stay, and what takes the place of others") {
  for (const std::string& stays : {std::string("azAZ09.-_"), std::string(48, 'x')}) CHECK(file_name(stays) == stays);
  CHECK(file_name("a b") == "a_b~c8687a08aa5d6ed20443");  // the text's SHA-256
  CHECK_THAT(file_name("@`[{/:a"), Catch::StartsWith("______a~"));
  CHECK_THAT(file_name("0123456789012345678901234 "), Catch::StartsWith("012345678901234567890123~"));
}

TEST_CASE("private folders: each right of others is taken away, or refused") {
  const TemporaryFolder folder;
  const std::string path = folder.path("own");
  make_private_folder(path);
  CHECK(folder_refusal([&] { check_private_folder(path); }) == "not refused");
  for (const mode_t mode : {0701, 0704, 0710, 0740, 01755}) {
    INFO(std::oct << mode);
    REQUIRE(chmod(path.c_str(), mode) == 0);
    CHECK(folder_refusal([&] { check_private_folder(path); }) == path);
    CHECK(folder_refusal([&] { make_private_folder(path); }) == "not refused");
    CHECK(mode_of(path) == 0700);
  }
  for (const mode_t mode : {0720, 0702, 01777}) {
    REQUIRE(chmod(path.c_str(), mode) == 0);
    CHECK(folder_refusal([&] { make_private_folder(path); }) == path);
    CHECK(mode_of(path) == mode);
  }
  // One that its owner may not write to is closed all the same.
  for (const mode_t mode : {0500, 0700, 0000}) {
    REQUIRE(chmod(path.c_str(), mode) == 0);
    CHECK(folder_refusal([&] { make_private_folder(path); }) == "not refused");
    CHECK(mode_of(path) == mode);
  }
  const std::string none = folder.path("none");
  CHECK(folder_refusal([&] { check_private_folder(none); }) == none);
  write_file(folder.path("file"), "");
  CHECK(folder_refusal([&] { check_private_folder(folder.path("file")); }) == folder.path("file"));
  const std::string inside = folder.path("file") + "/own";
  CHECK(folder_refusal([&] { make_private_folder(inside); }) == inside);
}

TEST_CASE("group folders: one that is missing is none, all others have to be root's and a group's") {
  const TemporaryFolder folder;
  const std::string path = folder.path("shared");
  CHECK_FALSE(is_group_folder(path));
  write_file(folder.path("file"), "");
  CHECK(folder_refusal([&] { (void)is_group_folder(folder.path("file")); }) == folder.path("file"));
  const std::string inside = folder.path("file") + "/shared";
  CHECK(folder_refusal([&] { (void)is_group_folder(inside); }) == inside);
  std::filesystem::create_directory(path);
  REQUIRE(chmod(path.c_str(), 0770) == 0);
  CHECK(folder_refusal([&] { (void)is_group_folder(path); }) == path);
  if (geteuid() != 0) return;
  REQUIRE(chmod(path.c_str(), 02770) == 0);
  CHECK(is_group_folder(path));
  REQUIRE(chmod(path.c_str(), 02775) == 0);
  CHECK(is_group_folder(path));
  REQUIRE(chmod(path.c_str(), 02772) == 0);
  CHECK(folder_refusal([&] { (void)is_group_folder(path); }) == path);
  REQUIRE(chown(path.c_str(), kAnotherUser, 0) == 0);
  REQUIRE(chmod(path.c_str(), 02770) == 0);
  CHECK(folder_refusal([&] { (void)is_group_folder(path); }) == path);
}

TEST_CASE("own files: where others' files are taken, which mode new ones get, and that nothing is cut short unasked") {
  const TemporaryFolder folder;
  const std::string path = folder.path("file");
  const int make = O_WRONLY | O_CREAT;
  REQUIRE(opens(path, make));
  CHECK(mode_of(path) == 0600);
  write_file(path, "kept");
  REQUIRE(opens(path, make));
  CHECK(read_file(path) == "kept");
  REQUIRE(opens(path, make | O_TRUNC));
  CHECK(read_file(path).empty());
  CHECK(open_own_file(folder.path("none"), O_RDONLY) == -1);
  CHECK(errno == ENOENT);
  std::filesystem::create_directory(folder.path("folder"));
  CHECK_FALSE(opens(folder.path("folder"), O_RDONLY));
  if (geteuid() != 0) return;
  const std::string shared = folder.path("shared"), inside = shared + "/file", other = shared + "/other";
  std::filesystem::create_directory(shared);
  write_file(other, "theirs");
  REQUIRE(chown(other.c_str(), kAnotherUser, kAnyGroup) == 0);
  REQUIRE(chmod(other.c_str(), 0640) == 0);
  struct Row {
    uid_t user;
    mode_t mode;
    bool trusted;
  };
  for (const Row& row : {Row{0, 02770, true}, Row{0, 02775, true}, Row{0, 0770, false}, Row{0, 02750, false},
                         Row{0, 02772, false}, Row{kAnotherUser, 02770, false}}) {
    INFO(row.user << " " << std::oct << row.mode);
    REQUIRE(chown(shared.c_str(), row.user, kAnyGroup) == 0);
    REQUIRE(chmod(shared.c_str(), row.mode) == 0);
    std::filesystem::remove(inside);
    REQUIRE(opens(inside, make));
    CHECK(mode_of(inside) == (row.trusted ? 0660 : 0600));
    CHECK(opens(other, O_RDONLY) == row.trusted);
    CHECK(opens(other, O_WRONLY | O_TRUNC) == row.trusted);
    CHECK(mode_of(other) == 0640);  // another member's file keeps its mode
    CHECK(read_file(other) == (row.trusted ? "" : "theirs"));
    write_file(other, "theirs");
  }
}

TEST_CASE("scratch folders: where they are made, and that those of other users stay") {
  const TemporaryFolder folder;
  {
    const Variable temporary("TMPDIR", folder.path("none"));
    CHECK(temporary_folder() == "/tmp");
  }
  const Variable temporary("TMPDIR", folder.path());
  CHECK(std::filesystem::equivalent(temporary_folder(), folder.path()));
  CHECK(folder_refusal([] { const ScratchFolder none("no/where"); }) != "not refused");
  const std::string left = folder.path("tactbench-x.abcdef"), theirs = folder.path("tactbench-x.ghijkl");
  for (const std::string& path : {left, theirs}) {
    std::filesystem::create_directory(path);
    REQUIRE(chmod(path.c_str(), 0700) == 0);
  }
  const bool root = geteuid() == 0;
  if (root) REQUIRE(chown(theirs.c_str(), kAnotherUser, kAnyGroup) == 0);
  const ScratchFolder own("tactbench-x");
  CHECK_FALSE(std::filesystem::exists(left));
  CHECK(std::filesystem::exists(theirs) == root);
  const std::string name = std::filesystem::path(own.path()).filename().string();
  CHECK(name.size() == 18);
  CHECK(name.starts_with("tactbench-x."));
}
