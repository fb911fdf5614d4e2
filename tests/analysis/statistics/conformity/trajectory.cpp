// Which trajectory a run judges, from set-points written by hand.
#include "analysis/statistics/conformity/trajectory.h"

#include <catch2/catch.hpp>

using namespace tactbench::analysis;

namespace {

// Steps of 10 psi between turning points, `held_s` from command to frame.
SequenceData sequence_of(const std::vector<double>& turns, double held_s, int repeats = 1) {
  Repeat repeat;
  double psi = turns.front();
  repeat.steps.push_back({psi, psi, 0.0, held_s});
  for (std::size_t i = 1; i < turns.size(); ++i)
    while (psi != turns[i]) {
      psi += psi < turns[i] ? 10.0 : -10.0;
      repeat.steps.push_back({psi, psi, 0.0, held_s});
    }
  return {"s", std::vector<Repeat>(static_cast<std::size_t>(repeats), repeat)};
}

Dataset run_of(std::vector<SequenceData> sequences) {
  Dataset dataset;
  dataset.run = 7;
  dataset.sequences = std::move(sequences);
  return dataset;
}

const std::vector<double> kLoop{0, 60, 20, 60, 0}, kCurves{0, 60, 10, 60, 20, 60, 30, 60, 40, 60, 0},
    kRandom{0, 60, 20, 40, 10, 50, 30, 40, 20, 50, 10, 30, 0};

}  // namespace

TEST_CASE("trajectory: the fitted set-points again, however often, and part of them") {
  const Dataset fitted = run_of({sequence_of(kLoop, 2.0, 3), sequence_of(kCurves, 2.0)});
  const JudgedTrajectory again = judged_trajectory(run_of({sequence_of(kLoop, 2.1)}), fitted);
  CHECK(again.run == 7);
  CHECK(again.trajectory == Trajectory::kAsFitted);
  CHECK_FALSE(again.other_dwell);
  CHECK(again.reversals == 3);
  CHECK(again.inner_share == Approx(8.0 / 20.0));
  CHECK_THAT(in_words(again), Catch::StartsWith("set-points as fitted: 3 turning points, 40 % of the frames on inner"));
}

TEST_CASE("trajectory: random reversals, curves that return to an end, another dwell") {
  const Dataset fitted = run_of({sequence_of(kLoop, 2.0)});
  const JudgedTrajectory random = judged_trajectory(run_of({sequence_of(kRandom, 3.0)}), fitted);
  CHECK(random.trajectory == Trajectory::kRandomReversals);
  CHECK(random.other_dwell);
  CHECK(random.dwell_s == 3.0);
  CHECK_THAT(in_words(random), Catch::Contains("dwell 3.0 s (fitted: 2.0 s)"));
  CHECK(judged_trajectory(run_of({sequence_of(kCurves, 2.0)}), fitted).trajectory == Trajectory::kOther);
  // One sequence as fitted does not make the other so.
  CHECK(judged_trajectory(run_of({sequence_of(kLoop, 2.0), sequence_of(kCurves, 2.0)}), fitted).trajectory ==
        Trajectory::kOther);
  // Two turning points are no random path.
  CHECK(judged_trajectory(run_of({sequence_of({0, 30, 10, 60, 0}, 2.0)}), fitted).trajectory == Trajectory::kOther);
}
