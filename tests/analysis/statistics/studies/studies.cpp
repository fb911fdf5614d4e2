// Results of further runs, on frames whose answer is known.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <random>
#include <stdexcept>

#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/studies/contact.h"
#include "analysis/statistics/studies/studies.h"
#include "tests/analysis/support/straight_array.h"

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

TEST_CASE("uniformity: four quarter turns recover the chamber map except its rotation-invariant part") {
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

TEST_CASE("uniformity: the chamber's constant part is separated from the part that grows with pressure") {
  const Uniformity u = uniformity_of(turned({0, 90, 180, 270}, 0.0, 0.2), kSide, kSide);
  REQUIRE(u.assessed());
  CHECK(u.residual_rms_psi < 1e-9);
  // Stripes of +-0.2 psi add up to 0 over the four places of a taxel.
  CHECK(u.u_offset_psi == Approx(0.2 * std::sqrt(36.0 / 35.0)).epsilon(1e-6));
}

TEST_CASE("uniformity: noise appears as the residual") {
  const Uniformity u = uniformity_of(turned({0, 90, 180, 270}, 0.05), kSide, kSide);
  REQUIRE(u.assessed());
  CHECK(u.residual_rms_psi == Approx(0.05).epsilon(0.15));
}

TEST_CASE("uniformity: half a turn leaves twice as many constants open, and taxels without a model are skipped") {
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

TEST_CASE("uniformity: without a rotation nothing can be separated") {
  CHECK_FALSE(uniformity_of(turned({0, 0}), kSide, kSide).assessed());
  CHECK_FALSE(Uniformity().assessed());
}

TEST_CASE("mounts: those that differ less than the sweeps of one mount count as equal") {
  const SweepEstimates estimates{.pressure_psi = {10.0}, .sweeps = 2, .taxels = 1, .psi = {9.0, 11.0}};
  const std::vector<MountedRun> mounts{{1, estimates}, {2, estimates}};
  CHECK(remount_of(mounts).between_psi[0] == 0.0);
  CHECK_FALSE(remount_of(std::span(mounts).first(1)).assessed());
}

// Mounts of unequal size, contacts at their threshold, paces at their bound, and frames in their time: by hand.

using namespace straight_array;

namespace {

// Estimates of one mount: levels x sweeps x taxels.
MountedRun mount_with(std::int64_t run, std::vector<double> levels, int sweeps, int taxels, std::vector<double> psi) {
  return {run, {std::move(levels), sweeps, taxels, std::move(psi)}};
}

}  // namespace

TEST_CASE("mounts: one, two and three sweeps are weighted by their number") {
  // 10 psi: 10 | 11 13 | 8 9 10. Means 10, 12, 9; of all six 61 / 6. Within: 2 + 2 = 4 with three degrees of freedom.
  const std::vector<MountedRun> mounts{mount_with(1, {10}, 1, 1, {10}), mount_with(2, {10}, 2, 1, {11, 13}),
                                       mount_with(3, {10}, 3, 1, {8, 9, 10})};
  const Remount found = remount_of(mounts);
  REQUIRE(found.assessed());
  CHECK(found.runs == std::vector<std::int64_t>{1, 2, 3});
  const double within = 4.0 / 3.0, all = 61.0 / 6.0;
  const double between = (std::pow(10 - all, 2) + 2 * std::pow(12 - all, 2) + 3 * std::pow(9 - all, 2)) / 2.0;
  const double size = (6.0 - 14.0 / 6.0) / 2.0;  // of a group: 11 / 6
  CHECK(found.within_psi[0] == Approx(std::sqrt(within)));
  CHECK(found.between_psi[0] == Approx(std::sqrt((between - within) / size)));
  CHECK(found.within_share == Approx(std::sqrt(within) / 10));
  CHECK(found.degrees == 2);
  CHECK(found.per_taxel_degrees == 2);  // one taxel: of its own there is nothing, and the number is not 0
}

TEST_CASE("mountings: the common shift and that of each taxel match hand-computed values, unread taxels are left out") {
  // One sweep a mount; at 20 psi the taxels move by +3 and +1 psi: variances 4.5 and 0.5, of their mean 2. The third is
  // not fitted.
  const std::vector<MountedRun> mounts{mount_with(1, {20}, 1, 3, {20, 20, kNan}),
                                       mount_with(2, {20}, 1, 3, {23, 21, kNan})};
  const Remount found = remount_of(mounts);
  CHECK(found.within_psi[0] == 0.0);
  CHECK(found.between_psi[0] == Approx(std::sqrt(2.5)));
  CHECK(found.mean_between_psi[0] == Approx(std::sqrt(2.0)));
  CHECK(found.taxel_between_psi[0] == Approx(std::sqrt(4.5)));
  CHECK(found.taxel_between_psi[1] == Approx(std::sqrt(0.5)));
  CHECK(std::isnan(found.taxel_between_psi[2]));
  CHECK(found.s_share == Approx(std::sqrt(2.5) / 20));
  CHECK(found.common_share == Approx(std::sqrt(2.0) / 20));
  CHECK(found.per_taxel_share == Approx(std::sqrt(0.5) / 20));
  CHECK(found.per_taxel_degrees == 1);  // one further mount, two taxels less one
}

TEST_CASE("mounts: the common part is at most the whole, and values of single taxels are over all levels") {
  // At 10 psi the first taxel moves by +2, at 20 psi by +4; the other stands still: variances 2, 8 and 0.
  const std::vector<MountedRun> mounts{mount_with(1, {10, 20}, 1, 2, {10, 10, 20, 20}),
                                       mount_with(2, {10, 20}, 1, 2, {12, 10, 24, 20})};
  const Remount found = remount_of(mounts);
  CHECK(found.taxel_between_psi[0] == Approx(std::sqrt(5.0)));
  CHECK(found.taxel_between_psi[1] == 0.0);
  CHECK(found.between_psi[0] == Approx(1.0));
  CHECK(found.mean_between_psi[0] == Approx(std::sqrt(0.5)));
  CHECK(found.common_share == Approx(std::sqrt(0.5) / 10));  // 7.07 % at both
}

TEST_CASE("mounts: levels match within 0.05 psi and count above 0.5 psi, shares from a tenth of the highest") {
  const auto levels_found = [](std::vector<double> second, double lowest = 1.0) {
    const std::vector<MountedRun> mounts{mount_with(1, {lowest, 10}, 1, 1, {1, 10}),
                                         mount_with(2, std::move(second), 1, 1, {1, 11})};
    return remount_of(mounts);
  };
  CHECK(levels_found({1, 10.04}).pressure_psi == std::vector<double>{1, 10});
  CHECK(levels_found({1, 10.06}).pressure_psi == std::vector<double>{1});
  CHECK(levels_found({0.5, 10}, 0.5).pressure_psi == std::vector<double>{10});
  CHECK(levels_found({0.51, 10}, 0.51).pressure_psi == std::vector<double>{0.51, 10});
  const Remount none = levels_found({2, 20});
  CHECK_FALSE(none.assessed());
  CHECK_FALSE(none.not_assessed.empty());
  // The lower level does not move, the upper one by 1 psi, s = 1 / sqrt 2: 7.07 %. From a tenth of it on both count.
  CHECK(levels_found({1, 10}, 1).s_share == Approx(std::sqrt(0.005 / 2)));
  CHECK(levels_found({0.99, 10}, 0.99).s_share == Approx(std::sqrt(0.005)));
}

TEST_CASE("contact: taxels count from a tenth of the peak or 0.5 psi on, the threshold included") {
  const ArrayGeometry geometry{2.0, 1.0 / kNewtonPerPsiMm2};  // 1 psi on a taxel is 1 N
  const ContactFigures ten = contact_figures(std::vector<double>{20, 2, 1.99, -1}, 1, 4, geometry);
  CHECK(ten.threshold_psi == 2.0);
  CHECK(ten.force_n == Approx(22.99));
  CHECK(ten.area_mm2 == Approx(2.0 * geometry.taxel_area_mm2));
  // Places -3, -1, 1, 3 mm: 20 and 2 N at -3 and -1.
  CHECK(ten.moment_y_nmm == Approx(62.0));
  CHECK(ten.x_mm == Approx(-62.0 / 22.0));
  CHECK(ten.y_mm == Approx(0.0).margin(1e-12));
  const ContactFigures half = contact_figures(std::vector<double>{0.4, 0.5, 4.0}, 3, 1, geometry);
  CHECK(half.threshold_psi == 0.5);
  CHECK(half.y_mm == Approx(8.0 / 4.5));  // 0.5 N at 0 and 4 N at 2 mm
  CHECK(half.moment_x_nmm == Approx(8.0));
  const ContactFigures none = contact_figures(std::vector<double>{0.4, 0.3, -9.0}, 3, 1, geometry);
  CHECK((std::isnan(none.x_mm) && std::isnan(none.y_mm)));
  CHECK(none.area_mm2 == 0.0);
  CHECK_THROWS_AS(contact_figures(std::vector<double>(4, 1.0), 1, 3, geometry), std::invalid_argument);
  const double infinite = std::numeric_limits<double>::infinity();
  CHECK(contact_figures(std::vector<double>{infinite, 3.0, kNan}, 1, 3, geometry).force_n == Approx(3.0));
}

TEST_CASE("contact: each rise starts unloaded, after another repeat, another position or a fall") {
  // One taxel of 20 psi a volt going up, and of 30 V / (V + 1) psi or so coming down: 1 V is 20 psi on the way up
  // alone.
  SensorModel fit;
  fit.rows = fit.columns = 1;
  fit.origin = "simulated";
  fit.sensor_serial = "S";
  fit.pressure_psi = {0.0, 20.0, 40.0, 60.0};
  const std::vector<double> up{0.0, 1.0, 2.0, 3.0}, down{0.0, 2.0, 2.6, 3.0};
  fit.taxels = {by_hand::elam_taxel(PatternCurve(fit.pressure_psi, up, 0.0, 3.0),
                                    PatternCurve(fit.pressure_psi, down, 0.0, 3.0))};
  by_hand::finish(fit, fit.taxels[0]);
  const auto last_reading = [&](int repeat, int position, bool rising) {
    PressRun run;
    run.origin = "simulated";
    run.sensor_serial = "S";
    run.rows = run.columns = 1;
    const auto press = [&](int own_repeat, int own_position, bool own_rising, double target_n, double volts) {
      PressFrame frame;
      frame.repeat = own_repeat;
      frame.position = own_position;
      frame.rising = own_rising;
      frame.target_n = target_n;
      frame.volts = {volts};
      run.frames.push_back(frame);
    };
    press(0, 0, true, 1, 1.0);
    press(0, 0, true, 2, 3.0);
    press(0, 0, false, 1, 1.0);
    press(repeat, position, rising, 7, 1.0);
    for (const ContactLevel& level : contact_result(run, fit, {2.0, 1.0}).levels)
      if (level.target_n == 7) return level.compensated_psi[0];
    return kNan;
  };
  CHECK(last_reading(0, 0, true) == Approx(20.0));
  CHECK(last_reading(1, 0, false) == Approx(20.0));
  CHECK(last_reading(0, 1, false) == Approx(20.0));
  CHECK(last_reading(0, 0, false) < 18.0);  // still on its way down
}

TEST_CASE("rate study: repeats 1.2 times faster have another rate, and held levels have no rate") {
  const auto paced_at = [](double seconds, double volts) {
    Repeat repeat;
    for (int i = 0; i < 2; ++i) {
      repeat.steps.push_back({20.0 * i, 20.0 * i, seconds * i, 0.0});
      repeat.volts.insert(repeat.volts.end(), {volts, volts, 9.0});
    }
    return repeat;
  };
  const auto share_of = [&](double quick_s) {
    return rate_hold_of(dataset_of({{"rate", {paced_at(60, 1.0), paced_at(quick_s, 1.45)}}}), straight_fit(), 1)
        .front()
        .output_mean_share;
  };
  CHECK(share_of(50.1) == 0.0);
  CHECK(share_of(49.9) == Approx(0.1));  // 0.45 of 4.5 V
  CHECK(share_of(50.0) == Approx(0.1));  // 1.2 times as long is 60 s
  // Of one frame each there is one difference.
  const auto one_frame = [](double volts) { return Repeat{{{20.0, 20.0, 0.0, 0.0}}, {volts, volts, 9.0}}; };
  CHECK(rate_hold_of(dataset_of({{"rate", {one_frame(1.0), one_frame(1.9)}}}), straight_fit(), 1)
            .front()
            .output_mean_share == Approx(0.2));
  // Two frames at one set-point: 0.4 psi in 2 s of the reference are noise. A step without time has no rate.
  Repeat held;
  for (const auto& [setpoint, reference, time] : {std::tuple{0.0, 0.0, 0.0}, std::tuple{20.0, 20.0, 10.0},
                                                  std::tuple{20.0, 20.4, 12.0}, std::tuple{40.0, 40.0, 12.0}}) {
    held.steps.push_back({setpoint, reference, time, 0.0});
    held.volts.insert(held.volts.end(), {reference / 20.0, reference / 10.0, 9.0});
  }
  const RateHoldRun run = rate_hold_of(dataset_of({{"creep-hold", {held}}}), straight_fit(), 1).front();
  REQUIRE(run.by_rate.size() == 1);
  CHECK(run.by_rate[0].low == Approx(2.0));  // 20 psi in 10 s
  CHECK(run.by_rate[0].error.samples == 2);
  CHECK(run.by_hold.empty());
  CHECK((run.run == 2 && run.sequence == "creep-hold"));
}

// Crosstalk to each of its bounds, on prints of one taxel, or two, whose shares are given by zone.

namespace {

constexpr int kMap = 17;

struct PrintShares {
  double row = 0.0, column = 0.0, elsewhere = 0.0;  // beyond two pitches along rows and columns
  double peak_v = 1.0;
  double right = 0.0, corner = 0.0;  // of the next taxel along the row, and of the one next to both
};

// One taxel at (row, column) of an array, 1 V over a zero of 0.125 V; nothing else within two pitches but what is
// asked.
PointFrame small_print(int position, int at_row, int at_column, const PrintShares& shares, int rows = kMap,
                       int columns = kMap) {
  PointFrame frame{position, true, 5.0, {}};
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int down = std::abs(row - at_row), along = std::abs(column - at_column);
      double share = shares.elsewhere;
      if (down == 0 && along == 0)
        share = 1.0;
      else if (row == at_row && column == at_column + 1)
        share = shares.right;
      else if (row == at_row + 1 && column == at_column + 1)
        share = shares.corner;
      else if (down <= 2 && along <= 2)
        share = 0.0;
      else if (down <= 1)
        share = shares.row;
      else if (along <= 1)
        share = shares.column;
      frame.volts.push_back(0.125 + shares.peak_v * share);
    }
  }
  return frame;
}

// On the diagonal, so that no two share a row or a column and each taxel is at rest under two of the four.
std::vector<PointFrame> on_the_diagonal(const std::vector<PrintShares>& shares) {
  std::vector<PointFrame> frames;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const int at = 2 + 4 * static_cast<int>(i);
    frames.push_back(small_print(static_cast<int>(i), at, at, shares[i]));
  }
  return frames;
}

