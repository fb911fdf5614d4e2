// The stage's driver over real libserialport, the kernel's ftdi_sio and an emulated USB adapter, against the simulated
// chain outside (host_chain.cpp).
#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <string>

#include "devices/stage/zaber_stage.h"
#include "devices/wire/byte_stream.h"
#include "tests/vm/guest.h"

using namespace tactbench::devices;
using namespace tactbench::tests;
using namespace std::chrono_literals;
using Catch::Contains;
using Catch::EndsWith;

namespace {

constexpr const char* kPort = "/dev/ttyUSB0";
constexpr const char* kUsbSerial = "ZB0001";

// Orders to the host over the second port of the guest's board, one number back for each: libserialport on an 8250.
class Host {
 public:
  void send(const std::string& order) {
    const std::string line = order + "\n";
    port_->write(std::vector<std::uint8_t>(line.begin(), line.end()));
  }
  double answer() {
    std::string line;
    for (std::uint8_t byte = 0; byte != '\n'; line += static_cast<char>(byte)) {
      REQUIRE(port_->read(std::span(&byte, 1), 20s) == 1);
    }
    return std::stod(line);
  }
  double ask(const std::string& order) {
    send(order);
    return answer();
  }
  // After send("unplug"): the time from the pull until now, in ms.
  double unplugged_since() {
    send("lost");
    (void)answer();
    return answer();
  }
  void plug_in() {
    (void)ask("plug");
    REQUIRE(within_ten_seconds([] { return adapter().has_value(); }));
  }
  static std::optional<SerialPortInfo> adapter() {
    for (const SerialPortInfo& info : list_serial_ports()) {
      if (info.usb_serial == kUsbSerial) return info;
    }
    return std::nullopt;
  }

 private:
  std::unique_ptr<ByteStream> port_ = open_serial({"/dev/ttyS1", 115200, 'N', 1, ""});
};

SerialAddress usb_port() { return {kPort, 9600, 'N', 1, kUsbSerial}; }

ZaberStageOptions paper_stage() {
  ZaberStageOptions options;
  options.axes[1].device = 2;
  options.axes[2].device = 3;
  options.axes[2].device_id = 5082;
  options.axes[2].high = Millimetres(50.0);
  options.axes[2].maximum_speed = MillimetresPerSecond(8.0);
  options.reply_timeout = 2s;
  return options;
}

struct Rig {
  Host host;
  SteadyClock clock;
  ZaberStage stage{[] { return open_serial(usb_port()); }, paper_stage(), clock};
};

// The kernel's settings of the port; root may look in spite of TIOCEXCL.
termios settings() {
  termios result{};
  const int port = ::open(kPort, O_RDWR | O_NOCTTY | O_NONBLOCK);
  CHECK(::tcgetattr(port, &result) == 0);
  ::close(port);
  return result;
}

// The error of opening the port as a user without rights over others' locks; 0: it opened.
int error_for_user() {
  const pid_t child = ::fork();
  if (child == 0) {
    const bool user = ::setgid(65534) == 0 && ::setuid(65534) == 0;
    ::_exit(!user ? 255 : ::open(kPort, O_RDWR | O_NOCTTY | O_NONBLOCK) < 0 ? errno : 0);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  return WEXITSTATUS(status);
}

}  // namespace

TEST_CASE("serial port in VM: the adapter is listed with its ids and found by its serial number") {
  REQUIRE(within_ten_seconds([] { return Host::adapter().has_value(); }));
  const auto info = *Host::adapter();
  CHECK(info.name == kPort);
  CHECK(info.usb_vendor == 0x0403);
  CHECK(info.usb_product == 0x6001);
  CHECK(open_serial({"", 9600, 'N', 1, kUsbSerial})->description() == kPort);
  const auto wrong = fault_of([] { (void)open_serial({kPort, 9600, 'N', 1, "ZB0002"}); });
  CHECK(wrong.id() == "TB-SERIAL-OPEN");
  CHECK_THAT(wrong.what(), Contains("its USB serial is 'ZB0001', expected 'ZB0002'"));
  const auto absent = fault_of([] { (void)open_serial({"", 9600, 'N', 1, "ZB0002"}); });
  CHECK(absent.id() == "TB-SERIAL-OPEN");
  CHECK_THAT(absent.what(), Contains("/dev/ttyUSB0 (serial ZB0001)"));
}

TEST_CASE("serial port in VM: an open port cannot be opened again") {
  REQUIRE(::chmod(kPort, 0666) == 0);
  auto held = open_serial(usb_port());
  const auto fault = fault_of([] { (void)open_serial(usb_port()); });
  CHECK(fault.id() == "TB-SERIAL-BUSY");
  CHECK_THAT(fault.what(), Contains(kPort));
  CHECK(error_for_user() == EBUSY);
  held.reset();
  CHECK(error_for_user() == 0);
  CHECK_NOTHROW(open_serial(usb_port()));
}

TEST_CASE("serial port in VM: baud rate, parity and stop bits reach the port") {
  for (const char parity : {'N', 'E', 'O'}) {
    for (const int stop_bits : {1, 2}) {
      INFO(parity << stop_bits);
      const auto port = open_serial({kPort, 19200, parity, stop_bits, ""});
      const termios set = settings();
      CHECK(((set.c_cflag & PARENB) != 0) == (parity != 'N'));
      CHECK(((set.c_cflag & PARODD) != 0) == (parity == 'O'));
      CHECK(((set.c_cflag & CSTOPB) != 0) == (stop_bits == 2));
      CHECK((set.c_cflag & CSIZE) == CS8);
      CHECK((set.c_cflag & CRTSCTS) == 0);
      CHECK(::cfgetospeed(&set) == B19200);
    }
  }
}

TEST_CASE("serial port in VM: waiting for a silent line uses little processor time") {
  const auto port = open_serial(usb_port());
  std::uint8_t byte = 0;
  const auto begin = now();
  const std::clock_t used = std::clock();
  CHECK(port->read(std::span(&byte, 1), 500ms) == 0);
  CHECK(now() - begin >= 500ms);
  CHECK(std::clock() - used < CLOCKS_PER_SEC / 10);
}

TEST_CASE("stage in VM: homes, moves and stops") {
  Rig rig;
  rig.stage.arm();
  for (const Axis axis : {Axis::kX, Axis::kY, Axis::kZ}) rig.stage.home(axis);
  rig.stage.start_move_to(Axis::kZ, Millimetres(2.0), std::nullopt);
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(2.0).margin(1e-3));
  CHECK(rig.host.ask("z") == Approx(2.0).margin(1e-3));
  rig.stage.start_move_to(Axis::kZ, Millimetres(50.0), MillimetresPerSecond(1.0));
  const double stands = rig.stage.stop(Axis::kZ).value();
  CHECK(stands < 25.0);
  CHECK(rig.host.ask("z") == Approx(stands).margin(1e-3));

