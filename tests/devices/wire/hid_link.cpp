// HID devices over a hidapi of the tests' own (fake_hidapi.h): what is asked of it, and what each of its failures is
// told as.
#include "devices/wire/report_link.h"

#include <array>
#include <catch2/catch.hpp>
#include <cerrno>

#include "tests/devices/fault_of.h"
#include "tests/devices/wire/fake_hidapi.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

struct HidBench {
  HidBench() {
    hid = FakeHid{};
    hid.devices = {{0x1234, 0xABCD, L"S1", L"scanner", "/dev/hidraw0"}, {0x00FF, 0x0001, {}, {}, {}}};
  }
  [[nodiscard]] std::unique_ptr<ReportLink> open() const { return open_hid_link({0x1234, 0xABCD, "S1"}); }
  FakeHid& hid = fake_hid();
};

constexpr const char* kHidName = "HID device 1234:abcd serial 'S1'";

}  // namespace

TEST_CASE("HID devices: the list has what the library reports of each, in ASCII") {
  HidBench bench;
  bench.hid.devices.push_back({1, 2, L"S\u00E4ge\x7F\x80", L"", "/p"});
  const auto list = list_hid_devices();
  REQUIRE(list.size() == 3);
  CHECK(list[0].vendor_id == 0x1234);
  CHECK(list[0].product_id == 0xABCD);
  CHECK(list[0].serial == "S1");
  CHECK(list[0].product == "scanner");
  CHECK(list[0].path == "/dev/hidraw0");
  CHECK(list[1].vendor_id == 0x00FF);
  CHECK(list[1].product_id == 0x0001);
  CHECK(list[1].serial.empty());
  CHECK(list[1].product.empty());
  CHECK(list[1].path.empty());
  CHECK(list[2].serial == "S?ge\x7F?");
  CHECK(bench.hid.lists == 0);
}

TEST_CASE("HID link: opens a device by its ids, and by its serial number if one is given") {
  HidBench bench;
  {
    const auto one = bench.open();
    CHECK(one->description() == kHidName);
    const auto other = open_hid_link({0x00FF, 0x0001, ""});
    CHECK(other->description() == "HID device 00ff:0001");
    CHECK(bench.hid.opened == 2);
  }
  CHECK(bench.hid.opened == 0);
  CHECK(bench.hid.asked_serials == std::vector<std::optional<std::wstring>>{L"S1", std::nullopt});
}

TEST_CASE("HID link: a device that does not open is a fault that lists the present devices") {
  HidBench bench;
  bench.hid.error = L"no such device";
  check_fault([] { (void)open_hid_link({0x1234, 0xABCE, "S1"}); }, "TB-HID-OPEN", "1234:abce", "1234:abcd");
  bench.hid.devices.clear();
  bench.hid.error.reset();
  CHECK(fault_id_of([] { (void)open_hid_link({1, 2, ""}); }) == "TB-HID-OPEN");
}

TEST_CASE("HID link: a report is written whole, again after a signal, and any other result is a fault") {
  HidBench bench;
  const auto link = bench.open();
  const std::array<std::uint8_t, 3> report{1, 2, 3};
  bench.hid.results = {{3, 0}};
  link->write(report);
  REQUIRE(bench.hid.written.size() == 1);
  CHECK(bench.hid.written[0] == std::vector<std::uint8_t>{1, 2, 3});
  bench.hid.results = {{-1, EINTR}, {-1, EINTR}, {3, 0}};
  link->write(report);
  CHECK(bench.hid.written.size() == 4);
  const FakeHid::Result failures[] = {{-1, EIO}, {-1, 0}, {2, 0}, {2, EINTR}, {0, EINTR}, {0, 0}, {4, 0}};
  for (const auto& failure : failures) {
    INFO("returns " << failure.returned << ", error " << failure.error);
    bench.hid.results = {failure};
    bench.hid.usual = {3, 0};  // were it tried again
    bench.hid.error = L"unplugged \u2014 pipe";
    bench.hid.written.clear();
    errno = EINTR;  // an older call's
    check_fault([&] { link->write(report); }, "TB-HID-WRITE", kHidName);
    CHECK(bench.hid.written.size() == 1);
  }
}

TEST_CASE("HID link: read timeouts are whole milliseconds, rounded up") {
  HidBench bench;
  const auto link = bench.open();
  std::array<std::uint8_t, 4> into{};
  bench.hid.results = {{4, 0}, {1, 0}, {0, 0}, {0, 0}, {0, 0}, {0, 0}};
  CHECK(link->read(into, 5ms) == 4);
  CHECK(into == std::array<std::uint8_t, 4>{0x5A, 0x5A, 0x5A, 0x5A});
  CHECK(link->read(into, 1500us) == 1);
  CHECK(link->read(into, 0ns) == 0);
  CHECK(link->read(into, 1ns) == 0);
  CHECK(link->read(into, -5ms) == 0);
  CHECK(link->read(into, 1s) == 0);
  CHECK(bench.hid.waits == std::vector<int>{5, 2, 0, 1, 0, 1000});
}

TEST_CASE("HID link: a signal does not extend a read, and any other failure is a lost connection") {
  HidBench bench;
  const auto link = bench.open();
  std::array<std::uint8_t, 4> into{};
  bench.hid.results = {{-1, EINTR}, {-1, EINTR}, {2, 0}};
  CHECK(link->read(into, 1h) == 2);
  REQUIRE(bench.hid.waits.size() == 3);
  CHECK(bench.hid.waits[0] == 3'600'000);
  CHECK(bench.hid.waits[1] <= bench.hid.waits[0]);
  CHECK(bench.hid.waits[1] > 1'800'000);
  CHECK(bench.hid.waits[2] <= bench.hid.waits[1]);
  bench.hid.waits.clear();
  bench.hid.results = {{-1, EINTR}, {0, 0}};
  CHECK(link->read(into, 0ns) == 0);
  CHECK(bench.hid.waits == std::vector<int>{0, 0});
  for (const int error : {EIO, ENODEV, 0}) {
    INFO("error " << error);
    bench.hid.results = {{-1, error}};
    bench.hid.error = L"gone";
    errno = EINTR;  // an older call's
    check_fault([&] { (void)link->read(into, 1s); }, "TB-HID-LOST", kHidName);
  }
}

TEST_CASE("HID link: drain reads what waits without waiting, and ends even if the sender never stops") {
  HidBench bench;
  const auto link = bench.open();
  bench.hid.results = {{4, 0}, {1, 0}, {4, 0}};
  CHECK(link->drain() == 3);
  CHECK(bench.hid.waits == std::vector<int>{0, 0, 0, 0});
  CHECK(link->drain() == 0);
  bench.hid.usual = {4, 0};
  CHECK(link->drain() == 10'000);
  bench.hid.usual = {-1, EIO};
  CHECK(fault_id_of([&] { (void)link->drain(); }) == "TB-HID-LOST");
}
