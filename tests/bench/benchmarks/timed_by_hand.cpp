// Whole benchmarks on few frames, by a clock that says how long everything took: what is timed, in which order, how
// often, and what is told of it. Each expected time is worked out from the acts' order (counted_time.h).
#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "analysis/compensate/dispatch.h"
#include "analysis/compensate/dynamic_frame_compensator.h"
#include "bench/benchmarks/compensate.h"
#include "bench/benchmarks/compensate_dynamic.h"
#include "bench/benchmarks/store.h"
#include "tests/bench/benchmarks/counted_time.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using tests::ActsInOrder;
using tests::CountedTime;

namespace {

using TimedFigures = std::vector<std::pair<std::string, double>>;

void check_timed(const std::vector<Figure>& figures, const std::string& benchmark, const TimedFigures& expected) {
  REQUIRE(figures.size() == expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    CHECK(figures[i].name == benchmark + "_" + expected[i].first);
    INFO(figures[i].name);
    CHECK(figures[i].value == Approx(expected[i].second).epsilon(1e-9));
  }
}

std::vector<std::string> levels_here() {
  std::vector<std::string> levels{"base"};
  if (analysis::best_dispatch() >= analysis::Dispatch::kAvx2) levels.emplace_back("avx2");
  if (analysis::best_dispatch() >= analysis::Dispatch::kAvx512) levels.emplace_back("avx512");
  return levels;
}

}  // namespace

TEST_CASE("benchmark store: stretches of 100 frames of each subject in turn, then five readings of both") {
  const tests::TemporaryFolder folder;
  std::vector<By> readings;
  const std::vector<Figure> figures = [&] {
    const CountedTime time;
    std::vector<Figure> found = benchmark_store(2, folder.path(), {201, 2});  // three stretches, and one
    readings = time.readings();
    return found;
  }();
  ActsInOrder act;
  const double plain = act.next(), full = act.next(), bare = act.sum_of(3), normal = act.sum_of(3),
               grouped = act.sum_of(3), bare_read = act.next();
  act.pass(4);
  const double read = act.next();
  const double per_durable = 1e6 / 2, per_frame = 1e6 / 201;
  check_timed(figures, "store",
              {{"append_and_fdatasync", per_durable * plain},
               {"full", per_durable * full},
               {"full_over_floor", full / plain},
               {"full_over_floor_goal_at_most", 1.5},
               {"bare_insert", per_frame * bare},
               {"normal", per_frame * normal},
               {"normal_over_bare", normal / bare},
               {"normal_over_bare_goal_at_most", 1.25},
               {"bare_insert_groups_of_100", per_frame * grouped},
               {"bare_read", per_frame * bare_read},
               {"read", per_frame * read},
               {"read_over_bare", read / bare_read},
               {"read_over_bare_goal_at_most", 1.3}});
  // In each round 11 stretches by wall clock, then 10 readings by the processor's.
  std::vector<By> expected;
  for (int round = 0; round < 2; ++round) {
    expected.insert(expected.end(), 22, By::kWall);
    expected.insert(expected.end(), 20, By::kProcessor);
  }
  CHECK(readings == expected);
}

TEST_CASE("benchmark store: each stretch counts with its own best round") {
  const tests::TemporaryFolder folder;
  const std::vector<Figure> figures = [&] {
    double now = 0.0;
    int reading = 0;
    // Act n of the 18 of a round takes n s, in the other round 100 s more.
    const ClockInPlace clock([&](By) {
      if (++reading % 2 == 0) {
        const int round = (reading / 2 - 1) / 18, act = (reading / 2 - 1) % 18 + 1;
        now += (act + round) % 2 == 0 ? act : act + 100;
      }
      return now;
    });
    return benchmark_store(2, folder.path(), {101, 1});
  }();
  const double per_frame = 1e6 / 101;
  check_timed(figures, "store",
              {{"append_and_fdatasync", 1e6 * 1},
               {"full", 1e6 * 2},
               {"full_over_floor", 2.0},
               {"full_over_floor_goal_at_most", 1.5},
               {"bare_insert", per_frame * (3 + 4)},
               {"normal", per_frame * (5 + 6)},
               {"normal_over_bare", 11.0 / 7},
               {"normal_over_bare_goal_at_most", 1.25},
               {"bare_insert_groups_of_100", per_frame * (7 + 8)},
               {"bare_read", per_frame * 9},
               {"read", per_frame * 14},
               {"read_over_bare", 14.0 / 9},
               {"read_over_bare_goal_at_most", 1.3}});
}

