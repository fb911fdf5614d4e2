#include "bench/safety/safe_state.h"

#include <catch2/catch.hpp>

#include "bench/safety/ramp.h"
#include "bench/simulation/plant.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;

namespace {

// Raises the chamber to 40 psi and feeds it there.
void load(Rig& rig) {
  rig.open();
  (void)ramp_to(rig, devices::Psi(40.0));
  for (int i = 0; i < 20; ++i) {
    rig.clock().wait_until(rig.clock().now() + std::chrono::milliseconds(200));
    rig.source().keep_alive();
  }
  REQUIRE(rig.plant()->true_pressure().value() == Approx(40.0).margin(1.0));
}

}  // namespace

TEST_CASE("safe state: two witnesses prove it on a healthy rig") {
  Rig rig(small_request().bench);
  load(rig);
  const SafeProof proof = make_safe(rig, {});
  CHECK(proof.state == db::SafeState::kVerified);
  CHECK(rig.plant()->true_pressure().value() < 1.0);
  CHECK(make_safe(rig, {}).state == db::SafeState::kVerified);  // callable twice
}

TEST_CASE("safe state: a silent module vents by its watchdog and is reported as unverified") {
  // bring-up, ramp and 4 s of feeding take fewer than 160 requests; then nothing answers.
  const BenchConfig config = small_request({{"simulation.wire_faults.module_silent_after_requests", "160"},
                                            {"module.response_timeout_ms", "50"}})
                                 .bench;
  Rig rig(config);
  load(rig);
  try {
    for (int i = 0; i < 100; ++i) {
      rig.clock().wait_until(rig.clock().now() + std::chrono::milliseconds(200));
      rig.source().keep_alive();
    }
    FAIL("the module never went silent");
  } catch (const std::exception&) {
  }
  const SafeProof proof = make_safe(rig, {});
  CHECK(proof.state == db::SafeState::kUnverified);
  CHECK(rig.plant()->true_pressure().value() < 1.0);
  CHECK_THAT(proof.text, Catch::Contains("watchdog"));
}

TEST_CASE("safe state: remaining pressure is reported as failed, not safe") {
  // A reference that reads 5 psi too much at zero never shows an empty chamber.
  const BenchConfig config = small_request({{"reference.span_psi", "[5, 100]"}, {"limits.vent_timeout_s", "3"}}).bench;
  Rig rig(config);
  load(rig);
  const SafeProof proof = make_safe(rig, {});
  CHECK(proof.state == db::SafeState::kFailed);
}
