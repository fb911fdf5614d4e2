// Baselines and repetitions at their edges.
#include <catch2/catch.hpp>

#include "db/frames_hash.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;

namespace {

std::int64_t seeded(RunStore& store, std::int64_t seed, const std::string& origin = "simulated") {
  db::RunRecord record = example_run();
  record.seed = seed;
  record.origin = origin;
  return store_example(store, record);
}

}  // namespace

TEST_CASE("a repetition is named by the earlier run, in whatever order they are asked for") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t first = seeded(store, 1), second = seeded(store, 1), third = seeded(store, 1);
  using Repeated = std::map<std::int64_t, std::int64_t>;
  CHECK(store.repeated_runs("rig", {third, first, second}) == Repeated{{second, first}, {third, first}});
  CHECK(store.repeated_runs("rig", {third, second}) == Repeated{{third, second}});
  CHECK(store.repeated_runs("rig", {}).empty());
}

TEST_CASE("runs without figures or without an end are not repetitions of each other") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t one = seeded(store, 1), two = seeded(store, 2);
  CHECK(store.repeated_runs("rig", {one, two}).empty());
  const std::int64_t open = store.begin_run(example_run()), other = store.begin_run(example_run());
  store.replace_figures(open, "rig", {{"x_psi", 1.5}});
  store.replace_figures(other, "rig", {{"x_psi", 2.5}});
  CHECK(store.repeated_runs("rig", {open, other}).empty());
  store.replace_figures(other, "rig", {{"x_psi", 1.5}});
  CHECK(store.repeated_runs("rig", {open, other}) == std::map<std::int64_t, std::int64_t>{{other, open}});
}

TEST_CASE("a baseline has a date and one origin") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
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
  // A repetition beside a run measured anew is no reason to refuse: one figure has a spread.
  const std::int64_t again = seeded(store, 1), anew = seeded(store, 5);
  store.replace_figures(again, "rig", {{"x_psi", 7.0}});
  store.replace_figures(anew, "rig", {{"x_psi", 8.0}});
  CHECK(added(kUtc, {simulated, again, anew}).empty());
  CHECK(added(kUtc, {simulated, again}) == "TB-STORE-CONFLICT");
}

TEST_CASE("a report names the one that it replaces and why, the first names none") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = store_example(store);
  const auto approved = [&](const std::string& number, const std::string& replaces, const std::string& reason) {
    return store_error([&] { store.add_report({run, number, "c", "K. Lee", kUtc, replaces, reason}); });
  };
  CHECK(approved("1-a", "1-0", "why") == "TB-STORE-CONFLICT");
  CHECK(approved("1-a", "", "why") == "TB-STORE-CONFLICT");
  CHECK(approved("1-a", "", "").empty());
  CHECK(approved("1-b", "", "") == "TB-STORE-CONFLICT");
  for (const char* nothing : {"", " \n"}) CHECK(approved("1-b", "1-a", nothing) == "TB-STORE-BLANK");
  CHECK(approved("1-b", "1-a", std::string(db::kLongestText + 1, 'x')) == "TB-STORE-TOO-LONG");
  CHECK(approved("1-b", "1-a", "customer's name corrected").empty());
  CHECK(approved("1-a", "1-b", "why") == "TB-STORE-CONFLICT");
  REQUIRE(store.reports(run).size() == 2);
  const db::ReportRecord last = store.reports(run).back();
  CHECK((last.run == run && last.number == "1-b" && last.content_sha256 == "c" && last.approved_by == "K. Lee"));
  CHECK((last.approved_utc == kUtc && last.replaces == "1-a"));
  CHECK((last.reason == "customer's name corrected" && store.reports(run).front().reason.empty()));
  CHECK(store.check_seals(run).empty());
}

TEST_CASE("a tag may have 64 characters, and any of the signs that tags may have") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = store_example(store);
  const std::vector<std::string> good = {std::string(64, 'x'), "AZaz09._:/+-"};
  store.set_tags(run, good, {});
  CHECK(store.run(run).tags == std::vector<std::string>{"AZaz09._:/+-", std::string(64, 'x')});
  for (const char* sign : {"@", "[", "`", "{", "/*", ";", " ", "\t", ","}) {
    CAPTURE(sign);
    CHECK(store_error([&] { store.set_tags(run, {sign}, {}); }) == "TB-STORE-TAG");
    CHECK(store_error([&] { store.set_tags(run, {}, {sign}); }) == "TB-STORE-TAG");
  }
  store.set_tags(run, {}, good);
  CHECK(store.run(run).tags.empty());
}

TEST_CASE("a run is void with a reason, a name and a date") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::int64_t run = store_example(store);
  CHECK(store_error([&] { store.void_run(run, "why", "me", ""); }) == "TB-STORE-CONFLICT");
  CHECK_FALSE(store.run(run).is_void());
  store.void_run(run, std::string(db::kLongestText, 'w'), std::string(db::kLongestName, 'm'), kUtc);
  CHECK(store.run(run).is_void());
  CHECK(store.check_seals(run).empty());
}

TEST_CASE("equal counts are no repetition, the same content is") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
  const std::vector<std::int64_t> runs = {seeded(store, 1), seeded(store, 2), seeded(store, 2)};
  for (const std::int64_t run : runs) store.replace_figures(run, "rig", {{"frames", 124.0}, {"branches_redone", 2.0}});
  CHECK(store.repeated_runs("rig", runs) == std::map<std::int64_t, std::int64_t>{{runs[2], runs[1]}});
}

TEST_CASE("the hash over the frames is that of what was measured, whatever program did") {
  const TemporaryFolder folder;
  RunStore store = RunStore::open(folder.path("runs.db"));
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
