// Waiting on a wire is bounded in real time; margins of 5 and more.
#include <catch2/catch.hpp>

#include "devices/pressure/regulator.h"
#include "devices/pressure/simulated_module.h"
#include "devices/tactile/hid_scanner.h"
#include "devices/wire/packet_link.h"
#include "tests/devices/scripted_server.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

template <class Act>
Nanoseconds time_of(Act&& act) {
  const auto start = std::chrono::steady_clock::now();
  act();
  return std::chrono::steady_clock::now() - start;
}

}  // namespace

TEST_CASE("bounds: a silent module holds a request for its response timeout, a vent for two") {
  TurnedClock clock;
  TestChamber chamber(clock);
  const SimulatedModule server(module_profile("beckhoff-ek9000"), 0, chamber, clock, {.silent_after_requests = 0});
  const ModbusEndpoint endpoint{"127.0.0.1", server.port(), 1, 200ms};
  ModbusLink link(endpoint, "module", clock);
  std::uint16_t value = 0;
  const auto took =
      time_of([&] { CHECK(fault_id_of([&] { link.read_input_registers(0, std::span(&value, 1)); }) != "none"); });
  CHECK(took >= 200ms);
  CHECK(took < 1s);
  AnalogModule module(module_profile("beckhoff-ek9000"), endpoint, 1s, clock, Origin::kSimulated);
  CHECK(time_of([&] { CHECK_FALSE(module.zero_outputs()); }) < 2s);
}

TEST_CASE("bounds: a module that trickles its answer cannot stretch the response timeout") {
  // Half an answer, then nothing: the wait ends with the response timeout, counted from the request.
  ScriptedServer server([](int, int socket, const Bytes& request) {
    auto reply = ScriptedServer::answer(request, {1, 2, 3, 4});
    reply.resize(9);
    ScriptedServer::send(socket, reply);
  });
  TurnedClock clock;
  ModbusLink link({"127.0.0.1", server.port(), 1, 200ms}, "module", clock);
  std::array<std::uint16_t, 4> values{};
  const auto took =
      time_of([&] { CHECK(fault_id_of([&] { link.read_input_registers(0, values); }) == "TB-MODBUS-TIMEOUT"); });
  CHECK(took < 1s);
}

TEST_CASE("bounds: connecting to a host that does not answer ends with the response timeout") {
  // A listener whose queue is full drops what more comes, as an absent host does.
  const int listener = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  REQUIRE(::bind(listener, reinterpret_cast<const sockaddr*>(&address), size) == 0);
  REQUIRE(::listen(listener, 0) == 0);
  REQUIRE(::getsockname(listener, reinterpret_cast<sockaddr*>(&address), &size) == 0);
  std::vector<int> crowd;
  for (int i = 0; i < 4; ++i) {
    crowd.push_back(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK, 0));
    (void)::connect(crowd.back(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
  }
  TurnedClock clock;
  ModbusLink link({"127.0.0.1", ntohs(address.sin_port), 1, 200ms}, "module", clock);
  std::uint16_t value = 0;
  const auto took = time_of(
      [&] { CHECK(fault_id_of([&] { link.read_input_registers(0, std::span(&value, 1)); }) == "TB-MODBUS-TIMEOUT"); });
  CHECK(took >= 200ms);
  CHECK(took < 1s);
  CHECK(clock.now() == 200ms);
  for (const int socket : crowd) ::close(socket);
  ::close(listener);
}

TEST_CASE("bounds: a silent scanner holds a scan for its frame timeout, and simulated ends stop at once") {
  const TemporaryFolder folder;
  TurnedClock clock;
  TestArray array;
  TestChamber chamber(clock);
  auto server = std::make_unique<SimulatedScanner>(folder.path("s"), IdentityReport{0, 16, 16, 1.0F, "S", "1"}, array,
                                                   clock, SimulatedScannerFaults{.silent_after_scans = 0});
  HidScannerOptions options;
  options.frame_timeout = 200ms;
  HidScanner scanner(open_packet_link(folder.path("s")), options, clock);
  const auto took = time_of([&] { CHECK(fault_id_of([&] { (void)scanner.read(5); }) == "TB-SCANNER-TIMEOUT"); });
  CHECK(took >= 200ms);
  CHECK(took < 1s);
  auto module = std::make_unique<SimulatedModule>(module_profile("beckhoff-ek9000"), 0, chamber, clock);
  ModbusLink link({"127.0.0.1", module->port(), 1, 200ms}, "module", clock);
  std::uint16_t value = 0;
  link.read_input_registers(0, std::span(&value, 1));
  CHECK(time_of([&] { server.reset(); }) < 1s);
  CHECK(time_of([&] { module.reset(); }) < 1s);  // with a client still connected
}
