// The program's own folders and files when made by others, linked elsewhere or open to all.
#include "bench/common/private_files.h"

#include <fcntl.h>
#include <grp.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cerrno>
#include <filesystem>
#include <functional>
#include <set>

#include "bench/common/error.h"
#include "bench/guard/trip.h"
#include "tests/bench/common/file_mode.h"
#include "tests/support/process.h"
#include "tests/support/refusal.h"
#include "tests/support/variable.h"

using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

constexpr uid_t kNobody = 65534;
constexpr gid_t kSomeGroup = 54321;

template <class Work>
std::string refused_as(const Work& work) {
  const auto error = refusal_by(work);
  if (!error) return "not refused";
  return error->id();
}

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
  const int file = open_private_file(path, flags);
  if (file < 0) {
    CHECK(errno == EPERM);
    return false;
  }
  close(file);
  return true;
}

}  // namespace

TEST_CASE("private files: a bench id becomes a unique file name within its folder") {
  CHECK(file_name("rig-1_left.b") == "rig-1_left.b");
  std::set<std::string> names;
  std::vector<std::string> ids = {std::string(48, 'x'), std::string(49, 'x'), std::string(2000, '/'),
                                  std::string("a\0b", 3)};
  for (const char* id :
       {"a b", "a_b", "a/b", "a\nb", "../../victim", "..", ".", "", "~", ".git", "r\xc3\xbcttler", "a b~"})
    ids.emplace_back(id);
  for (const std::string& id : ids) {
    const std::string name = file_name(id);
    INFO(id << " -> " << name);
    CHECK(names.insert(name).second);
    CHECK((file_name(name) == name || names.count(file_name(name)) == 0));  // a name is not another text's either
    CHECK(name.size() <= 48);
    CHECK(name.front() != '.');
    CHECK(name.find('/') == std::string::npos);
    CHECK_FALSE(name.empty());
  }
  const std::string trip = TripFile("../../victim").path();
  CHECK(std::filesystem::path(trip).parent_path() == state_folder());
}

TEST_CASE("private files: links, pipes and files of other users are not opened, and not truncated") {
  const TemporaryFolder folder;
  const std::string precious = folder.path("precious"), path = folder.path("log");
  const int flags = O_WRONLY | O_CREAT | O_TRUNC;
  write_file(precious, "kept");
  std::filesystem::create_symlink(precious, path);
  CHECK(open_private_file(path, flags) < 0);
  std::filesystem::remove(path);
  std::filesystem::create_hard_link(precious, path);
  CHECK(open_private_file(path, flags) < 0);
  std::filesystem::remove(path);
  REQUIRE(mkfifo(path.c_str(), 0600) == 0);
  CHECK(open_private_file(path, O_RDONLY) < 0);
  std::filesystem::remove(path);
  CHECK(read_file(precious) == "kept");
  write_file(path, "older and longer");
  const int file = open_private_file(path, flags);
  REQUIRE(file >= 0);
  CHECK(write(file, "new", 3) == 3);
  CHECK((fcntl(file, F_GETFD) & FD_CLOEXEC) != 0);
  close(file);
  CHECK(read_file(path) == "new");
  if (geteuid() != 0) return;
  REQUIRE(chown(path.c_str(), kNobody, kNobody) == 0);
  CHECK(open_private_file(path, flags) < 0);
  CHECK(read_file(path) == "new");
}

TEST_CASE("private files: without a home folder, trips are stored in a folder that no other user made") {
  const TemporaryFolder folder;
  const Variable home("HOME", std::nullopt), state("XDG_STATE_HOME", std::nullopt), temporary("TMPDIR", folder.path());
  const std::string base = folder.path("tactbench-state-" + std::to_string(geteuid()));
  write_file(folder.path("precious"), "kept");
  std::filesystem::create_directory(base);
  REQUIRE(chmod(base.c_str(), 0777) == 0);
  CHECK(refused_as([] { (void)state_folder("/no/machine"); }) == "TB-FOLDER-UNSAFE");
  REQUIRE(chmod(base.c_str(), 0700) == 0);
  std::filesystem::create_directory_symlink(folder.path(), base + "/tactbench");
  CHECK(refused_as([] { (void)state_folder("/no/machine"); }) == "TB-FOLDER-UNSAFE");
  std::filesystem::remove(base + "/tactbench");
  REQUIRE(state_folder("/no/machine") == base + "/tactbench");
  CHECK(mode_of(base + "/tactbench") == 0700);
  const Variable there("XDG_STATE_HOME", base);
  const TripFile trip("rig");
  std::filesystem::create_symlink(folder.path("precious"), trip.log_path());
  REQUIRE(trip.store({"TB-CHAMBER-TRIP", "67 psi", 1, {}}));
  CHECK(refused_as([&] { trip.reset(*trip.read(), "P"); }) == "TB-FILE-WRITE");
  CHECK(trip.read());
  CHECK(read_file(folder.path("precious")) == "kept");
}

