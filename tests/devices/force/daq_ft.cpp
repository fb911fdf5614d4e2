#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "devices/force/daq_ft.h"
#include "devices/force/daqmx_gauges.h"
#include "tests/devices/daqmx_card.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/force/invented_calibration.h"
#include "tests/support/paths.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using tactbench::tests::FakeDaqmx;

namespace {

using Rows = std::vector<std::vector<double>>;

// Gives rows in turn, in the shape requested.
class Gauges final : public GaugeSource {
 public:
  explicit Gauges(Rows rows) : rows_(std::move(rows)) {}
  GaugeSamples read(int samples) override {
    if (broken) throw Fault("TB-DAQMX-ERROR", "analog input", "the card says no", "Mend it.");
    GaugeSamples set{samples, channels(), {}, Nanoseconds(5)};
    for (int i = 0; i < samples; ++i) {
      const auto& row = rows_[next_++ % rows_.size()];
      set.volts.insert(set.volts.end(), row.begin(), row.end());
    }
    ++reads_;
    return set;
  }
  [[nodiscard]] int channels() const override { return static_cast<int>(rows_.front().size()); }
  [[nodiscard]] std::uint64_t exchanges() const override { return reads_; }
  [[nodiscard]] Identity identity() const override { return {"analog input", "card", "C1", "", Origin::kSimulated}; }
  bool broken = false;

 private:
  Rows rows_;
  std::size_t next_ = 0;
  std::uint64_t reads_ = 0;
};

AtiCalibration calibration(const char* more = "") {
  InventedCalibration invented;
  invented.more = more;
  return parse_ati_calibration(invented.text(), "test.cal");
}

Vector6 axes_of(const Wrench& wrench) {
  Vector6 axes;
  for (int i = 0; i < 3; ++i) {
    axes[i] = wrench.force_n[static_cast<std::size_t>(i)];
    axes[i + 3] = wrench.torque_nmm[static_cast<std::size_t>(i)];
  }
  return axes;
}

const std::vector<double> kOne{0.1, -0.2, 0.3, 0.05, -0.15, 0.25};
const std::vector<double> kTwo{0.3, -0.1, 0.1, 0.15, -0.05, 0.15};
const std::vector<double> kMean{0.2, -0.15, 0.2, 0.1, -0.1, 0.2};

Vector6 vector(const std::vector<double>& values) { return Vector6::Map(values.data()); }

}  // namespace

TEST_CASE("DAQ F/T: a reading is the mean of its samples times the matrix, and includes the mean gauge voltages") {
  DaqFt sensor(std::make_unique<Gauges>(Rows{kOne, kTwo}), calibration(), {});
  const auto reading = sensor.read(2);
  CHECK(reading.records == 2);
  CHECK(reading.time == Nanoseconds(5));
  CHECK_FALSE(reading.thermistor_v);
  for (std::size_t i = 0; i < 6; ++i) CHECK(reading.raw[i] == Approx(kMean[i]));
  const Vector6 expected = working_matrix(calibration()) * vector(kMean);
  CHECK((axes_of(reading.wrench) - expected).cwiseAbs().maxCoeff() < 1e-9);
  CHECK(sensor.exchanges() == 1);
  CHECK(sensor.calibration_serial() == "FT99901");
  CHECK(sensor.range() == SixAxes{50, 50, 70, 500, 500, 500});
  CHECK(sensor.identity().origin == Origin::kSimulated);
  CHECK(fault_id_of([&] { (void)sensor.read(0); }) == "TB-FORCE-RECORDS");
}

TEST_CASE("DAQ F/T: the bias is subtracted from the gauge voltages, then the tool transform is applied") {
  DaqFtOptions options;
  options.tool = {{0, 0, 10}, {0, 0, 90}};
  DaqFt sensor(std::make_unique<Gauges>(Rows{kOne, kTwo}), calibration(), options);
  const Matrix6 matrix = wrench_transform(options.tool) * working_matrix(calibration());
  CHECK((axes_of(sensor.bias(1).wrench) - matrix * vector(kOne)).cwiseAbs().maxCoeff() < 1e-9);
  const auto reading = sensor.read(1);
  CHECK((axes_of(reading.wrench) - matrix * (vector(kTwo) - vector(kOne))).cwiseAbs().maxCoeff() < 1e-9);
  CHECK(reading.raw[0] == 0.3);
}

