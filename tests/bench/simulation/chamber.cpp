#include "bench/simulation/chamber.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

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

TEST_CASE("chamber: a jump over the whole range takes less than 3 s, no faster than the valve") {
  Chamber chamber({});
  const Response response = respond(chamber, 60.0);
  CHECK(response.settled_s < 3.0);
  CHECK(response.settled_s > 0.9);
  CHECK(response.overshoot_psi < 1.0);
}

TEST_CASE("chamber: the regulator's hysteresis separates true and reported pressure by its share of the span") {
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

TEST_CASE("chamber: the command has the regulator's resolution") {
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

TEST_CASE("chamber: the result does not depend on how time is divided into inner steps") {
  Chamber whole({});
  Chamber pieces({});
  whole.command(volts_for(20.0));
  pieces.command(volts_for(20.0));
  whole.advance(1.0);
  for (int i = 0; i < 100; ++i) pieces.advance(0.01);
  CHECK(whole.pressure().value() == Approx(pieces.pressure().value()).margin(1e-9));
}

TEST_CASE("chamber: no vacuum and no more than the command's range") {
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

TEST_CASE("chamber: the dump valve empties it in a quarter of a second whatever the regulator does") {
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