TEST_CASE("private files: trips of the machine are stored only in a group folder of root") {
  const TemporaryFolder folder;
  const Variable state("XDG_STATE_HOME", std::nullopt), home("HOME", folder.path());
  const std::string machine = folder.path("machine");
  CHECK(state_folder(machine) == folder.path(".local/state/tactbench"));
  std::filesystem::create_directory(machine);
  REQUIRE(chmod(machine.c_str(), 0700) == 0);
  CHECK(refused_as([&] { (void)state_folder(machine); }) == "TB-FOLDER-UNSAFE");
  if (geteuid() != 0) return;
  const auto give = [&](uid_t user, mode_t mode) {
    REQUIRE(chown(machine.c_str(), user, kSomeGroup) == 0);
    REQUIRE(chmod(machine.c_str(), mode) == 0);
  };
  give(kNobody, 02770);
  CHECK(refused_as([&] { (void)state_folder(machine); }) == "TB-FOLDER-UNSAFE");
  give(0, 02777);
  CHECK(refused_as([&] { (void)state_folder(machine); }) == "TB-FOLDER-UNSAFE");
  give(0, 02770);
  CHECK(state_folder(machine) == machine);
  std::filesystem::create_directory_symlink(machine, folder.path("link"));
  CHECK(refused_as([&] { (void)state_folder(folder.path("link")); }) == "TB-FOLDER-UNSAFE");
  // One member writes, another reads and continues to write; a non-member gets an error.
  REQUIRE(chmod(folder.path().c_str(), 0755) == 0);
  const std::string path = machine + "/rig.log";
  const auto as_member = [&](uid_t user, gid_t group, const std::function<bool()>& work) {
    const pid_t child = fork();
    if (child == 0) {
      const bool became = setgroups(1, &group) == 0 && setgid(60000) == 0 && setuid(user) == 0;
      _exit(became && work() ? 0 : 1);
    }
    int status = -1;
    waitpid(child, &status, 0);
    return status == 0;
  };
  for (const uid_t user : {60001, 60002}) {
    CHECK(as_member(user, kSomeGroup, [&] {
      const int file = open_private_file(path, O_WRONLY | O_CREAT | O_APPEND);
      return state_folder(machine) == machine && file >= 0 && write(file, "x", 1) == 1;
    }));
  }
  CHECK(read_file(path) == "xx");
  CHECK(as_member(60003, 60004, [&] { return refused_as([&] { (void)state_folder(machine); }) == "TB-STATE-DENIED"; }));
}