  const auto exchanges = rig.stage.exchanges();
  const auto begin = now();
  for (int i = 0; i < 50; ++i) (void)rig.stage.state(Axis::kZ);
  figure("vm_serial_exchange", milliseconds(now() - begin) / static_cast<double>(rig.stage.exchanges() - exchanges),
         "ms");
}

TEST_CASE("serial port in VM: unplugging ends a blocking read within two seconds, as a lost port and not as silence") {
  Host host;
  {
    const auto port = open_serial(usb_port());
    std::uint8_t byte = 0;
    host.send("unplug");
    const auto fault = fault_of([&] { (void)port->read(std::span(&byte, 1), 20s); });
    const double took = host.unplugged_since();
    figure("vm_serial_unplug_to_fault_of_read", took, "ms");
    CHECK(took < 2000.0);
    CHECK(fault.id() == "TB-SERIAL-LOST");
    CHECK_THAT(fault.what(), Contains(kPort));
    const auto begin = now();
    CHECK(fault_of([&] { (void)port->read(std::span(&byte, 1), 20s); }).id() == "TB-SERIAL-LOST");
    CHECK(fault_of([&] { port->write(std::span(&byte, 1)); }).id() == "TB-SERIAL-LOST");
    CHECK(fault_of([&] { (void)port->discard(); }).id() == "TB-SERIAL-LOST");
    CHECK(now() - begin < 1s);
  }
  host.plug_in();
  CHECK(Host::adapter()->name == kPort);
}

TEST_CASE("stage in VM: a stage unplugged during a move is lost, and can be halted once it is back") {
  Rig rig;
  rig.stage.arm();
  rig.stage.home(Axis::kZ);
  rig.stage.start_move_to(Axis::kZ, Millimetres(50.0), MillimetresPerSecond(0.5));  // 100 s
  (void)rig.host.ask("mark");
  rig.host.send("unplug");
  const auto fault = fault_of([&] { (void)rig.stage.wait(Axis::kZ); });
  const double took = rig.host.unplugged_since();
  figure("vm_serial_unplug_to_fault_of_move", took, "ms");
  CHECK(took < 2000.0);
  CHECK(fault.id() == "TB-SERIAL-LOST");
  CHECK_FALSE(rig.stage.armed());
  CHECK(fault_of([&] { (void)rig.stage.state(Axis::kZ); }).id() == "TB-STAGE-NOT-ARMED");
  const auto begin = now();
  CHECK_FALSE(rig.stage.halt());
  CHECK(now() - begin < 1s);
  const auto absent = fault_of([&] { rig.stage.arm(); });
  CHECK(absent.id() == "TB-SERIAL-OPEN");
  CHECK_THAT(absent.what(), EndsWith("present: /dev/ttyS0, /dev/ttyS1"));

  const auto back = now();
  rig.host.plug_in();
  figure("vm_serial_plug_in_to_port", milliseconds(now() - back), "ms");
  CHECK(Host::adapter()->name == kPort);  // the lost handle was closed: the number is free again
  CHECK(rig.stage.identify().at(2).id == "5082");
  rig.stage.arm();
  CHECK(rig.host.ask("moves") == 0.0);                             // nothing was sent again
  CHECK(rig.stage.state(Axis::kZ).activity == Activity::kMoving);  // the devices had kept their power
  CHECK(rig.stage.halt());
  const double stands = rig.host.ask("z");
  CHECK(stands < 25.0);
  rig.stage.arm();
  CHECK(rig.stage.state(Axis::kZ).position.value() == Approx(stands).margin(1e-3));
  rig.stage.start_move_to(Axis::kZ, Millimetres(1.0), std::nullopt);
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(1.0).margin(1e-3));
  CHECK(rig.host.ask("moves") == 1.0);
}
