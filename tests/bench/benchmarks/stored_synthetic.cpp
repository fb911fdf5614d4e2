// The run of synthetic taxels that benchmarks measure on: its outputs as they were recorded, and its edges in a store.
#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "bench/benchmarks/synthetic_array.h"
#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;

TEST_CASE(
    "benchmarks' run in a store: outputs beyond the converter's range are cut off, and times are whole nanoseconds") {
  analysis::Dataset made = synthetic_dataset(1, 2, 1);
  made.sequences[0].repeats[0].volts[0] = 6.0;
  made.sequences[0].repeats[0].volts[1] = -0.5;
  made.sequences[0].repeats[0].volts[2] = 65533.4 * (5.0 / 65536.0);
  made.sequences[0].repeats[0].steps[1].time_s = 3.0000000004;
  made.sequences[0].repeats[0].steps[1].held_s = 0.125;
  const tests::TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("b.db"), db::Durability::kNormal);
  const std::int64_t number = store_run(store, made);
  const std::vector<db::FrameRecord> frames = store.frames(number);
  CHECK(frames[0].counts == std::vector<std::uint16_t>{65534, 0});
  CHECK(frames[1].counts[0] == 65533);
  CHECK(frames[1].time_ns == 3'000'000'000);
  CHECK(frames[1].since_command_ns == 125'000'000);
  const db::RunRecord run = store.run(number);
  CHECK(run.scanner_serial == "SIM-SCANNER-1");
  REQUIRE(run.devices.size() == 1);
  CHECK(run.devices[0].calibration_json == "{\"volts_per_count\": 7.62939453125e-05}");
  const std::vector<db::BranchRecord> branches = store.branches(number);
  REQUIRE(branches.size() == 2);
  CHECK((branches[0].sequence == 0 && branches[1].sequence == 1 && branches[1].repeat == 0));
}

TEST_CASE("benchmarks' run: outputs of two taxels along all branches, as they were recorded") {
  const analysis::Dataset made = synthetic_dataset(1, 2, 2);
  std::vector<double> sums;
  for (const analysis::SequenceData& sequence : made.sequences)
    for (const analysis::Repeat& repeat : sequence.repeats)
      for (std::size_t t = 0; t < 2; ++t) {
        double sum = 0.0;  // weighted, so that each sample counts
        for (std::size_t i = 0; i < repeat.steps.size(); ++i)
          sum += repeat.volts[2 * i + t] * std::cos(static_cast<double>(i));
        sums.push_back(sum);
      }
  const std::vector<double> recorded{0.126849893623724, 0.251445254510007, 0.00378512102441652, 0.287058202735143,
                                     1.36982237608843,  2.09336745660032,  1.46918936290312,    2.06507959970639};
  REQUIRE(sums.size() == recorded.size());
  for (std::size_t i = 0; i < sums.size(); ++i) CHECK(sums[i] == Approx(recorded[i]).epsilon(1e-9));
}
