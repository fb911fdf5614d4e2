// Runs from one store into another: the same content under other keys, all or nothing.
#include <catch2/catch.hpp>

#include "db/sqlite.h"
#include "tests/db/store_example.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;

namespace {

// Run 2 is judged by the fit of run 1.
void store_judged(RunStore& store) {
  const std::int64_t first = store_example(store), second = store_example(store);
  db::FitRecord fit;
  fit.run = first;
  fit.model = "elam";
  fit.document = R"({"taxels":[]})";
  const std::int64_t number = store.add_fit(fit);
  db::VerdictRecord verdict;
  verdict.verdict = "pass";
  store.replace_verdicts(second, number, {verdict});
  store.set_tags(second, {"night"}, {});
}

}  // namespace

TEST_CASE("copied runs keep their content, tags, fits and verdicts, under the numbers of the other store") {
  const TemporaryFolder folder;
  RunStore source = RunStore::open(folder.path("a.db"));
  RunStore target = RunStore::open(folder.path("b.db"));
  store_judged(source);
  store_judged(target);
  store_example(target);
  CHECK(target.copy_runs_from(source, {1, 2}) == std::vector<std::int64_t>{4, 5});
  for (const std::int64_t run : {1, 2, 3, 4, 5}) CHECK(target.check_content(run).holds());
  CHECK(target.run(4).content_sha256 == source.run(1).content_sha256);
  CHECK(target.run(4).uuid == source.run(1).uuid);
  CHECK(target.run(5).tags == std::vector<std::string>{"night"});
  REQUIRE(target.fits(4).size() == 1);
  CHECK(target.fits(4).front().fit == 2);
  CHECK(target.fit(2).document == source.fit(1).document);
  REQUIRE(target.verdicts(5).size() == 1);
  CHECK(target.verdicts(5).front().fit == 2);
  CHECK(target.check_structure().empty());
  CHECK(target.frames(5).size() == 3);
  // The copy works as a store: the next run's keys follow.
  CHECK(store_example(target) == 6);
  CHECK(target.check_content(6).holds());
}

TEST_CASE("a run is copied once, ended and complete, or nothing is copied") {
  const TemporaryFolder folder;
  RunStore source = RunStore::open(folder.path("a.db"));
  RunStore target = RunStore::open(folder.path("b.db"));
  store_judged(source);
  CHECK(target.copy_runs_from(source, {2}) == std::vector<std::int64_t>{1});
  CHECK(target.verdicts(1).front().fit == 0);  // the run of its models was not copied
  CHECK(store_error([&] { target.copy_runs_from(source, {1, 2}); }) == "TB-STORE-EXISTS");
  CHECK(target.runs().size() == 1);
  const std::int64_t open = source.begin_run(example_run());
  CHECK(store_error([&] { target.copy_runs_from(source, {1, open}); }) == "TB-STORE-CONFLICT");
  CHECK(store_error([&] { target.copy_runs_from(source, {99}); }) == "TB-STORE-NOT-FOUND");
  db::sqlite::Connection(folder.path("a.db"), db::sqlite::Access::kReadWrite)
      .execute("UPDATE frames SET status = 9 WHERE frame = 1000000002");
  std::string message;
  CHECK(store_error([&] { target.copy_runs_from(source, {1}); }, &message) == "TB-STORE-CONFLICT");
  CHECK_THAT(message, Catch::Contains("frame 2"));
  CHECK(target.runs().size() == 1);
  CHECK(target.check_structure().empty());
  RunStore third = RunStore::open(folder.path("c.db"));
  db::SensorRecord other = example_sensor();
  other.type_sha256 = db::sha256_hex("another");
  third.add_sensor(other);
  CHECK(store_error([&] { third.copy_runs_from(source, {2}); }) == "TB-STORE-CONFLICT");
}
