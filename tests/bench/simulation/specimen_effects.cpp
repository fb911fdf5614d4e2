// Each switchable effect against its known truth.
#include <catch2/catch.hpp>
#include <functional>

#include "tests/bench/simulation/specimen_runs.h"

namespace tactbench::bench::testing {
namespace {

SpecimenOptions changed(const std::function<void(SpecimenOptions&)>& change) {
  SpecimenOptions options;
  change(options);
  return options;
}

// The frame at `pressure_psi` on the ascending branch, after one cycle, and the unloaded frame before it.
struct Reading {
  Frame zero;
  Frame loaded;
};

Reading read(const SpecimenOptions& options, double pressure_psi = 30.0) {
  Specimen specimen(options);
  Walker walker(specimen);
  walker.walk({60, 0});
  Reading reading;
  reading.zero = walker.frame();
  walker.walk({pressure_psi});
  reading.loaded = walker.frame();
  return reading;
}

}  // namespace

TEST_CASE("specimen: crosstalk adds the given share of the others' mean in row and column") {
  const Frame plain = read({}).loaded;
  const Frame crossed = read(changed([](SpecimenOptions& o) {
                          o.effects.row_crosstalk = 0.02;
                          o.effects.column_crosstalk = 0.01;
                        })).loaded;
  for (std::size_t i = 0; i < 256; ++i) {
    double row = 0.0;
    double column = 0.0;
    for (std::size_t k = 0; k < 16; ++k) {
      row += plain[i / 16 * 16 + k];
      column += plain[k * 16 + i % 16];
    }
    const double truth = plain[i] + 0.02 * (row - plain[i]) / 15.0 + 0.01 * (column - plain[i]) / 15.0;
    REQUIRE(crossed[i] == Approx(std::min(5.0, truth)).margin(1e-12));
  }
}

TEST_CASE("specimen: temperature changes the signal by the coefficient, not the zero") {
  const Reading cool = read({});
  const Reading warm = read(changed([](SpecimenOptions& o) { o.temperature_c = 28.0; }));
  const Reading off = read(changed([](SpecimenOptions& o) {
    o.temperature_c = 28.0;
    o.effects.temperature_coefficient = 0.0;
  }));
  for (std::size_t i = 0; i < 256; ++i) {
    REQUIRE((warm.loaded[i] - warm.zero[i]) / (cool.loaded[i] - cool.zero[i]) == Approx(0.99).epsilon(1e-9));
    REQUIRE(warm.zero[i] == Approx(cool.zero[i]).margin(1e-12));
    REQUIRE(off.loaded[i] == cool.loaded[i]);
  }
}

TEST_CASE("specimen: below its lift-off pressure a taxel rests at its zero") {
  const auto options = changed([](SpecimenOptions& o) { o.effects.lift_off_psi = 3.0; });
  Specimen specimen(options);
  const Frame zero = Walker(specimen).frame();
  int silent_at_3 = 0;
  for (const double pressure : {1.0, 3.0, 6.0}) {
    for (int k = 0; k < 20; ++k) specimen.advance(pressure, 0.5);
    const Frame frame = Walker(specimen).frame();
    int silent = 0;
    for (std::size_t i = 0; i < 256; ++i) silent += frame[i] == Approx(zero[i]).margin(1e-9) ? 1 : 0;
    if (pressure == 1.0) CHECK(silent == 256);
    if (pressure == 3.0) silent_at_3 = silent;
    if (pressure == 6.0) CHECK(silent == 0);
  }
  CHECK(silent_at_3 > 90);  // the spread lies around the mean
  CHECK(silent_at_3 < 166);
  // On the way down too: the film forgets what it held.
  specimen.advance(1.0, 0.5);
  for (int k = 0; k < 60; ++k) specimen.advance(1.0, 1.0);
  CHECK(mean(Walker(specimen).frame()) == Approx(mean(zero)).margin(1e-9));
}

TEST_CASE("specimen: chamber non-uniformity scales the corner's pressure") {
  const auto lift_free = [](SpecimenOptions& o) { o.effects.lift_off_psi = 0.0; };
  const auto uneven = changed([&](SpecimenOptions& o) {
    lift_free(o);
    o.effects.chamber_nonuniformity = -0.1;
  });
  // A corner at 20 / 0.9 psi of the uneven chamber feels 20 psi; the conditioning goes with the chamber's pressure, so
  // both specimens are new and see their own pressure in one hold.
  Specimen flat(changed(lift_free));
  Specimen bowed(uneven);
  flat.advance(20.0, 10.0);
  bowed.advance(20.0 / 0.9, 10.0);
  const Frame a = Walker(flat).frame();
  const Frame b = Walker(bowed).frame();
  for (const std::size_t corner : {0U, 15U, 240U, 255U}) CHECK(b[corner] == Approx(a[corner]).epsilon(0.01));
  for (const std::size_t centre : {119U, 120U, 135U, 136U}) CHECK(b[centre] > 1.02 * a[centre]);
}

TEST_CASE("specimen: the chamber's tilt presses one edge more, whichever way the film lies under its leads") {
  // Taxels of the edge that the tilt rises to and of the other feel 20 psi at 20 / 1.05 and 20 / 0.95 psi.
  const auto frame_at = [](double pressure_psi, double tilt, double deg, MountTurn turn, double in_chamber_deg) {
    Specimen specimen(changed([&](SpecimenOptions& o) {
      o.effects.lift_off_psi = 0.0;
      o.effects.chamber_tilt = tilt;
      o.effects.chamber_tilt_deg = deg;
      o.mount_turn = turn;
      o.turned_in_chamber_deg = in_chamber_deg;
    }));
    specimen.advance(pressure_psi, 10.0);
    return Walker(specimen).frame();
  };
  for (const MountTurn turn : {MountTurn::kNone, MountTurn::kBy90, MountTurn::kTransposed}) {
    const Frame even = frame_at(20.0, 0.0, 0.0, turn, 0.0);
    const Frame high = frame_at(20.0 / 1.05, 0.1, 0.0, turn, 0.0);
    const Frame low = frame_at(20.0 / 0.95, 0.1, 0.0, turn, 0.0);
    for (std::size_t row = 0; row < 16; ++row) {
      CHECK(high[row * 16 + 15] == Approx(even[row * 16 + 15]).epsilon(0.01));
      CHECK(low[row * 16] == Approx(even[row * 16]).epsilon(0.01));
      CHECK(high[row * 16] < 0.99 * even[row * 16]);
    }
    // 90 degrees: toward row 0.
    const Frame upward = frame_at(20.0 / 1.05, 0.1, 90.0, turn, 0.0);
    for (std::size_t column = 0; column < 16; ++column) {
      CHECK(upward[column] == Approx(even[column]).epsilon(0.01));
      CHECK(upward[240 + column] < 0.99 * even[240 + column]);
    }
  }
  // Turned with its leads by a quarter counter-clockwise, the last column comes to where row 0 lay.
  CHECK(frame_at(20.0, 0.1, 90.0, MountTurn::kNone, 90.0) == frame_at(20.0, 0.1, 0.0, MountTurn::kNone, 0.0));
  CHECK(frame_at(20.0, 0.1, 90.0, MountTurn::kNone, 0.0) != frame_at(20.0, 0.1, 0.0, MountTurn::kNone, 0.0));
  CHECK(frame_at(20.0, 0.0, 33.0, MountTurn::kNone, 90.0) == frame_at(20.0, 0.0, 0.0, MountTurn::kNone, 0.0));
}

TEST_CASE("specimen: zero drift, gain drift over months and over cycles") {
  const Reading fresh = read({});
  const auto aged = [](double months, double zero_rate, double gain_rate) {
    return read(changed([&](SpecimenOptions& o) {
      o.age_months = months;
      o.effects.zero_drift_v_per_month = zero_rate;
      o.effects.gain_drift_per_month = gain_rate;
    }));
  };
  const Reading zero = aged(2.0, 0.005, 0.0);
  const Reading gain = aged(2.0, 0.0, 0.01);
  const Reading age_alone = aged(2.0, 0.0, 0.0);
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < 256; ++i) {
    REQUIRE(zero.zero[i] - fresh.zero[i] == Approx(0.010).margin(1e-12));
    REQUIRE(zero.loaded[i] - fresh.loaded[i] == Approx(0.010).margin(1e-12));
    REQUIRE(gain.zero[i] == Approx(fresh.zero[i]).margin(1e-12));
    REQUIRE(age_alone.loaded[i] == fresh.loaded[i]);
    const double change = (gain.loaded[i] - gain.zero[i]) / (fresh.loaded[i] - fresh.zero[i]) - 1.0;
    sum += change;
    squares += change * change;
  }
  CHECK(sum / 256 == Approx(0.0).margin(0.001));
  CHECK(std::sqrt(squares / 256) == Approx(0.02).epsilon(0.15));  // 1 % a month, two months; truncated

