// Modbus RTU on a pseudo-terminal: the simulated line, and a scripted one that answers late, short, damaged, or for
// another unit.

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/select.h>
#include <termios.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <array>
#include <atomic>
#include <filesystem>
#include <functional>
#include <mutex>
#include <vector>

#include "devices/pressure/analog_module.h"
#include "devices/pressure/regulator.h"
#include "devices/pressure/simulated_module.h"
#include "devices/wire/modbus/modbus_link.h"
#include "tests/devices/full_queue.h"
#include "tests/devices/scripted_line.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace std::chrono_literals;
using namespace tactbench::devices;

TEST_CASE("modbus rtu: two units on one line each have their own registers") {
  ManualClock clock;
  TestChamber chamber(clock);
  SimulatedModule line({{1, module_profile("waveshare-analog-output-8ch-b"), {}},
                        {2, module_profile("waveshare-analog-input-8ch-b"), {}}},
                       SimulatedModule::Wire::kRtu, 0, chamber, clock);
  ModbusLink outputs(rtu_endpoint(line.serial_port(), 1), "output module", clock);
  ModbusLink inputs(outputs, 2, "input module");
  outputs.write_register(0, 4596);
  CHECK(chamber.output().value() == Approx(4.596));
  chamber.reference_volts = Volts(3.0);
  std::array<std::uint16_t, 2> in{};
  for (int i = 0; i < 3; ++i) {
    inputs.read_input_registers(0, in, 8);
    CHECK(in == std::array<std::uint16_t, 2>{4596, 3000});
  }
  std::array<std::uint16_t, 8> out{};
  outputs.read_holding_registers(0, out);
  CHECK(out[0] == 4596);
  CHECK_THAT(inputs.peer(), Catch::Contains("115200 baud, 8N1") && Catch::Contains("unit 2"));
  CHECK(fault_id_of([&] { outputs.read_input_registers(0x4000, in); }) == "TB-MODBUS-EXCEPTION");
}

TEST_CASE("modbus rtu: a regulator works on Waveshare's two modules and is vented at the end") {
  ManualClock clock;
  TestChamber chamber(clock);
  const auto output_profile = module_profile("waveshare-analog-output-8ch-b");
  const auto input_profile = module_profile("waveshare-analog-input-8ch-b");
  SimulatedModule line({{1, output_profile, {}}, {2, input_profile, {}}}, SimulatedModule::Wire::kRtu, 0, chamber,
                       clock);
  AnalogModule output(output_profile, rtu_endpoint(line.serial_port(), 1), 0s, clock, Origin::kSimulated);
  AnalogModule input(input_profile, output, 2, clock, Origin::kSimulated);
  RegulatorOptions options;
  options.command_span.high = options.feedback_span.high = Psi(9.0 * kPsiPerBar);
  Regulator regulator(output, input, options, clock);
  CHECK(fault_id_of([&] { regulator.command(Psi(10.0)); }) == "TB-CHAMBER-NOT-ARMED");
  CHECK(output.exchanges() == 0);
  regulator.arm();
  CHECK(regulator.command(Psi(60.0)) == 4597);
  CHECK(regulator.feedback().pressure.value() == Approx(60.0).margin(0.01));
  clock.wait_until(450ms);
  regulator.keep_alive();
  CHECK(regulator.vent());
  CHECK(chamber.output() == Volts(0.0));
}

TEST_CASE("modbus rtu: successive readings differ in length, so that a stale answer is not used") {
  std::vector<int> counts;
  Bytes held;
  auto line = std::make_unique<ScriptedLine>([&](int number, const Bytes& request) -> Bytes {
    counts.push_back(request[5]);
    Bytes answer = rtu_reading(1, 4, request[5], static_cast<std::uint16_t>(100 + number));
    if (number == 2) std::swap(answer, held);  // answers this one later ...
    if (number == 3) std::swap(answer, held);  // ... instead of the next
    return answer;
  });
  ManualClock clock;
  ModbusLink link(rtu_endpoint(line->path(), 1, kShort), "module", clock);
  std::array<std::uint16_t, 2> in{};
  link.read_input_registers(0, in, 3);
  CHECK(in[0] == 100);
  link.read_input_registers(0, in, 3);
  CHECK(in[1] == 101);
  CHECK(fault_id_of([&] { link.read_input_registers(0, in, 3); }) == "TB-MODBUS-TIMEOUT");
  CHECK(fault_id_of([&] { link.read_input_registers(0, in, 3); }) == "TB-MODBUS-PROTOCOL");
  link.read_input_registers(0, in, 3);
  CHECK(in[0] == 104);
  line.reset();  // with its thread, which wrote the counts
  CHECK(counts == std::vector<int>{2, 3, 2, 3, 2});
}

TEST_CASE("modbus rtu: old bytes on the line are discarded before the next request") {
  ScriptedLine line([&](int number, const Bytes& request) -> Bytes {
    Bytes answer = rtu_reading(1, 4, request[5], static_cast<std::uint16_t>(100 + number));
    const Bytes again = answer;
    if (number == 0) answer.insert(answer.end(), again.begin(), again.end());  // a repeater's echo
    return answer;
  });
  ManualClock clock;
  ModbusLink link(rtu_endpoint(line.path(), 1), "module", clock);
  std::array<std::uint16_t, 1> in{};
  for (std::uint16_t i = 0; i < 5; ++i) {
    link.read_input_registers(0, in);
    CHECK(in[0] == 100 + i);
  }
}

