#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <vector>

#include "bench/simulation/chamber.h"
#include "bench/simulation/contact.h"

namespace tactbench::bench {
namespace {

devices::Volts volts_for(double psi) { return devices::Volts(psi / ChamberOptions().span_psi * 10.0); }

struct Response {
  double settled_s = 0.0;  // last time outside 0.25 psi
  double overshoot_psi = 0.0;
  double end_psi = 0.0;
};

Response respond(Chamber& chamber, double target_psi, double seconds = 5.0) {
  const double sign = target_psi >= chamber.pressure().value() ? 1.0 : -1.0;
  chamber.command(volts_for(target_psi));
  Response response;
  double furthest = -1e9;
  const int cells = static_cast<int>(std::lround(seconds * 100.0));
  for (int cell = 1; cell <= cells; ++cell) {
    chamber.advance(0.01);
    if (std::abs(chamber.pressure().value() - target_psi) > 0.25) response.settled_s = 0.01 * cell;
    furthest = std::max(furthest, sign * chamber.pressure().value());
  }
  response.end_psi = chamber.pressure().value();
  response.overshoot_psi = furthest - sign * response.end_psi;
  return response;
}

}  // namespace

TEST_CASE("chamber: a 2 psi step settles within 0.25 psi in 0.6 s with a small overshoot") {
  Chamber chamber({});
  double worst_time = 0.0;
  double worst_overshoot = 0.0;
  for (int level = 2; level <= 60; level += 2) {
    const Response up = respond(chamber, level);
    worst_time = std::max(worst_time, up.settled_s);
    worst_overshoot = std::max(worst_overshoot, up.overshoot_psi);
  }
  for (int level = 58; level >= 0; level -= 2) {
    const Response down = respond(chamber, level);
    worst_time = std::max(worst_time, down.settled_s);
    if (level > 0) worst_overshoot = std::max(worst_overshoot, down.overshoot_psi);
  }
  CHECK(worst_time < 0.6);
  CHECK(worst_time > 0.1);  // finite speed
  CHECK(worst_overshoot < 0.3);
  CHECK(worst_overshoot > 0.01);
  CHECK(chamber.pressure().value() == Approx(0.0).margin(1e-6));
}

TEST_CASE("chamber: a step over the whole range takes less than 3 s, but no less than the valve allows") {
  Chamber chamber({});
  const Response response = respond(chamber, 60.0);
  CHECK(response.settled_s < 3.0);
  CHECK(response.settled_s > 0.9);
  CHECK(response.overshoot_psi < 1.0);
}

TEST_CASE("chamber: hysteresis of the regulator separates true and reported pressure by its share of the span") {
  for (const double share : {0.0, 0.002, 0.005}) {
    ChamberOptions options;
    options.hysteresis_share = share;
    options.damping = 1.5;  // no overshoot, which would take a part back
    Chamber chamber(options);
    respond(chamber, 30.0);
    const double up = chamber.pressure().value();
    CHECK(chamber.believed().value() == Approx(30.0).margin(0.5 * options.resolution_v * options.span_psi / 10 + 1e-6));
    respond(chamber, 60.0);
    respond(chamber, 30.0);
    const double down = chamber.pressure().value();
    const double width = share * options.span_psi;
    CHECK(up - down == Approx(width).margin(1e-4));
    CHECK(chamber.believed().value() - down == Approx(0.5 * width).margin(1e-4));
  }
}

TEST_CASE("chamber: the command has the resolution of the regulator") {
  ChamberOptions options;
  options.hysteresis_share = 0.0;
  Chamber a(options);
  Chamber b(options);
  a.command(devices::Volts(2.0000));
  b.command(devices::Volts(2.0009));
  a.advance(5.0);
  b.advance(5.0);
  CHECK(a.pressure() == b.pressure());
  b.command(devices::Volts(2.0011));
  b.advance(5.0);
  CHECK(b.pressure().value() - a.pressure().value() == Approx(0.002 / 10 * options.span_psi).epsilon(1e-6));
}

TEST_CASE("chamber: the result does not depend on the division of time into steps") {
  Chamber whole({});
  Chamber pieces({});
  whole.command(volts_for(20.0));
  pieces.command(volts_for(20.0));
  whole.advance(1.0);
  for (int i = 0; i < 100; ++i) pieces.advance(0.01);
  CHECK(whole.pressure().value() == Approx(pieces.pressure().value()).margin(1e-9));
}

TEST_CASE("chamber: pressure stays between 0 and the range of the command") {
  Chamber chamber({});
  chamber.command(devices::Volts(25.0));
  chamber.advance(10.0);
  CHECK(chamber.pressure().value() < ChamberOptions().span_psi + 0.5);
  chamber.command(devices::Volts(-3.0));
  for (int i = 0; i < 1000; ++i) {
    chamber.advance(0.01);
    REQUIRE(chamber.pressure().value() >= 0.0);
    REQUIRE(chamber.believed().value() >= 0.0);
  }
  CHECK(chamber.pressure().value() == 0.0);
}

TEST_CASE("chamber: the dump valve empties it in a quarter of a second, whatever the regulator does") {
  Chamber chamber({});
  respond(chamber, 60.0);
  chamber.dump(true);  // the command stays at 60 psi
  chamber.advance(0.3);
  CHECK(chamber.pressure().value() < 1.0);
  chamber.advance(5.0);
  CHECK(chamber.pressure().value() < 1.0);
  chamber.dump(false);
  chamber.advance(5.0);
  CHECK(chamber.pressure().value() == Approx(60.0).margin(0.25));
}

}  // namespace tactbench::bench

