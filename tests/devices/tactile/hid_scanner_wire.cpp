#include "devices/tactile/hid_scanner.h"

#include <catch2/catch.hpp>

#include "devices/tactile/simulated_scanner.h"
#include "devices/wire/report_link.h"
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
  mutable ManualClock clock;
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

TEST_CASE("hid scanner: sequence numbers and tags wrap without effect") {
  const Scanner rig;
  auto scanner = rig.open();
  for (int scan = 0; scan < 4100; ++scan) check_hid_scan(scanner.read(1), 0, scan);  // 65600 reports
}

TEST_CASE("hid scanner: a damaged report is refused and the next scan is whole") {
  const Scanner rig({.corrupt_scan = 1});
  auto scanner = rig.open();
  check_hid_scan(scanner.read(1), 0, 0);
  CHECK(fault_id_of([&] { (void)scanner.read(1); }) == "TB-SCANNER-CORRUPT");
  CHECK(rig.clock.now() == 0ns);
  check_hid_scan(scanner.read(1), 0, 2);
}

TEST_CASE("hid scanner: old reports in the queue are not used") {
  const Scanner rig;
  auto link = open_packet_link(rig.path);
  ReportLink& wire = *link;
  HidScanner scanner(std::move(link), rig.options, rig.clock);
  wire.write(encode(CommandReport{ScanCommand::kScan, 999}));
  Report report(kScanReportBytes);
  REQUIRE(wire.read(report, kPatient) == kScanReportBytes);  // the scan has come; its other rows wait
  check_hid_scan(scanner.read(1), 0, 1);
}

TEST_CASE("simulated scanner: damaged commands are not answered, and the next client is served") {
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
