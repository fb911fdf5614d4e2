// Each bit of the header of a store's file, flipped: reading or writing reports it, or is not affected.
#include <catch2/catch.hpp>
#include <filesystem>

#include "bench/common/error.h"
#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

namespace {

constexpr std::size_t kHeaderBytes = 100;

// True when `use` ends with an error, which must be one of the store.
template <class Use>
bool told(Use use) {
  try {
    use();
    return false;
  } catch (const db::StoreError&) {
    CHECK(bench::as_error(std::current_exception()).code() == bench::ExitCode::kStore);
    return true;
  }
}

bool as_it_was(const RunStore& store, const std::string& content) {
  return store.content_hash(1) == content && store.check_content(1).holds() && store.check_seals(1).empty();
}

void write_something(RunStore& store) {
  store.add_note(1, "written after the flip");
  db::RunRecord record = example_run();
  record.purpose = std::string(30'000 / 4, 'x');  // more than a page
  const std::int64_t run = store.begin_run(record);
  const std::int64_t branch = store.begin_branch(run, example_branch());
  for (int i = 0; i < 5; ++i) store.append_frame(run, example_frame(branch, i));
  store.end_run(run, db::Outcome::kStopped, "", db::SafeState::kVerified, "2024-05-02T10:00:00Z");
}

void remove_all_of(const std::string& path) {
  for (const char* ending : {"", "-wal", "-shm", "-journal"}) std::filesystem::remove(path + ending);
}

struct Fates {
  int refused = 0, harmless = 0;
};

Fates flip_each(const std::string& whole, const std::string& content, std::size_t first, std::size_t end) {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  Fates fates;
  for (std::size_t bit = 8 * first; bit < 8 * end; ++bit) {
    CAPTURE(bit / 8, bit % 8);
    std::string bytes = whole;
    bytes[bit / 8] = static_cast<char>(static_cast<unsigned char>(bytes[bit / 8]) ^ (1U << (bit % 8)));
    write_file(path, bytes);
    bool same = true;
    const bool read = !told([&] { same = as_it_was(RunStore::open_read_only(path), content); });
    CHECK(same);
    remove_all_of(path);
    write_file(path, bytes);
    const bool written = !told([&] {
      RunStore store = RunStore::open(path, db::Durability::kNormal);
      write_something(store);
    });
    CHECK(!(written && !read));
    if (read) {  // rows of a refused attempt are not lost either
      CHECK_FALSE(told([&] { same = as_it_was(RunStore::open_read_only(path), content); }));
      CHECK(same);
    }
    ++(written ? fates.harmless : fates.refused);
    remove_all_of(path);
  }
  return fates;
}

std::string store_in(const std::string& path, bool with_free_pages) {
  std::string content;
  {
    RunStore store = RunStore::open(path, db::Durability::kNormal);
    content = store.run(store_example(store)).content_sha256;
  }
  if (with_free_pages)
    Connection(path, Access::kReadWrite)
        .execute("CREATE TABLE gone (b BLOB); INSERT INTO gone VALUES (zeroblob(20000)); DROP TABLE gone");
  REQUIRE_FALSE(std::filesystem::exists(path + "-wal"));
  return content;
}

}  // namespace

TEST_CASE("each flipped bit of a store's header is refused, or makes no difference to reading and writing") {
  const TemporaryFolder folder;
  const std::string content = store_in(folder.path("runs.db"), false);
  const Fates fates = flip_each(read_file(folder.path("runs.db")), content, 0, kHeaderBytes);
  CHECK(fates.refused + fates.harmless == 800);
  CHECK(fates.refused > 400);   // page size, versions, formats, pages, encoding, schema, application
  CHECK(fates.harmless > 100);  // counters of changes, reserved bytes, the version of the library
}

TEST_CASE("each flipped bit of the header is refused or harmless also where pages are free") {
  const TemporaryFolder folder;
  const std::string content = store_in(folder.path("runs.db"), true);
  REQUIRE(Connection(folder.path("runs.db"), Access::kReadOnly).integer("PRAGMA freelist_count") > 3);
  const Fates fates = flip_each(read_file(folder.path("runs.db")), content, 24, 40);
  CHECK(fates.refused + fates.harmless == 128);
}

TEST_CASE("an impossible schema version is reported as damage") {
  const TemporaryFolder folder;
  const std::string path = folder.path("runs.db");
  RunStore::open(path);
  for (const int version : {-1, -5, -2147483647, 0}) {
    Connection(path, Access::kReadWrite).execute("PRAGMA user_version = " + std::to_string(version));
    CHECK(store_error([&] { RunStore::open(path); }) == "TB-STORE-OPEN");
    CHECK(store_error([&] { RunStore::open_read_only(path); }) == "TB-STORE-OPEN");
    CHECK(store_error([&] { (void)db::schema_version_of(path); }) == "TB-STORE-OPEN");
  }
  CHECK_FALSE(std::filesystem::exists(path + ".schema--1.backup"));
}
