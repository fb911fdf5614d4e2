// The HID scanner's driver over real hidapi, hidraw and the kernel's HID core, against a scanner made with uhid.
#include <pthread.h>
#include <signal.h>

#include <algorithm>
#include <memory>

#include "devices/tactile/hid_scanner.h"
#include "devices/wire/report_link.h"
#include "tests/vm/guest.h"
#include "tests/vm/uhid_scanner.h"

using namespace tactbench::devices;
using namespace tactbench::tests;
using namespace std::chrono_literals;
using Catch::Contains;
using Report = UhidScanner::Report;

namespace {

constexpr const char* kSerial = "VM-42";
constexpr std::size_t kKernelRing = 63;  // unread reports that hidraw keeps; newer ones are lost
const HidAddress kAddress{UhidScanner::kVendor, UhidScanner::kProduct, kSerial};

bool listed() {
  const auto list = list_hid_devices();
  return std::any_of(list.begin(), list.end(), [](const HidInfo& info) {
    return info.vendor_id == kAddress.vendor_id && info.product_id == kAddress.product_id &&
           info.serial == kAddress.serial;
  });
}

std::unique_ptr<UhidScanner> plug_in() {
  auto device = std::make_unique<UhidScanner>(kSerial);
  REQUIRE(within_ten_seconds(listed));
  return device;
}

void check_scan(const ScanSet& set, long scan) {
  REQUIRE(set.counts.size() == 256);
  REQUIRE(set.frame_counters == std::vector<std::uint32_t>{static_cast<std::uint32_t>(scan)});
  for (std::size_t i = 0; i < set.counts.size(); ++i) {
    if (set.counts[i] != UhidScanner::sample(scan, i)) FAIL("scan " << scan << " taxel " << i << ": " << set.counts[i]);
  }
}

// The rows of a frame that nobody asked for, as good as real ones in all but their samples.
void send_unasked(UhidScanner& device, std::uint16_t tag, int reports) {
  for (int i = 0; i < reports; ++i) {
    RowReport row{static_cast<std::uint16_t>(i), 0xDEAD, tag, static_cast<std::uint8_t>(i % 16), 0, 0, {}};
    row.samples.fill(0xBEEF);
    device.send(encode(row));
  }
}

struct Rig {
  [[nodiscard]] HidScanner open() { return HidScanner(open_hid_link(kAddress), options, clock); }
  SteadyClock clock;
  HidScannerOptions options;
  std::unique_ptr<UhidScanner> device = plug_in();
};

// Unplugs while the reader waits: it was given time to go to sleep in poll().
void unplug_soon(UhidScanner& device, std::vector<Report>& reports) {
  reports.clear();
  std::this_thread::sleep_for(100ms);
  device.unplug();
}

}  // namespace

TEST_CASE("hid scanner in VM: an absent scanner is a fault that names it and those present") {
  const auto fault = fault_of([] { (void)open_hid_link(kAddress); });
  CHECK(fault.id() == "TB-HID-OPEN");
  CHECK_THAT(fault.what(), Contains("5443:0016 serial 'VM-42'") && Contains("present: none"));
  const Rig rig;
  const auto other = fault_of([] { (void)open_hid_link({kAddress.vendor_id, kAddress.product_id, "VM-41"}); });
  CHECK(other.id() == "TB-HID-OPEN");
  CHECK_THAT(other.what(), Contains("present: 5443:0016 serial 'VM-42' tactbench test scanner"));
}

TEST_CASE("hid scanner in VM: identity and 200 frames are read correctly") {
  Rig rig;
  auto scanner = rig.open();
  CHECK(scanner.identity().serial == kSerial);
  CHECK(scanner.identity().firmware == "1.2");
  CHECK(scanner.volts_per_count().value() == Approx(1.0e-4));
  const auto begin = now();
  for (long scan = 0; scan < 200; ++scan) check_scan(scanner.read(1), scan);
  figure("vm_hid_frame_of_16_reports", milliseconds(now() - begin) / 200, "ms");

  const auto link = open_hid_link(kAddress);
  const auto one_by_one = now();
  for (std::uint16_t tag = 0; tag < 200; ++tag) {
    link->write(encode(CommandReport{ScanCommand::kIdentify, tag}));
    Report report{};
    REQUIRE(link->read(report, 5s) == report.size());
    REQUIRE(decode_identity(report)->tag == tag);
  }
  figure("vm_hid_exchange_of_one_report", milliseconds(now() - one_by_one) / 200, "ms");
}

