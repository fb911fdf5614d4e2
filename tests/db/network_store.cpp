// What lies on a network file system is refused. To mount one needs rights that a test does not have, so statfs answers
// here for one folder as it does for NFS, and for all others as ever.
#include <sys/syscall.h>
#include <sys/vfs.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <filesystem>
#include <string_view>

#include "db/store_file.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;

namespace {
std::string networked;
}

extern "C" int statfs(const char* path, struct statfs* status) noexcept {
  const long result = ::syscall(SYS_statfs, path, status);
  if (result == 0 && !networked.empty() && std::string_view(path).starts_with(networked)) status->f_type = 0x6969;
  return static_cast<int>(result);
}

TEST_CASE("a store on a network file system is neither made, opened, read nor copied there") {
  const TemporaryFolder folder;
  const std::string local = folder.path("local"), there = folder.path("there");
  std::filesystem::create_directory(local);
  std::filesystem::create_directory(there);
  const RunStore store = RunStore::open(local + "/runs.db");
  RunStore::open(there + "/old.db");  // before the folder became a network's
  networked = there;
  std::string message;
  CHECK(store_error([&] { RunStore::open(there + "/new.db"); }, &message) == "TB-STORE-NETWORK");
  CHECK_THAT(message, Catch::Contains("NFS"));
  CHECK(store_error([&] { RunStore::open(there + "/old.db"); }) == "TB-STORE-NETWORK");
  CHECK(store_error([&] { RunStore::open_read_only(there + "/old.db"); }) == "TB-STORE-NETWORK");
  CHECK(store_error([&] { store.snapshot(there + "/copy.db"); }) == "TB-STORE-NETWORK");
  CHECK(store_error([&] { db::schema_version_of(there + "/old.db"); }) == "TB-STORE-NETWORK");
  CHECK(store_error([&] { RunStore::open(local + "/other.db"); }).empty());
  networked.clear();
  CHECK_FALSE(std::filesystem::exists(there + "/new.db"));
  CHECK_FALSE(std::filesystem::exists(there + "/copy.db"));
  CHECK(store_error([&] { RunStore::open(there + "/old.db"); }).empty());
}
