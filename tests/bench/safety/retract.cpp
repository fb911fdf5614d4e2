// The retraction on an ideal stage: what proves it and what does not, to the last micrometre and millinewton.
#include "bench/safety/retract.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/bench/run/press/ideal_press.h"

using namespace tactbench;
using namespace tactbench::tests;
using bench::RetractProof;
using std::chrono::milliseconds;

namespace {

struct Retreat {
  explicit Retreat(double z_mm, double force_n = 0.0) : bed([=](double) { return force_n; }) {
    bed.stage.put(devices::Axis::kZ, z_mm);
  }
  RetractProof go(const std::function<void(devices::Nanoseconds)>& wait = {}, bool sensor = true) {
    return bench::retract(bed.stage, sensor ? &bed.force : nullptr, bed.clock, {10.0, 2.0, 0.5, 37}, wait);
  }
  IdealBed bed;
};

}  // namespace

TEST_CASE("retract on an ideal stage: halts, arms, moves to clear at its speed, settles, reads the force") {
  Retreat high(13.0, 0.2);
  const RetractProof proof = high.go();
  CHECK(proof.verified);
  CHECK(proof.halted);
  CHECK(proof.z_mm == 10.0);
  CHECK(proof.force_n == 0.2);
  CHECK_THAT(proof.text, Catch::Contains("10.000 mm") && Catch::Contains("0.20 N"));
  CHECK(high.bed.stage.sent_mm == std::vector<double>{10.0});
  CHECK(high.bed.stage.speeds == std::vector<double>{2.0});
  CHECK(high.bed.stage.halts == 1);
  CHECK(high.bed.stage.arms == 1);
  CHECK(high.bed.clock.now() == milliseconds(1500 + 100));  // 3 mm at 2 mm/s, and the settling
  REQUIRE(high.bed.force.reads.size() == 1);
  CHECK(high.bed.force.reads[0].records == 37);
}

TEST_CASE("retract on an ideal stage: z at clear does not move, arrival has a tolerance of one micrometre") {
  for (const double z_mm : {0.0, 10.0, 10.001}) {
    Retreat there(z_mm);
    CHECK(there.go().verified);
    CHECK(there.bed.stage.sent_mm.empty());
    CHECK(there.bed.clock.now() == milliseconds(100));
  }
  Retreat beyond(std::nextafter(10.001, 11.0));
  CHECK(beyond.go().verified);
  CHECK(beyond.bed.stage.sent_mm.size() == 1);
}

TEST_CASE("retract on an ideal stage: the force must be below the safe limit in both directions, and finite") {
  const auto at = [](double force_n) {
    const RetractProof proof = Retreat(12.0, force_n).go();
    CHECK(proof.z_mm == (std::abs(force_n) < 0.5 ? 10.0 : 0.0));  // pressed at clear: goes home
    if (!proof.verified) CHECK_THAT(proof.text, Catch::StartsWith("NOT SAFE"));
    return proof.verified;
  };
  CHECK(at(std::nextafter(0.5, 0.0)));
  CHECK_FALSE(at(0.5));
  CHECK_FALSE(at(-0.5));
  CHECK_FALSE(at(-3.0));
  CHECK(at(-0.49));
  CHECK_FALSE(at(std::numeric_limits<double>::quiet_NaN()));
}

TEST_CASE("retract on an ideal stage: a stage that does not arm and a silent force sensor are tried twice") {
  Retreat once(12.0);
  once.bed.stage.refuses_arms = 1;
  CHECK(once.go().verified);
  CHECK(once.bed.stage.halts == 2);
  Retreat never(12.0);
  never.bed.stage.refuses_arms = 5;
  const RetractProof proof = never.go();
  CHECK_FALSE(proof.verified);
  CHECK_FALSE(proof.z_mm);
  CHECK(never.bed.stage.arms == 2);
  CHECK_THAT(proof.text, Catch::Contains("0.00 N") && Catch::Contains("does not arm"));
  Retreat mute(12.0);
  mute.bed.force.failures = 1;
  CHECK(mute.go().verified);
  mute.bed.force.failures = 2;
  const RetractProof silent = mute.go();
  CHECK_FALSE(silent.verified);
  CHECK_FALSE(silent.force_n);
  CHECK(silent.z_mm == 10.0);
  CHECK_THAT(silent.text, Catch::Contains("10.000 mm") && Catch::Contains("no record"));
  const RetractProof blind = Retreat(12.0).go({}, false);
  CHECK_FALSE(blind.verified);
  CHECK(blind.z_mm == 10.0);
  CHECK_FALSE(blind.force_n);
  Retreat disobeys(12.0);
  disobeys.bed.stage.obeys = false;
  CHECK_FALSE(disobeys.go().halted);
}

TEST_CASE("retract on an ideal stage: z without a home position is homed, whatever the clear position is") {
  Retreat lost(12.0);
  lost.bed.stage.homed = false;
  const RetractProof proof = lost.go();
  CHECK(proof.verified);
  CHECK(proof.z_mm == 0.0);
  CHECK(lost.bed.stage.homed_order == std::vector<devices::Axis>{devices::Axis::kZ});
  CHECK(lost.bed.stage.sent_mm.empty());
}

TEST_CASE("retract on an ideal stage: if the object still presses at clear, z goes home") {
  for (const auto& [z_mm, surface_mm] :
       {std::pair(6.0, 5.0), std::pair(10.0, 5.0), std::pair(13.0, 5.0), std::pair(10.0, 9.8), std::pair(13.0, 9.8)}) {
    Retreat tall(z_mm);
    tall.bed.force.law = [top = surface_mm](double at_mm) { return 20.0 * std::max(0.0, at_mm - top); };
    const RetractProof proof = tall.go();
    REQUIRE(proof.verified);
    CHECK(proof.z_mm == 0.0);
    CHECK(proof.force_n == 0.0);
    CHECK(tall.bed.stage.sent_mm.back() == 0.0);
  }
}

TEST_CASE("retract on an ideal stage: waits in slices of 100 ms, and uses the clock if the wait throws") {
  std::vector<devices::Nanoseconds> asked;
  Retreat fed(10.5);  // 250 ms
  CHECK(fed.go([&](devices::Nanoseconds time) { asked.push_back(time); }).verified);
  CHECK(asked ==
        std::vector<devices::Nanoseconds>{milliseconds(100), milliseconds(200), milliseconds(250), milliseconds(350)});
  Retreat thrown(10.5);
  CHECK(thrown.go([](devices::Nanoseconds) { throw std::runtime_error("stop"); }).verified);
  CHECK(thrown.bed.clock.now() == milliseconds(350));
}
