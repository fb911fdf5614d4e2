// The pressure drivers against a foreign Modbus server: pymodbus, over TCP and RTU.
#include <catch2/catch.hpp>

#include "devices/pressure/pressure_reference.h"
#include "devices/pressure/regulator.h"
#include "tests/devices/test_chamber.h"
#include "tests/support/child_process.h"
#include "tests/support/paths.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

constexpr double kSpanPsi = 9 * 14.503774;

ModbusEndpoint endpoint_of(const std::string& place) {
  ModbusEndpoint endpoint;
  endpoint.response_timeout = 10s;
  if (place.starts_with("/")) {
    endpoint.serial_port = place;
    endpoint.baud = 115200;
  } else {
    endpoint.port = std::stoi(place.substr(place.rfind(':') + 1));
  }
  return endpoint;
}

}  // namespace

TEST_CASE("foreign server: a regulator is armed, commanded, fed and vented on pymodbus") {
  const std::string wire = GENERATE(as<std::string>{}, "tcp", "rtu");
  tactbench::tests::ChildProcess server(
      {"/usr/bin/python3", tactbench::tests::source_path("tests/peers/pymodbus_server.py"), wire});
  const std::string line = server.line();
  REQUIRE(line.starts_with("listening on "));
  SteadyClock clock(1.0);
  ModuleProfile profile = module_profile("generic");
  profile.outputs.function = GENERATE(6, 16);
  CAPTURE(wire, profile.outputs.function);
  AnalogModule module(profile, endpoint_of(line.substr(line.rfind(' ') + 1)), 0s, clock, Origin::kSimulated);
  RegulatorOptions options;
  options.command_span.high = options.feedback_span.high = Psi(kSpanPsi);
  Regulator regulator(module, module, options, clock);
  CHECK(fault_id_of([&] { regulator.command(Psi(10.0)); }) == "TB-CHAMBER-NOT-ARMED");
  regulator.arm();
  const auto counts = static_cast<std::uint16_t>(std::lround(30.0 / kSpanPsi * 32767));
  CHECK(regulator.command(Psi(30.0)) == counts);
  CHECK(regulator.feedback().pressure.value() == Approx(30.0).margin(0.01));
  regulator.keep_alive();

  ModbusLink gauge(module.link(), 1, "gauge");
  ModbusQuantity psi;
  psi.address = 100;
  psi.format = {RegisterType::kF32, true};
  CHECK(read_quantity(gauge, psi).value == Approx(30.0).margin(0.01));
  psi.address = 110;
  psi.format.low_word_first = false;
  CHECK(read_quantity(gauge, psi).value == Approx(30.0).margin(0.01));
  std::array<std::uint16_t, 1> beyond{};
  CHECK(fault_id_of([&] { gauge.read_input_registers(4000, beyond); }) == "TB-MODBUS-EXCEPTION");

  CHECK(regulator.vent());
  clock.wait_until(clock.now() + 2 * kSameImage);  // this server falls at once, and an image may be that old
  CHECK(regulator.feedback().pressure.value() == Approx(0.0).margin(0.01));
}
