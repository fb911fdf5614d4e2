// Stores on a network file system are refused. Mounting one needs rights that a test does not have, so here statfs
// reports NFS for one folder and the truth for all others.
#include <fcntl.h>
#include <mntent.h>
#include <sys/syscall.h>
#include <sys/vfs.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <cstdio>
#include <filesystem>
#include <string_view>
#include <vector>

#include "bench/cli/session.h"
#include "db/store_file.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;

namespace {

std::string networked;
std::int64_t magic_there = 0x6969;  // NFS

// The type of the file system on which a folder lies, by the longest mount point above it.
std::string mounted_type(const std::string& folder) {
  std::string type;
  std::size_t longest = 0;
  FILE* mounts = ::setmntent("/proc/self/mounts", "r");
  REQUIRE(mounts != nullptr);
  while (const mntent* entry = ::getmntent(mounts)) {
    std::string point = entry->mnt_dir;
    if (!point.ends_with('/')) point += '/';
    if (!(folder + '/').starts_with(point) || point.size() < longest) continue;
    longest = point.size();
    type = entry->mnt_type;
  }
  ::endmntent(mounts);
  return type;
}

}  // namespace

extern "C" int statfs(const char* path, struct statfs* status) noexcept {
  const long result = ::syscall(SYS_statfs, path, status);
  if (result == 0 && !networked.empty() && std::string_view(path).starts_with(networked)) status->f_type = magic_there;
  return static_cast<int>(result);
}

TEST_CASE("network store: a store on a network file system is not created, opened or copied to") {
  const TemporaryFolder folder;
  const std::string local = folder.path("local"), there = folder.path("there");
  std::filesystem::create_directory(local);
  std::filesystem::create_directory(there);
  const RunStore store = RunStore::open(local + "/runs.db");
  RunStore::open(there + "/old.db");  // before the folder is reported as NFS
  networked = there;
  std::string message;
  CHECK(store_error([&] { RunStore::open(there + "/new.db"); }, &message) == "TB-STORE-NETWORK");
  CHECK_THAT(message, Catch::Contains("NFS"));
  CHECK(store_error([&] { RunStore::open(there + "/old.db"); }) == "TB-STORE-NETWORK");
  CHECK(store_error([&] { store.snapshot(there + "/copy.db"); }) == "TB-STORE-NETWORK");
  CHECK(store_error([&] { db::schema_version_of(there + "/old.db"); }) == "TB-STORE-NETWORK");
  CHECK(store_error([&] { RunStore::open(local + "/other.db"); }).empty());
  networked.clear();
  CHECK_FALSE(std::filesystem::exists(there + "/new.db"));
  CHECK_FALSE(std::filesystem::exists(there + "/copy.db"));
  CHECK(store_error([&] { RunStore::open(there + "/old.db"); }).empty());
}

TEST_CASE("network store: a finished store is readable with a warning, one with a non-empty log is not") {
  const TemporaryFolder folder;
  const std::string there = folder.path("there"), path = there + "/runs.db", log = path + "-wal";
  std::filesystem::create_directory(there);
  std::int64_t run = 0;
  {
    RunStore store = RunStore::open(path);
    run = store_example(store);
  }
  networked = there;
  std::vector<std::string> warnings;
  db::set_warning_handler([&](const std::string& text) { warnings.push_back(text); });
  {
    RunStore store = RunStore::open_read_only(path);
    REQUIRE(warnings.size() == 1);
    CHECK_THAT(warnings[0], Catch::Contains(path) && Catch::Contains("NFS"));
    (void)RunStore::open_read_only(path);
    CHECK(warnings.size() == 1);
    CHECK(store.check_content(run).holds());
    CHECK(store_error([&] { store.add_note(run, "late"); }) == "TB-STORE-OPEN");
    CHECK_FALSE(std::filesystem::exists(path + "-shm"));  // no memory is shared over a network
    RunStore local = RunStore::open(folder.path("local.db"));
    CHECK(store_error([&] { (void)local.copy_runs_from(store, {run}); }) == "TB-STORE-NETWORK");
  }
  write_file(log, "");  // a log in which there is nothing
  CHECK(RunStore::open_read_only(path).frame_count(run) == 3);
  CHECK(warnings.size() == 1);
  write_file(log, "1");
  CHECK(store_error([&] { RunStore::open_read_only(path); }) == "TB-STORE-NETWORK");
  write_file(log, "frames that are not in the file yet");
  CHECK(store_error([&] { RunStore::open_read_only(path); }) == "TB-STORE-NETWORK");
  networked.clear();
  db::set_warning_handler({});
}

TEST_CASE("network store: the warning escapes control characters of the file name") {
  const TemporaryFolder folder;
  const std::string there = folder.path("th\x1b[31mere"), told = folder.path("told");
  std::filesystem::create_directory(there);
  RunStore::open(there + "/runs.db");
  networked = there;
  std::vector<std::string> words = {"tactbench", "runs", "list", "--db", there + "/runs.db"};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  const int terminal = dup(STDERR_FILENO), file = open(told.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0600);
  REQUIRE((terminal >= 0 && file >= 0 && dup2(file, STDERR_FILENO) >= 0));
  const int code = bench::run_command_line(static_cast<int>(arguments.size()), arguments.data());
  REQUIRE(dup2(terminal, STDERR_FILENO) >= 0);
  for (const int descriptor : {terminal, file}) close(descriptor);
  networked.clear();
  db::set_warning_handler({});
  CHECK(code == 0);
  CHECK_THAT(read_file(told), Catch::Contains("th\\x1b[31mere/runs.db") && !Catch::Contains("\x1b"));
}

TEST_CASE("network store: a FUSE file system is named as in the mount table") {
  const TemporaryFolder folder;
  const std::string type = mounted_type(folder.path());
  networked = folder.path();
  magic_there = 0x65735546;
  std::string message;
  const std::string id = store_error([&] { RunStore::open(folder.path("runs.db")); }, &message);
  networked.clear();
  magic_there = 0x6969;
  CAPTURE(message, type);
  CHECK(id == "TB-STORE-NETWORK");
  CHECK_THAT(message, Catch::Contains("(" + type + ")"));
}

TEST_CASE("network store: a 32-bit file system number is recognised with and without sign extension") {
  const TemporaryFolder folder;
  networked = folder.path();
  for (const std::int64_t number : {std::int64_t{0xff534d42}, std::int64_t{0xff534d42} - (std::int64_t{1} << 32)}) {
    magic_there = number;
    std::string message;
    CHECK(store_error([&] { RunStore::open(folder.path("runs.db")); }, &message) == "TB-STORE-NETWORK");
    CHECK_THAT(message, Catch::Contains("(CIFS)"));
  }
  networked.clear();
  magic_there = 0x6969;
}
