// Tags, notes and voids: kept beside a run, not part of its content.
#include <catch2/catch.hpp>

#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using Words = std::vector<std::string>;

TEST_CASE("tags are a sorted set of words") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = store_example(store), other = store_example(store);
  store.set_tags(run, {"night", "a:b", "night"}, {});
  CHECK(store.run(run).tags == Words{"a:b", "night"});
  CHECK(store.run(other).tags.empty());
  store.set_tags(run, {"new"}, {"night", "never-there"});
  CHECK(store.runs().front().tags == Words{"a:b", "new"});
  store.set_tags(run, {"lot=A7", "order=5"}, {});
  store.set_tags(run, {"lot=A8"}, {"order=5"});  // a key has one value
  CHECK(store.run(run).tags == Words{"a:b", "lot=A8", "new"});
  store.set_tags(run, {}, {"lot=A8"});
  for (const char* wrong : {"", "two words", "x\n", "ä", "a,b", "=x", "x=", "x=y=z"}) {
    CHECK(store_error([&] { store.set_tags(run, {wrong}, {}); }) == "TB-STORE-TAG");
  }
  CHECK(store_error([&] { store.set_tags(run, {std::string(65, 'x')}, {}); }) == "TB-STORE-TAG");
  CHECK(store_error([&] { store.set_tags(99, {"a"}, {}); }) == "TB-STORE-NOT-FOUND");
  CHECK(store.run(run).tags == Words{"a:b", "new"});
  CHECK(store.check_content(run).holds());
}

TEST_CASE("notes are lines that only grow") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = store_example(store);
  store.add_note(run, "first");
  store.add_note(run, "second, \"quoted\"");
  CHECK(store.run(run).notes == "first\nsecond, \"quoted\"");
  for (const char* nothing : {"", " ", "\n\t"})
    CHECK(store_error([&] { store.add_note(run, nothing); }) == "TB-STORE-BLANK");
  CHECK(store_error([&] { store.add_note(99, "x"); }) == "TB-STORE-NOT-FOUND");
  CHECK(store.check_content(run).holds());
}

TEST_CASE("a void run is kept with reason and name, and is not a reference for later runs") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = store_example(store);
  REQUIRE(store.last_check("S-1", "seating", "pass", run + 1));
  CHECK(store_error([&] { store.void_run(run, " ", "me", "2026-01-01T00:00:00Z"); }) == "TB-STORE-BLANK");
  CHECK(store_error([&] { store.void_run(run, "why", "", "2026-01-01T00:00:00Z"); }) == "TB-STORE-BLANK");
  store.void_run(run, "gauge was closed", "N. Nobody", "2026-01-01T00:00:00Z");
  const db::RunRecord record = store.run(run);
  CHECK((record.is_void() && record.void_reason == "gauge was closed" && record.void_by == "N. Nobody"));
  CHECK(store.frame_count(run) == 3);
  CHECK(store.check_content(run).holds());
  CHECK_FALSE(store.last_check("S-1", "seating", "pass", run + 1));
  CHECK(store_error([&] { store.void_run(run, "again", "me", "2026-01-02T00:00:00Z"); }) == "TB-STORE-CONFLICT");
  const std::int64_t open = store.begin_run(example_run());
  CHECK(store_error([&] { store.void_run(open, "why", "me", "2026-01-01T00:00:00Z"); }) == "TB-STORE-CONFLICT");
  db::sqlite::Connection raw(folder.path("runs.db"), db::sqlite::Access::kReadWrite);
  CHECK(raw.integer("SELECT void FROM v_runs WHERE run = 1") == 1);
  CHECK(raw.integer("SELECT void FROM v_runs WHERE run = 2") == 0);
  CHECK(store_error([&] { raw.execute("UPDATE runs SET void_by = ''"); }) == "TB-STORE-CONFLICT");
}

TEST_CASE("time estimates do not learn from void runs") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t first = store_example(store), second = store_example(store);
  CHECK(store.timed_sequences("bench-a", 5).size() == 4);
  store.void_run(second, "gauge closed", "K. Lee", "2026-01-01T00:00:00Z");
  const std::vector<db::TimedSequence> left = store.timed_sequences("bench-a", 5);
  REQUIRE(left.size() == 2);
  CHECK(left.front().run == first);
}
