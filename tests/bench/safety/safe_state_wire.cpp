#include "bench/safety/safe_state.h"

#include <catch2/catch.hpp>

#include "bench/safety/ramp.h"
#include "bench/simulation/plant.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using Settings = std::vector<sequences::Override>;

namespace {

// The safe state of a rig that was never loaded, after an unloaded frame that is lower by `less` counts than it is.
SafeProof proof_of(const Settings& settings, double less, bool independent = true) {
  BenchConfig config = small_request(settings).bench;
  config.reference_independent = independent;
  Rig rig(config);
  rig.open();
  UnloadedFrame baseline = unloaded_frame_of(rig.array().read(8));
  for (double& counts : baseline) counts -= less;
  return make_safe(rig, baseline);
}

}  // namespace

TEST_CASE("safe state: a silent module vents by its watchdog and is reported as unverified") {
  // bring-up, ramp and 4 s of feeding take fewer than 160 requests; then nothing answers.
  Rig rig(small_request(
              {{"simulation.wire_faults.module_silent_after_requests", "160"}, {"module.response_timeout_ms", "300"}})
              .bench);
  rig.open();
  (void)ramp_to(rig, devices::Psi(40.0));
  const auto feed = [&](int times) {
    for (int i = 0; i < times; ++i) {
      rig.clock().wait_until(rig.clock().now() + std::chrono::milliseconds(200));
      rig.source().keep_alive();
    }
  };
  feed(20);
  REQUIRE(rig.plant()->true_pressure().value() == Approx(40.0).margin(1.0));
  CHECK_THROWS_AS(feed(100), std::exception);
  CHECK(make_safe(rig, {}).state == db::SafeState::kUnverified);
  CHECK(rig.plant()->true_pressure().value() < 1.0);
}

TEST_CASE("safe state: each witness is compared with the limit, and its reading is reported") {
  const auto offset = [](const char* span) {
    return Settings{{"reference.span_psi", span}, {"limits.vent_timeout_s", "3"}};
  };
  const SafeProof sound = proof_of({}, 0.0);
  CHECK(sound.state == db::SafeState::kVerified);
  const SafeProof below = proof_of(offset("[0.7, 100]"), 0.0);  // [limits] safe_psi is 1
  CHECK(below.state == db::SafeState::kVerified);
  CHECK_THAT(below.text.in(tactbench::analysis::PressureUnit::kPsi),
             Catch::Contains("0.0 psi") && Catch::Contains("0.7 psi"));
  const SafeProof above = proof_of(offset("[1.3, 100]"), 0.0);  // the array may bear witness, and cannot outvote it
  CHECK(above.state == db::SafeState::kFailed);
  CHECK_THAT(above.text.in(tactbench::analysis::PressureUnit::kPsi),
             Catch::StartsWith("NOT SAFE") && Catch::Contains("1.3 psi"));
}

TEST_CASE("safe state: an array loaded by more than 2 % of the converter range contradicts proved pressures") {
  const SafeProof within = proof_of({}, 0.019 * 65535.0);
  CHECK(within.state == db::SafeState::kVerified);
  const SafeProof beyond = proof_of({}, 0.021 * 65535.0);
  CHECK(beyond.state == db::SafeState::kUnverified);
  CHECK(proof_of({}, -20000.0).state == db::SafeState::kVerified);  // the unloaded frame itself still relaxed
}

TEST_CASE("safe state: without an independent reference the array is the second witness") {
  const SafeProof both = proof_of({}, 0.0, false);
  CHECK(both.state == db::SafeState::kVerified);
  const SafeProof loaded = proof_of({}, 0.021 * 65535.0, false);
  CHECK(loaded.state == db::SafeState::kFailed);
  BenchConfig dependent = small_request().bench;
  dependent.reference_independent = false;
  Rig rig(dependent);
  rig.open();
  const SafeProof alone = make_safe(rig, {});  // no unloaded frame to compare with
  CHECK(alone.state == db::SafeState::kUnverified);
}

TEST_CASE("safe state: the unloaded frame is the mean of eight scans, and half of the taxels decide") {
  Rig rig(small_request().bench);
  rig.open();
  const auto proof = [&](std::size_t loaded) {
    UnloadedFrame baseline = unloaded_frame_of(rig.array().read(8));
    for (std::size_t i = 0; i < loaded; ++i) baseline[i] -= 20000.0;
    return make_safe(rig, baseline).state;
  };
  CHECK(proof(120) == db::SafeState::kVerified);
  CHECK(proof(136) == db::SafeState::kUnverified);
}
