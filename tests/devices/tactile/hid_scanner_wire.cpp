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

// Real reports of the simulated scanner, altered on their way: faults beyond its switches.
class TamperingLink final : public ReportLink {
 public:
  // Maps one decoded row to the rows that arrive.
  using Tamper = std::function<std::vector<RowReport>(const RowReport&)>;
  TamperingLink(std::unique_ptr<ReportLink> inner, Tamper tamper)
      : inner_(std::move(inner)), tamper_(std::move(tamper)) {}
  void write(std::span<const std::uint8_t> report) override { inner_->write(report); }
  std::size_t read(std::span<std::uint8_t> into, Nanoseconds timeout) override {
    for (;;) {
      if (!altered_.empty()) {
        const auto bytes = encode(altered_.front());
        altered_.pop_front();
        std::copy(bytes.begin(), bytes.end(), into.begin());
        return bytes.size();
      }
      const std::size_t size = inner_->read(into, timeout);
      const auto row = decode_row(into.first(size));
      if (!row) return size;
      for (const RowReport& report : tamper_(*row)) altered_.push_back(report);
    }
  }
  std::size_t drain() override { return inner_->drain(); }
  std::string description() const override { return inner_->description(); }

 private:
  std::unique_ptr<ReportLink> inner_;
  Tamper tamper_;
  std::deque<RowReport> altered_;
};

std::optional<Fault> fault_with(const TamperingLink::Tamper& tamper, Nanoseconds timeout = kPatient) {
  const Scanner rig({}, timeout);
  HidScanner scanner(std::make_unique<TamperingLink>(open_packet_link(rig.path), tamper), rig.options, rig.clock);
  return fault_of([&] { (void)scanner.read(1); });
}

}  // namespace

TEST_CASE("hid scanner: identity, geometry and scale come from the device") {
  const Scanner rig;
  const auto scanner = rig.open();
  CHECK(scanner.identity().serial == "SIM-42");
  CHECK(scanner.identity().firmware == "1.2");
  CHECK(scanner.identity().origin == Origin::kSimulated);
  CHECK(scanner.volts_per_count().value() == Approx(1.0e-4));
  CHECK(scanner.exchanges() == 1);
}

TEST_CASE("hid scanner: another serial or geometry is refused") {
  Scanner rig;
  rig.options.expected_serial = "SIM-41";
  const auto serial = fault_of([&] { (void)rig.open(); });
  REQUIRE(serial);
  CHECK(serial->id() == "TB-SCANNER-SERIAL");
  CHECK_THAT(serial->what(), Catch::Contains("SIM-41") && Catch::Contains("SIM-42"));
  rig.options.expected_serial = "SIM-42";
  CHECK(fault_id_of([&] { (void)rig.open(); }) == "none");
  rig.options.rows = 8;
  CHECK(fault_id_of([&] { (void)rig.open(); }) == "TB-SCANNER-GEOMETRY");
}

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

TEST_CASE("hid scanner: a single taxel is an array, too") {
  Scanner rig;
  rig.server.reset();
  rig.server =
      std::make_unique<SimulatedScanner>(rig.path, IdentityReport{0, 1, 1, 1.0F, "S", "1"}, rig.array, rig.clock);
  rig.options.rows = rig.options.columns = 1;
  const auto set = rig.open().read(3);
  REQUIRE(set.counts.size() == 3);
  for (int scan = 0; scan < 3; ++scan) check_hid_scan(set, scan, scan);
}

TEST_CASE("hid scanner: silence is a timeout and costs process time once") {
  const Scanner rig({.silent_after_scans = 2}, kShort);
  auto scanner = rig.open();
  check_hid_scan(scanner.read(2), 1, 1);
  const auto fault = fault_of([&] { (void)scanner.read(3); });
  REQUIRE(fault);
  CHECK(fault->id() == "TB-SCANNER-TIMEOUT");
  CHECK_THAT(fault->what(), Catch::Contains("400 ms") && Catch::Contains(rig.path));
  CHECK_FALSE(fault->remedy().empty());
  CHECK(rig.clock.now() == kShort);
}

TEST_CASE("hid scanner: a damaged report is refused and the next scan is whole") {
  const Scanner rig({.corrupt_scan = 1});
  auto scanner = rig.open();
  check_hid_scan(scanner.read(1), 0, 0);
  const auto fault = fault_of([&] { (void)scanner.read(1); });
  REQUIRE(fault);
  CHECK(fault->id() == "TB-SCANNER-CORRUPT");
  CHECK_THAT(fault->what(), Catch::Contains("damaged") && Catch::Contains("8, 9"));
  CHECK(rig.clock.now() == 0ns);
  check_hid_scan(scanner.read(1), 0, 2);
}

TEST_CASE("hid scanner: a missing report is named and the next scan is whole") {
  const Scanner rig({.drop_report_scan = 0});
  auto scanner = rig.open();
  const auto fault = fault_of([&] { (void)scanner.read(1); });
  REQUIRE(fault);
  CHECK(fault->id() == "TB-SCANNER-CORRUPT");
  CHECK_THAT(fault->what(), Catch::Contains("sequence 9 follows 7"));
  CHECK_THAT(fault->what(), Catch::Contains("not yet received: 8"));
  check_hid_scan(scanner.read(1), 0, 1);
}

TEST_CASE("hid scanner: an unplugged scanner is lost, and stays so") {
  const Scanner rig({.unplug_after_scans = 1});
  auto scanner = rig.open();
  check_hid_scan(scanner.read(1), 0, 0);
  for (int i = 0; i < 2; ++i) {
    const auto fault = fault_of([&] { (void)scanner.read(1); });
    REQUIRE(fault);
    CHECK(fault->id() == "TB-SCANNER-LOST");
    CHECK_THAT(fault->what(), Catch::Contains(rig.path));
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

TEST_CASE("hid scanner: rows that come twice, late, from another frame or with a wrong number") {
  const auto twice = fault_with([](const RowReport& row) {
    auto again = row;
    again.sequence = static_cast<std::uint16_t>(row.sequence + 1);
    return row.row == 5 ? std::vector{row, again} : std::vector{row};
  });
  REQUIRE(twice);
  CHECK(twice->id() == "TB-SCANNER-CORRUPT");
  CHECK_THAT(twice->what(), Catch::Contains("row 5 came twice"));

  const auto last = fault_with(
      [](const RowReport& row) { return row.row == 15 ? std::vector<RowReport>{} : std::vector{row}; }, kShort);
  REQUIRE(last);
  CHECK(last->id() == "TB-SCANNER-CORRUPT");
  CHECK_THAT(last->what(), Catch::Contains("row 15 did not come"));

  const auto frame = fault_with([](const RowReport& row) {
    auto other = row;
    other.frame += row.row == 9 ? 1U : 0U;
    return std::vector{other};
  });
  REQUIRE(frame);
  CHECK_THAT(frame->what(), Catch::Contains("row 9 belongs to frame 1"));

  const auto nowhere = fault_with([](const RowReport& row) {
    auto other = row;
    other.row = row.row == 2 ? std::uint8_t{200} : row.row;
    return std::vector{other};
  });
  REQUIRE(nowhere);
  CHECK_THAT(nowhere->what(), Catch::Contains("no row 200"));

  CHECK_FALSE(fault_with([](const RowReport& row) { return std::vector{row}; }));
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
