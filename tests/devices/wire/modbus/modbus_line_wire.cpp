// Connections and lines of Modbus: rates, gaps between frames, locks, endpoints that cannot be opened.
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/select.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <filesystem>
#include <mutex>
#include <vector>

#include "devices/wire/modbus/modbus_link.h"
#include "tests/devices/full_queue.h"
#include "tests/devices/scripted_line.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

using RealTimes = std::vector<std::chrono::steady_clock::time_point>;

std::uint16_t read_first(ModbusLink& link) {
  std::array<std::uint16_t, 1> one{};
  link.read_input_registers(0, one);
  return one[0];
}

std::string complaint_of(const ModbusEndpoint& endpoint) {
  ManualClock clock;
  ModbusLink link(endpoint, "device", clock);
  const auto fault = fault_of([&] { (void)read_first(link); });
  CHECK(clock.now() == (fault && fault->id() == "TB-MODBUS-TIMEOUT" ? endpoint.response_timeout : 0ns));
  return fault ? fault->id() : "none";
}

Bytes answer_of_one(int, const Bytes&) { return rtu_reading(1, 4, 1, 42); }

void answer_seven(int, int socket, const Bytes& request) {
  ScriptedServer::send(socket, ScriptedServer::answer(request, {7}));
}

}  // namespace

TEST_CASE("modbus line: accepts every baud rate that libmodbus knows, and no other") {
  ScriptedLine line(answer_of_one);
  for (const int baud :
       {110, 300, 600, 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200, 230400, 460800, 500000, 576000, 921600}) {
    INFO(baud << " baud");
    auto endpoint = rtu_endpoint(line.path(), 1);
    endpoint.baud = baud;
    CHECK(complaint_of(endpoint) == "none");
    for (const int other : {baud - 1, baud + 1}) {
      endpoint.baud = other;
      CHECK(complaint_of(endpoint) == "TB-MODBUS-CONNECT");
    }
  }
}

TEST_CASE("modbus line: keeps 3.5 characters of silence between frames, and 1.75 ms above 19200 baud") {
  const struct {
    int baud;
    Nanoseconds gap;
  } gaps[] = {{1200, 32'083us}, {9600, 4'010us}, {19200, 2'005us}, {38400, 1'750us}};
  for (const auto& [baud, gap] : gaps) {
    INFO(baud << " baud");
    RealTimes times;
    auto line = std::make_unique<ScriptedLine>([&](int, const Bytes&) {
      times.push_back(std::chrono::steady_clock::now());
      return rtu_reading(1, 4, 1, 42);
    });
    auto endpoint = rtu_endpoint(line->path(), 1);
    endpoint.baud = baud;
    ManualClock clock;
    ModbusLink link(endpoint, "device", clock);
    for (int i = 0; i < 4; ++i) CHECK(read_first(link) == 42);
    line.reset();
    REQUIRE(times.size() == 4);
    for (std::size_t i = 1; i < 4; ++i) {
      CHECK(times[i] - times[i - 1] >= gap);
      CHECK(times[i] - times[i - 1] < 10s);
    }
  }
}

TEST_CASE("modbus line: pauses after an error for the longest delay of a reply") {
  RealTimes times;
  auto line = std::make_unique<ScriptedLine>([&](int number, const Bytes&) {
    times.push_back(std::chrono::steady_clock::now());
    return rtu_reading(number == 0 ? 2 : 1, 4, number == 1 ? 2 : 1, 42);  // another unit's, a longer one, the right one
  });
  auto endpoint = rtu_endpoint(line->path(), 1);
  endpoint.max_reply_delay = 80ms;
  ManualClock clock;
  ModbusLink link(endpoint, "device", clock);
  CHECK(fault_id_of([&] { (void)read_first(link); }) == "TB-MODBUS-PROTOCOL");
  CHECK(fault_id_of([&] { (void)read_first(link); }) == "TB-MODBUS-PROTOCOL");
  CHECK(read_first(link) == 42);
  line.reset();
  REQUIRE(times.size() == 3);
  CHECK(times[1] - times[0] >= 80ms);
  CHECK(times[2] - times[1] >= 80ms);
}

