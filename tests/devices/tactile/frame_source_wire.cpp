#include <catch2/catch.hpp>

#include "devices/tactile/frame_source.h"
#include "devices/tactile/simulated_frame_source.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

namespace protocol = tactbench::devices::frame_protocol;
using namespace tactbench::devices;
using namespace std::chrono_literals;

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

  mutable ManualClock clock;
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

TEST_CASE("frame source: supports arrays of any shape up to 256 x 256") {
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

TEST_CASE("frame source: frames read by another client appear as a jump of the counter") {
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

TEST_CASE("frame source: each scan fault has its id, and the next scan succeeds, on a new connection if need be") {
  const struct {
    SimulatedFrameSourceFaults faults;
    std::string id;
    bool lives;
    int next;
  } cases[] = {{{.double_scan = 0}, "none", true, 2},  // used once
               {{.drop_scan = 1}, "TB-SCANNER-TIMEOUT", true, 2},
               {{.repeat_scan = 1}, "TB-SCANNER-CORRUPT", true, 1},  // under a new tag
               {{.corrupt_scan = 1}, "TB-SCANNER-CORRUPT", false, 2},
               {{.cut_scan = 1}, "TB-SCANNER-LOST", false, 2}};
  for (const auto& [faults, id, lives, next] : cases) {
    const FrameSourceRig rig(faults, id == "TB-SCANNER-TIMEOUT" ? kShort : kPatient);
    auto source = rig.open();
    check_frame_scan(source.read(1), 0, 0);
    for (int i = 0; i < (lives ? 1 : 2); ++i) CHECK(fault_id_of([&] { (void)source.read(1); }) == id);
    auto again = rig.open();
    const ScanSet after = (lives ? source : again).read(1);
    check_frame_scan(after, 0, next);
    CHECK(after.frame_counters == std::vector<std::uint32_t>{static_cast<std::uint32_t>(next)});
  }
}

TEST_CASE("frame source: a port without a listener or an invalid address is a lost-scanner fault") {
  FrameSourceRig rig;
  rig.server.reset();
  CHECK(fault_id_of([&] { (void)rig.open(); }) == "TB-SCANNER-LOST");
  rig.options.address = "tcp:nowhere";
  CHECK(fault_id_of([&] { (void)rig.open(); }) == "TB-SCANNER-LOST");
  rig.options.address = "unix:no/such/socket";
  CHECK(fault_id_of([&] { (void)rig.open(); }) == "TB-SCANNER-LOST");
}

TEST_CASE("simulated frame source: a port in use is a fault") {
  const FrameSourceRig rig;
  TestArray array;
  CHECK(fault_id_of([&] {
          SimulatedFrameSource({.description = kDescription, .port = rig.server->port()}, array, rig.clock);
        }) == "TB-SIM-LISTEN");
}
