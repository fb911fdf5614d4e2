// Results of further runs, on frames whose answer is known.
#include "analysis/statistics/studies/studies.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>

using namespace tactbench::analysis;

namespace {

constexpr int kSide = 6;  // 36 taxels, 9 sets of four places

double share_of_tilt(int place) { return 0.004 * (place % kSide - 2.5) - 0.002 * (place / kSide - 2.5); }
// The same at all places that a quarter turn takes a taxel to.
double share_of_bowl(int place) {
  const double x = place % kSide - 2.5, y = place / kSide - 2.5;
  return 0.001 * (x * x + y * y);
}
double share_of_taxel(int taxel) { return 0.01 * std::sin(1.7 * taxel); }

SweepEstimates estimates_at(int angle, double noise_psi = 0.0, double offset_psi = 0.0) {
  const std::vector<int> places = turned_places(kSide, kSide, angle);
  std::mt19937 random(static_cast<unsigned>(angle) + 1);
  std::normal_distribution<double> normal;
  SweepEstimates out;
  out.pressure_psi = {0.0, 10.0, 20.0, 40.0, 60.0};
  out.sweeps = 1;
  out.taxels = kSide * kSide;
  for (const double p : out.pressure_psi)
    for (int taxel = 0; taxel < out.taxels; ++taxel) {
      const int place = places[static_cast<std::size_t>(taxel)];
      const double share = share_of_tilt(place) + share_of_bowl(place) + share_of_taxel(taxel);
      const double fixed = offset_psi * (place % 2 == 0 ? 1.0 : -1.0);
      out.psi.push_back(p * (1.0 + share) + fixed + noise_psi * normal(random));
    }
  return out;
}

std::vector<TurnedRun> turned(const std::vector<int>& angles, double noise_psi = 0.0, double offset_psi = 0.0) {
  std::vector<TurnedRun> runs;
  for (const int angle : angles)
    runs.push_back({static_cast<std::int64_t>(runs.size()) + 1, angle, estimates_at(angle, noise_psi, offset_psi)});
  return runs;
}

}  // namespace

TEST_CASE("four quarter turns give the chamber's map back but for what a quarter turn does not change") {
  const Uniformity u = uniformity_of(turned({0, 90, 180, 270}), kSide, kSide);
  REQUIRE(u.assessed());
  CHECK(u.pressure_psi == std::vector<double>{10.0, 20.0, 40.0});  // at 60 psi estimates come to the models' end
  CHECK(u.undetermined == 9);
  // 36 cells less the 9 sets of four whose common part could be the sensor's: what a taxel differs by within a set.
  CHECK(u.degrees == 27);
  CHECK(u.residual_rms_psi < 1e-9);
  double squares = 0.0, mean_of_taxels = 0.0, mean_of_bowl = 0.0;
  for (int i = 0; i < kSide * kSide; ++i) {
    mean_of_taxels += share_of_taxel(i) / (kSide * kSide);
    mean_of_bowl += share_of_bowl(i) / (kSide * kSide);
  }
  for (int i = 0; i < kSide * kSide; ++i) {
    const auto at = static_cast<std::size_t>(i);
    // The tilt's mean over a set of four is 0: it comes back whole; the bowl stays with the sensor.
    CHECK(u.chamber_share[at] == Approx(share_of_tilt(i)).margin(1e-12));
    CHECK(u.chamber_psi[at] == Approx(0.0).margin(1e-9));
    CHECK(u.sensor_share[at] ==
          Approx(share_of_taxel(i) - mean_of_taxels + share_of_bowl(i) - mean_of_bowl).margin(1e-12));
    squares += share_of_tilt(i) * share_of_tilt(i);
  }
  CHECK(u.u_share == Approx(std::sqrt(squares / 35.0)).epsilon(1e-9));
  for (std::size_t level = 0; level < u.u_psi.size(); ++level)
    CHECK(u.u_psi[level] == Approx(u.pressure_psi[level] * u.u_share).epsilon(1e-9));
  // Typed the other way round, the maps cannot explain the runs.
  CHECK(u.residual_other_sense_psi > 0.05);
}

TEST_CASE("the chamber's constant part is separated from the part that grows with pressure") {
  const Uniformity u = uniformity_of(turned({0, 90, 180, 270}, 0.0, 0.2), kSide, kSide);
  REQUIRE(u.assessed());
  CHECK(u.residual_rms_psi < 1e-9);
  // Stripes of +-0.2 psi add up to 0 over the four places of a taxel.
  CHECK(u.u_offset_psi == Approx(0.2 * std::sqrt(36.0 / 35.0)).epsilon(1e-6));
}

TEST_CASE("noise comes out as the residual") {
  const Uniformity u = uniformity_of(turned({0, 90, 180, 270}, 0.05), kSide, kSide);
  REQUIRE(u.assessed());
  CHECK(u.residual_rms_psi == Approx(0.05).epsilon(0.15));
}

TEST_CASE("half a turn alone leaves twice as many constants undetermined, and taxels without a model are skipped") {
  std::vector<TurnedRun> runs = turned({0, 180});
  const Uniformity half = uniformity_of(runs, kSide, kSide);
  REQUIRE(half.assessed());
  CHECK((half.undetermined == 18 && half.degrees == 18));  // pairs
  CHECK(half.chamber_share[1] == Approx(share_of_tilt(1)).margin(1e-12));
  runs = turned({0, 90, 180, 270});
  for (TurnedRun& run : runs)
    for (std::size_t level = 0; level < 5; ++level)
      run.estimates.psi[level * 36 + 7] = std::numeric_limits<double>::quiet_NaN();
  const Uniformity u = uniformity_of(runs, kSide, kSide);
  REQUIRE(u.assessed());
  CHECK((u.undetermined == 9 && u.degrees == 27));  // without one taxel its set of four places is still one
  CHECK(u.residual_rms_psi < 1e-9);
  CHECK(std::isnan(u.sensor_share[7]));
  CHECK(u.chamber_share[7] == Approx(share_of_tilt(7)).margin(1e-12));  // other taxels came to its place
}

TEST_CASE("without a turn nothing can be separated") {
  CHECK_FALSE(uniformity_of(turned({0, 0}), kSide, kSide).assessed());
  CHECK_FALSE(Uniformity().assessed());
}

TEST_CASE("mounts that differ less than their own sweeps count as equal") {
  SweepEstimates estimates;
  estimates.pressure_psi = {10.0};
  estimates.sweeps = 2;
  estimates.taxels = 1;
  estimates.psi = {9.0, 11.0};
  const std::vector<MountedRun> mounts{{1, estimates}, {2, estimates}};
  CHECK(remount_of(mounts).between_psi[0] == 0.0);
  CHECK_FALSE(remount_of(std::span(mounts).first(1)).assessed());
}
