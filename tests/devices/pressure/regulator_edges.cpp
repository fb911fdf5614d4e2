// The regulator, transducers and corrections before anything is sent: channels, spans and limits at their edges.

#include <catch2/catch.hpp>

#include <cmath>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "devices/pressure/analog_module.h"
#include "devices/pressure/controller_lines.h"
#include "devices/pressure/pressure_reference.h"
#include "devices/pressure/regulator.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;

namespace {

// Not connected: two outputs, three inputs.
struct RegulatorBench {
  RegulatorBench() {
    profile.outputs.channels = 2;
    profile.outputs.volts = {0, 1000, 0, 10};
    profile.inputs.channels = 3;
    options.command_span = options.feedback_span = {Volts(0.0), Volts(10.0), Psi(0.0), Psi(100.0)};
  }
  [[nodiscard]] std::string refused() {
    AnalogModule module(profile, {}, Nanoseconds(0), clock, Origin::kSimulated);
    return fault_id_of([&] { Regulator(module, module, options, clock); });
  }
  // Of a command to a regulator that is not armed.
  [[nodiscard]] std::string commanded(double psi) {
    AnalogModule module(profile, {}, Nanoseconds(0), clock, Origin::kSimulated);
    Regulator regulator(module, module, options, clock);
    return fault_id_of([&] { regulator.command(Psi(psi)); });
  }
  ManualClock clock;
  ModuleProfile profile;
  RegulatorOptions options;
};

}  // namespace

TEST_CASE("regulator: its output and feedback channels must exist in the module") {
  for (const int channel : {-1, 0, 1, 2, 3}) {
    RegulatorBench output, feedback;
    output.options.output_channel = channel;
    feedback.options.feedback_channel = channel;
    CHECK(output.refused() == (channel >= 0 && channel <= 1 ? "none" : "TB-MODULE-CHANNEL"));
    CHECK(feedback.refused() == (channel >= 0 && channel <= 2 ? "none" : "TB-MODULE-CHANNEL"));
  }
}

TEST_CASE("regulator: each of its spans must rise, in volts and in psi") {
  for (const bool command : {true, false}) {
    for (const LinearSpan& falling : {LinearSpan{Volts(0.0), Volts(0.0), Psi(0.0), Psi(100.0)},
                                      LinearSpan{Volts(5.0), Volts(1.0), Psi(0.0), Psi(100.0)},
                                      LinearSpan{Volts(0.0), Volts(10.0), Psi(20.0), Psi(20.0)},
                                      LinearSpan{Volts(1.0), Volts(5.0), Psi(30.0), Psi(20.0)}}) {
      RegulatorBench bench;
      (command ? bench.options.command_span : bench.options.feedback_span) = falling;
      CHECK(bench.refused() == "TB-MODULE-SPAN");
    }
  }
  CHECK(RegulatorBench().refused() == "none");
}

TEST_CASE("regulator: accepts 0 psi up to the limit, both included, within what the output can give") {
  const std::string allowed = "TB-CHAMBER-NOT-ARMED", beyond = "TB-CHAMBER-LIMIT";
  RegulatorBench bench;
  bench.options.command_limit = Psi(60.0);
  for (const double psi : {0.0, 30.0, 60.0}) CHECK(bench.commanded(psi) == allowed);
  for (const double psi : {60.25, -0.25}) CHECK(bench.commanded(psi) == beyond);
  bench.options.command_limit = Psi(200.0);
  CHECK(bench.commanded(100.0) == allowed);  // 10 V, all that the output has
  CHECK(bench.commanded(150.0) == beyond);
  bench.options.command_span.low = Psi(10.0);
  bench.options.command_span.high = Psi(110.0);
  CHECK(bench.commanded(10.0) == allowed);
  CHECK(bench.commanded(0.0) == beyond);  // it needs -1 V
}

TEST_CASE("regulator: starts disarmed, and reports its identity") {
  RegulatorBench bench;
  bench.options.model = "model";
  bench.options.serial = "serial";
  AnalogModule module(bench.profile, {}, Nanoseconds(0), bench.clock, Origin::kSimulated);
  Regulator regulator(module, module, bench.options, bench.clock);
  CHECK_FALSE(regulator.armed());
  CHECK(regulator.identity().role == "regulator");
  CHECK(regulator.identity().model == "model");
  CHECK(regulator.identity().serial == "serial");
  CHECK(regulator.identity().origin == Origin::kHardware);
  CHECK(regulator.last_fed() < Nanoseconds(0));
}