Crosstalk crosstalk_on(const std::vector<PrintShares>& shares) {
  return crosstalk_of(7, on_the_diagonal(shares), kMap, kMap);
}

}  // namespace

TEST_CASE("crosstalk: taxels from a tenth of the peak on define the centre of the print") {
  // A neighbour of 3/32 counts for nothing; one of 1/8 pulls the centre by 1/9 of a pitch: the column two to the left
  // is then beyond the reach, and the one to the left no loaded one any more.
  const PrintShares below{.right = 0.09375}, above{.right = 0.125};
  const Crosstalk still = crosstalk_on({below, below, below, below}),
                  pulled = crosstalk_on({above, above, above, above});
  CHECK(still.row.samples == 4 * 3 * (17 - 5));
  CHECK(still.column.samples == 4 * 3 * (17 - 5));
  CHECK(pulled.row.samples == 4 * 3 * (17 - 4));
  CHECK(pulled.column.samples == 4 * 2 * (17 - 5));
  CHECK(pulled.elsewhere.samples == 4 * (17 * 17 - 5 * 4 - 3 * 13 - 2 * 12));
}

TEST_CASE("crosstalk: the centre of the print is weighted by the shares in both directions") {
  // 1 and 0.5 at one pitch down and to the right: the centre is a third of a pitch off. Rows and columns at -1/3 and
  // +2/3 are loaded; -4/3 to +5/3 are within reach.
  const PrintShares two{.corner = 0.5};
  const Crosstalk c = crosstalk_on({two, two, two, two});
  CHECK(c.row.samples == 4 * 2 * (17 - 4));
  CHECK(c.column.samples == 4 * 2 * (17 - 4));
  CHECK(c.elsewhere.samples == 4 * (17 * 17 - 4 * 4 - 2 * 2 * 13));
  // Distances to the nearest whole pitch: of the two loaded rows at none 1 and 0, at one 0 0 (-4/3) and 0 0.5 (+2/3).
  CHECK(c.along_row_share[0] == Approx(0.5));
  CHECK(c.along_row_share[1] == Approx(0.125));
  CHECK(c.along_column_share[0] == Approx(0.5));
  CHECK(c.along_column_share[1] == Approx(0.125));
}

