// selfcheck's checks of the store in a folder whose files are there already: what they find is told, and they fail.
#include <catch2/catch.hpp>
#include <string>

#include "bench/selfcheck/selfcheck.h"
#include "db/run_store.h"
#include "db/sqlite.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

// Run 1 of one frame, which is none of selfcheck's; ended, or not.
void store_before(const std::string& path, bool ended, int frames = 1) {
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  store.add_sensor({"SELFCHECK", "synthetic", "", db::sha256_hex(""), "SIM-SCANNER-1", "", ""});
  db::RunRecord run;
  run.uuid = db::new_uuid();
  run.origin = "simulated";
  run.state = "prepared";
  run.sensor_serial = "SELFCHECK";
  run.sequences = {{0, "frames", "", "", 1, 60}};
  const std::int64_t number = store.begin_run(run);
  const std::int64_t branch = store.begin_branch(number, {});
  for (int i = 0; i < frames; ++i) {
    db::FrameRecord frame;
    frame.branch = branch;
    frame.ordinal = i;
    frame.rows = frame.columns = frame.scans = 1;
    frame.counts = {7};
    store.append_frame(number, frame);
  }
  if (ended) store.end_run(number, db::Outcome::kCompleted, "", db::SafeState::kVerified, "2026-01-01T00:00:00Z");
}

void change_store(const std::string& path, const char* sql) {
  db::sqlite::Connection(path, db::sqlite::Access::kReadWrite).execute(sql);
}

}  // namespace

TEST_CASE("selfcheck's store: a file in the way of the durable writes is told") {
  const TemporaryFolder folder;
  write_file(folder.path("durable"), "");
  const SelfcheckLine line = check_store(folder.path()).at(0);
  CHECK_FALSE(line.pass);
  CHECK(line.found == "could not be checked: " + folder.path("durable") + ": File exists");
}

TEST_CASE("selfcheck's store: fewer frames of the killed run than were acknowledged fail") {
  const TemporaryFolder folder;
  store_before(folder.path("killed.db"), true, 3);
  const SelfcheckLine line = check_store(folder.path()).at(2);
  CHECK_FALSE(line.pass);
  CHECK_THAT(line.found, Catch::EndsWith(" acknowledged, 3 there, content hash holds"));
}

TEST_CASE("selfcheck's store: a run beside the killed one that had not ended either fails") {
  const TemporaryFolder folder;
  store_before(folder.path("killed.db"), false, 4000);  // more than are ever acknowledged
  const SelfcheckLine line = check_store(folder.path()).at(2);
  CHECK_FALSE(line.pass);
  CHECK_THAT(line.found, Catch::EndsWith(" acknowledged, 4000 there, content hash holds"));
}

TEST_CASE("selfcheck's store: content that has changed fails after a kill") {
  const TemporaryFolder folder;
  store_before(folder.path("killed.db"), true, 4000);
  change_store(folder.path("killed.db"), "UPDATE frames SET status = 9 WHERE frame = (SELECT min(frame) FROM frames)");
  const SelfcheckLine line = check_store(folder.path()).at(2);
  CHECK_FALSE(line.pass);
  CHECK_THAT(line.found, Catch::EndsWith(" acknowledged, 4000 there, content hash DIFFERS"));
}

TEST_CASE("selfcheck's store: a structure that is not sound fails, and is named") {
  const TemporaryFolder folder;
  for (const char* name : {"selfcheck.db", "killed.db"}) {
    store_before(folder.path(name), true);
    store_before(folder.path(name), true);
    change_store(folder.path(name),
                 "PRAGMA foreign_keys = OFF; DELETE FROM runs WHERE run = 2");  // a run that is missing
  }
  const SelfcheckLines lines = check_store(folder.path());
  CHECK_FALSE(lines.at(1).pass);
  CHECK_THAT(lines.at(1).found,
             Catch::StartsWith("60 of 60 frames equal, content hash holds, structure ") && !Catch::Contains("sound"));
  CHECK_FALSE(lines.at(2).pass);
  CHECK_THAT(lines.at(2).found, Catch::EndsWith("content hash DIFFERS"));
}

TEST_CASE("selfcheck's store: a flipped bit that is not of the run looked at is found in none") {
  const TemporaryFolder folder;
  store_before(folder.path("selfcheck.db"), true);
  const SelfcheckLines lines = check_store(folder.path());
  CHECK(lines.at(1).pass);  // run 2 is read back
  CHECK_FALSE(lines.at(3).pass);
  CHECK(lines.at(3).found == "0 of 6 named; the last: ");
}
