#include "bench/simulation/contact.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

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

TEST_CASE("contact: the taxels' pressures times their area are the force, for every object on the array") {
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

TEST_CASE("contact: the ring is a ring on the array, 30 N bring 30 to 60 psi on it and none in its hole") {
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

TEST_CASE("contact: a held position loses 6 % of its force with two time constants, a pause in the air heals it") {
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

TEST_CASE("contact: z turns back by the backlash before anything changes") {
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

TEST_CASE("contact: the fabric gives back less than it took, and the force rises with depth on each way") {
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

TEST_CASE("contact: a sensor put down askew moves the object on it") {
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
