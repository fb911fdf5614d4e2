// Which trajectory a run judges, at the edges of its rules: how near to an end a turning point lies, how many there
// are, how long a branch is, how far two dwells differ.
#include <catch2/catch.hpp>
#include <cmath>

#include "analysis/judgement/judgement.h"
#include "analysis/statistics/numbers/moments.h"

using namespace tactbench::analysis;

namespace trajectory_edges {
namespace {

// One step for each set-point, without a time from command to frame.
SequenceData steps_at(const std::vector<double>& set_points) {
  Repeat repeat;
  for (const double psi : set_points) repeat.steps.push_back({psi, psi, 0.0, 0.0});
  return {"s", {repeat}};
}

Dataset run_at(const std::vector<std::vector<double>>& sequences) {
  Dataset dataset;
  dataset.run = 7;
  for (const std::vector<double>& set_points : sequences) dataset.sequences.push_back(steps_at(set_points));
  return dataset;
}

JudgedTrajectory judged(const std::vector<double>& set_points) {
  return judged_trajectory(run_at({set_points}), run_at({{0, 50, 0}}));
}

}  // namespace

TEST_CASE("trajectory: eight turning points make a random path, seven do not") {
  CHECK(judged({0, 50, 20, 60, 30, 70, 40, 80, 10, 100}).trajectory == Trajectory::kRandomReversals);
  CHECK(judged({0, 50, 20, 60, 30, 70, 40, 80, 5}).trajectory == Trajectory::kOther);
}

TEST_CASE("trajectory: no random path if a third of the turning points lie within 1 % of an end") {
  // Nine turning points from 0 to 100 psi: those at 99, 1 and 100 psi lie at an end.
  CHECK(judged({0, 99, 40, 60, 1, 50, 30, 100, 20, 70, 10}).trajectory == Trajectory::kOther);
  CHECK(judged({0, 98.9, 40, 60, 1, 50, 30, 100, 20, 70, 10}).trajectory == Trajectory::kRandomReversals);
  CHECK(judged({0, 99, 40, 60, 1.1, 50, 30, 100, 20, 70, 10}).trajectory == Trajectory::kRandomReversals);
  // Three of ten are fewer than a third.
  CHECK(judged({0, 99, 40, 60, 1, 50, 30, 100, 20, 70, 10, 15}).trajectory == Trajectory::kRandomReversals);
}

TEST_CASE("trajectory: a branch is inner when it is shorter than 98 % of the range") {
  // Six branches of one frame each: the last two span 97.9 of 100 psi.
  const JudgedTrajectory found = judged({0, 100, 0, 98, 0, 97.9, 0});
  CHECK(found.inner_share == Approx(2.0 / 6.0));
  CHECK(found.reversals == 5);
  // Frames count, not branches: 3 of 8.
  CHECK(judged({0, 50, 100, 50, 0, 100, 50, 40, 30}).inner_share == Approx(3.0 / 8.0));
}

TEST_CASE("trajectory: the range is that of all sequences, the turning points are those of the longest") {
  const JudgedTrajectory found = judged_trajectory(run_at({{0, 40, 0, 40, 0}, {20, 80, 20}}), run_at({{0, 40, 0}}));
  CHECK(found.reversals == 3);
  CHECK(found.inner_share == 1.0);
  CHECK(judged_trajectory(run_at({{20, 80, 20}, {0, 40, 0, 40, 0}}), run_at({{0, 40, 0}})).reversals == 3);
  CHECK(judged({50}).inner_share == 0.0);
  CHECK(judged({50}).reversals == 0);
}

TEST_CASE("trajectory: set-points equal the fitted ones within 1e-6 psi each, with no step missing") {
  CHECK(judged({0, 50.0000009, 0}).trajectory == Trajectory::kAsFitted);
  CHECK(judged({0, 50.0000011, 0}).trajectory == Trajectory::kOther);
  CHECK(judged({0, 50}).trajectory == Trajectory::kOther);
  CHECK(judged({0, 50, 0, 50}).trajectory == Trajectory::kOther);
  // Every sequence must be one of the fitted ones; not every fitted one must be there.
  CHECK(judged_trajectory(run_at({{0, 50, 0}, {0, 30, 0}}), run_at({{0, 30, 0}, {0, 50, 0}, {0, 20, 0}})).trajectory ==
        Trajectory::kAsFitted);
  CHECK(judged_trajectory(run_at({{0, 30, 0}, {0, 50, 0}}), run_at({{0, 50, 0}})).trajectory == Trajectory::kOther);
}

TEST_CASE("trajectory: dwells differ if they are more than 20 % of the fitted dwell apart") {
  const auto differ = [](double dwell_s) {
    JudgedTrajectory out;
    set_dwell(out, dwell_s, 5.0);
    CHECK((out.dwell_s == dwell_s || std::isnan(dwell_s)));
    CHECK(out.fitted_dwell_s == 5.0);
    return out.other_dwell;
  };
  CHECK_FALSE(differ(6.0));
  CHECK(differ(6.01));
  CHECK_FALSE(differ(4.0));
  CHECK(differ(3.99));
  CHECK_FALSE(differ(kNan));
}

TEST_CASE("trajectory: the dwell is the median of the stated times, and unknown if none is stated") {
  Dataset own = run_at({{0, 50, 0}}), fitted = own;
  const JudgedTrajectory none = judged_trajectory(own, fitted);
  CHECK(std::isnan(none.dwell_s));
  own.sequences[0].repeats[0].steps[1].held_s = 0.5;
  own.sequences[0].repeats[0].steps[2].held_s = 1.5;
  fitted.sequences[0].repeats[0].steps[2].held_s = 4.0;
  const JudgedTrajectory known = judged_trajectory(own, fitted);
  CHECK((known.dwell_s == 1.0 && known.fitted_dwell_s == 4.0));
}

}  // namespace trajectory_edges