TEST_CASE("crosstalk: a peak below 50 mV does not count as a press, and four positions are needed") {
  const PrintShares full, weak{.peak_v = 0.049}, enough{.peak_v = 0.051};
  CHECK_FALSE(crosstalk_on({full, full, full, weak}).assessed());
  CHECK_FALSE(crosstalk_on({full, full, full, weak}).not_assessed.empty());
  CHECK(crosstalk_on({full, full, full, enough}).positions == 4);
  CHECK_FALSE(crosstalk_on({full, full, full}).assessed());
  const Crosstalk none = crosstalk_of(7, {}, kMap, kMap);
  CHECK_FALSE(none.not_assessed.empty());
  CHECK(none.run == 7);
}

TEST_CASE("crosstalk: the uncertainty of a zone's share is that of the mean over the positions") {
  std::vector<PrintShares> shares(4);
  for (std::size_t i = 0; i < 4; ++i) shares[i].row = 0.002 * static_cast<double>(i + 1);
  const Crosstalk c = crosstalk_on(shares);
  // 2, 4, 6, 8 thousandths: mean 5, variance 20 / 3, over four.
  CHECK(c.row.mean_share == Approx(0.005));
  CHECK(c.row.u_share == Approx(0.001 * std::sqrt(20.0 / 3.0 / 4.0)));
  CHECK(c.row.max_share == Approx(0.008));
  CHECK(c.column.u_share == Approx(0.0).margin(1e-12));
  CHECK(c.force_n == Approx(5.0));
}

