// Rows of a run at the edges that neighbours and changes from outside make: branches in turn, keys of tags, frames of
// no branch, frames that came back.
#include <catch2/catch.hpp>

#include "db/hash_chain.h"
#include "db/sqlite.h"
#include "tests/db/new_store.h"

using namespace tactbench;
using namespace tactbench::tests;
using Catch::Contains;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

TEST_CASE("frames of two branches and of two runs in turn each have the place of their own branch") {
  NewStore store;
  const Begun one = begin_example(store), other = begin_example(store);
  db::BranchRecord next = example_branch();
  next.ordinal = 1;
  const std::int64_t second = store.begin_branch(one.run, next);
  for (int i = 0; i < 3; ++i) {
    store.append_frame(one.run, example_frame(one.branch, i));
    store.append_frame(one.run, example_frame(second, i));
    store.append_frame(other.run, example_frame(other.branch, i));
  }
  CHECK(store_error([&] { store.append_frame(one.run, example_frame(other.branch, 4)); }) == "TB-STORE-CONFLICT");
  store.append_frame(other.run, example_frame(other.branch, 3));
  CHECK(store_error([&] { store.append_frame(one.run, example_frame(other.branch, 4)); }) == "TB-STORE-CONFLICT");
  for (const std::int64_t run : {one.run, other.run}) {
    store.end_run(run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
    CHECK(store.check_content(run).holds());
    CHECK(store.content_hash(run) == store.run(run).content_sha256);
  }
  CHECK((store.frame_count(one.run) == 6 && store.frame_count(other.run) == 4));
}

TEST_CASE(
    "a frame of no branch of its run is told by its place and still enters the hash, wherever its branch would lie") {
  for (const char* branch : {"-1", "2", "77"}) {
    CAPTURE(branch);
    const TemporaryFolder folder;
    RunStore store = RunStore::open(folder.path("runs.db"));
    const Begun begun = begin_example(store), other = begin_example(store);  // branches 1 and 2
    db::BranchRecord next = example_branch();
    next.attempt = 1;
    const std::int64_t third = store.begin_branch(begun.run, next);
    REQUIRE((begun.branch == 1 && other.branch == 2 && third == 3));
    store.append_frame(begun.run, example_frame(begun.branch, 0));
    store.append_frame(begun.run, example_frame(third, 1));
    store.append_frame(begun.run, example_frame(third, 2));
    store.end_run(begun.run, db::Outcome::kCompleted, "", db::SafeState::kVerified, kUtc);
    const std::string before = store.content_hash(begun.run);
    Connection(store.path(), Access::kReadWrite)
        .execute("PRAGMA foreign_keys = OFF; UPDATE frames SET branch = " + std::string(branch) +
                 " WHERE frame % 10 = 2");
    const db::ContentCheck check = store.check_content(begun.run);
    CHECK_THAT(check.difference, Contains("frame 2 "));
    CHECK(check.computed_sha256 == store.content_hash(begun.run));
    CHECK(check.computed_sha256 != before);
    // As if it were of a branch 0 of sequence 0, which nothing else says of it.
    db::HashChain chain;
    db::Digest link = chain.header(store.run(begun.run));
    const auto branches = store.branches(begun.run);
    link = chain.frame(link, branches[0], example_frame(1, 0));
    link = chain.frame(link, {}, example_frame(0, 1));
    link = chain.frame(link, branches[1], example_frame(3, 2));
    db::RunEnd end;
    end.branches = branches;
    end.outcome = db::Outcome::kCompleted;
    end.safe = db::SafeState::kVerified;
    CHECK(db::hex(chain.close(link, 3, end)) == check.computed_sha256);
  }
}

TEST_CASE("frames that came back after all were removed are told, with the day of the removal") {
  NewStore store;
  store_example(store);
  store_example(store);
  store.set_tags(2, {"nightly"}, {});
  store.prune_frames(2, "a rule", "2026-07-08T00:00:00Z");
  CHECK(store.check_content(2).holds());
  Connection raw(store.path(), Access::kReadWrite);
  raw.execute(
      "CREATE TEMP TABLE kept AS SELECT * FROM frames WHERE frame = 1000000001; UPDATE kept SET frame = 2000000001, "
      "branch = 3; INSERT INTO frames SELECT * FROM kept");
  CHECK_THAT(store.check_content(2).difference, Contains("1 frames") && Contains("2026-07-08T00:00:00Z"));
  CHECK(store_error([&] { (void)store.frames(2); }) == "TB-STORE-PRUNED");
}

TEST_CASE("texts are compared with their own hashes only where there are such") {
  NewStore store;
  db::RunRecord record = example_run();
  record.bench_sha256 = std::string(63, 'a');  // no SHA-256
  record.sensor_sha256 = std::string(65, 'a');
  const std::int64_t run = store_example(store, record);
  Connection(store.path(), Access::kReadWrite).execute("UPDATE runs SET bench_toml = 'x', sensor_toml = 'y'");
  CHECK_THAT(store.check_content(run).difference, Contains("the run's row, a sequence, a device, or frame 1 "));
}

TEST_CASE("runs copied in any order keep their verdicts beside the fits of each") {
  NewStore source, target;
  for (int i = 0; i < 3; ++i) store_example(source);
  const auto fit_of = [&](std::int64_t run, const std::string& model) {
    return source.add_fit({0, run, model, true, 1, std::to_string(run), "", "0.1.0", kUtc});
  };
  const std::int64_t of_two = fit_of(2, "two"), of_three = fit_of(3, "three"), again = fit_of(3, "again");
  const auto verdict = [](const std::string& criterion) {
    db::VerdictRecord record;
    record.criterion = criterion;
    record.verdict = "pass";
    record.limits_sha256 = criterion;
    return record;
  };
  source.replace_verdicts(1, of_two, {verdict("by two")});
  source.replace_verdicts(1, of_three, {verdict("by three")});
  source.replace_verdicts(1, again, {verdict("by again")});
  store_example(target);
  (void)target.add_fit({0, 1, "own", true, 1, "{}", "", "0.1.0", kUtc});
  CHECK(target.copy_runs_from(source, {3, 1}) == std::vector<std::int64_t>{2, 3});
  CHECK(target.copy_runs_from(source, {2}) == std::vector<std::int64_t>{4});
  const std::vector<db::VerdictRecord> verdicts = target.verdicts(3);
  REQUIRE(verdicts.size() == 3);
  CHECK((verdicts[0].criterion == "by two" && verdicts[0].fit == 0));  // the run of its fit came later
  CHECK((verdicts[1].criterion == "by three" && target.fit(verdicts[1].fit).model == "three"));
  CHECK((verdicts[2].criterion == "by again" && target.fit(verdicts[2].fit).model == "again"));
  CHECK(verdicts[1].model_run == 2);
  REQUIRE(target.fits(4).size() == 1);
  CHECK(target.fits(4)[0].document == "2");
  for (const std::int64_t run : {2, 3, 4}) {
    CHECK(target.check_content(run).holds());
    CHECK(target.check_seals(run).empty());
  }
  CHECK(target.check_structure().empty());
  CHECK(store_error([&] { (void)target.copy_runs_from(source, {1}); }) == "TB-STORE-EXISTS");
}

TEST_CASE("nights, too, are missed when they were deleted") {
  NewStore store;
  (void)store.add_night({0, "small", "f", "t", "{}", 1, 1, kUtc, kUtc, "p", {}});
  CHECK(store.check_structure().empty());
  Connection(store.path(), Access::kReadWrite).execute("DELETE FROM nights");
  REQUIRE(store.check_structure().size() == 1);
  CHECK_THAT(store.check_structure().front(), Contains("nights: 1 "));
}
