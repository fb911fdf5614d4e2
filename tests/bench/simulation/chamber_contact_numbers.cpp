// Chamber and contact in numbers: what another implementation of their equations
// (bench/simulation/README.md) gives, in Python, to ten digits. A deliberate change of the physics changes them.
#include <catch2/catch.hpp>
#include <stdexcept>

#include "bench/simulation/chamber.h"
#include "bench/simulation/contact.h"

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

TEST_CASE("chamber numbers: rising in two ways, with time divided differently, and falling") {
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

TEST_CASE("chamber numbers: other options, a leak, a shut valve, no supply, the dump valve") {
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
  chamber.set_trouble({false, 0.0, 2.0});
  chamber.advance(0.4);
  check_pressures(chamber, 29.776380854519, 29.414381191003);
  chamber.set_trouble({true, 0.0, 2.0});
  chamber.advance(0.3);
  check_pressures(chamber, 28.876380854519, 28.694381191003);
  chamber.set_trouble({false, 3.0, 2.0});
  drive(chamber, 6.0, 0.5);
  check_pressures(chamber, 25.501380854519, 25.994381191003);
  chamber.set_trouble({});
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

TEST_CASE("chamber numbers: an overshoot up, one down, and one that a leak keeps from its level for two seconds") {
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
  chamber.set_trouble({false, 0.0, 30.0});
  chamber.overshoot(5.0);
  walk(0.55, {28.287553463, 28.31890887, 28.317421349, 25.419885843});
}

TEST_CASE("contact numbers: approach, hold, turn, retreat, rest, and approach again") {
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

TEST_CASE("contact numbers: what a ring put down askew and a point press on each taxel") {
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