TEST_CASE("crosstalk: a ghost line must exceed the rest by 0.5 %") {
  const PrintShares below{.row = 0.0049, .column = 0.0049}, above{.row = 0.0051, .column = 0.0051};
  const Crosstalk none = crosstalk_on({below, below, below, below});
  CHECK(none.ghost_rows.empty());
  CHECK(none.ghost_columns.empty());
  const Crosstalk all = crosstalk_on({below, above, below, below});
  REQUIRE(all.ghost_rows.size() == 3);
  REQUIRE(all.ghost_columns.size() == 3);
  for (std::size_t i = 0; i < 3; ++i) {
    CHECK(all.ghost_rows[i].line == 5 + static_cast<int>(i));
    CHECK(all.ghost_rows[i].mean_share == Approx(0.0051));
    CHECK(all.ghost_columns[i].line == 5 + static_cast<int>(i));
  }
}

TEST_CASE("crosstalk: a ghost line must exceed the rest by three standard deviations") {
  // Elsewhere shows 8 thousandths at one of four positions: 2 in the mean, u = 4 / sqrt(4) = 2 (variance 16).
  const auto ghosts = [](double row) {
    std::vector<PrintShares> shares(4);
    shares[0].elsewhere = 0.008;
    shares[1].row = row;
    return crosstalk_on(shares);
  };
  CHECK(ghosts(0.0).elsewhere.mean_share == Approx(0.002).epsilon(0.02));
  CHECK(ghosts(0.0).elsewhere.u_share == Approx(0.002).epsilon(0.02));
  CHECK(ghosts(0.0076).ghost_rows.empty());  // 5.6 beyond, of the 6 that are needed
  CHECK(ghosts(0.0085).ghost_rows.size() == 3);
}

