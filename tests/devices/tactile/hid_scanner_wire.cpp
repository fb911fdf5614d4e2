#include "devices/tactile/hid_scanner.h"

#include <catch2/catch.hpp>

#include <deque>
#include <functional>

#include "devices/tactile/simulated_scanner.h"
#include "devices/wire/packet_link.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

struct Scanner {
  explicit Scanner(SimulatedScannerFaults faults = {}, Nanoseconds timeout = kPatient) {
    options.frame_timeout = timeout;
    options.origin = Origin::kSimulated;
    server = std::make_unique<SimulatedScanner>(path, IdentityReport{0, 16, 16, 1.0e-4F, "SIM-42", "1.2"}, array, clock,
                                                faults);
  }
  [[nodiscard]] HidScanner open() const { return HidScanner(open_packet_link(path), options, clock); }

  TemporaryFolder folder;
  std::string path = folder.path("scanner.sock");
  mutable TurnedClock clock;
  TestArray array;
  HidScannerOptions options;
  std::unique_ptr<SimulatedScanner> server;
};

void check_hid_scan(const ScanSet& set, int index, int scan) {
  const std::size_t taxels = static_cast<std::size_t>(set.rows) * static_cast<std::size_t>(set.columns);
  for (std::size_t i = 0; i < taxels; ++i) {
    const auto got = set.counts[static_cast<std::size_t>(index) * taxels + i];
    if (got != TestArray::sample(scan, i)) FAIL("scan " << index << " taxel " << i << ": " << got);
  }
}

using Report = std::vector<std::uint8_t>;

}  // namespace

TEST_CASE("hid scanner: K scans in order, with counters, status and times") {
  const Scanner rig;
  auto scanner = rig.open();
  rig.clock.wait_until(5s);
  const auto set = scanner.read(3);
  REQUIRE(set.counts.size() == 3 * 256);
  for (int i = 0; i < 3; ++i) check_hid_scan(set, i, i);
  CHECK(set.frame_counters == std::vector<std::uint32_t>{0, 1, 2});
  CHECK(set.status == kStatusNotSettled);
  CHECK(set.time == 5s);
  CHECK(set.device_time_us == 5'000'000);
  CHECK(scanner.exchanges() == 4);
  CHECK(rig.clock.now() == 5s);
}

TEST_CASE("hid scanner: sequence numbers and tags wrap without effect") {
  const Scanner rig;
  auto scanner = rig.open();
  for (int scan = 0; scan < 4100; ++scan) check_hid_scan(scanner.read(1), 0, scan);  // 65600 reports
}

TEST_CASE("hid scanner: an array smaller than a report") {
  Scanner rig;
  rig.server.reset();
  rig.server =
      std::make_unique<SimulatedScanner>(rig.path, IdentityReport{0, 4, 5, 1.0F, "S", "1"}, rig.array, rig.clock);
  rig.options.rows = 4;
  rig.options.columns = 5;
  auto scanner = rig.open();
  const auto set = scanner.read(2);
  REQUIRE(set.counts.size() == 40);
  check_hid_scan(set, 0, 0);
  check_hid_scan(set, 1, 1);
}

TEST_CASE("hid scanner: a damaged report is refused and the next scan is whole") {
  const Scanner rig({.corrupt_scan = 1});
  auto scanner = rig.open();
  check_hid_scan(scanner.read(1), 0, 0);
  CHECK(fault_id_of([&] { (void)scanner.read(1); }) == "TB-SCANNER-CORRUPT");
  CHECK(rig.clock.now() == 0ns);
  check_hid_scan(scanner.read(1), 0, 2);
}

TEST_CASE("hid scanner: a missing report is named and the next scan is whole") {
  const Scanner rig({.drop_report_scan = 0});
  auto scanner = rig.open();
  check_fault([&] { (void)scanner.read(1); }, "TB-SCANNER-CORRUPT", {}, "8");
  check_hid_scan(scanner.read(1), 0, 1);
}

TEST_CASE("hid scanner: an unplugged scanner is lost, and stays so") {
  const Scanner rig({.unplug_after_scans = 1});
  auto scanner = rig.open();
  check_hid_scan(scanner.read(1), 0, 0);
  for (int i = 0; i < 2; ++i) {
    CHECK(fault_id_of([&] { (void)scanner.read(1); }) == "TB-SCANNER-LOST");
  }
  CHECK(fault_id_of([&] { (void)rig.open(); }) == "TB-HID-OPEN");
}

TEST_CASE("hid scanner: reports that waited in the queue are not used") {
  const Scanner rig;
  auto link = open_packet_link(rig.path);
  ReportLink& wire = *link;
  HidScanner scanner(std::move(link), rig.options, rig.clock);
  wire.write(encode(CommandReport{ScanCommand::kScan, 999}));
  Report report(kScanReportBytes);
  REQUIRE(wire.read(report, kPatient) == kScanReportBytes);  // the scan has come; its other rows wait
  check_hid_scan(scanner.read(1), 0, 1);
}

TEST_CASE("hid scanner: damaged reports in the queue are discarded with it") {
  Scanner rig({.corrupt_scan = 0});
  auto link = open_packet_link(rig.path);
  ReportLink& wire = *link;
  HidScanner scanner(std::move(link), rig.options, rig.clock);
  wire.write(encode(CommandReport{ScanCommand::kScan, 998}));
  wire.write(encode(CommandReport{ScanCommand::kScan, 999}));
  while (rig.array.scans < 2) rig.array.scans.wait(rig.array.scans);  // the second begins when the first is all sent
  check_hid_scan(scanner.read(1), 0, 2);
}

TEST_CASE("hid scanner: answers to an older command that come after the drain are ignored") {
  const Scanner rig;
  auto link = open_packet_link(rig.path);
  ReportLink& wire = *link;
  HidScanner scanner(std::move(link), rig.options, rig.clock);
  for (int i = 0; i < 20; ++i) {
    wire.write(encode(CommandReport{ScanCommand::kScan, 999}));
    check_hid_scan(scanner.read(1), 0, 2 * i + 1);
  }
}

TEST_CASE("simulated scanner: damaged commands are not answered, the next client is served") {
  const Scanner rig;
  {
    const auto link = open_packet_link(rig.path);
    auto command = encode(CommandReport{ScanCommand::kScan, 1});
    command[2] ^= 1U;
    link->write(command);
    link->write(std::vector<std::uint8_t>{0x02});
    link->write(encode(CommandReport{ScanCommand::kIdentify, 5}));
    Report report(kScanReportBytes);
    REQUIRE(link->read(report, kPatient) == kScanReportBytes);
    CHECK(decode_identity(report)->tag == 5);  // the first answer of all
  }
  auto scanner = rig.open();
  check_hid_scan(scanner.read(1), 0, 0);
}