TEST_CASE("transducer: its channel must exist in the module, and its span must rise") {
  RegulatorBench bench;
  AnalogModule module(bench.profile, {}, Nanoseconds(0), bench.clock, Origin::kSimulated);
  TransducerOptions options;
  options.model = "transducer";
  options.serial = "T1";
  options.span = {Volts(0.0), Volts(10.0), Psi(0.0), Psi(100.0)};
  for (const int channel : {-1, 0, 2, 3}) {
    options.channel = channel;
    CHECK(fault_id_of([&] { ModuleTransducer(module, options); }) ==
          (channel < 0 || channel > 2 ? "TB-MODULE-CHANNEL" : "none"));
  }
  options.channel = 1;
  const auto identity = ModuleTransducer(module, options).identity();
  CHECK(identity.role == "pressure reference");
  CHECK(identity.model == "transducer");
  CHECK(identity.serial == "T1");
  options.span.high = Psi(0.0);
  check_fault([&] { ModuleTransducer(module, options); }, "TB-MODULE-SPAN", "pressure reference");
}

TEST_CASE("analog module: volts are rounded to counts and limited to the output's span, and NaN is the lowest count") {
  RegulatorBench bench;
  bench.profile.outputs.volts = {100, 1100, 1, 11};
  const AnalogModule module(bench.profile, {}, Nanoseconds(0), bench.clock, Origin::kSimulated);
  const struct {
    double volts;
    int counts;
  } cases[] = {{1.0, 100},     {1.004, 100}, {1.006, 101}, {0.0, 100},          {-5.0, 100},      {11.0, 1100},
               {10.994, 1099}, {12.0, 1100}, {6.0, 600},   {std::nan(""), 100}, {HUGE_VAL, 1100}, {-HUGE_VAL, 100}};
  for (const auto& [volts, counts] : cases) {
    INFO(volts << " V");
    CHECK(module.counts(Volts(volts)) == counts);
  }
}

TEST_CASE(
    "pressure correction: interpolates, keeps its end values outside the table, and an empty table corrects nothing") {
  PressureCorrection one;
  one.reading_psi = {50.0};
  one.correction_psi = {0.5};
  one.expanded_uncertainty_psi = {0.25};
  for (const double reading : {0.0, 50.0, 100.0}) {
    CHECK(one.corrected(Psi(reading)).value() == Approx(reading + 0.5));
    CHECK(one.expanded_uncertainty(Psi(reading)) == Approx(0.25));
  }
  PressureCorrection three;
  three.reading_psi = {10.0, 20.0, 60.0};
  three.correction_psi = {1.0, 3.0, -1.0};
  three.expanded_uncertainty_psi = {0.1, 0.2, 0.6};
  const struct {
    double reading, correction, uncertainty;
  } rows[] = {{9.0, 1.0, 0.1},  {10.0, 1.0, 0.1}, {12.5, 1.5, 0.125}, {20.0, 3.0, 0.2},
              {30.0, 2.0, 0.3}, {50.0, 0.0, 0.5}, {60.0, -1.0, 0.6},  {61.0, -1.0, 0.6}};
  for (const auto& [reading, correction, uncertainty] : rows) {
    INFO(reading << " psi");
    CHECK(three.corrected(Psi(reading)).value() == Approx(reading + correction));
    CHECK(three.expanded_uncertainty(Psi(reading)) == Approx(uncertainty));
  }
  CHECK(std::isnan(PressureCorrection().expanded_uncertainty(Psi(1.0))));
  CHECK(PressureCorrection().corrected(Psi(7.0)) == Psi(7.0));
}

TEST_CASE("analog module: 0x7FFF counts are 10 V, and every count survives conversion to volts and back") {
  ManualClock clock;
  const AnalogModule module(module_profile("beckhoff-ek9000"), {}, std::chrono::seconds(1), clock, Origin::kSimulated);
  const LinearScale& volts = module.profile().inputs.volts;
  CHECK((volts.physical(0x7FFF) == 10.0 && volts.physical(0) == 0.0 && volts.physical(-0x7FFF) == -10.0));
  CHECK(module.counts(Volts(5.0)) == 16384);  // 16383.5 rounds up
  CHECK(module.counts(Volts(-1.0)) == 0);
  for (int counts = 0; counts <= 0x7FFF; ++counts) {
    if (module.counts(Volts(volts.physical(counts))) != counts) FAIL("counts " << counts << " do not come back");
  }
}

TEST_CASE("regulator span: 60 psi of a 9 bar regulator are 4.596 V, 2 psi 0.1532 V") {
  LinearSpan span;
  span.high = Psi(9.0 * kPsiPerBar);
  CHECK(span.voltage(Psi(60.0)).value() == Approx(4.5965).margin(0.0005));
  CHECK(span.voltage(Psi(2.0)).value() == Approx(0.1532).margin(0.00005));
  CHECK(span.pressure(Volts(10.0)).value() == Approx(130.534).epsilon(1e-5));
  CHECK(span.pressure(span.voltage(Psi(37.5))).value() == Approx(37.5));
  const LinearSpan live_zero{Volts(1.0), Volts(5.0), Psi(0.0), Psi(100.0)};
  CHECK(live_zero.pressure(Volts(3.0)).value() == Approx(50.0));
  CHECK(live_zero.voltage(Psi(0.0)).value() == Approx(1.0));
}

