// Waiting on a wire is bounded in real time; margins of 5 and more.
#include <catch2/catch.hpp>

#include "devices/force/net_ft.h"
#include "devices/force/simulated_net_ft.h"
#include "devices/pressure/regulator.h"
#include "devices/pressure/simulated_module.h"
#include "devices/stage/simulated_chain.h"
#include "devices/tactile/frame_source.h"
#include "devices/tactile/hid_scanner.h"
#include "devices/tactile/simulated_frame_source.h"
#include "devices/wire/byte_stream.h"
#include "devices/wire/report_link.h"
#include "tests/devices/full_queue.h"
#include "tests/devices/scripted_server.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

constexpr auto kTimeout = 400ms;
constexpr auto kBound = 5 * kTimeout;

template <class Act>
Nanoseconds time_of(Act&& act) {
  const auto start = std::chrono::steady_clock::now();
  act();
  return std::chrono::steady_clock::now() - start;
}

}  // namespace

TEST_CASE("timeouts: with a silent module a request ends after its response timeout, and a vent within bounded time") {
  ManualClock clock;
  TestChamber chamber(clock);
  const SimulatedModule server(module_profile("beckhoff-ek9000"), 0, chamber, clock, {.silent_after_requests = 0});
  const ModbusEndpoint endpoint{"127.0.0.1", server.port(), 1, kTimeout};
  ModbusLink link(endpoint, "module", clock);
  std::uint16_t value = 0;
  const auto took =
      time_of([&] { CHECK(fault_id_of([&] { link.read_input_registers(0, std::span(&value, 1)); }) != "none"); });
  CHECK(took >= kTimeout);
  CHECK(took < kBound);
  AnalogModule module(module_profile("beckhoff-ek9000"), endpoint, 1s, clock, Origin::kSimulated);
  CHECK(time_of([&] { CHECK_FALSE(module.zero_outputs()); }) < 2 * kBound);
}

// The machine holds an end's thread up for ten times the timeout: no answer is lost.
TEST_CASE("timeouts: a delayed reply of a simulated instrument is waited for beyond the timeout") {
  static constexpr auto kTooShort = 20ms;
  const FaultInjector held_up = [] {
    std::this_thread::sleep_for(10 * kTooShort);
    return InjectedFault::kNone;
  };
  const TemporaryFolder folder;
  ManualClock clock;
  TestArray array;
  TestChamber chamber(clock);
  SECTION("analog module") {
    const auto wire = GENERATE(SimulatedModule::Wire::kTcp, SimulatedModule::Wire::kRtu);
    const SimulatedModule server({{1, module_profile("beckhoff-ek9000"), {}}}, wire, 0, chamber, clock,
                                 {.inject = held_up});
    ModbusEndpoint endpoint{"127.0.0.1", wire == SimulatedModule::Wire::kTcp ? server.port() : 0, 1, kTooShort};
    if (wire == SimulatedModule::Wire::kRtu) endpoint.serial_port = server.serial_port();
    ModbusLink link(endpoint, "module", clock);
    std::uint16_t value = 0;
    CHECK(fault_id_of([&] { link.read_input_registers(0, std::span(&value, 1)); }) == "none");
  }
  SECTION("scanner") {
    const SimulatedScanner server(folder.path("s"), IdentityReport{0, 16, 16, 1.0F, "S", "1"}, array, clock,
                                  SimulatedScannerFaults{.inject = held_up});
    HidScannerOptions options;
    options.frame_timeout = kTooShort;
    CHECK(fault_id_of([&] { (void)HidScanner(open_packet_link(folder.path("s")), options, clock).read(2); }) == "none");
  }
  SECTION("frame source") {
    SimulatedFrameSourceOptions served;
    served.description = {1, 16, 16, 1e-4, "source", "S", "1"};
    served.faults.inject = held_up;
    const SimulatedFrameSource server(served, array, clock);
    FrameSourceOptions options;
    options.address = "tcp:127.0.0.1:" + std::to_string(server.port());
    options.frame_timeout = kTooShort;
    CHECK(fault_id_of([&] { (void)FrameSource(options, clock).read(2); }) == "none");
  }
  SECTION("stage") {
    const SimulatedChain chain({}, clock, {.inject = held_up});
    const auto stream = open_stream(chain.address());
    stream->write(encode_without_id({3, ZaberCommand::kStatus, 0, 0}));
    std::array<std::uint8_t, 6> reply{};
    CHECK(stream->read(reply, kTooShort) == reply.size());
  }
  SECTION("force sensor over a network") {
    struct Load final : ForcePort {
      Wrench wrench() override { return {}; }
    } load;
    NetFtPage page;
    page.product = "simulated Net F/T";
    page.calibration_serial = "FT1";
    page.firmware = "1";
    page.range = SixAxes{25, 25, 35, 250, 250, 250};
    const SimulatedNetFt server({0, 0, page, {.inject = held_up}}, load);
    NetFtOptions options;
    options.host = "127.0.0.1";
    options.port = server.rdt_port();
    options.http_port = server.http_port();
    options.reply_timeout = kTooShort;
    CHECK(fault_id_of([&] { (void)NetFt(options, clock).read(2); }) == "none");
  }
  CHECK(clock.now() == 0ns);  // nothing was lost
}