TEST_CASE("DAQ F/T: temperature is compensated if the calibration and the thermistor allow it, unless switched off") {
  auto warm = kOne, warmer = kTwo;
  warm.push_back(1.5);
  warmer.push_back(1.75);
  const auto with = calibration(kInventedTemperature);
  DaqFt sensor(std::make_unique<Gauges>(Rows{warm, warmer}), with, {});
  const auto reading = sensor.read(2);
  const Vector6 expected =
      working_matrix(with) *
      ((compensated(*with.temperature, vector(kOne), 1.5) + compensated(*with.temperature, vector(kTwo), 1.75)) / 2);
  CHECK((axes_of(reading.wrench) - expected).cwiseAbs().maxCoeff() < 1e-9);
  CHECK(reading.thermistor_v == 1.625);
  CHECK(reading.raw[0] == Approx(kMean[0]));
  DaqFtOptions off;
  off.temperature_compensation = false;
  DaqFt plain(std::make_unique<Gauges>(Rows{kOne}), with, off);
  CHECK((axes_of(plain.read(1).wrench) - working_matrix(with) * vector(kOne)).cwiseAbs().maxCoeff() < 1e-9);
}

TEST_CASE("DAQ F/T: a load beyond the rated range is an overload fault, judged relative to the bias") {
  const std::vector<double> heavy{0, 0, 3, 0, 3, 3};  // Fz = (22.25 + 24.125 - 1.25) * 3 / 2.75 = 49.2 N
  const std::vector<double> heavier{0, 0, 5, 0, 5, 5};
  DaqFt sensor(std::make_unique<Gauges>(Rows{heavy, heavier}), calibration(), {});
  CHECK(sensor.read(1).wrench.force_n[2] == Approx(49.227).margin(0.001));
  check_fault([&] { (void)sensor.read(1); }, "TB-FORCE-OVERLOAD", {}, "82.05 N");
  DaqFt biased(std::make_unique<Gauges>(Rows{heavy, heavier}), calibration(), {});
  biased.bias(1);
  CHECK(fault_id_of([&] { (void)biased.read(1); }) == "none");
}

TEST_CASE("DAQ F/T: faults of the gauge source pass through, and another serial number is refused") {
  auto gauges = std::make_unique<Gauges>(Rows{kOne});
  Gauges& source = *gauges;
  DaqFt sensor(std::move(gauges), calibration(), {});
  source.broken = true;
  CHECK(fault_id_of([&] { (void)sensor.read(1); }) == "TB-DAQMX-ERROR");
  DaqFtOptions options;
  options.expected_serial = "FT00000";
  CHECK(fault_id_of([&] { DaqFt(std::make_unique<Gauges>(Rows{kOne}), calibration(), options); }) == "TB-FORCE-SERIAL");
}

namespace {

// Says what it is told to say.
class ScriptedGauges final : public GaugeSource {
 public:
  ScriptedGauges(int channels, GaugeSamples told) : channels_(channels), told_(std::move(told)) {}
  GaugeSamples read(int /*samples*/) override { return told_; }
  [[nodiscard]] int channels() const override { return channels_; }
  [[nodiscard]] std::uint64_t exchanges() const override { return 1; }
  [[nodiscard]] Identity identity() const override { return {"gauge source", "NI 6210", "C1", "", Origin::kSimulated}; }

 private:
  int channels_;
  GaugeSamples told_;
};

std::string read_of(int channels, GaugeSamples told, int asked = 1, DaqFtOptions options = {}) {
  DaqFt sensor(std::make_unique<ScriptedGauges>(channels, std::move(told)), calibration(), std::move(options));
  return fault_id_of([&] { (void)sensor.read(asked); });
}

GaugeSamples one_of(std::vector<double> volts) {
  const int channels = static_cast<int>(volts.size());
  return {1, channels, std::move(volts), Nanoseconds(0)};
}

}  // namespace

TEST_CASE("DAQ F/T: a gauge source that returns a wrong number of samples, channels or values is a protocol fault") {
  const std::vector<double> twelve(12, 0.25), fourteen(14, 0.25);
  CHECK(read_of(6, {2, 6, twelve, {}}, 2) == "none");
  CHECK(read_of(6, {1, 6, twelve, {}}, 2) == "TB-FORCE-PROTOCOL");
  CHECK(read_of(6, {2, 7, twelve, {}}, 2) == "TB-FORCE-PROTOCOL");
  CHECK(read_of(6, {2, 6, fourteen, {}}, 2) == "TB-FORCE-PROTOCOL");
  CHECK(read_of(6, {2, 6, {}, {}}, 2) == "TB-FORCE-PROTOCOL");
  CHECK(read_of(6, {2, 6, std::vector<double>(11), {}}, 2) == "TB-FORCE-PROTOCOL");
}

TEST_CASE("DAQ F/T: six or seven channels are required, and seven for temperature compensation") {
  const auto opened = [](int channels, const AtiCalibration& file, bool compensated) {
    DaqFtOptions options;
    options.temperature_compensation = compensated;
    return fault_id_of([&] { DaqFt(std::make_unique<ScriptedGauges>(channels, GaugeSamples{}), file, options); });
  };
  for (const bool compensated : {false, true}) {
    CHECK(opened(6, calibration(), compensated) == "none");
    CHECK(opened(7, calibration(), compensated) == "none");
    CHECK(opened(7, calibration(kInventedTemperature), compensated) == "none");
    CHECK(opened(5, calibration(), compensated) == "TB-FORCE-GAUGES");
    CHECK(opened(8, calibration(), compensated) == "TB-FORCE-GAUGES");
  }
  CHECK(opened(6, calibration(kInventedTemperature), false) == "none");
  CHECK(opened(6, calibration(kInventedTemperature), true) == "TB-FORCE-GAUGES");
}