TEST_CASE("crosstalk: the scatter of a ghost line over its positions counts") {
  // Row 2 lies under two prints, 12 thousandths in the mean; +-6 leave u = 6, +-2 leave u = 2.
  const auto ghosts = [](double half) {
    std::vector<PointFrame> frames;
    for (int i = 0; i < 4; ++i) {
      PrintShares own;
      if (i < 2) own.row = i == 0 ? 0.012 - half : 0.012 + half;
      frames.push_back(small_print(i, i < 2 ? 2 : 8 + 3 * (i - 2), 2 + 4 * i, own));
    }
    return crosstalk_of(7, frames, kMap, kMap).ghost_rows;
  };
  CHECK(ghosts(0.006).empty());
  REQUIRE(ghosts(0.002).size() == 3);
  CHECK(ghosts(0.002)[0].line == 1);
  CHECK(ghosts(0.002)[1].mean_share == Approx(0.012));
}

TEST_CASE("crosstalk: a zone without taxels has no result, and its lines are not ghost lines") {
  // Five columns: all of a print's rows lie within its reach along them.
  std::vector<PointFrame> frames;
  for (int i = 0; i < 4; ++i) frames.push_back(small_print(i, 2 + 4 * i, 2, {.column = 0.004}, kMap, 5));
  // Each taxel of the middle columns is at rest under none of the prints but its own rows': the quartile is the second.
  const Crosstalk c = crosstalk_of(7, frames, kMap, 5);
  REQUIRE(c.assessed());
  CHECK(c.row.samples == 0);
  CHECK((std::isnan(c.row.mean_share) && std::isnan(c.row.u_share) && std::isnan(c.row.max_share)));
  CHECK(c.ghost_rows.empty());
  CHECK(c.column.samples == 4 * 3 * (17 - 5));
  CHECK(c.elsewhere.samples == 4 * 2 * (17 - 5));
}