TEST_CASE("timeouts: a reply that arrives in pieces does not extend the response timeout") {
  // Half an answer, then nothing: the wait ends with the response timeout, counted from the request.
  ScriptedServer server([](int, int socket, const Bytes& request) {
    auto reply = ScriptedServer::answer(request, {1, 2, 3, 4});
    reply.resize(9);
    ScriptedServer::send(socket, reply);
  });
  ManualClock clock;
  ModbusLink link({"127.0.0.1", server.port(), 1, kTimeout}, "module", clock);
  std::array<std::uint16_t, 4> values{};
  const auto took =
      time_of([&] { CHECK(fault_id_of([&] { link.read_input_registers(0, values); }) == "TB-MODBUS-TIMEOUT"); });
  CHECK(took < kBound);
  // A byte at a time, each soon after the one before, the last when more than the timeout has passed: too late, too.
  ScriptedServer slow(
      [](int, int socket, const Bytes& request) {
        for (const std::uint8_t byte : ScriptedServer::answer(request, {1, 2, 3, 4})) {
          ScriptedServer::send(socket, {byte});
          std::this_thread::sleep_for(kTimeout / 8);
        }
      },
      false);
  ModbusLink patient({"127.0.0.1", slow.port(), 1, kTimeout}, "module", clock);
  CHECK(fault_id_of([&] { patient.read_input_registers(0, values); }) == "TB-MODBUS-TIMEOUT");
}

TEST_CASE("timeouts: connecting to an unresponsive host ends after the response timeout") {
  FullQueue queue;
  queue.fill();
  ManualClock clock;
  ModbusLink link({"127.0.0.1", queue.port(), 1, kTimeout}, "module", clock);
  std::uint16_t value = 0;
  const auto took = time_of(
      [&] { CHECK(fault_id_of([&] { link.read_input_registers(0, std::span(&value, 1)); }) == "TB-MODBUS-TIMEOUT"); });
  CHECK(took >= kTimeout);
  CHECK(took < kBound);
  CHECK(clock.now() == kTimeout);
}

TEST_CASE(
    "timeouts: with a silent scanner a scan ends after its frame timeout, and simulated instruments stop at once") {
  const TemporaryFolder folder;
  ManualClock clock;
  TestArray array;
  TestChamber chamber(clock);
  auto server = std::make_unique<SimulatedScanner>(folder.path("s"), IdentityReport{0, 16, 16, 1.0F, "S", "1"}, array,
                                                   clock, SimulatedScannerFaults{.silent_after_scans = 0});
  HidScannerOptions options;
  options.frame_timeout = kTimeout;
  HidScanner scanner(open_packet_link(folder.path("s")), options, clock);
  const auto took = time_of([&] { CHECK(fault_id_of([&] { (void)scanner.read(5); }) == "TB-SCANNER-TIMEOUT"); });
  CHECK(took >= kTimeout);
  CHECK(took < kBound);
  auto module = std::make_unique<SimulatedModule>(module_profile("beckhoff-ek9000"), 0, chamber, clock);
  ModbusLink link({"127.0.0.1", module->port(), 1, kTimeout}, "module", clock);
  std::uint16_t value = 0;
  link.read_input_registers(0, std::span(&value, 1));
  CHECK(time_of([&] { server.reset(); }) < kBound);
  CHECK(time_of([&] { module.reset(); }) < kBound);  // with a client still connected
}
