// Runs whose frames were removed by a rule: what stays, what is checked, and what is never removed.
#include <catch2/catch.hpp>

#include "db/hash_chain.h"
#include "db/sqlite.h"
#include "tests/db/new_store.h"

using namespace tactbench;
using namespace tactbench::tests;
using db::RunStore;
using db::sqlite::Access;
using db::sqlite::Connection;

namespace {

constexpr const char* kRule = "nights before 2026-01-01";

std::int64_t night_run(RunStore& store, const db::RunRecord& run = example_run()) {
  const std::int64_t number = store_example(store, run);
  store.set_tags(number, {"nightly"}, {});
  return number;
}

// Run `judged` is judged by a fit of run `fitted`.
void judge(RunStore& store, std::int64_t fitted, std::int64_t judged) {
  db::FitRecord fit;
  fit.run = fitted;
  fit.model = "elam";
  db::VerdictRecord verdict;
  verdict.verdict = "pass";
  verdict.limits_sha256 = "l";
  store.replace_verdicts(judged, store.add_fit(fit), {verdict});
}

}  // namespace

TEST_CASE("prune: removes the frames of a nightly run, and everything else stays and still verifies") {
  NewStore store;
  const std::int64_t run = night_run(store), other = night_run(store);
  store.replace_figures(run, "nightly/a", {{"mean_error_psi", 0.25}});
  const std::string content = store.run(run).content_sha256, frames = db::frames_hash(store, run);
  CHECK(store.why_not_pruned(run).empty());
  const db::PrunedRecord pruned = store.prune_frames(run, kRule, kUtc);
  CHECK((pruned.frames == 3 && pruned.bytes == 3 * (24 + 32)));
  CHECK(store.frame_count(run) == 0);
  CHECK(store.frame_count(other) == 3);
  CHECK(store.run(run).content_sha256 == content);
  CHECK(db::frames_hash(store, run) == frames);
  CHECK(store.events(run).size() == 2);
  CHECK(store.figures("nightly/a").size() == 1);
  CHECK(store.check_structure().empty());
  const db::ContentCheck check = store.check_content(run);
  REQUIRE(check.pruned);
  CHECK((check.holds() && check.frames == 3 && check.computed_sha256 == content && check.pruned->rule == kRule));
  CHECK_FALSE(store.check_content(other).pruned);
  CHECK(store_error([&] { (void)store.frames(run); }) == "TB-STORE-PRUNED");
  CHECK(store_error([&] { store.for_each_frame(run, [](const auto&) {}); }) == "TB-STORE-PRUNED");
  CHECK(store_error([&] { store.prune_frames(run, kRule, kUtc); }) == "TB-STORE-CONFLICT");
  Connection raw(store.path(), Access::kReadOnly);
  CHECK(raw.integer("SELECT frames_pruned FROM v_runs WHERE run = 1") == 3);
}

TEST_CASE("prune: a later change to the rest of a pruned run is detected") {
  const auto difference_after = [](const char* sql) {
    const TemporaryFolder folder;
    RunStore store = RunStore::open(folder.path("runs.db"));
    night_run(store);
    store.prune_frames(1, kRule, kUtc);
    Connection(folder.path("runs.db"), Access::kReadWrite).execute(sql);
    return store.check_content(1).difference;
  };
  CHECK(difference_after("SELECT 1").empty());
  CHECK_THAT(difference_after("UPDATE runs SET seed = 8"), Catch::Contains("the run's row"));
  CHECK_THAT(difference_after("UPDATE runs SET bench_toml = 'x'"), Catch::Contains("the bench file"));
  CHECK_THAT(difference_after("UPDATE devices SET serial = 'x'"), Catch::Contains("a device"));
  CHECK_THAT(difference_after("UPDATE events SET detail = 'x'"), Catch::Contains("an event"));
  CHECK_THAT(difference_after("UPDATE runs SET outcome = 'failed'"), Catch::Contains("the outcome"));
  CHECK_THAT(difference_after("UPDATE pruned SET frames = 4"), Catch::Contains("number of frames"));
  CHECK_THAT(difference_after("UPDATE pruned SET chain = randomblob(32)"), Catch::Contains("the link"));
  CHECK_FALSE(difference_after("DELETE FROM pruned").empty());
}