// Chamber and contact in numbers: what another implementation of their equations
// (bench/simulation/README.md) gives, in Python, to ten digits. A deliberate change of the physics changes them.

using namespace tactbench;
using namespace tactbench::bench;

namespace {

void check_pressures(const Chamber& chamber, double truth, double believed) {
  CHECK(chamber.pressure().value() == Approx(truth).epsilon(1e-10).margin(1e-10));
  CHECK(chamber.believed().value() == Approx(believed).epsilon(1e-10).margin(1e-10));
}

void drive(Chamber& chamber, double volts, double seconds) {
  chamber.command(devices::Volts(volts));
  chamber.advance(seconds);
}

}  // namespace

TEST_CASE("chamber values: rising two ways with different time steps, and falling") {
  Chamber chamber({});
  drive(chamber, 1.5321, 0.1);
  check_pressures(chamber, 4.556228263912, 4.425694263912);
  chamber.advance(0.3);
  check_pressures(chamber, 18.833607840588, 18.703073840588);
  chamber.advance(1.0);
  check_pressures(chamber, 20.01450374867, 19.993295725329);
  drive(chamber, 1.6852, 0.0137);
  check_pressures(chamber, 20.033447260529, 20.008450534817);
  chamber.advance(0.2);
  check_pressures(chamber, 21.395026359289, 21.264492359289);
  drive(chamber, 4.0, 0.25);
  check_pressures(chamber, 35.675528540856, 35.544994540856);
  chamber.advance(0.6);
  check_pressures(chamber, 52.722881156979, 52.603158889506);
  drive(chamber, 1.0, 0.31);
  check_pressures(chamber, 34.489999398959, 34.620533398959);
  chamber.advance(2.0);
  check_pressures(chamber, 13.030946295682, 13.053305925903);
}

TEST_CASE("chamber values: other options, a leak, a shut valve, no supply, the dump valve") {
  ChamberOptions options;
  options.span_psi = 100.0;
  options.time_constant_s = 0.2;
  options.damping = 1.1;
  options.slew_psi_per_s = 25.0;
  options.resolution_v = 0.01;
  options.hysteresis_share = 0.01;
  options.leak_psi_per_s = 0.4;
  options.dump_psi_per_s = 80.0;
  Chamber chamber(options);
  drive(chamber, 3.017, 1.0);
  check_pressures(chamber, 24.153842121831, 23.653842121831);
  chamber.advance(1.5);
  check_pressures(chamber, 30.466382536939, 29.966382536939);
  chamber.set_faults({false, 0.0, 2.0});
  chamber.advance(0.4);
  check_pressures(chamber, 29.776380854519, 29.414381191003);
  chamber.set_faults({true, 0.0, 2.0});
  chamber.advance(0.3);
  check_pressures(chamber, 28.876380854519, 28.694381191003);
  chamber.set_faults({false, 3.0, 2.0});
  drive(chamber, 6.0, 0.5);
  check_pressures(chamber, 25.501380854519, 25.994381191003);
  chamber.set_faults({});
  chamber.advance(0.2);
  check_pressures(chamber, 30.947754766668, 30.447754766668);
  chamber.dump(true);
  chamber.advance(0.1);
  check_pressures(chamber, 24.407754766668, 24.907754766668);
  chamber.advance(0.4);
  check_pressures(chamber, 2.247754766668, 2.747754766668);
  chamber.dump(false);
  drive(chamber, 0.5, 3.0);
  check_pressures(chamber, 4.843207477916, 4.824116935667);
}

