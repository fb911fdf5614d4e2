// Modbus RTU on a pseudo-terminal: the simulated line, and a scripted one that answers late, short, damaged, or for
// another unit.
#include <atomic>
#include <catch2/catch.hpp>
#include <functional>
#include <vector>

#include "devices/pressure/analog_module.h"
#include "devices/pressure/regulator.h"
#include "devices/pressure/simulated_module.h"
#include "devices/wire/modbus/modbus_link.h"
#include "tests/devices/scripted_line.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

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