TEST_CASE("benchmark compensate: each form on all frames, stretch by stretch, and latencies frame by frame") {
  const std::vector<Figure> figures = [] {
    const CountedTime time;
    CompensateSizes sizes;
    sizes.taxels = 4;
    sizes.slow_frames = 240;
    sizes.random_frames = 110;
    sizes.growth_frames = 3;
    sizes.middle_frames = 7;
    return benchmark_compensate(2, sizes);
  }();
  ActsInOrder act;
  const auto best_of_two = [&](int stretches) {
    const double best = act.sum_of(stretches);
    act.pass(stretches);
    return best;
  };
  const double slow = 1e6 / 240, random = 1e6 / 110;
  TimedFigures expected;
  const double scale = best_of_two(3), plain = best_of_two(3), bare = best_of_two(3);
  expected = {{"scale_only", slow * scale}, {"straightforward", slow * plain}, {"bare_scalar", slow * bare}};
  double fast = 0.0;
  for (const std::string& level : levels_here()) expected.emplace_back("fast_" + level, slow * (fast = best_of_two(3)));
  // Of 240 frames that take longer and longer: number 121, number 238 and the last.
  ActsInOrder latency = act;
  latency.pass(120);
  expected.emplace_back("fast_median", 1e6 * latency.next());
  latency.pass(116);
  expected.emplace_back("fast_p99", 1e6 * latency.next());
  latency.pass(1);
  expected.emplace_back("fast_worst", 1e6 * latency.next());
  act.pass(240);
  const double turning = best_of_two(2), turning_plain = best_of_two(2), turning_bare = best_of_two(2);
  expected.emplace_back("turning_fast", random * turning);
  expected.emplace_back("turning_straightforward", random * turning_plain);
  expected.emplace_back("turning_bare_scalar", random * turning_bare);
  latency = act;
  latency.pass(108);  // 0.99 of 110 frames is place 108
  expected.emplace_back("turning_p99", 1e6 * latency.next());
  expected.emplace_back("turning_worst", 1e6 * latency.next());
  act.pass(110);
  expected.emplace_back("unknown_start_median", 1e6 * act.median_of(7));
  for (const int side : {16, 32, 64})
    expected.emplace_back("growth_" + std::to_string(side) + "x" + std::to_string(side) + "_per_taxel",
                          1e9 * best_of_two(1) / 3 / (side * side));
  expected.emplace_back("speedup", plain / fast);
  expected.emplace_back("speedup_over_bare", bare / fast);
  expected.emplace_back("speedup_over_bare_goal_at_least", 3.0);
  expected.emplace_back("over_scale_only", fast / scale);
  expected.emplace_back("over_scale_only_goal_at_most", 25.0);
  expected.emplace_back("turning_slowdown", turning / turning_plain);
  expected.emplace_back("turning_slowdown_over_bare", turning / turning_bare);
  expected.emplace_back("turning_slowdown_over_bare_goal_at_most", 2.5);
  check_timed(figures, "compensate", expected);
}

TEST_CASE("benchmark compensate-dynamic: both compensators on both streams by each vector level, in turn") {
  const std::vector<Figure> figures = [] {
    const CountedTime time;
    return benchmark_compensate_dynamic(2, {3, 201, 101});
  }();
  ActsInOrder act;
  const auto best_of_two = [&](int stretches) {
    const double best = act.sum_of(stretches);
    act.pass(stretches);
    return best;
  };
  TimedFigures expected;
  const double slow = 1e6 / 201, random = 1e6 / 101;
  for (const std::string& level : levels_here()) {
    expected.emplace_back("slow_" + level, slow * best_of_two(3));
    if (level == "avx2") expected.emplace_back("slow_avx2_goal_at_most", 2.0);
    expected.emplace_back("turning_" + level, random * best_of_two(2));
    if (level == "avx2") expected.emplace_back("turning_avx2_goal_at_most", 12.0);
    expected.emplace_back("slow_elam_" + level, slow * best_of_two(3));
    expected.emplace_back("turning_elam_" + level, random * best_of_two(2));
  }
  const analysis::DynamicFrameCompensator<float> compensator(slow_dynamic(3, 201).setup);
  expected.emplace_back("memory_a_taxel", static_cast<double>(compensator.bytes_per_taxel()));
  expected.emplace_back("memory_a_taxel_goal_at_most", 2048.0);
  check_timed(figures, "compensate-dynamic", expected);
}
