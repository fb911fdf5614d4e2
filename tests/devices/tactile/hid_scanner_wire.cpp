#include "devices/tactile/hid_scanner.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <functional>
#include <thread>

#include "devices/tactile/simulated_scanner.h"
#include "devices/wire/report_link.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/packet_listener.h"
#include "tests/devices/tactile/frame_client.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace std::chrono_literals;
using namespace tactbench::devices;
using RawReport = std::vector<std::uint8_t>;

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

using Report = std::vector<std::uint8_t>;

}  // namespace

TEST_CASE("hid scanner: sequence numbers and tags wrap without effect") {
  const Scanner rig;
  auto scanner = rig.open();
  for (int scan = 0; scan < 4100; ++scan) check_scan(scanner.read(1), 0, scan);  // 65600 reports
}

TEST_CASE("hid scanner: a damaged report is refused and the next scan is whole") {
  const Scanner rig({.corrupt_scan = 1});
  auto scanner = rig.open();
  check_scan(scanner.read(1), 0, 0);
  CHECK(fault_id_of([&] { (void)scanner.read(1); }) == "TB-SCANNER-CORRUPT");
  CHECK(rig.clock.now() == 0ns);
  check_scan(scanner.read(1), 0, 2);
}

TEST_CASE("hid scanner: old reports in the queue are not used") {
  const Scanner rig;
  auto link = open_packet_link(rig.path);
  ReportLink& wire = *link;
  HidScanner scanner(std::move(link), rig.options, rig.clock);
  wire.write(encode(CommandReport{ScanCommand::kScan, 999}));
  Report report(kScanReportBytes);
  REQUIRE(wire.read(report, kPatient) == kScanReportBytes);  // the scan has come; its other rows wait
  check_scan(scanner.read(1), 0, 1);
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
  check_scan(scanner.read(1), 0, 0);
}

// The simulated scanner by its reports: each field, each of its faults, and clients that read late or leave.

namespace {

struct ScannerSim {
  explicit ScannerSim(SimulatedScannerFaults faults = {}, int rows = 5, int columns = 3)
      : server(path, {0, static_cast<std::uint8_t>(rows), static_cast<std::uint8_t>(columns), 0.25F, "S1", "F1"}, array,
               clock, std::move(faults)) {}
  [[nodiscard]] std::unique_ptr<ReportLink> open() const { return open_packet_link(path); }
  TemporaryFolder folder;
  std::string path = folder.path("scanner.sock");
  ManualClock clock;
  CountedArray array;
  SimulatedScanner server;
};

void send_command(ReportLink& link, ScanCommand command, std::uint16_t tag) {
  link.write(encode(CommandReport{command, tag}));
}

RawReport next_report(ReportLink& link) {
  RawReport report(kScanReportBytes + 1);
  report.resize(link.read(report, kPatient));
  return report;
}

// The next report answers the identity: nothing else was on its way.
void expect_identity(ReportLink& link) {
  send_command(link, ScanCommand::kIdentify, 4242);
  const auto identity = decode_identity(next_report(link));
  REQUIRE(identity);
  CHECK(*identity == IdentityReport{4242, 5, 3, 0.25F, "S1", "F1"});
}

// The reports of scan number `scan` of 5 x 3 taxels, the first with this sequence number.
RowReport row_of(int scan, int row, std::uint16_t tag, int sequence, std::uint32_t frame, std::uint32_t time) {
  RowReport report{static_cast<std::uint16_t>(sequence + row), frame, tag, static_cast<std::uint8_t>(row),
                   static_cast<std::uint8_t>(16 * scan + row), time,  {}};
  for (int column = 0; column < 3; ++column)
    report.samples[static_cast<std::size_t>(column)] = static_cast<std::uint16_t>(100 * scan + 3 * row + column);
  return report;
}

}  // namespace