TEST_CASE("DAQ F/T: a gauge is saturated at the set share of the converter's limit, the thermistor never") {
  DaqFtOptions options;
  options.converter_limit = Volts(0.5);
  options.saturation_share = 0.5;  // 0.25 V
  for (std::size_t gauge = 0; gauge < 6; ++gauge) {
    for (const double sign : {1.0, -1.0}) {
      std::vector<double> volts(7, 0.0);
      volts[6] = 12.0;
      volts[gauge] = sign * std::nextafter(0.25, 0.0);
      CHECK(read_of(7, one_of(volts), 1, options) == "none");
      volts[gauge] = sign * 0.25;
      CHECK(read_of(7, one_of(volts), 1, options) == "TB-FORCE-SATURATED");
    }
    std::vector<double> volts(6, 0.0);
    volts[gauge] = std::nan("");
    DaqFt sensor(std::make_unique<ScriptedGauges>(6, one_of(volts)), calibration(), {});
    check_fault([&] { (void)sensor.read(1); }, "TB-FORCE-SATURATED", {}, "G" + std::to_string(gauge));
  }
}

TEST_CASE("DAQ F/T: the thermistor is reported even without compensation, and the identity names the card") {
  const GaugeSamples told{
      2, 7, {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 1.5, 0.3, 0.2, 0.1, 0.0, -0.1, -0.2, 2.5}, Nanoseconds(9)};
  DaqFt sensor(std::make_unique<ScriptedGauges>(7, told), calibration(), {});
  const ForceReading reading = sensor.read(2);
  REQUIRE(reading.thermistor_v);
  CHECK(*reading.thermistor_v == Approx(2.0));
  CHECK((reading.raw[0] == Approx(0.2) && reading.raw[5] == Approx(0.2) && reading.raw[3] == Approx(0.2)));
  CHECK((reading.time == Nanoseconds(9) && reading.records == 2));
  const Identity identity = sensor.identity();
  CHECK((identity.role == "force sensor" && identity.serial == "FT99901" && identity.firmware == "NI 6210 C1"));
}

namespace {

struct GaugeRig : DaqmxCard {
  GaugeRig() {
    card.volts = [](const FakeDaqmx::Levels&, int channel, int sample) { return channel + 0.001 * sample; };
    options.library = tactbench::tests::fake_nidaqmx_path();
    options.sample_rate_hz = 1000;
    options.timeout = 300ms;
  }
  DaqmxGaugesOptions options;
};

}  // namespace

TEST_CASE("daqmx gauges: the read timeout is the reply time plus the duration of the samples") {
  GaugeRig rig;
  rig.options.channels = "Dev1/ai16:21,Dev1/ai30";
  CHECK(DaqmxGauges(rig.options, rig.clock).read(2).volts[13] == 6 + 0.001);
  rig.options.channels = "Dev1/ai16:21";
  rig.clock.wait_until(3s);
  DaqmxGauges gauges(rig.options, rig.clock);
  CHECK(gauges.channels() == 6);
  for (const auto& [samples, seconds] : {std::pair{1, 0.301}, {200, 0.5}, {50, 0.35}}) {
    const GaugeSamples read = gauges.read(samples);
    CHECK((read.samples == samples && read.channels == 6 && read.time == 3s));
    REQUIRE(read.volts.size() == static_cast<std::size_t>(6 * samples));
    CHECK((read.volts.front() == 0.0 && read.volts.back() == 5 + 0.001 * (samples - 1)));
    CHECK(rig.card.timeout == Approx(seconds).epsilon(1e-12));
    CHECK(rig.card.rate == 1000.0);
  }
  CHECK((rig.card.minimum == -10.0 && rig.card.maximum == 10.0 && rig.card.terminal == 10106));
  CHECK(rig.clock.now() == 3s);
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

TEST_CASE("daqmx gauges: five or eight channels are refused, and the fault states the number") {
  GaugeRig rig;
  for (const auto& [channels, number] : {std::pair{"Dev1/ai0:4", 5}, {"Dev1/ai0:7", 8}}) {
    rig.options.channels = channels;
    check_fault([&] { DaqmxGauges(rig.options, rig.clock); }, "TB-DAQMX-CHANNELS", "Dev1", std::to_string(number));
  }
}

TEST_CASE("daqmx gauges: only a sample timeout advances the clock, and every failed reading stops the task") {
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

TEST_CASE("daqmx gauges: sample timing that could not be set up is set up again by the next reading") {
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