TEST_CASE("modbus rtu: wrong unit, wrong function, damaged, short and absent answers are distinguished") {
  const auto spoilt = [](int kind, const Bytes& request) -> Bytes {
    if (kind == 0) return rtu_reading(7, 4, request[5], 1);
    if (kind == 1) return rtu_reading(1, 3, request[5], 1);
    if (kind == 2) {
      Bytes answer = rtu_reading(1, 4, request[5], 1);
      answer[4] = static_cast<std::uint8_t>(answer[4] ^ 0x10U);
      return answer;
    }
    if (kind == 3) {
      Bytes answer = rtu_reading(1, 4, request[5], 1);
      answer.pop_back();
      return answer;
    }
    if (kind == 4) return {};
    return rtu_frame(Bytes{1, 0x84, 4});  // exception: failure
  };
  const char* expected[] = {"TB-MODBUS-PROTOCOL", "TB-MODBUS-PROTOCOL", "TB-MODBUS-PROTOCOL",
                            "TB-MODBUS-TIMEOUT",  "TB-MODBUS-TIMEOUT",  "TB-MODBUS-EXCEPTION"};
  for (int kind = 0; kind < 6; ++kind) {
    INFO("kind " << kind);
    ScriptedLine line([&](int number, const Bytes& request) {
      return number == 0 ? spoilt(kind, request) : rtu_reading(1, 4, request[5], 42);
    });
    ManualClock clock;
    ModbusLink link(rtu_endpoint(line.path(), 1, kShort), "module", clock);
    std::array<std::uint16_t, 1> in{};
    CHECK(fault_id_of([&] { link.read_input_registers(0, in); }) == expected[kind]);
    link.read_input_registers(0, in);
    CHECK(in[0] == 42);
  }
}

TEST_CASE("modbus rtu: an echoing adapter is recognised, and with local_echo set all requests work") {
  for (const bool echoes : {true, false}) {
    for (const bool expected : {true, false}) {
      INFO("echoes " << echoes << ", expected " << expected);
      ManualClock clock;
      TestChamber chamber(clock);
      SimulatedModule line({{1, module_profile("waveshare-analog-output-8ch-b"), {}},
                            {2, module_profile("waveshare-analog-input-8ch-b"), {}},
                            {3, module_profile("beckhoff-ek9000"), {}}},
                           SimulatedModule::Wire::kRtu, 0, chamber, clock, {.echoes = echoes});
      ModbusEndpoint endpoint = rtu_endpoint(line.serial_port(), 1, kShort);
      endpoint.local_echo = expected;
      ModbusLink outputs(endpoint, "output module", clock);
      ModbusLink inputs(outputs, 2, "input module");
      ModbusLink far(outputs, 3, "module with addresses of two bytes");
      chamber.reference_volts = Volts(3.0);
      std::array<std::uint16_t, 8> out{};
      std::array<std::uint16_t, 2> in{};
      std::array<std::uint16_t, 1> watchdog{};
      const std::array<std::uint16_t, 1> time{900};
      const std::vector<std::function<void()>> acts{
          [&] { outputs.read_holding_registers(0, out); }, [&] { inputs.read_input_registers(0, in, 8); },
          [&] { far.read_holding_registers(0x1120, watchdog); }, [&] { far.write_registers(0x1120, time); },
          [&] { far.write_and_read_registers(0x1120, time, 0x1120, watchdog); }};
      for (const auto& act : acts) CHECK(fault_id_of(act) == (echoes == expected ? "none" : "TB-MODBUS-ECHO"));
      if (echoes != expected) continue;
      outputs.write_register(0, 4596);
      outputs.read_holding_registers(0, out);
      CHECK(out[0] == 4596);
      CHECK(in[1] == 3000);
      CHECK(watchdog[0] == 900);
      CHECK(clock.now() == 0s);  // nothing was lost
    }
  }
}

TEST_CASE("modbus rtu: a damaged answer is not mistaken for an echo") {
  ManualClock clock;
  ScriptedLine line([&](int, const Bytes& request) {
    Bytes answer = request[1] == 16 ? rtu_frame(Bytes(request.begin(), request.begin() + 6))
                                    : rtu_reading(1, request[1], request[5], 0);
    answer.back() ^= 1U;
    return answer;
  });
  ModbusLink link(rtu_endpoint(line.path(), 1, kShort), "module", clock);
  const std::array<std::uint16_t, 2> out{};
  std::array<std::uint16_t, 4> in{};
  CHECK(fault_id_of([&] { link.read_holding_registers(0x0800, in); }) == "TB-MODBUS-PROTOCOL");
  CHECK(fault_id_of([&] { link.read_holding_registers(0, in); }) == "TB-MODBUS-PROTOCOL");
  CHECK(fault_id_of([&] { link.write_registers(0, out); }) == "TB-MODBUS-PROTOCOL");
}

TEST_CASE("modbus rtu: a port that hangs up is a connection fault") {
  ManualClock clock;
  TestChamber chamber(clock);
  SimulatedModule line({{1, module_profile("waveshare-analog-output-8ch-b"), {}}}, SimulatedModule::Wire::kRtu, 0,
                       chamber, clock, {.dead_after_requests = 1});
  ModbusLink link(rtu_endpoint(line.serial_port(), 1), "module", clock);
  std::array<std::uint16_t, 1> in{};
  link.read_holding_registers(0, in);
  CHECK(fault_id_of([&] { link.read_holding_registers(0, in); }) == "TB-MODBUS-CONNECT");
}

// Connections and lines of Modbus: rates, gaps between frames, locks, endpoints that cannot be opened.

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
