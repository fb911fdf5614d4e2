// Serial ports over a libserialport of the tests' own (fake_libraries.h): what is set, what each failing call is told
// as, and that nothing stays open.

#include "devices/wire/byte_stream.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <array>
#include <cerrno>
#include <filesystem>
#include <functional>
#include <vector>

#include "devices/wire/ends/stream_end.h"
#include "devices/wire/report_link.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/timeouts.h"
#include "tests/devices/wire/fake_libraries.h"
#include "tests/support/process.h"

using namespace std::chrono_literals;
using namespace tactbench::devices;

namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr const char* kSerialName = "/dev/ttyFake7";

struct SerialBench {
  SerialBench() {
    ports = FakeSerialPorts{};
    ports.ports = {{"/dev/ttyFake5", std::nullopt, std::nullopt, std::nullopt, terminal.path()},
                   {"/dev/ttyFake6", "adapter", "S6", std::pair{0x0403, 0x6001}, terminal.path()},
                   {kSerialName, "adapter", "S7", std::pair{0x0403, 0x6015}, terminal.path()}};
  }
  [[nodiscard]] std::unique_ptr<ByteStream> open() const { return open_serial(address); }
  // Opening ends in this fault, and leaves nothing open.
  void check_refused(const std::string& id, const std::string& says = {}) const {
    check_fault([&] { (void)open(); }, id, {}, says);
    CHECK(ports.opened == 0);
    CHECK(ports.made == 0);
  }
  void fail(const std::string& function, sp_return code = SP_ERR_FAIL, const std::string& text = "it broke") const {
    ports.fail_function = function;
    ports.fail_code = code;
    ports.error_text = text;
  }
  void send(const Bytes& bytes) const {
    REQUIRE(::write(terminal.master(), bytes.data(), bytes.size()) == static_cast<ssize_t>(bytes.size()));
  }
  PseudoTerminal terminal;
  FakeSerialPorts& ports = fake_serial_ports();
  SerialAddress address{kSerialName, 19200, 'E', 2, ""};
};

}  // namespace

TEST_CASE("serial port: is set to eight bits without handshake and to its address, is emptied and locked") {
  const struct {
    char parity;
    int number;  // libserialport's
  } parities[] = {{'N', 0}, {'O', 1}, {'E', 2}};
  for (const auto& [parity, number] : parities) {
    SerialBench bench;
    bench.address.parity = parity;
    const auto port = bench.open();
    CHECK(bench.ports.calls == std::vector<std::string>{"sp_open 3", "sp_set_baudrate 19200", "sp_set_bits 8",
                                                        "sp_set_parity " + std::to_string(number), "sp_set_stopbits 2",
                                                        "sp_set_flowcontrol 0", "sp_flush 3"});
    CHECK(port->description() == kSerialName);
    REQUIRE(port->descriptor() >= 0);
    CHECK(::fcntl(port->descriptor(), F_GETFD) == FD_CLOEXEC);
    int exclusive = 0;
    REQUIRE(::ioctl(port->descriptor(), TIOCGEXCL, &exclusive) == 0);
    CHECK(exclusive != 0);
    const int other = ::open(bench.terminal.path().c_str(), O_RDWR | O_NOCTTY);
    if (other >= 0) CHECK(::flock(other, LOCK_EX | LOCK_NB) != 0);  // exclusive to all but root
    if (other >= 0) ::close(other);
    ::ioctl(port->descriptor(), TIOCNXCL);
  }
  CHECK(fake_serial_ports().opened == 0);
  CHECK(fake_serial_ports().made == 0);
}

TEST_CASE("serial port: each setting that is refused is a fault and leaves nothing open") {
  for (const char* function :
       {"sp_set_baudrate", "sp_set_bits", "sp_set_parity", "sp_set_stopbits", "sp_set_flowcontrol", "sp_flush"}) {
    for (const sp_return code : {SP_ERR_ARG, SP_ERR_SUPP, SP_ERR_MEM, SP_ERR_FAIL}) {
      INFO(function << " " << code);
      SerialBench bench;
      bench.fail(function, code);
      bench.check_refused("TB-SERIAL-OPEN", kSerialName);
    }
  }
  SerialBench bench;
  bench.fail("sp_set_bits");
  bench.ports.error_text.reset();
  bench.check_refused("TB-SERIAL-OPEN");
  SerialBench odd;
  odd.address.parity = 'M';
  odd.check_refused("TB-SERIAL-OPEN", "'M'");
}

TEST_CASE("serial port: an absent, failing or locked port and another serial number are faults") {
  SerialBench absent;
  absent.address.port = "/dev/ttyFake8";
  absent.check_refused("TB-SERIAL-OPEN", "S6");  // it names those that are present
  absent.ports.ports.clear();
  absent.check_refused("TB-SERIAL-OPEN", "/dev/ttyFake8");
  for (const int error : {EACCES, EBUSY}) {
    SerialBench bench;
    bench.fail("sp_open");
    bench.ports.error_code = error;
    bench.check_refused(error == EBUSY ? "TB-SERIAL-BUSY" : "TB-SERIAL-OPEN");
    bench.fail("sp_open", SP_ERR_SUPP);  // then the last error is an older call's
    bench.check_refused("TB-SERIAL-OPEN");
  }
  SerialBench held;
  const int other = ::open(held.terminal.path().c_str(), O_RDWR | O_NOCTTY);
  REQUIRE(::flock(other, LOCK_EX | LOCK_NB) == 0);
  held.check_refused("TB-SERIAL-BUSY", kSerialName);
  ::close(other);
  SerialBench another;
  another.address.usb_serial = "S6";
  another.check_refused("TB-SERIAL-OPEN", "'S7'");
  another.address.port = "/dev/ttyFake5";
  another.check_refused("TB-SERIAL-OPEN", "'S6'");
  another.address = {"", 9600, 'N', 1, "S9"};
  another.check_refused("TB-SERIAL-OPEN", "S9");
  another.address.usb_serial = "";
  another.check_refused("TB-SERIAL-OPEN");
}