TEST_CASE("modbus line: is locked for one program, unless its endpoint turns the lock off") {
  ScriptedLine line(answer_of_one);
  const tactbench::tests::TemporaryFolder folder;
  std::filesystem::create_symlink(line.path(), folder.path("port"));
  const int other = ::open(line.path().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  const auto is_exclusive = [&] {
    int exclusive = -1;
    REQUIRE(::ioctl(other, TIOCGEXCL, &exclusive) == 0);
    return exclusive != 0;
  };
  ManualClock clock;
  {
    ModbusLink first(rtu_endpoint(line.path(), 1), "device", clock);
    CHECK(read_first(first) == 42);
    CHECK_FALSE(is_exclusive());  // on a pseudo-terminal it would outlive a killed client
    auto endpoint = rtu_endpoint(line.path(), 1);
    CHECK(complaint_of(endpoint) == "TB-MODBUS-CONNECT");
    endpoint.lock = false;
    CHECK(complaint_of(endpoint) == "none");
  }
  for (const bool exclusive : {false, true}) {
    auto endpoint = rtu_endpoint(folder.path("port"), 1);
    endpoint.exclusive = exclusive;
    ModbusLink link(endpoint, "device", clock);
    CHECK(read_first(link) == 42);
    CHECK(is_exclusive() == exclusive);
    ::ioctl(other, TIOCNXCL);
  }
  ::close(other);
}

TEST_CASE("modbus line: uses the parity, stop bits and unit of its endpoint") {
  ScriptedLine line(answer_of_one);
  for (const char parity : {'N', 'E', 'O'}) {
    auto endpoint = rtu_endpoint(line.path(), 1);
    endpoint.parity = parity;
    endpoint.stop_bits = 2;
    ManualClock clock;
    ModbusLink link(endpoint, "device", clock);
    CHECK(read_first(link) == 42);
    CHECK(link.peer() == "device at " + line.path() + " (115200 baud, 8" + parity + "2) unit 1");
    const int other = ::open(line.path().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    termios settings{};
    REQUIRE(::tcgetattr(other, &settings) == 0);
    ::close(other);
    CHECK((settings.c_cflag & CSTOPB) != 0);
  }
  auto endpoint = rtu_endpoint(line.path(), 300);
  CHECK(complaint_of(endpoint) == "TB-MODBUS-CONNECT");
  endpoint = rtu_endpoint("/dev/no-such-port", 1);
  CHECK(complaint_of(endpoint) == "TB-MODBUS-CONNECT");
}

TEST_CASE("modbus line: invalid, unresolvable, refusing and unresponsive TCP endpoints are faults") {
  FullQueue queue;
  const int port = queue.port();  // nobody listens
  for (const ModbusEndpoint& endpoint : std::vector<ModbusEndpoint>{{"127.0.0.1", 1502, 256, kShort},
                                                                    {"127.0.0.1", 1502, 1, 0ns},
                                                                    {"127.0.0.1", 1502, 1, 999ns},
                                                                    {"no host.invalid", 1502, 1, kShort},
                                                                    {"127.0.0.1", port, 1, kPatient}})
    CHECK(complaint_of(endpoint) == "TB-MODBUS-CONNECT");
  queue.fill();
  CHECK(complaint_of({"127.0.0.1", port, 1, kShort}) == "TB-MODBUS-TIMEOUT");
}

TEST_CASE("modbus line: resolves a host name, and accepts timeouts of whole and fractional seconds") {
  const ScriptedServer server(answer_seven);
  ManualClock clock;
  ModbusLink link({"localhost", server.port(), 1, kPatient}, "device", clock);
  CHECK(read_first(link) == 7);
  link.close();
  CHECK(read_first(link) == 7);
  for (const Nanoseconds timeout : {Nanoseconds(1s), Nanoseconds(2s), Nanoseconds(20s), Nanoseconds(20'999'999us)})
    CHECK(complaint_of({"127.0.0.1", server.port(), 1, timeout}) == "none");
}

TEST_CASE("modbus line: refuses a descriptor that select() cannot hold") {
  rlimit limit{};
  REQUIRE(::getrlimit(RLIMIT_NOFILE, &limit) == 0);
  const rlimit before = limit;
  limit.rlim_cur = FD_SETSIZE + 64;
  if (limit.rlim_cur < before.rlim_cur) limit.rlim_cur = before.rlim_cur;
  if (::setrlimit(RLIMIT_NOFILE, &limit) != 0) return;  // not allowed here
  const ScriptedServer server(answer_seven);
  ManualClock clock;
  const int base = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
  std::vector<int> taken;
  do {
    taken.push_back(::fcntl(base, F_DUPFD_CLOEXEC, 0));
  } while (taken.back() < FD_SETSIZE - 1);
  ::close(taken.back());  // the last one that select() can hold is free
  taken.pop_back();
  {
    ModbusLink link({"127.0.0.1", server.port(), 1, kPatient}, "device", clock);
    CHECK(read_first(link) == 7);
    ModbusLink beyond({"127.0.0.1", server.port(), 1, kPatient}, "device", clock);
    CHECK(fault_id_of([&] { (void)read_first(beyond); }) == "TB-MODBUS-CONNECT");
  }
  for (const int each : taken) ::close(each);
  ::close(base);
  ::setrlimit(RLIMIT_NOFILE, &before);
}