TEST_CASE("prune: keeps the frames of hardware, non-nightly, void, pinned, reported and open runs") {
  NewStore store;
  db::RunRecord hardware = example_run();
  hardware.origin = "hardware";
  const std::int64_t real = night_run(store, hardware), own = store_example(store), voided = night_run(store),
                     pinned = night_run(store), reported = night_run(store), free = night_run(store);
  store.void_run(voided, "by hand", "K. Lee", kUtc);
  store.set_tags(pinned, {"pinned"}, {});
  store.add_report({reported, "5-0123abcd", "hash", "K. Lee", kUtc, "", ""});
  const std::int64_t open = begin_example(store).run;
  store.set_tags(open, {"nightly"}, {});
  CHECK_THAT(store.why_not_pruned(reported), Catch::Contains("5-0123abcd"));
  CHECK(store.why_not_pruned(free).empty());
  for (const std::int64_t run : {real, own, voided, pinned, reported, open}) {
    CHECK_FALSE(store.why_not_pruned(run).empty());
    CHECK(store_error([&] { store.prune_frames(run, kRule, kUtc); }) == "TB-STORE-CONFLICT");
  }
  CHECK(store.frame_count(real) == 3);
  // Runs on which a verdict of a kept run is based are kept, on either side of the verdict.
  const std::int64_t models = night_run(store), judged = night_run(store);
  judge(store, models, pinned);
  judge(store, reported, judged);
  CHECK_THAT(store.why_not_pruned(models), Catch::Contains("run 4 "));
  CHECK_THAT(store.why_not_pruned(judged), Catch::Contains("run 5 "));
  judge(store, free, night_run(store));
  CHECK(store.why_not_pruned(free).empty());
}

TEST_CASE("prune: a damaged run is not pruned, and a pruned run is not continued") {
  NewStore store;
  night_run(store);
  const Begun begun = begin_example(store);
  store.append_frame(begun.run, example_frame(begun.branch, 0));
  store.end_run(begun.run, db::Outcome::kStopped, "by hand", db::SafeState::kVerified, kUtc);
  store.set_tags(begun.run, {"nightly"}, {});
  store.prune_frames(begun.run, kRule, kUtc);
  CHECK(store_error([&] { store.reopen_run(begun.run, {}); }) == "TB-STORE-CONFLICT");
  Connection(store.path(), Access::kReadWrite).execute("UPDATE frames SET status = 9 WHERE frame = 1000000002");
  CHECK(store_error([&] { store.prune_frames(1, kRule, kUtc); }) == "TB-STORE-CONFLICT");
  CHECK(store.frame_count(1) == 3);
}

TEST_CASE("prune: a pruned run is copied as pruned, and shrink frees the space of removed frames") {
  NewStore store;
  for (int i = 0; i < 30; ++i) {
    const Begun begun = begin_example(store);
    db::FrameRecord frame = example_frame(begun.branch, 0);
    frame.trace.resize(2000);
    for (int k = 0; k < 5; ++k) store.append_frame(begun.run, frame);
    store.end_run(begun.run, db::Outcome::kCompleted, "done", db::SafeState::kVerified, kUtc);
    store.set_tags(begun.run, {"nightly"}, {});
    store.prune_frames(begun.run, kRule, kUtc);
  }
  const auto bytes = [&] { return read_file(store.path()).size(); };
  Connection(store.path(), Access::kReadWrite).execute("PRAGMA wal_checkpoint(TRUNCATE)");
  const std::size_t before = bytes();
  store.shrink();
  CHECK(bytes() + 100'000 < before);  // frames of one run at a time lay there
  CHECK(store.check_structure().empty());
  // Of a program that dies before the shorter file is cut: log and file tell of different lengths.
  const TemporaryFolder folder;
  const std::string dying = folder.path("runs.db");
  db::FrameRecord long_one = example_frame(begin_example(store).branch, 0);
  long_one.trace.resize(2000);
  store.append_frame(31, long_one);
  store.snapshot(dying);
  REQUIRE(in_child([&] {
            auto* raw = new Connection(dying, Access::kReadWrite);  // never closed: the log stays
            raw->execute("PRAGMA wal_autocheckpoint = 0; DELETE FROM frames; VACUUM");
            return 0;
          }) == 0);
  CHECK(RunStore::open_read_only(dying).runs().size() == 31);
  CHECK(RunStore::open(dying).check_structure().empty());
  NewStore copy;
  CHECK(copy.copy_runs_from(store, {3}) == std::vector<std::int64_t>{1});
  REQUIRE(copy.check_content(1).pruned);
  CHECK(copy.check_content(1).holds());
  CHECK(copy.run(1).content_sha256 == store.run(3).content_sha256);
  RunStore::open(store.path());  // the header of a shrunk file is one of a store
}