TEST_CASE("serial port: is found by its USB serial number, by a link or by its name") {
  SerialBench bench;
  bench.address.usb_serial = "S7";
  CHECK(bench.open()->description() == kSerialName);
  bench.address.port = "";
  CHECK(bench.open()->description() == kSerialName);
  bench.address.usb_serial = "S6";
  CHECK(bench.open()->description() == "/dev/ttyFake6");
  const tactbench::tests::TemporaryFolder folder;
  bench.ports.ports[0].name = folder.path("port");
  const int file = ::open(folder.path("port").c_str(), O_CREAT | O_RDWR, 0600);
  ::close(file);
  std::filesystem::create_symlink(folder.path("port"), folder.path("link"));
  bench.address = {folder.path("link"), 9600, 'N', 1, ""};
  CHECK(bench.open()->description() == std::filesystem::canonical(folder.path("port")).string());
}

TEST_CASE("serial ports: the list has what the system reports of each") {
  const SerialBench bench;
  const auto list = list_serial_ports();
  REQUIRE(list.size() == 3);
  CHECK(list[0].name == "/dev/ttyFake5");
  CHECK(list[0].description.empty());
  CHECK(list[0].usb_serial.empty());
  CHECK(list[0].usb_vendor == -1);
  CHECK(list[0].usb_product == -1);
  CHECK(list[2].name == kSerialName);
  CHECK(list[2].description == "adapter");
  CHECK(list[2].usb_serial == "S7");
  CHECK(list[2].usb_vendor == 0x0403);
  CHECK(list[2].usb_product == 0x6015);
  CHECK(bench.ports.made == 0);
  bench.fail("sp_list_ports");
  CHECK(list_serial_ports().empty());
}

TEST_CASE("serial port: carries bytes both ways, in whole or in part, and discard returns the number dropped") {
  const SerialBench bench;
  const auto port = bench.open();
  std::array<std::uint8_t, 8> into{};
  CHECK(port->read(into, 0ns) == 0);
  CHECK(port->read(into, 1ms) == 0);
  bench.send({7});
  CHECK(port->read(into, kPatient) == 1);
  CHECK(into[0] == 7);
  bench.send({1, 2, 3});
  CHECK(port->read(std::span(into).first(2), kPatient) == 2);
  CHECK(port->read(into, 0ns) == 1);
  CHECK(into[0] == 3);
  bench.send({8, 9});
  bench.ports.swallowed = 1;  // ready, and yet nothing to read: it is waited for
  CHECK(port->read(std::span(into).first(1), kPatient) == 1);
  CHECK(into[0] == 9);
  bench.send({8});
  bench.ports.swallowed = 1;
  const auto begin = std::chrono::steady_clock::now();
  CHECK(port->read(into, 20ms) == 0);
  CHECK(std::chrono::steady_clock::now() - begin >= 20ms);
  bench.send({0, 1, 2, 3, 4, 5});
  CHECK(port->read(std::span(into).first(1), kPatient) == 1);  // then all have come
  CHECK(port->discard() == 5);
  CHECK(bench.ports.calls.back() == "sp_flush 1");  // what came in, not what is to go out
  CHECK(port->discard() == 0);
  CHECK(port->read(into, 0ns) == 0);
  port->write(Bytes{5, 6, 7});
  CHECK(bench.ports.calls.back() == "sp_blocking_write 1000");
  CHECK(::read(bench.terminal.master(), into.data(), into.size()) == 3);
  CHECK(into[2] == 7);
}

TEST_CASE("serial port: a write that is not accepted in whole is a timeout") {
  for (const int taken : {0, 1, 2}) {
    SerialBench bench;
    const auto port = bench.open();
    bench.ports.write_takes = taken;
    check_fault([&] { port->write(Bytes{1, 2, 3}); }, "TB-SERIAL-TIMEOUT", {}, std::to_string(taken) + " were");
  }
  SerialBench bench;
  const auto port = bench.open();
  bench.ports.write_takes = 3;
  CHECK(fault_id_of([&] { port->write(Bytes{1, 2, 3}); }) == "none");
}

TEST_CASE("serial port: each failing call is a lost-port fault") {
  std::array<std::uint8_t, 8> into{};
  const auto write = [](ByteStream& port) { port.write(Bytes{1}); };
  const auto read = [&](ByteStream& port) { (void)port.read(into, 0ns); };
  const auto discard = [](ByteStream& port) { (void)port.discard(); };
  for (const auto& [function, act] :
       std::vector<std::pair<const char*, std::function<void(ByteStream&)>>>{{"sp_blocking_write", write},
                                                                             {"sp_nonblocking_read", read},
                                                                             {"sp_input_waiting", read},
                                                                             {"sp_flush", discard},
                                                                             {"sp_input_waiting", discard}}) {
    for (const sp_return code : {SP_ERR_FAIL, SP_ERR_ARG}) {
      INFO(function << " " << code);
      const SerialBench bench;
      const auto port = bench.open();
      bench.fail(function, code);
      CHECK(fault_id_of([&, &act = act] { act(*port); }) == "TB-SERIAL-LOST");
    }
  }
  SerialBench bench;
  const auto port = bench.open();
  bench.terminal.hang_up();
  CHECK(fault_id_of([&] { (void)port->read(into, kPatient); }) == "TB-SERIAL-LOST");
}

// HID devices over a hidapi of the tests' own (fake_libraries.h): what is asked of it, and what each of its failures is
// told as.

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