TEST_CASE("hid scanner in VM: an overflowed report queue is drained before a scan is requested") {
  Rig rig;
  const auto link = open_hid_link(kAddress);
  send_unasked(*rig.device, 1, 200);
  CHECK(link->drain() == kKernelRing);
  auto scanner = rig.open();
  check_scan(scanner.read(1), 0);
  // These carry the tag that the next scan will have.
  send_unasked(*rig.device, static_cast<std::uint16_t>(scanner.exchanges() + 1), 200);
  check_scan(scanner.read(1), 1);
}

TEST_CASE("hid scanner in VM: a missing and a damaged report are detected, and the next scan is whole") {
  Rig rig;
  auto scanner = rig.open();
  rig.device->at_next_scan([](UhidScanner&, auto& reports) { reports.erase(reports.begin() + 8); });
  const auto gap = fault_of([&] { (void)scanner.read(1); });
  CHECK(gap.id() == "TB-SCANNER-CORRUPT");
  CHECK_THAT(gap.what(), Contains("sequence 9 follows 7") && Contains("not yet received: 8"));
  check_scan(scanner.read(1), 1);
  rig.device->at_next_scan([](UhidScanner&, auto& reports) { reports[8][20] ^= 0x10U; });
  const auto damage = fault_of([&] { (void)scanner.read(1); });
  CHECK(damage.id() == "TB-SCANNER-CORRUPT");
  CHECK_THAT(damage.what(), Contains("damaged") && Contains("8, 9"));
  check_scan(scanner.read(1), 3);
}

TEST_CASE("hid scanner in VM: a signal does not end a reading") {
  Rig rig;
  auto scanner = rig.open();
  static volatile sig_atomic_t signals = 0;
  struct sigaction action {};
  action.sa_handler = [](int) { signals = signals + 1; };  // no SA_RESTART
  REQUIRE(sigaction(SIGUSR1, &action, nullptr) == 0);
  rig.device->at_next_scan([reader = pthread_self()](UhidScanner&, auto&) {
    for (int i = 0; i < 3; ++i) {
      std::this_thread::sleep_for(20ms);
      pthread_kill(reader, SIGUSR1);
    }
    std::this_thread::sleep_for(20ms);
  });
  check_scan(scanner.read(1), 0);
  CHECK(signals == 3);
}

TEST_CASE("hid scanner in VM: unplugging ends a blocking read within a second, and the link stays lost") {
  Rig rig;
  const auto link = open_hid_link(kAddress);
  rig.device->at_next_scan(unplug_soon);
  link->write(encode(CommandReport{ScanCommand::kScan, 7}));
  Report report{};
  const auto fault = fault_of([&] { (void)link->read(report, 20s); });
  const auto took = now() - rig.device->unplugged_at();
  figure("vm_hid_unplug_to_fault", milliseconds(took), "ms");
  CHECK(took < 1s);
  CHECK(fault.id() == "TB-HID-LOST");
  CHECK_THAT(fault.what(), Contains("5443:0016") && Contains("disconnected"));
  CHECK(fault_of([&] { (void)link->read(report, 20s); }).id() == "TB-HID-LOST");
  CHECK(fault_of([&] { link->write(encode(CommandReport{ScanCommand::kScan, 8})); }).id() == "TB-HID-WRITE");
}

TEST_CASE("hid scanner in VM: a scanner unplugged during a scan is lost, and is read again once it is back") {
  Rig rig;
  rig.options.frame_timeout = 20s;
  auto scanner = rig.open();
  check_scan(scanner.read(1), 0);
  rig.device->at_next_scan(unplug_soon);
  const auto fault = fault_of([&] { (void)scanner.read(1); });
  const auto took = now() - rig.device->unplugged_at();
  figure("vm_hid_unplug_to_fault_of_scanner", milliseconds(took), "ms");
  CHECK(took < 1s);
  CHECK(fault.id() == "TB-SCANNER-LOST");
  CHECK(within_ten_seconds([] { return !listed(); }));
  CHECK(fault_of([&] { (void)rig.open(); }).id() == "TB-HID-OPEN");

  const auto begin = now();
  rig.device = plug_in();
  auto again = rig.open();
  figure("vm_hid_plug_in_to_identity", milliseconds(now() - begin), "ms");
  CHECK(fault_of([&] { (void)scanner.read(1); }).id() == "TB-SCANNER-LOST");  // the old link stays dead
  for (long scan = 0; scan < 20; ++scan) check_scan(again.read(1), scan);
}
