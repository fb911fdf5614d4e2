#include "devices/tactile/frame_source.h"

#include <catch2/catch.hpp>

#include "devices/tactile/simulated_frame_source.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
namespace protocol = tactbench::devices::frame_protocol;

namespace {

const protocol::Description kDescription = {1, 16, 16, 1e-4, "Laboratory scanner", "SIM-42", "1.2"};

struct FrameSourceRig {
  explicit FrameSourceRig(SimulatedFrameSourceFaults faults = {}, Nanoseconds timeout = kPatient,
                          const protocol::Description& description = kDescription)
      : server(std::make_unique<SimulatedFrameSource>(
            SimulatedFrameSourceOptions{.description = description, .faults = faults}, array, clock)) {
    options.address = "tcp:127.0.0.1:" + std::to_string(server->port());
    options.frame_timeout = timeout;
    options.origin = Origin::kSimulated;
  }
  [[nodiscard]] FrameSource open() const { return FrameSource(options, clock); }

  mutable TurnedClock clock;
  TestArray array;
  FrameSourceOptions options;
  std::unique_ptr<SimulatedFrameSource> server;
};

void check_frame_scan(const ScanSet& set, int index, int scan) {
  const std::size_t taxels = static_cast<std::size_t>(set.rows) * static_cast<std::size_t>(set.columns);
  for (std::size_t i = 0; i < taxels; ++i) {
    const auto got = set.counts[static_cast<std::size_t>(index) * taxels + i];
    if (got != TestArray::sample(scan, i)) FAIL("scan " << index << " taxel " << i << ": " << got);
  }
}

}  // namespace

TEST_CASE("frame source: K scans in order, with counters, status and times") {
  const FrameSourceRig rig;
  auto source = rig.open();
  rig.clock.wait_until(5s);
  const auto set = source.read(3);
  REQUIRE(set.counts.size() == 3 * 256);
  for (int i = 0; i < 3; ++i) check_frame_scan(set, i, i);
  CHECK(set.frame_counters == std::vector<std::uint32_t>{0, 1, 2});
  CHECK(set.status == kStatusNotSettled);
  CHECK(set.time == 5s);
  CHECK(set.device_time_us == 5'000'000);
  CHECK(source.exchanges() == 4);
  CHECK(rig.clock.now() == 5s);
}

TEST_CASE("frame source: arrays of any shape up to 256 x 256") {
  for (const auto& [rows, columns] : {std::pair{1, 1}, {3, 200}, {256, 256}}) {
    auto description = kDescription;
    description.rows = static_cast<std::uint16_t>(rows);
    description.columns = static_cast<std::uint16_t>(columns);
    FrameSourceRig rig({}, kPatient, description);
    rig.options.rows = rows;
    rig.options.columns = columns;
    auto source = rig.open();
    const auto set = source.read(2);
    check_frame_scan(set, 0, 0);
    check_frame_scan(set, 1, 1);
  }
}

TEST_CASE("frame source: frames taken by another client show as a jump of the counter") {
  const FrameSourceRig rig;
  auto source = rig.open();
  auto other = rig.open();
  (void)other.read(5);
  const ScanSet first = source.read(1);
  check_frame_scan(first, 0, 5);
  (void)other.read(3);
  const ScanSet second = source.read(1);
  check_frame_scan(second, 0, 9);
  CHECK(second.frame_counters.front() - first.frame_counters.front() == 4);
}

TEST_CASE("frame source: a dropped frame is a timeout, then the counter shows it") {
  const FrameSourceRig rig({.drop_scan = 1}, kShort);
  auto source = rig.open();
  (void)source.read(1);
  CHECK(fault_id_of([&] { (void)source.read(1); }) == "TB-SCANNER-TIMEOUT");
  const ScanSet late = source.read(1);
  check_frame_scan(late, 0, 2);
  CHECK(late.frame_counters == std::vector<std::uint32_t>{2});
}

TEST_CASE("frame source: damage ends the connection for good, a new one is whole") {
  const FrameSourceRig rig({.corrupt_scan = 1});
  auto source = rig.open();
  (void)source.read(1);
  for (int i = 0; i < 2; ++i) {
    CHECK(fault_id_of([&] { (void)source.read(1); }) == "TB-SCANNER-CORRUPT");
  }
  auto again = rig.open();
  check_frame_scan(again.read(1), 0, 2);
}

TEST_CASE("frame source: a frame that comes twice under a new tag is refused") {
  const FrameSourceRig rig({.repeat_scan = 1});
  auto source = rig.open();
  (void)source.read(1);
  CHECK(fault_id_of([&] { (void)source.read(1); }) == "TB-SCANNER-CORRUPT");
  check_frame_scan(source.read(1), 0, 1);
}

TEST_CASE("frame source: an answer sent twice is used once") {
  const FrameSourceRig rig({.double_scan = 0});
  auto source = rig.open();
  const auto set = source.read(3);
  for (int i = 0; i < 3; ++i) check_frame_scan(set, i, i);
}

TEST_CASE("frame source: a connection closed in mid-frame is lost, and stays so") {
  const FrameSourceRig rig({.cut_scan = 1});
  auto source = rig.open();
  (void)source.read(1);
  for (int i = 0; i < 2; ++i) CHECK(fault_id_of([&] { (void)source.read(1); }) == "TB-SCANNER-LOST");
  auto again = rig.open();
  check_frame_scan(again.read(1), 0, 2);
}

TEST_CASE("frame source: a port without a listener") {
  FrameSourceRig rig;
  rig.server.reset();
  CHECK(fault_id_of([&] { (void)rig.open(); }) == "TB-SCANNER-LOST");
  rig.options.address = "tcp:nowhere";
  CHECK(fault_id_of([&] { (void)rig.open(); }) == "TB-SCANNER-LOST");
  rig.options.address = "unix:no/such/socket";
  CHECK(fault_id_of([&] { (void)rig.open(); }) == "TB-SCANNER-LOST");
}

TEST_CASE("simulated frame source: a port in use, an invalid rate") {
  const FrameSourceRig rig;
  TestArray array;
  CHECK(fault_id_of([&] {
          SimulatedFrameSource({.description = kDescription, .port = rig.server->port()}, array, rig.clock);
        }) == "TB-SIM-LISTEN");
  CHECK(fault_id_of([&] {
          SimulatedFrameSource({.description = kDescription, .free_running_hz = 0.0}, array, rig.clock);
        }) == "TB-SIM-LISTEN");
}
