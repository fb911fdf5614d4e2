// The regulator, transducers and corrections before anything is sent: channels, spans and limits at their edges, and
// what each refusal says.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "devices/pressure/pressure_reference.h"
#include "devices/pressure/regulator.h"
#include "tests/devices/fault_of.h"

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
    const auto fault = fault_of([&] { Regulator(module, module, options, clock); });
    return fault ? fault->id() + ": " + fault->what() : "";
  }
  // What a command says to a regulator that is not armed.
  [[nodiscard]] std::string says(double psi) {
    AnalogModule module(profile, {}, Nanoseconds(0), clock, Origin::kSimulated);
    Regulator regulator(module, module, options, clock);
    const auto fault = fault_of([&] { regulator.command(Psi(psi)); });
    REQUIRE(fault);
    return fault->id() + ": " + fault->what();
  }
  TurnedClock clock;
  ModuleProfile profile;
  RegulatorOptions options;
};

}  // namespace

TEST_CASE("regulator: each of its channels is one of the module's, from 0") {
  for (const int channel : {-1, 0, 1, 2}) {
    RegulatorBench bench;
    bench.options.output_channel = channel;
    CHECK(bench.refused() == (channel >= 0 && channel <= 1
                                  ? std::string()
                                  : "TB-MODULE-CHANNEL: output channel " + std::to_string(channel) +
                                        " of the regulator was requested, the module has 2"));
  }
  for (const int channel : {-1, 0, 2, 3}) {
    RegulatorBench bench;
    bench.options.feedback_channel = channel;
    CHECK(bench.refused() == (channel >= 0 && channel <= 2
                                  ? std::string()
                                  : "TB-MODULE-CHANNEL: feedback channel " + std::to_string(channel) +
                                        " of the regulator was requested, the module has 3"));
  }
}

TEST_CASE("regulator: each of its spans rises, in volts and in psi") {
  for (const bool command : {true, false}) {
    const LinearSpan falling[] = {{Volts(0.0), Volts(0.0), Psi(0.0), Psi(100.0)},
                                  {Volts(5.0), Volts(1.0), Psi(0.0), Psi(100.0)},
                                  {Volts(0.0), Volts(10.0), Psi(20.0), Psi(20.0)},
                                  {Volts(1.0), Volts(5.0), Psi(30.0), Psi(20.0)}};
    const std::string says[] = {"from 0 V = 0 psi to 0 V = 100 psi", "from 5 V = 0 psi to 1 V = 100 psi",
                                "from 0 V = 20 psi to 10 V = 20 psi", "from 1 V = 30 psi to 5 V = 20 psi"};
    for (std::size_t i = 0; i < 4; ++i) {
      RegulatorBench bench;
      (command ? bench.options.command_span : bench.options.feedback_span) = falling[i];
      CHECK(bench.refused() == "TB-MODULE-SPAN: the regulator's span " + says[i] + " does not rise");
    }
  }
  CHECK(RegulatorBench().refused().empty());
}

TEST_CASE("regulator: from 0 psi to the limit, both included, and only what the output can give") {
  const std::string not_armed =
      "TB-CHAMBER-NOT-ARMED: {:g} psi was requested while the regulator is not armed; nothing was sent";
  RegulatorBench bench;
  bench.options.command_limit = Psi(60.0);
  for (const double psi : {0.0, 30.0, 60.0}) CHECK(bench.says(psi) == fmt::format(fmt::runtime(not_armed), psi));
  CHECK(bench.says(60.25) == "TB-CHAMBER-LIMIT: 60.25 psi was requested, allowed is 0 to 60 psi; nothing was sent");
  CHECK(bench.says(-0.25) == "TB-CHAMBER-LIMIT: -0.25 psi was requested, allowed is 0 to 60 psi; nothing was sent");
  bench.options.command_limit = Psi(200.0);
  CHECK(bench.says(100.0) == fmt::format(fmt::runtime(not_armed), 100.0));  // 10 V, all that the output has
  CHECK(bench.says(150.0) ==
        "TB-CHAMBER-LIMIT: 150 psi was requested, which needs 15 V of an output of 0 to 10 V; nothing was sent");
  bench.options.command_span.low = Psi(10.0);
  bench.options.command_span.high = Psi(110.0);
  CHECK(bench.says(10.0) == fmt::format(fmt::runtime(not_armed), 10.0));
  CHECK(bench.says(0.0) ==
        "TB-CHAMBER-LIMIT: 0 psi was requested, which needs -1 V of an output of 0 to 10 V; nothing was sent");
}

TEST_CASE("regulator: disarmed by hand, and its identity") {
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

TEST_CASE("transducer: its channel is one of the module's, and its span rises") {
  RegulatorBench bench;
  AnalogModule module(bench.profile, {}, Nanoseconds(0), bench.clock, Origin::kSimulated);
  TransducerOptions options;
  options.model = "transducer";
  options.serial = "T1";
  options.span = {Volts(0.0), Volts(10.0), Psi(0.0), Psi(100.0)};
  for (const int channel : {-1, 0, 2, 3}) {
    options.channel = channel;
    const auto fault = fault_of([&] { ModuleTransducer(module, options); });
    CHECK(fault.has_value() == (channel < 0 || channel > 2));
    if (fault) {
      CHECK(fault->id() == "TB-MODULE-CHANNEL");
      CHECK(fault->device() == "pressure reference");
      CHECK(fault->what() ==
            "input channel " + std::to_string(channel) + " of the pressure reference was requested, the module has 3");
    }
  }
  options.channel = 1;
  const auto identity = ModuleTransducer(module, options).identity();
  CHECK(identity.role == "pressure reference");
  CHECK(identity.model == "transducer");
  CHECK(identity.serial == "T1");
  options.span.high = Psi(0.0);
  const auto fault = fault_of([&] { ModuleTransducer(module, options); });
  REQUIRE(fault);
  CHECK(fault->id() == "TB-MODULE-SPAN");
  CHECK(fault->what() == std::string("the pressure reference's span from 0 V = 0 psi to 10 V = 0 psi does not rise"));
}

TEST_CASE("analog module: counts of volts, nearest, clipped to the output's span, no number is its lowest") {
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

TEST_CASE("correction: a table of one point, of points at its ends, and of none") {
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