TEST_CASE("private files: a new scratch folder removes the folders of killed processes, and nothing else") {
  const TemporaryFolder folder;
  const Variable temporary("TMPDIR", folder.path());
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  const pid_t owner = fork();
  if (owner == 0) {
    alarm(60);
    const ScratchFolder own("tactbench-x");
    write_file(own.path() + "/store", "x");
    if (write(ends[1], own.path().c_str(), own.path().size()) < 0) _exit(1);
    for (;;) pause();
  }
  char told[4096];
  const ssize_t size = read(ends[0], told, sizeof told);
  for (const int end : ends) close(end);
  REQUIRE(size > 0);
  const std::string left(told, static_cast<std::size_t>(size));
  // Not of this program, or of an earlier one that locked nothing.
  const std::vector<std::string> others = {"tactbench-x.shared", "tactbench-xy.abcde", "tactbench-x-abcdef",
                                           "tactbench-x.longer-one", "precious"};
  for (const std::string& name : others) {
    std::filesystem::create_directory(folder.path(name));
    REQUIRE(chmod(folder.path(name).c_str(), name == others.front() ? 0755 : 0700) == 0);
    write_file(folder.path(name) + "/file", "kept");
  }
  std::filesystem::create_directory_symlink(folder.path("precious"), folder.path("tactbench-x.linked"));
  write_file(folder.path("tactbench-x.a-file"), "kept");
  { const ScratchFolder next("tactbench-x"); }
  CHECK(read_file(left + "/store") == "x");  // its owner lives
  REQUIRE(kill(owner, SIGKILL) == 0);
  REQUIRE(waitpid(owner, nullptr, 0) == owner);
  { const ScratchFolder another("tactbench-y"); }
  CHECK(std::filesystem::exists(left));
  const ScratchFolder next("tactbench-x");
  CHECK_FALSE(std::filesystem::exists(left));
  CHECK(std::filesystem::exists(next.path()));
  for (const std::string& name : others) CHECK(read_file(folder.path(name) + "/file") == "kept");
  CHECK(std::filesystem::is_symlink(folder.path("tactbench-x.linked")));
  CHECK(read_file(folder.path("tactbench-x.a-file")) == "kept");
}

TEST_CASE("private files: a scratch folder has an unpredictable name, is closed to others, and is removed") {
  const TemporaryFolder folder;
  const Variable temporary("TMPDIR", folder.path());
  std::string one, other;
  {
    const ScratchFolder first("tactbench-x"), second("tactbench-x");
    one = first.path();
    other = second.path();
    CHECK(one != other);
    CHECK(mode_of(one) == 0700);
    write_file(one + "/file", "x");
  }
  CHECK_FALSE(std::filesystem::exists(one));
  CHECK(std::filesystem::is_empty(folder.path()));
}

TEST_CASE("private file names: which characters are kept, and how others are replaced") {
  for (const std::string& stays : {std::string("azAZ09.-_"), std::string(48, 'x')}) CHECK(file_name(stays) == stays);
  CHECK(file_name("a b") == "a_b~c8687a08aa5d6ed20443");  // the text's SHA-256
  CHECK_THAT(file_name("@`[{/:a"), Catch::StartsWith("______a~"));
  CHECK_THAT(file_name("0123456789012345678901234 "), Catch::StartsWith("012345678901234567890123~"));
}

TEST_CASE("private folders: access rights of others are removed, or the folder is rejected") {
  const TemporaryFolder folder;
  const std::string path = folder.path("own");
  make_private_folder(path);
  CHECK(mode_of(path) == 0700);
  CHECK(folder_refusal([&] { check_private_folder(path); }) == "not refused");
  const std::string link = folder.path("link");
  std::filesystem::create_directory_symlink(path, link);
  CHECK(folder_refusal([&] { make_private_folder(link); }) == link);
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
  if (geteuid() != 0) return;
  REQUIRE(chown(path.c_str(), kNobody, kNobody) == 0);
  CHECK(folder_refusal([&] { make_private_folder(path); }) == path);
}

TEST_CASE(
    "own files: which files of other users are trusted, which mode new files get, no truncation unless requested") {
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
  CHECK(open_private_file(folder.path("none"), O_RDONLY) == -1);
  CHECK(errno == ENOENT);
  std::filesystem::create_directory(folder.path("folder"));
  CHECK_FALSE(opens(folder.path("folder"), O_RDONLY));
  if (geteuid() != 0) return;
  const std::string shared = folder.path("shared"), inside = shared + "/file", other = shared + "/other";
  std::filesystem::create_directory(shared);
  write_file(other, "theirs");
  REQUIRE(chown(other.c_str(), kNobody, kSomeGroup) == 0);
  REQUIRE(chmod(other.c_str(), 0640) == 0);
  struct Row {
    uid_t user;
    mode_t mode;
    bool trusted;
  };
  for (const Row& row : {Row{0, 02770, true}, Row{0, 02775, true}, Row{0, 0770, false}, Row{0, 02750, false},
                         Row{0, 02772, false}, Row{kNobody, 02770, false}}) {
    INFO(row.user << " " << std::oct << row.mode);
    REQUIRE(chown(shared.c_str(), row.user, kSomeGroup) == 0);
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
