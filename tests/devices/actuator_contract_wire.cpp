// The laws of every actuator (devices/device.h), tested on each driver in the table of actuator_contract.h against its
// simulated end over a real wire.
#include <catch2/catch.hpp>
#include <chrono>
#include <optional>
#include <thread>

#include "tests/devices/actuator_contract.h"
#include "tests/devices/fault_of.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

constexpr BedOptions kShortBed{300ms, 2s};

// Runs `law` on a bed of each actuator of the table.
template <class Law>
void for_each_actuator(Law&& law, const BedOptions& options = {}) {
  REQUIRE_FALSE(actuators_under_law().empty());
  for (const ActuatorUnderLaw& one : actuators_under_law()) {
    INFO(one.name);
    const std::unique_ptr<ActuatorBed> bed = one.make(options);
    law(*bed);
  }
}

void check_not_armed(ActuatorBed& bed) {
  CHECK_FALSE(bed.actuator().armed());
  const std::uint64_t before = bed.received();
  for (const Act& command : bed.commands()) CHECK(fault_id_of(command) == bed.faults_begin_with() + "-NOT-ARMED");
  CHECK(bed.received() == before);
}

void check_made_safe(ActuatorBed& bed) {
  CHECK(bed.make_safe());
  CHECK(bed.is_in_safe_state());
}

}  // namespace

TEST_CASE("actuator contract: refuses each command before arming and after disarming, and sends nothing") {
  for_each_actuator([](ActuatorBed& bed) {
    check_not_armed(bed);
    CHECK(bed.received() == 0);
    bed.make_ready();
    CHECK(bed.actuator().armed());
    bed.load();
    bed.actuator().disarm();
    check_not_armed(bed);
  });
}

TEST_CASE("actuator contract: arming does not drive the output") {
  for_each_actuator([](ActuatorBed& bed) {
    bed.actuator().arm();
    CHECK(bed.received() > 0);
    CHECK(bed.driven() == 0);
    CHECK(bed.is_in_safe_state());
    bed.make_ready();
    const std::uint64_t before = bed.driven();
    bed.load();
    CHECK(bed.driven() > before);
    CHECK_FALSE(bed.is_in_safe_state());
  });
}

TEST_CASE("actuator contract: refuses a value out of range or NaN before anything is sent, and stays armed") {
  for_each_actuator([](ActuatorBed& bed) {
    bed.make_ready();
    const std::uint64_t before = bed.received();
    REQUIRE(bed.forbidden().size() >= 4);
    for (const Act& command : bed.forbidden()) {
      const std::optional<Fault> fault = fault_of(command);
      REQUIRE(fault);
      CHECK(fault->id() == bed.faults_begin_with() + "-LIMIT");
    }
    CHECK(bed.received() == before);
    CHECK(bed.actuator().armed());
  });
}

TEST_CASE(
    "actuator contract: can be made safe from any state, armed or not, under load, twice, and after reconnection") {
  for_each_actuator([](ActuatorBed& bed) {
    check_made_safe(bed);  // never armed
    bed.make_ready();
    check_made_safe(bed);  // armed, nothing commanded
    bed.make_ready();
    bed.load();
    REQUIRE_FALSE(bed.is_in_safe_state());
    check_made_safe(bed);
    check_made_safe(bed);
    bed.make_ready();
    bed.load();
    bed.actuator().disarm();
    REQUIRE_FALSE(bed.is_in_safe_state());
    check_made_safe(bed);
    bed.make_ready();
    bed.load();
    bed.break_wire();
    CHECK_FALSE(bed.make_safe());  // false when it cannot
    bed.mend_wire();
    check_made_safe(bed);
  });
}

TEST_CASE("actuator contract: another thread than the one that armed can make it safe") {
  for_each_actuator(
      [](ActuatorBed& bed) {
        bed.make_ready();
        bed.load();
        REQUIRE_FALSE(bed.is_in_safe_state());
        // The clock stands still meanwhile: that the actuator has come to rest may not be known yet.
        std::thread([&] { (void)bed.make_safe(); }).join();
        bed.clock().wait_until(bed.clock().now() + 500ms);
        CHECK(bed.is_in_safe_state());
        check_made_safe(bed);
      },
      {20s, 100ms});
}

TEST_CASE("actuator contract: a silent connection is a timeout fault after the reply timeouts, and disarms") {
  for_each_actuator(
      [](ActuatorBed& bed) {
        bed.make_ready();
        bed.load();
        bed.fall_silent();
        const Nanoseconds before = bed.clock().now();
        const std::string id = fault_id_of([&] { bed.load(); });
        CHECK(id.ends_with("-TIMEOUT"));
        // Process time has advanced by the time waited, and no more.
        CHECK(bed.clock().now() - before == bed.questions() * kShortBed.reply_timeout);
        check_not_armed(bed);
        CHECK(fault_id_of([&] { bed.actuator().arm(); }) != "none");
        check_not_armed(bed);
      },
      kShortBed);
}

TEST_CASE("actuator contract: with a silent connection, making safe ends in bounded time and returns false") {
  for_each_actuator(
      [](ActuatorBed& bed) {
        bed.make_ready();
        bed.load();
        bed.fall_silent();
        const Nanoseconds before = bed.clock().now();
        const auto start = std::chrono::steady_clock::now();
        CHECK_FALSE(bed.make_safe());
        const Nanoseconds longest = bed.questions_to_make_safe() * kShortBed.reply_timeout + kShortBed.safe_timeout;
        CHECK(bed.clock().now() - before <= longest);
        CHECK(std::chrono::steady_clock::now() - start < 5 * longest);
      },
      kShortBed);
}

TEST_CASE("actuator contract: a broken connection is a fault, disarms, and its restoration resends no command") {
  for_each_actuator([](ActuatorBed& bed) {
    bed.make_ready();
    bed.load();
    bed.break_wire();
    const Nanoseconds before = bed.clock().now();
    CHECK(fault_id_of([&] { bed.load(); }) != "none");
    CHECK(bed.clock().now() == before);  // it is not waited for
    check_not_armed(bed);
    CHECK(fault_id_of([&] { bed.actuator().arm(); }) != "none");
    check_not_armed(bed);
    bed.mend_wire();
    const std::uint64_t driven = bed.driven();
    check_not_armed(bed);
    bed.actuator().arm();
    CHECK(bed.driven() == driven);
    bed.load();
    CHECK(bed.driven() > driven);
    check_made_safe(bed);
  });
}