TEST_CASE("chamber values: an overshoot up, one down, and one delayed two seconds by a leak") {
  ChamberOptions options;
  options.hysteresis_share = 0.0;
  Chamber chamber(options);
  drive(chamber, 2.0, 2.0);
  chamber.overshoot(1.5);
  chamber.command(devices::Volts(2.2));
  const auto walk = [&](double seconds, const std::vector<double>& expected) {
    for (const double psi : expected) {
      chamber.advance(seconds);
      CHECK(chamber.pressure().value() == Approx(psi).epsilon(0.0).margin(2e-9));
    }
  };
  walk(0.1, {27.063804727, 28.522046822, 29.571083186, 30.103207284, 29.898219816, 29.395290707, 28.998383891,
             28.78096094, 28.695954365, 28.680199768, 28.689836749, 28.702969921});
  chamber.overshoot(-2.0);
  walk(0.1, {28.246555914, 27.541626924, 27.03279315, 27.003552134, 27.615852201, 28.203333536, 28.562254581,
             28.721605145, 28.764802203, 28.759084637, 28.741786172, 28.727760002});
  chamber.set_faults({false, 0.0, 30.0});
  chamber.overshoot(5.0);
  walk(0.55, {28.287553463, 28.31890887, 28.317421349, 25.419885843});
}

TEST_CASE("contact values: approach, hold, reversal, retreat, rest, and approach again") {
  const Contact contact({}, 16, 16);
  ContactState state;
  const std::vector<std::array<double, 3>> way = {
      {29.99, 0.1, 0.0},           {30.02, 0.0, 0.413696},       {30.3, 0.5, 7.110535714089},
      {30.3, 2.0, 6.97631896684},  {30.31, 1.0, 7.213119413314}, {30.295, 0.3, 7.042048845584},
      {30.1, 0.2, 2.002142513279}, {30.1, 10.0, 2.100277930334}, {29.9, 0.5, 0.0},
      {29.9, 60.0, 0.0},           {30.2, 0.1, 4.565587204971}};
  for (const auto& [z_mm, seconds, force_n] : way) {
    INFO("z " << z_mm);
    contact.advance(state, z_mm, seconds);
    CHECK(state.force_n == Approx(force_n).epsilon(0.0).margin(2e-11));
  }
  CHECK(state.relaxed_n[0] == Approx(0.28376926586088036).epsilon(1e-10));
  CHECK(state.relaxed_n[1] == Approx(0.06332390178245806).epsilon(1e-10));
  CHECK(state.friction == 1.0);
  CHECK_FALSE(contact.quiet(state));
  contact.advance(state, 30.0, 1000.0);
  CHECK_FALSE(contact.quiet(state));  // the backlash keeps the tip below the surface
  contact.advance(state, 29.99, 1000.0);
  CHECK(contact.quiet(state));
  CHECK_FALSE(contact.quiet({}));
}

TEST_CASE("contact values: pressure on each taxel of a rotated ring and of a point") {
  ContactOptions ring;
  ring.outer_diameter_mm = 6.0;
  ring.inner_diameter_mm = 3.0;
  ring.fabric_spread_mm = 0.8;
  ring.pitch_mm = 2.0;
  ring.centre_x_mm = 20.0;
  ring.centre_y_mm = 25.0;
  ring.misplaced_x_mm = 0.5;
  ring.misplaced_y_mm = -0.3;
  ring.misplaced_deg = 15.0;
  Contact askew(ring, 4, 5);
  const std::vector<double> on_ring = {0.0002497597, 0.0346221197, 0.2542012575, 0.2421525219, 0.0292163515,
                                       0.0229576539, 1.0634606122, 3.2578762068, 3.1980204913, 0.9477568551,
                                       0.1270256983, 2.8592721755, 2.5798424062, 2.7395032349, 2.6656385146,
                                       0.0852807941, 2.3490125104, 3.4782048846, 3.5467779469, 2.1596460861};
  const auto& found = askew.psi_per_newton(21.0, 26.5);
  REQUIRE(found.size() == on_ring.size());
  for (std::size_t i = 0; i < found.size(); ++i) CHECK(found[i] == Approx(on_ring[i]).epsilon(0.0).margin(2e-10));
  ContactOptions point;
  point.object = Footprint::kPoint;
  point.fabric_spread_mm = 0.7;
  point.pitch_mm = 1.5;
  Contact tip(point, 3, 3);
  const std::vector<double> on_point = {1.8407580335,  10.5933797958, 6.3453717692, 3.6951017569, 20.1617811745,
                                        12.2378590914, 0.6976063532,  4.3191971657, 2.5264425592};
  const auto& felt = tip.psi_per_newton(30.4, 29.7);
  for (std::size_t i = 0; i < felt.size(); ++i) CHECK(felt[i] == Approx(on_point[i]).epsilon(0.0).margin(2e-10));
  CHECK(tip.psi_per_newton(30.4, 29.7)[4] == felt[4]);
  CHECK(tip.psi_per_newton(30.4, 30.0)[4] != Approx(20.1617811745));
  ContactOptions flat;
  flat.object = Footprint::kFlat;
  flat.pitch_mm = 2.0;
  Contact plate(flat, 2, 3);
  for (const double psi : plate.psi_per_newton(1.0, 2.0)) CHECK(psi == Approx(145.038 / 24.0));
  ring.inner_diameter_mm = ring.outer_diameter_mm;
  CHECK_THROWS_AS(Contact(ring, 4, 5), std::invalid_argument);
  for (double ContactOptions::*size : {&ContactOptions::fabric_spread_mm, &ContactOptions::pitch_mm}) {
    ContactOptions none;
    none.*size = 0.0;
    CHECK_THROWS_AS(Contact(none, 4, 5), std::invalid_argument);
  }
}