  // read() is one load to 60 psi and half of one: 1.5 cycles.
  const Reading worn = read(changed([](SpecimenOptions& o) { o.effects.gain_drift_per_thousand_cycles = -0.2; }));
  for (std::size_t i = 0; i < 256; ++i) {
    const double change = (worn.loaded[i] - worn.zero[i]) / (fresh.loaded[i] - fresh.zero[i]) - 1.0;
    REQUIRE(change == Approx(-0.2 * 1.5 / 1000.0).epsilon(1e-6));
  }
}

TEST_CASE("specimen: a new mount changes each taxel's local pressure, the first mount is the reference") {
  const auto mounted = [](std::uint64_t seed, double variation) {
    return read(changed([&](SpecimenOptions& o) {
                  o.mount_seed = seed;
                  o.effects.remount_variation = variation;
                }),
                20.0)
        .loaded;
  };
  const Frame first = read({}, 20.0).loaded;
  CHECK(mounted(0, 0.03) == first);
  CHECK(mounted(5, 0.0) == first);
  const Frame second = mounted(5, 0.03);
  const Frame third = mounted(6, 0.03);
  CHECK(mounted(5, 0.03) == second);
  Frame change(256);
  Frame other(256);
  for (std::size_t i = 0; i < 256; ++i) {
    change[i] = second[i] / first[i] - 1.0;
    other[i] = third[i] / first[i] - 1.0;
  }
  // At 20 psi the output goes about as the 0.9th power of the local pressure.
  CHECK(deviation(change) > 0.015);
  CHECK(deviation(change) < 0.05);
  CHECK(std::abs(correlation(change, other)) < 0.25);
}

}  // namespace tactbench::bench::testing
