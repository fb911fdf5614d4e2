// A compensated frame as `live` sums it up and writes it, of frames that are known number by number.
#include <catch2/catch.hpp>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "analysis/compensate/compensator.h"
#include "bench/cli/models/live.h"

using namespace tactbench;
using namespace tactbench::bench;

namespace {

struct FrameByHand {
  std::vector<float> psi, uncertainty;
  std::vector<std::uint16_t> status;
  [[nodiscard]] LiveFrame frame() const { return {7, 1.5, psi, uncertainty, status, 123.4}; }
};

}  // namespace

TEST_CASE("live: a frame is summarised over the taxels that are not dead, the first of equal maxima is the highest") {
  const FrameByHand of = {{99.0F, -4.0F, 2.0F, 8.0F, 8.0F, 6.0F},
                          {0.5F, 0.25F, 0.125F, 0.5F, 0.5F, 0.5F},
                          {analysis::kTaxelDead, analysis::kTaxelFlat, analysis::kTaxelValid,
                           analysis::kTaxelUnknown | analysis::kTaxelOutOfRange, analysis::kTaxelLost,
                           analysis::kTaxelOutside | analysis::kTaxelFlat}};
  const FrameSummary sum = summed(of.frame());
  CHECK(sum.mean_psi == 4.0);
  CHECK(sum.highest_psi == 8.0);
  CHECK(sum.highest == 3);
  CHECK((sum.flags.flat == 2 && sum.flags.unknown == 1 && sum.flags.out_of_range == 1 && sum.flags.dead == 1));
  CHECK((sum.flags.lost == 1 && sum.flags.outside == 1));
  CHECK(frame_rows(of.frame()) ==
        "7,1.500000,0,99.0000,0.5000,8\n7,1.500000,1,-4.0000,0.2500,2\n7,1.500000,2,2.0000,0.1250,1\n"
        "7,1.500000,3,8.0000,0.5000,36\n7,1.500000,4,8.0000,0.5000,64\n7,1.500000,5,6.0000,0.5000,18\n");
  const FrameByHand negative = {{-3.0F, -1.0F}, {0.5F, 0.5F}, {1, 1}};
  CHECK(summed(negative.frame()).highest_psi == -1.0);
  CHECK(summed(negative.frame()).highest == 1);
  const FrameByHand below = {{-1.0F, -3.0F}, {0.5F, 0.5F}, {1, 1}};
  CHECK(summed(below.frame()).highest_psi == -1.0);
  CHECK(summed(below.frame()).mean_psi == -2.0);
  const FrameByHand dead = {{5.0F}, {0.5F}, {analysis::kTaxelDead}};
  CHECK(summed(dead.frame()).mean_psi == 0.0);
  CHECK(summed(dead.frame()).highest_psi == 0.0);
  CHECK(summed(dead.frame()).highest == 0);
}

TEST_CASE("live: the JSON document has the summary and the last frame") {
  LiveSummary summary;
  summary.frames = 1;
  summary.lost = 2;
  summary.other_scanner = true;
  summary.outside = {"scanner A (fitted on B)"};
  summary.median_us = 10.4;
  summary.p99_us = 20.6;
  summary.worst_us = 30.0;
  summary.compensation_median_us = 4.25;
  FrameSummary last;
  last.mean_psi = 1.5;
  last.highest_psi = 2.5;
  last.flags = {1, 2, 3, 4, 5, 6};
  CHECK(live_json(summary, last) == nlohmann::ordered_json::parse(R"text({
    "other_scanner": true, "outside_validity": ["scanner A (fitted on B)"], "frames": 1, "lost_frames": 2,
    "latency_us": {"median": 10.4, "p99": 20.6, "worst": 30.0, "compensation_median": 4.25},
    "last_frame": {"mean_psi": 1.5, "highest_psi": 2.5, "flat": 1, "unknown": 2, "out_of_range": 3, "dead": 4,
                   "outside_validity": 6, "lost": 5}})text"));
}