// Codec of the serial pressure controller.

TEST_CASE("controller lines: each request as bytes, and back") {
  const std::vector<std::tuple<char, ControllerRequest, int, std::string>> rows = {
      {'A', {}, 2, "A\r"},
      {'A', {ControllerAct::kSetpoint, 12.34}, 2, "AS12.34\r"},
      {'C', {ControllerAct::kSetpoint, 0.0}, 2, "CS0.00\r"},
      {'A', {ControllerAct::kSetpoint, 60.0}, 0, "AS60\r"},
      {'A', {ControllerAct::kExhaust}, 2, "AE\r"},
      {'Z', {ControllerAct::kCancel}, 2, "ZC\r"}};
  for (const auto& [unit, request, decimals, bytes] : rows) {
    INFO(bytes);
    CHECK(encode_request(unit, request, decimals) == bytes);
    const auto back = decode_request(std::string_view(bytes).substr(0, bytes.size() - 1), unit);
    REQUIRE(back);
    CHECK(back->act == request.act);
    CHECK(back->setpoint == request.setpoint);
    CHECK_FALSE(decode_request(std::string_view(bytes).substr(0, bytes.size() - 1), unit == 'B' ? 'D' : 'B'));
  }
  CHECK(decode_request("AS 5.5", 'A')->setpoint == 5.5);
  for (const char* line : {"", "AS", "AS ", "ASx", "AS1.2.3", "AX", "AEE", "ASnan", "ASinf"}) {
    INFO(line);
    CHECK_FALSE(decode_request(line, 'A'));
  }
}

TEST_CASE("controller lines: an answer has pressure, set-point and status, other text is not an answer") {
  struct Row {
    const char* line;
    ControllerFields fields;
    std::optional<std::tuple<double, double, std::vector<std::string>>> frame;
    bool refused = false;
  };
  using Lines = std::vector<std::string>;
  const std::vector<Row> rows = {
      {"A +012.34 +012.30", {}, {{12.34, 12.30, Lines{}}}},
      {"A -000.05 +000.00 EXH", {}, {{-0.05, 0.0, Lines{"EXH"}}}},
      {"A   012.34  0.00  HLD POV", {}, {{12.34, 0.0, Lines{"HLD", "POV"}}}},
      {"A +012.34 +023.4 +000.1 +000.2 12.34 Air OVR", {1, 5}, {{12.34, 12.34, Lines{"Air", "OVR"}}}},
      {"A +1 +2 +3", {3, 1}, {{3.0, 1.0, Lines{}}}},
      {"?", {}, std::nullopt, true},
      {"A ?", {}, std::nullopt, true},
      {"B +012.34 +012.30", {}, std::nullopt},
      {"A +012.34", {}, std::nullopt},
      {"A +012.34 +01", {2, 3}, std::nullopt},
      {"A +01#.34 +012.30", {}, std::nullopt},
      {"A +012.34 ----", {}, std::nullopt},
      {"A nan +012.30", {}, std::nullopt},
      {"AB +012.34 +012.30", {}, std::nullopt},
      {"", {}, std::nullopt}};
  for (const Row& row : rows) {
    INFO(row.line);
    const ControllerAnswer answer = decode_answer(row.line, 'A', row.fields);
    CHECK(answer.refused == row.refused);
    REQUIRE(answer.frame.has_value() == row.frame.has_value());
    if (!row.frame) continue;
    CHECK(answer.frame->pressure == std::get<0>(*row.frame));
    CHECK(answer.frame->setpoint == std::get<1>(*row.frame));
    CHECK(answer.frame->status == std::get<2>(*row.frame));
  }
}

TEST_CASE("controller lines: an answer of the simulated controller is read back to the last decimal") {
  for (const int decimals : {0, 1, 2}) {
    const std::string line = encode_answer('K', {-3.0, 60.0, {"EXH"}}, decimals);
    REQUIRE(line.back() == '\r');
    const auto frame = decode_answer(std::string_view(line).substr(0, line.size() - 1), 'K', {}).frame;
    REQUIRE(frame);
    CHECK(frame->pressure == -3.0);
    CHECK(frame->setpoint == 60.0);
    CHECK(frame->has("EXH"));
    CHECK_FALSE(frame->has("HLD"));
  }
  CHECK(encode_answer('A', {12.344, 0.5, {}}, 2) == "A +012.34 +000.50\r");
}
