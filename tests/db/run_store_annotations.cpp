// Baselines and repetitions at their edges.
#include <catch2/catch.hpp>

#include "db/hash_chain.h"
#include "db/sqlite.h"
#include "tests/db/new_store.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using Words = std::vector<std::string>;

namespace {

std::int64_t seeded(RunStore& store, std::int64_t seed, const std::string& origin = "simulated") {
  db::RunRecord record = example_run();
  record.seed = seed;
  record.origin = origin;
  return store_example(store, record);
}

}  // namespace

TEST_CASE("repeated runs: runs without statistics, or open runs with different ones, are not repetitions") {
  NewStore store;
  const std::int64_t one = seeded(store, 1), two = seeded(store, 2);
  CHECK(store.repeated_runs("rig", {one, two}).empty());
  const std::int64_t open = store.begin_run(example_run()), other = store.begin_run(example_run());
  store.replace_figures(open, "rig", {{"x_psi", 1.5}});
  store.replace_figures(other, "rig", {{"x_psi", 2.5}});
  CHECK(store.repeated_runs("rig", {open, other}).empty());
  store.replace_figures(other, "rig", {{"x_psi", 1.5}});
  CHECK(store.repeated_runs("rig", {open, other}) == std::map<std::int64_t, std::int64_t>{{other, open}});
}

TEST_CASE("baselines: a baseline requires a date and runs of one origin") {
  NewStore store;
  const std::int64_t simulated = seeded(store, 1), real = seeded(store, 2, "hardware");
  for (const std::int64_t run : {simulated, real}) {
    store.replace_figures(run, "rig", {{"x_psi", static_cast<double>(run)}});
  }
  const auto added = [&](const std::string& utc, const std::vector<std::int64_t>& runs) {
    return store_error([&] { store.add_baseline({0, "rig", "as made", "K. Lee", utc, runs}); });
  };
  CHECK(added("", {simulated}) == "TB-STORE-CONFLICT");
  CHECK(added(kUtc, {simulated, real}) == "TB-STORE-CONFLICT");
  CHECK(store.baselines().empty());
  CHECK(added(kUtc, {simulated}).empty());
  CHECK(added(kUtc, {real}).empty());
  CHECK(store.baselines().size() == 2);
  // A repetition together with a newly measured run is accepted: one figure has a spread.
  const std::int64_t again = seeded(store, 1), anew = seeded(store, 5);
  store.replace_figures(again, "rig", {{"x_psi", 7.0}});
  store.replace_figures(anew, "rig", {{"x_psi", 8.0}});
  CHECK(added(kUtc, {simulated, again, anew}).empty());
  CHECK(added(kUtc, {simulated, again}) == "TB-STORE-CONFLICT");
}

TEST_CASE("approved reports: a report names the one it replaces and why, and the first names none") {
  NewStore store;
  const std::int64_t run = store_example(store);
  const auto approved = [&](const std::string& number, const std::string& replaces, const std::string& reason) {
    return store_error([&] { store.add_report({run, number, "c", "K. Lee", kUtc, replaces, reason}); });
  };
  CHECK(approved("1-a", "1-0", "why") == "TB-STORE-CONFLICT");
  CHECK(approved("1-a", "", "why") == "TB-STORE-CONFLICT");
  CHECK(approved("1-a", "", "").empty());
  CHECK(approved("1-b", "", "") == "TB-STORE-CONFLICT");
  for (const char* nothing : {"", " \n"}) CHECK(approved("1-b", "1-a", nothing) == "TB-STORE-BLANK");
  CHECK(approved("1-b", "1-a", std::string(db::kMaxTextLength + 1, 'x')) == "TB-STORE-TOO-LONG");
  CHECK(approved("1-b", "1-a", "customer's name corrected").empty());
  CHECK(approved("1-a", "1-b", "why") == "TB-STORE-CONFLICT");
  CHECK(approved("1-c", "1-a", "replaced already") == "TB-STORE-CONFLICT");
  for (const char* nobody : {"", " \t"})
    CHECK(store_error([&] { store.add_report({run, "1-c", "c", nobody, kUtc, "1-b", "why"}); }) == "TB-STORE-BLANK");
  REQUIRE(store.reports(run).size() == 2);
  const db::ReportRecord last = store.reports(run).back();
  CHECK((last.run == run && last.number == "1-b" && last.content_sha256 == "c" && last.approved_by == "K. Lee"));
  CHECK((last.approved_utc == kUtc && last.replaces == "1-a"));
  CHECK((last.reason == "customer's name corrected" && store.reports(run).front().reason.empty()));
  CHECK(store.check_seals(run).empty());
}

TEST_CASE("repeated runs: equal counts are not a repetition, equal content is") {
  NewStore store;
  const std::vector<std::int64_t> runs = {seeded(store, 1), seeded(store, 2), seeded(store, 2)};
  for (const std::int64_t run : runs) store.replace_figures(run, "rig", {{"frames", 124.0}, {"branches_redone", 2.0}});
  CHECK(store.repeated_runs("rig", runs) == std::map<std::int64_t, std::int64_t>{{runs[2], runs[1]}});
}