namespace tactbench::bench {
namespace {

constexpr double kPsiPerNewtonPerMm2 = 145.038;
constexpr double kArea = 2.54 * 2.54;

// Stays so short that nothing relaxes.
double press(const Contact& contact, ContactState& state, double z_mm, double seconds = 0.0) {
  contact.advance(state, z_mm, seconds);
  return state.force_n;
}

// Approaches from the air and goes to `depth` in steps.
ContactState pressed(const Contact& contact, double depth) {
  ContactState state;
  const double surface = contact.options().surface_z_mm;
  press(contact, state, surface - 1.0);
  for (int i = 0; i <= 100; ++i) press(contact, state, surface + depth * i / 100.0);
  return state;
}

double sum(const std::vector<double>& values) { return std::accumulate(values.begin(), values.end(), 0.0); }

struct Centroid {
  double row = 0.0, column = 0.0;
};

Centroid centroid(const std::vector<double>& psi) {
  Centroid at;
  for (std::size_t i = 0; i < psi.size(); ++i) {
    at.row += psi[i] * static_cast<double>(i / 16);
    at.column += psi[i] * static_cast<double>(i % 16);
  }
  return {at.row / sum(psi), at.column / sum(psi)};
}

}  // namespace

TEST_CASE("contact: no force in the air, then a force that stiffens with depth") {
  ContactOptions options;
  const Contact contact(options, 16, 16);
  ContactState state;
  CHECK(press(contact, state, 29.999) == 0.0);
  CHECK(contact.quiet(state));
  for (const double depth : {0.1, 0.5, 1.0}) {
    const double elastic = options.stiffness_n_per_mm * depth + options.stiffening_n_per_mm2 * depth * depth;
    CHECK(pressed(contact, depth).force_n == Approx(elastic * (1.0 + options.friction_share)).epsilon(1e-9));
  }
  CHECK(pressed(contact, 1.0).force_n > 2.2 * pressed(contact, 0.5).force_n);
  CHECK_FALSE(contact.quiet(pressed(contact, 0.1)));
}

TEST_CASE("contact: the taxel pressures times their area sum to the force, for every object on the array") {
  for (const Footprint object : {Footprint::kRing, Footprint::kPoint, Footprint::kFlat}) {
    for (const double x : {30.0, 31.1, 35.7}) {
      ContactOptions options;
      options.object = object;
      options.misplaced_deg = 17.0;
      options.misplaced_y_mm = -0.8;
      Contact contact(options, 16, 16);
      CHECK(sum(contact.psi_per_newton(x, 29.0)) * kArea / kPsiPerNewtonPerMm2 == Approx(1.0).epsilon(2e-3));
    }
  }
  Contact ring({}, 16, 16);  // half of it beyond the edge
  CHECK(sum(ring.psi_per_newton(30.0 + 8 * 2.54, 30.0)) * kArea / kPsiPerNewtonPerMm2 == Approx(0.5).margin(0.01));
  CHECK(sum(ring.psi_per_newton(0.0, 0.0)) == Approx(0.0).margin(1e-12));
}

TEST_CASE("contact: the ring has a hole on the array, 30 N give 30 to 60 psi on the ring and 0 psi in the hole") {
  Contact contact({}, 16, 16);
  const auto psi = contact.psi_per_newton(30.0, 30.0);
  const double peak = 30.0 * *std::max_element(psi.begin(), psi.end());
  CHECK(peak > 30.0);
  CHECK(peak < 60.0);
  CHECK(30.0 * psi[7 * 16 + 7] < 0.5);  // the hole
  CHECK(30.0 * psi[0] < 1e-6);
  for (int i = 0; i < 16; ++i) {  // the same in all four directions
    const auto at = [&](int row, int column) { return psi[static_cast<std::size_t>(row * 16 + column)]; };
    CHECK(at(7, i) == Approx(at(8, 15 - i)).margin(1e-9));
    CHECK(at(i, 7) == Approx(at(7, i)).margin(1e-9));
  }
  const auto loaded = std::count_if(psi.begin(), psi.end(), [](double each) { return 30.0 * each > 3.0; });
  CHECK(loaded > 16);
  CHECK(loaded < 60);
}

TEST_CASE("contact: a held position loses 6 % of its force with two time constants, a pause in the air restores it") {
  ContactOptions options;
  const Contact contact(options, 16, 16);
  ContactState state = pressed(contact, 1.0);
  const double first = state.force_n;
  const double elastic = first / (1.0 + options.friction_share);
  contact.advance(state, 31.0, options.relaxation_s);
  const double lost = 0.03 * (1.0 - std::exp(-1.0)) + 0.03 * (1.0 - std::exp(-0.1));
  CHECK(first - state.force_n == Approx(lost * elastic).epsilon(1e-6));
  contact.advance(state, 31.0, 1000.0);
  CHECK(first - state.force_n == Approx(0.06 * elastic).epsilon(1e-6));
  ContactState pieces = pressed(contact, 1.0);  // cut as one likes
  for (int i = 0; i < 150; ++i) contact.advance(pieces, 31.0, options.relaxation_s / 150);
  CHECK(first - pieces.force_n == Approx(lost * elastic).epsilon(1e-6));
  contact.advance(state, 25.0, 1.0);
  CHECK(state.force_n == 0.0);
  CHECK_FALSE(contact.quiet(state));
  contact.advance(state, 25.0, 1000.0);
  CHECK(contact.quiet(state));
}

TEST_CASE("contact: z reverses by the backlash before anything changes") {
  ContactOptions options;
  const Contact contact(options, 16, 16);
  ContactState state = pressed(contact, 1.0);
  const double first = state.force_n;
  CHECK(press(contact, state, 31.0 - 0.9 * options.backlash_mm) == first);
  CHECK(press(contact, state, 31.0) == first);
  CHECK(press(contact, state, 31.0 - 3.0 * options.backlash_mm) < first - 0.5);
  const double back = state.force_n;
  CHECK(press(contact, state, 31.0 - 2.5 * options.backlash_mm) == back);  // the other way it has play again
  CHECK(press(contact, state, 31.0) > back);
}

TEST_CASE("contact: force is lower on unloading, and falls as the depth decreases") {
  ContactOptions options;
  options.backlash_mm = 0.0;
  const Contact contact(options, 16, 16);
  ContactState state = pressed(contact, 1.0);
  double last = state.force_n;
  for (int i = 1; i <= 99; ++i) {
    const double depth = 1.0 - 0.01 * i;
    const double force = press(contact, state, 30.0 + depth);
    CHECK(force < last);
    if (i > 10) CHECK(force == Approx(pressed(contact, depth).force_n * (1 - 0.04) / (1 + 0.04)).epsilon(1e-6));
    last = force;
  }
}

TEST_CASE("contact: a misplaced sensor moves the object on it") {
  ContactOptions options;
  options.object = Footprint::kPoint;
  options.misplaced_x_mm = 2.54;
  Contact shifted(options, 16, 16);
  Centroid at = centroid(shifted.psi_per_newton(30.0, 30.0));
  CHECK(at.column == Approx(6.5).margin(1e-3));
  CHECK(at.row == Approx(7.5).margin(1e-3));
  options.misplaced_x_mm = 0.0;
  options.misplaced_deg = 90.0;  // its columns now grow along y, its rows against x
  Contact turned(options, 16, 16);
  at = centroid(turned.psi_per_newton(30.0 + 2.54, 30.0 + 2 * 2.54));
  CHECK(at.column == Approx(7.5 + 2.0).margin(1e-3));
  CHECK(at.row == Approx(7.5 - 1.0).margin(1e-3));
}

}  // namespace tactbench::bench
