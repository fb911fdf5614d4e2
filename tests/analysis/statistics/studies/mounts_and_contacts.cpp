// Mounts of unequal size, contacts at their threshold, paces at their bound, and frames in their time: by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/studies/contact_results.h"
#include "analysis/statistics/studies/studies.h"
#include "tests/analysis/support/straight_array.h"

using namespace straight_array;

namespace {

// Estimates of one mount: levels x sweeps x taxels.
MountedRun mount_with(std::int64_t run, std::vector<double> levels, int sweeps, int taxels, std::vector<double> psi) {
  MountedRun mount{run, {}};
  mount.estimates.pressure_psi = std::move(levels);
  mount.estimates.sweeps = sweeps;
  mount.estimates.taxels = taxels;
  mount.estimates.psi = std::move(psi);
  return mount;
}

}  // namespace

TEST_CASE("mounts by hand: one, two and three sweeps weigh by their number") {
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
  CHECK(found.own_degrees == 2);  // one taxel: of its own there is nothing, and the number is not 0
}

TEST_CASE("mounts by hand: what two taxels have in common and what is a taxel's own, one without a reading left out") {
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
  CHECK(found.own_share == Approx(std::sqrt(0.5) / 20));
  CHECK(found.own_degrees == 1);  // one further mount, two taxels less one
}

TEST_CASE("mounts: the common part is no more than the whole, and single taxels' figures are over all levels") {
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

TEST_CASE(
    "mounts: levels within 0.05 psi are one, those from 0.5 psi down are none, shares from a tenth of the highest") {
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

TEST_CASE("contacts at their threshold: a tenth of the peak or half a psi, the taxel at it included") {
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

TEST_CASE("contacts: each rise begins unloaded, after another repeat or place and after a fall") {
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

TEST_CASE("rate study: repeats 1.2 times as quick are of another pace, rates of levels that are held are none") {
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