TEST_CASE("simulated scanner: every field of every row has its expected value, scan after scan") {
  ScannerSim sim;
  const auto link = sim.open();
  expect_identity(*link);
  sim.clock.wait_until(70us);
  for (int scan = 0; scan < 3; ++scan) {
    const auto tag = static_cast<std::uint16_t>(7 + 1000 * scan);
    send_command(*link, ScanCommand::kScan, tag);
    for (int row = 0; row < 5; ++row) {
      const auto report = decode_row(next_report(*link));
      REQUIRE(report);
      CHECK(*report == row_of(scan, row, tag, 5 * scan, static_cast<std::uint32_t>(scan), scan < 2 ? 70 : 71));
    }
    if (scan == 1) sim.clock.wait_until(71'999ns);  // whole microseconds are told
  }
  expect_identity(*link);
}

TEST_CASE("simulated scanner: a scan that the array fails to measure is not answered, and the next one is") {
  ScannerSim sim;
  sim.array.broken_scan = 0;
  const auto link = sim.open();
  send_command(*link, ScanCommand::kScan, 1);
  expect_identity(*link);
  send_command(*link, ScanCommand::kScan, 2);
  for (int row = 0; row < 5; ++row) CHECK(decode_row(next_report(*link)) == row_of(1, row, 2, 0, 0, 0));
}

TEST_CASE("simulated scanner: a damaged or missing row is the middle row of its scan, by number or injected") {
  using Faults = SimulatedScannerFaults;
  const auto check = [](const Faults& faults, int rows, int middle, bool missing) {
    ScannerSim sim(faults, rows);
    const auto link = sim.open();
    for (int scan = 0; scan < 3; ++scan) {
      send_command(*link, ScanCommand::kScan, 1);
      for (int row = 0; row < rows; ++row) {
        const bool wrong = scan == 1 && row == middle;
        if (wrong && missing) continue;
        RawReport report = next_report(*link);
        REQUIRE(report.size() == kScanReportBytes);
        if (wrong) {
          CHECK_FALSE(decode_row(report));
          report[20] ^= 0x10U;
        }
        CHECK(decode_row(report) == row_of(scan, row, 1, rows * scan, static_cast<std::uint32_t>(scan), 0));
      }
    }
  };
  for (const auto& [rows, middle] : {std::pair{5, 2}, {4, 2}, {1, 0}}) {
    check({.corrupt_scan = 1}, rows, middle, false);
    check({.inject = fault_at(1, InjectedFault::kCorrupt)}, rows, middle, false);
    check({.drop_report_scan = 1}, rows, middle, true);
    check({.inject = fault_at(1, InjectedFault::kTorn)}, rows, middle, true);
  }
}

TEST_CASE("simulated scanner: is silent from the set scan on, the first included, and still reports its identity") {
  for (const int silent : {0, 1}) {
    ScannerSim sim({.silent_after_scans = silent});
    const auto link = sim.open();
    for (int scan = 0; scan < 3; ++scan) {
      send_command(*link, ScanCommand::kScan, 1);
      for (int row = 0; row < 5 && scan < silent; ++row)
        CHECK(decode_row(next_report(*link)) == row_of(0, row, 1, 0, 0, 0));
    }
    expect_identity(*link);
    CHECK(sim.array.scans == silent);
  }
}

TEST_CASE("simulated scanner: is unplugged after the set number of scans, 0 included") {
  for (const int scans : {0, 2}) {
    ScannerSim sim({.unplug_after_scans = scans});
    const auto link = sim.open();
    for (int scan = 0; scan < scans; ++scan) {
      send_command(*link, ScanCommand::kScan, 1);
      for (int row = 0; row < 5; ++row) CHECK(decode_row(next_report(*link)).value().row == row);
    }
    send_command(*link, ScanCommand::kIdentify, 1);
    CHECK(fault_id_of([&] { (void)next_report(*link); }) == "TB-HID-LOST");
    CHECK_FALSE(std::filesystem::exists(sim.path));
    CHECK(fault_id_of([&] { (void)sim.open(); }) == "TB-HID-OPEN");
  }
}

TEST_CASE("simulated scanner: injected silence, an old scan and a broken connection each affect one command only") {
  const auto scanned = [](ReportLink& link, int scan, int sequence, std::uint32_t frame) {
    send_command(link, ScanCommand::kScan, 9);
    for (int row = 0; row < 5; ++row) CHECK(decode_row(next_report(link)) == row_of(scan, row, 9, sequence, frame, 0));
  };
  {
    ScannerSim sim({.inject = fault_at(1, InjectedFault::kSilent)});
    const auto link = sim.open();
    scanned(*link, 0, 0, 0);
    send_command(*link, ScanCommand::kScan, 9);
    scanned(*link, 1, 5, 1);
    CHECK(sim.array.scans == 2);
  }
  {
    ScannerSim sim({.inject = fault_at(1, InjectedFault::kStale)});
    const auto link = sim.open();
    scanned(*link, 0, 0, 0);
    scanned(*link, 0, 5, 1);  // the same values in a new frame
    scanned(*link, 1, 10, 2);
  }
  ScannerSim sim({.inject = fault_at(1, InjectedFault::kUnplugged)});
  const auto link = sim.open();
  scanned(*link, 0, 0, 0);
  send_command(*link, ScanCommand::kScan, 9);
  CHECK(fault_id_of([&] { (void)next_report(*link); }) == "TB-HID-LOST");
  const auto again = sim.open();  // it is there again
  scanned(*again, 1, 5, 1);
}

TEST_CASE("simulated scanner: serves one client at a time, and the next one after it disconnects") {
  ScannerSim sim;
  auto first = sim.open();
  const auto second = sim.open();
  send_command(*second, ScanCommand::kIdentify, 8);
  expect_identity(*first);
  expect_identity(*first);
  RawReport none(kScanReportBytes);
  CHECK(second->read(none, 0ns) == 0);
  first.reset();
  CHECK(decode_identity(next_report(*second)).value().tag == 8);
}

TEST_CASE("simulated scanner: a client that does not read loses the newest whole reports and stays connected") {
  ScannerSim sim;
  const auto link = sim.open();
  int sent = 0;
  for (; sent < 400; ++sent) {
    send_command(*link, ScanCommand::kScan, static_cast<std::uint16_t>(sent));
    while (sim.array.scans <= sent) std::this_thread::yield();
  }
  send_command(*link, ScanCommand::kIdentify, 76);  // this answer is lost, too
  send_command(*link, ScanCommand::kScan, 0);
  while (sim.array.scans <= sent) std::this_thread::yield();
  int came = 0;
  for (RawReport report(kScanReportBytes); link->read(report, 0ns) > 0; ++came) {
    const auto row = decode_row(report);
    REQUIRE(row);
    if (row->sequence != came) break;
  }
  CHECK((came > 10 && came < 5 * 400));
  send_command(*link, ScanCommand::kIdentify, 77);  // rows of the last scan may still come before its answer
  auto identity = decode_identity(next_report(*link));
  for (int late = 0; late < 10 && !identity; ++late) identity = decode_identity(next_report(*link));
  REQUIRE(identity);
  CHECK(identity->tag == 77);
}

TEST_CASE("simulated scanner: refuses more columns than a report holds and paths longer than an address holds") {
  ManualClock clock;
  CountedArray array;
  const TemporaryFolder folder;
  const auto fault_with = [&](const std::string& path, int columns) {
    return fault_id_of([&] {
      SimulatedScanner(path, {0, 1, static_cast<std::uint8_t>(columns), 1.0F, "S", "1"}, array, clock);
    });
  };
  const std::string path = folder.path("s.sock");
  CHECK(fault_with(path, 16) == "none");
  CHECK(fault_with(path, 17) == "TB-SIM-LISTEN");
  const std::string longest = folder.path("") + std::string(107 - folder.path("").size(), 'x');
  CHECK(fault_with(longest, 16) == "none");
  for (const std::string& none : {longest + "x", std::string(), folder.path("no/such")})
    CHECK(fault_with(none, 16) == "TB-SIM-LISTEN");
  CHECK_THROWS_AS(SimulatedScanner(path, {0, 1, 1, 1.0F, std::string(17, 's'), "1"}, array, clock),
                  std::invalid_argument);
}

TEST_CASE("simulated scanner: replaces a socket left by a dead program, and refuses one in use") {
  ManualClock clock;
  TestArray array;
  const IdentityReport identity{0, 16, 16, 1.0F, "S", "1"};
  const TemporaryFolder folder;
  const auto path = folder.path("scanner.sock");
  ::close(bound_at(path, SOCK_SEQPACKET));
  {
    const SimulatedScanner scanner(path, identity, array, clock);
    CHECK(fault_id_of([&] { SimulatedScanner(path, identity, array, clock); }) == "TB-SIM-LISTEN");
    CHECK(fault_id_of([&] { (void)HidScanner(open_packet_link(path), {}, clock); }) == "none");
  }
  CHECK_FALSE(std::filesystem::exists(path));
}

TEST_CASE("simulated scanner: five more clients may wait while one is served") {
  ManualClock clock;
  TestArray array;
  const TemporaryFolder folder;
  const auto path = folder.path("scanner.sock");
  const SimulatedScanner scanner(path, {0, 16, 16, 1.0F, "S", "1"}, array, clock);
  const HidScanner served(open_packet_link(path), {}, clock);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), address.sun_path);
  std::vector<int> waiting;
  for (int i = 0; i < 8; ++i) {
    const int socket = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0);
    waiting.push_back(socket);
    CHECK((::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) == (i < 5));
  }
  for (const int socket : waiting) ::close(socket);
}

TEST_CASE("hid link: an absent device is a fault that names it") {
  check_fault([] { (void)open_hid_link({0xFFF7, 0xFFF3, "NOBODY"}); }, "TB-HID-OPEN", {}, "fff7:fff3");
}