TEST_CASE("frames hash: depends on the measured data, not on the program that measured") {
  NewStore store;
  db::RunRecord record = example_run();
  const std::int64_t first = store_example(store, record);
  record.program_version = "9.9";
  record.git_commit = "fedcba";
  const std::int64_t second = store_example(store, record);
  CHECK(store.content_hash(first) != store.content_hash(second));
  CHECK(db::frames_hash(store, first) == db::frames_hash(store, second));
  const std::int64_t none = begin_example(store, record).run;
  CHECK(db::frames_hash(store, none) != db::frames_hash(store, first));
  CHECK_THROWS_AS(db::frames_hash(store, 99), db::StoreError);
}

TEST_CASE("tags: are a sorted set of words, with one value per key") {
  NewStore store;
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
  CHECK(store.run(run).tags == Words{"a:b", "new"});
  for (const char* wrong :
       {"", "two words", "x\n", "ä", "a,b", "=x", "x=", "x=y=z", "@", "[", "`", "{", "/*", ";", " ", "\t", ","}) {
    CAPTURE(wrong);
    CHECK(store_error([&] { store.set_tags(run, {wrong}, {}); }) == "TB-STORE-TAG");
    CHECK(store_error([&] { store.set_tags(run, {}, {wrong}); }) == "TB-STORE-TAG");
  }
  CHECK(store_error([&] { store.set_tags(run, {std::string(65, 'x')}, {}); }) == "TB-STORE-TAG");
  CHECK(store_error([&] { store.set_tags(99, {"a"}, {}); }) == "TB-STORE-NOT-FOUND");
  CHECK(store.run(run).tags == Words{"a:b", "new"});
  store.set_tags(run, {std::string(64, 'x'), "AZaz09._:/+-"}, {"a:b", "new"});
  CHECK(store.run(run).tags == Words{"AZaz09._:/+-", std::string(64, 'x')});
  // A key is the whole word before the sign, and has one value.
  store.set_tags(other, {"lot=A", "lots=B", "lo=C", "lot", "a=b"}, {});
  store.set_tags(other, {"lot=D"}, {});
  store.set_tags(other, {"lot"}, {"a=c"});
  CHECK(store.run(other).tags == Words{"a=b", "lo=C", "lot", "lot=D", "lots=B"});
  CHECK(store.check_content(run).holds());
}

TEST_CASE("notes: are lines that can only be added") {
  NewStore store;
  const std::int64_t run = store_example(store);
  store.add_note(run, "first");
  store.add_note(run, "second, \"quoted\"");
  CHECK(store.run(run).notes == "first\nsecond, \"quoted\"");
  for (const char* nothing : {"", " ", "\n\t"})
    CHECK(store_error([&] { store.add_note(run, nothing); }) == "TB-STORE-BLANK");
  CHECK(store_error([&] { store.add_note(99, "x"); }) == "TB-STORE-NOT-FOUND");
  CHECK(store.check_content(run).holds());
}

TEST_CASE("void run: is kept with reason and name, and is not a reference for later runs") {
  NewStore store;
  const std::int64_t run = store_example(store);
  REQUIRE(store.last_check("S-1", "seating", "pass", run + 1));
  CHECK(store_error([&] { store.void_run(run, " ", "me", "2026-01-01T00:00:00Z"); }) == "TB-STORE-BLANK");
  CHECK(store_error([&] { store.void_run(run, "why", "", "2026-01-01T00:00:00Z"); }) == "TB-STORE-BLANK");
  CHECK(store_error([&] { store.void_run(run, "why", "me", ""); }) == "TB-STORE-CONFLICT");
  CHECK_FALSE(store.run(run).is_void());
  store.void_run(run, "gauge was closed", "N. Nobody", "2026-01-01T00:00:00Z");
  const db::RunRecord record = store.run(run);
  CHECK((record.is_void() && record.void_reason == "gauge was closed" && record.void_by == "N. Nobody"));
  CHECK(store.frame_count(run) == 3);
  CHECK(store.check_content(run).holds());
  CHECK_FALSE(store.last_check("S-1", "seating", "pass", run + 1));
  CHECK(store.check_seals(run).empty());
  CHECK(store_error([&] { store.void_run(run, "again", "me", "2026-01-02T00:00:00Z"); }) == "TB-STORE-CONFLICT");
  const std::int64_t open = store.begin_run(example_run());
  CHECK(store_error([&] { store.void_run(open, "why", "me", "2026-01-01T00:00:00Z"); }) == "TB-STORE-CONFLICT");
  db::sqlite::Connection raw(store.path(), db::sqlite::Access::kReadWrite);
  CHECK(raw.integer("SELECT void FROM v_runs WHERE run = 1") == 1);
  CHECK(raw.integer("SELECT void FROM v_runs WHERE run = 2") == 0);
  CHECK(store_error([&] { raw.execute("UPDATE runs SET void_by = ''"); }) == "TB-STORE-CONFLICT");
}

TEST_CASE("time estimates: void runs are not used") {
  NewStore store;
  const std::int64_t first = store_example(store), second = store_example(store);
  CHECK(store.timed_sequences("bench-a", 5).size() == 4);
  store.void_run(second, "gauge closed", "K. Lee", "2026-01-01T00:00:00Z");
  const std::vector<db::TimedSequence> left = store.timed_sequences("bench-a", 5);
  REQUIRE(left.size() == 2);
  CHECK(left.front().run == first);
}
