// Gauges on an NI card: how long a reading may take, what a failure leaves behind, and what the next reading sets up.
#include "devices/force/daqmx_gauges.h"

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/devices/fault_of.h"
#include "tests/support/fake_nidaqmx/fake_nidaqmx.h"
#include "tests/support/paths.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using tactbench::tests::fake_daqmx;
using tactbench::tests::FakeDaqmx;

namespace {

struct GaugeRig {
  GaugeRig() {
    card = FakeDaqmx{};
    card.volts = [](const FakeDaqmx::Levels&, int channel, int sample) { return channel + 0.001 * sample; };
    options.library = tactbench::tests::fake_nidaqmx_path();
    options.sample_rate_hz = 1000;
    options.timeout = 300ms;
  }
  ~GaugeRig() {
    CHECK(card.tasks == 0);
    CHECK(card.misuse.empty());
  }
  GaugeRig(const GaugeRig&) = delete;
  GaugeRig& operator=(const GaugeRig&) = delete;
  [[nodiscard]] auto called(const std::string& function) const {
    return std::count(card.calls.begin(), card.calls.end(), function);
  }
  // The next call of this function and all later ones fail.
  void fail(const std::string& function, int code) const {
    card.fail_function = function;
    card.fail_code = code;
    card.fail_call = static_cast<int>(called(function));
  }
  FakeDaqmx& card = fake_daqmx();
  TurnedClock clock;
  DaqmxGaugesOptions options;
};

}  // namespace

TEST_CASE("daqmx gauges told: a reading may take its time and that of its samples") {
  GaugeRig rig;
  DaqmxGauges gauges(rig.options, rig.clock);
  for (const auto& [samples, seconds] : {std::pair{1, 0.301}, {200, 0.5}, {50, 0.35}}) {
    CHECK(gauges.read(samples).volts.size() == static_cast<std::size_t>(6 * samples));
    CHECK(rig.card.timeout == Approx(seconds).epsilon(1e-12));
    CHECK(rig.card.rate == 1000.0);
  }
  CHECK((rig.card.minimum == -10.0 && rig.card.maximum == 10.0));
  CHECK(rig.clock.now() == 0s);
  CHECK(gauges.exchanges() == 3);
  const Identity identity = gauges.identity();
  CHECK((identity.role == "gauge source" && identity.model == "NI USB-6259" && identity.serial == "01A2B3C4"));
  CHECK((identity.firmware.empty() && identity.origin == Origin::kHardware));
  rig.card.devices[0].simulated = true;
  CHECK(DaqmxGauges(rig.options, rig.clock).identity().origin == Origin::kSimulated);
  CHECK_THROWS_AS(gauges.read(0), std::invalid_argument);
  CHECK_THROWS_AS(gauges.read(-1), std::invalid_argument);
  CHECK(gauges.exchanges() == 3);
}

TEST_CASE("daqmx gauges told: five and eight channels are refused, by their number") {
  GaugeRig rig;
  for (const auto& [channels, number] : {std::pair{"Dev1/ai0:4", 5}, {"Dev1/ai0:7", 8}}) {
    rig.options.channels = channels;
    check_fault([&] { DaqmxGauges(rig.options, rig.clock); }, "TB-DAQMX-CHANNELS", "Dev1", std::to_string(number));
  }
}

TEST_CASE("daqmx gauges told: only samples that did not come in time cost time, and every failure stops the task") {
  for (const auto& [code, cost] : {std::pair{-200284, 310ms}, {-200279, 0ms}, {-50103, 0ms}}) {
    GaugeRig rig;
    DaqmxGauges gauges(rig.options, rig.clock);
    rig.fail("ReadAnalogF64", code);
    const auto stops = rig.called("StopTask");
    CHECK(fault_id_of([&] { (void)gauges.read(10); }) == "TB-DAQMX-ERROR");
    CHECK(rig.clock.now() == cost);
    CHECK(rig.called("StopTask") == stops + 1);
    rig.card.fail_function.clear();
    CHECK(gauges.read(10).volts.size() == 60);
    CHECK(rig.called("StopTask") == stops + 2);
    CHECK(gauges.exchanges() == 2);
    CHECK(rig.called("CfgSampClkTiming") == 1);  // as many samples as before: nothing to set up
  }
  GaugeRig rig;
  DaqmxGauges gauges(rig.options, rig.clock);
  rig.fail("StartTask", -50103);
  CHECK(fault_id_of([&] { (void)gauges.read(10); }) == "TB-DAQMX-ERROR");
  CHECK(rig.called("StopTask") == 1);
  rig.card.fail_function.clear();
  rig.card.short_by = 1;
  CHECK(fault_id_of([&] { (void)gauges.read(10); }) == "TB-DAQMX-SHORT");
  CHECK(rig.clock.now() == 0s);
  CHECK(rig.called("StopTask") == 2);
}

TEST_CASE("daqmx gauges told: a number of samples that could not be set up is set up again") {
  GaugeRig rig;
  DaqmxGauges gauges(rig.options, rig.clock);
  (void)gauges.read(10);
  for (const std::string function : {"TaskControl", "CfgSampClkTiming"}) {
    rig.fail(function, -50103);
    CHECK(fault_id_of([&] { (void)gauges.read(20); }) == "TB-DAQMX-ERROR");
    rig.card.fail_function.clear();
    const auto timings = rig.called("CfgSampClkTiming"), commits = rig.called("TaskControl");
    CHECK(gauges.read(10).volts.size() == 60);
    CHECK(rig.called("CfgSampClkTiming") == timings + 1);
    CHECK(rig.called("TaskControl") == commits + 1);
  }
}
