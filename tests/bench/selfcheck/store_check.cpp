// selfcheck's checks of the store, in this process: what each says of a sound folder and of one that is missing, and
// what it leaves in its files.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/selfcheck/selfcheck.h"
#include "db/run_store.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

// Frame i at each second second, at tenths of a psi, with counts of 251 i + 7 t + 1.
bool is_checked_frame(const db::FrameRecord& frame, int i) {
  bool same = frame.ordinal == i && frame.time_ns == 2'000'000'000LL * i && frame.rows == 16 && frame.columns == 16 &&
              frame.scans == 1 && frame.counts.size() == 256 && std::abs(frame.setpoint_psi - 0.1 * i) < 1e-12 &&
              frame.feedback_psi == frame.setpoint_psi && frame.reference_psi == frame.setpoint_psi;
  for (int t = 0; same && t < 256; ++t)
    same = frame.counts[static_cast<std::size_t>(t)] == (251 * i + 7 * t + 1) % 65536;
  return same;
}

}  // namespace

TEST_CASE("selfcheck's store: four checks pass in a sound folder, and their files hold what they say") {
  const tests::TemporaryFolder folder;
  const SelfcheckLines lines = check_store(folder.path());
  REQUIRE(lines.size() == 4);
  for (const SelfcheckLine& line : lines) {
    INFO(line.what << ": " << line.found);
    CHECK(line.area == "store");
    CHECK(line.pass);
  }
  CHECK(lines[0].what == "50 writes of 512 bytes with fdatasync in the store's folder");
  CHECK(lines[0].expected == "each is acknowledged, in less than 500 ms");
  CHECK_THAT(lines[0].found, Catch::EndsWith(" ms each"));
  CHECK(lines[1].what == "a run of 60 frames written and read back");
  CHECK(lines[1].expected == "60 of 60 frames equal, content hash holds, structure sound");
  CHECK(lines[1].found == lines[1].expected);
  CHECK(lines[2].what == "a process killed by SIGKILL while it wrote frames");
  CHECK(lines[2].expected == "every acknowledged frame is there, content hash holds");
  CHECK_THAT(lines[2].found, Catch::EndsWith(" there, content hash holds"));
  CHECK(lines[3].what == "one bit of a frame's counts flipped in the file, 6 frames");
  CHECK(lines[3].expected == "the frame is named, 6 of 6");
  CHECK_THAT(lines[3].found, Catch::StartsWith("6 of 6 named; the last: ") && Catch::Contains("frame 56 ("));

  CHECK(tests::read_file(folder.path("durable")) == std::string(std::size_t{50} * 512, '\0'));
  const db::RunStore store = db::RunStore::open_read_only(folder.path("selfcheck.db"));
  const db::RunRecord run = store.run(1);
  CHECK(run.origin == "simulated");
  CHECK(run.sensor_serial == "SELFCHECK");
  CHECK(run.outcome == db::Outcome::kCompleted);
  REQUIRE(run.sequences.size() == 1);
  CHECK(run.sequences[0].repeats == 1);
  CHECK(run.sequences[0].frames_per_repeat == 60);
  const std::vector<db::FrameRecord> frames = store.frames(1);
  REQUIRE(frames.size() == 60);
  for (int i = 0; i < 60; ++i) CHECK(is_checked_frame(frames[static_cast<std::size_t>(i)], i));

  // The last copy has one other bit: the fifth of byte 100 of frame 56's counts.
  const std::string whole = tests::read_file(folder.path("selfcheck.db")),
                    flipped = tests::read_file(folder.path("selfcheck.db.flipped"));
  REQUIRE(whole.size() == flipped.size());
  const std::string counts(reinterpret_cast<const char*>(frames[55].counts.data()), 512);
  const std::size_t place = whole.find(counts);
  REQUIRE(place != std::string::npos);
  for (std::size_t i = 0; i < whole.size(); ++i)
    if ((whole[i] ^ flipped[i]) != (i == place + 100 ? 0x10 : 0)) FAIL("byte " << i << " of " << whole.size());

  const db::RunStore killed = db::RunStore::open_read_only(folder.path("killed.db"));
  const std::vector<db::FrameRecord> there = killed.frames(1);
  CHECK(there.size() >= 25);
  CHECK(there.size() < 100000);
  for (std::size_t i = 0; i < there.size(); ++i) CHECK(is_checked_frame(there[i], static_cast<int>(i)));
  CHECK(killed.run(1).outcome == db::Outcome::kInterrupted);
  int acknowledged = 0, stored = 0;
  REQUIRE(std::sscanf(lines[2].found.c_str(), "%d acknowledged, %d there", &acknowledged, &stored) == 2);
  CHECK(acknowledged >= 25);
  CHECK(acknowledged <= stored);
  CHECK(stored == static_cast<int>(there.size()));
}

TEST_CASE("selfcheck's store: in a folder that is missing every check says why it could not be carried out") {
  const SelfcheckLines lines = check_store("/no/such/folder");
  REQUIRE(lines.size() == 4);
  for (const SelfcheckLine& line : lines) CHECK_FALSE(line.pass);
  CHECK(lines[0].found == "could not be checked: /no/such/folder/durable: No such file or directory");
  CHECK_THAT(lines[1].found, Catch::StartsWith("could not be checked: "));
  CHECK_THAT(lines[2].found, Catch::StartsWith("could not be checked: "));
  CHECK(lines[3].found == "0 of 0 named; the last: ");
}

TEST_CASE("selfcheck: a check's answer stands in its line, and what it throws in its place") {
  const SelfcheckLine good = selfchecked("area", "what", "one", [] { return SelfcheckAnswer{true, "two"}; });
  CHECK(good.area == "area");
  CHECK(good.what == "what");
  CHECK(good.expected == "one");
  CHECK(good.found == "two");
  CHECK(good.pass);
  CHECK_FALSE(selfchecked("a", "b", "c", [] { return SelfcheckAnswer{false, "two"}; }).pass);
  const SelfcheckLine thrown =
      selfchecked("a", "b", "c", []() -> SelfcheckAnswer { throw std::runtime_error("no disk"); });
  CHECK(thrown.found == "could not be checked: no disk");
  CHECK_FALSE(thrown.pass);
}

TEST_CASE("selfcheck's clocks: three lines, that of ticks from 200000 readings") {
  const SelfcheckLines lines = check_clocks();
  REQUIRE(lines.size() == 3);
  for (const SelfcheckLine& line : lines) CHECK(line.area == "clock");
  CHECK(lines[0].what == "steady clock, read 200000 times");
  CHECK(lines[0].expected == "0 backwards, ticks below 100000 ns");
  CHECK(lines[0].pass);
  CHECK_THAT(lines[0].found, Catch::StartsWith("0 backwards, ticks of ") && Catch::EndsWith(" ns"));
  CHECK(lines[1].what == "steady and wall clock over 300 ms");
  CHECK(lines[1].expected == "at most 3 ms apart");
  CHECK_THAT(lines[1].found, Catch::Contains(" ms apart after "));
  double apart = 0.0, passed = 0.0;
  REQUIRE(std::sscanf(lines[1].found.c_str(), "%lf ms apart after %lf ms", &apart, &passed) == 2);
  CHECK(passed >= 300.0);
  CHECK(lines[2].what == "wall clock against the program's commit");
  CHECK_THAT(lines[2].expected, Catch::StartsWith("not before 20"));
  CHECK(lines[2].pass);
}