TEST_CASE("crosstalk: a non-square array has distances up to its longer side, NaN where there is none") {
  std::vector<PointFrame> frames;
  for (int i = 0; i < 4; ++i)
    frames.push_back(small_print(i, i % 2 == 0 ? 2 : 6, 2 + 4 * i, {.row = 0.004, .column = 0.002}, 9, kMap));
  const Crosstalk c = crosstalk_of(7, frames, 9, kMap);
  REQUIRE(c.assessed());
  REQUIRE(c.distance_pitches.size() == 15);  // from column 2 to the last of 17
  CHECK(c.distance_pitches.back() == 14.0);
  CHECK(c.along_row_share[14] == Approx(0.004));
  CHECK(c.along_column_share[6] == Approx(0.002));  // from row 2 to the last of 9
  CHECK(std::isnan(c.along_column_share[7]));
  CHECK(std::isnan(c.along_column_share[14]));
  // Two prints lie in each row, so the line's samples are those of both.
  CHECK(c.row.samples == 4 * 3 * (17 - 5));
  CHECK(c.column.samples == 4 * 3 * (9 - 5));
}

TEST_CASE("crosstalk: only rising frames within a tenth of the highest force count") {
  std::vector<PointFrame> frames = on_the_diagonal(std::vector<PrintShares>(4));
  struct More {
    int position;
    double force_n;
    bool rising;
  };
  // The second is just a tenth less, the third a lower level, the last on its way down.
  for (const More& more : {More{0, 4.6, true}, More{3, 4.5, true}, More{1, 4.4, true}, More{2, 5.0, false}}) {
    PointFrame frame = frames[static_cast<std::size_t>(more.position)];
    frame.force_n = more.force_n;
    frame.rising = more.rising;
    frames.push_back(frame);
  }
  const Crosstalk c = crosstalk_of(7, frames, kMap, kMap);
  REQUIRE(c.assessed());
  CHECK(c.positions == 4);
  CHECK(c.reach_pitches == 2.0);
  CHECK(c.force_n == Approx((4 * 5.0 + 4.6 + 4.5) / 6));
  CHECK(c.row.samples == 6 * 3 * 12);
  CHECK(c.elsewhere.samples == 6 * (17 * 17 - 5 * 5 - 2 * 3 * 12));
}
