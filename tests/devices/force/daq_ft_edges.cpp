// The driver of the DAQ F/T at the bounds of its source's answers.
#include <catch2/catch.hpp>
#include <cmath>

#include "devices/force/daq_ft.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/force/invented_calibration.h"

using namespace tactbench::devices;

namespace {

// Says what it is told to say.
class ToldGauges final : public GaugeSource {
 public:
  ToldGauges(int channels, GaugeSamples told) : channels_(channels), told_(std::move(told)) {}
  GaugeSamples read(int /*samples*/) override { return told_; }
  [[nodiscard]] int channels() const override { return channels_; }
  [[nodiscard]] std::uint64_t exchanges() const override { return 1; }
  [[nodiscard]] Identity identity() const override { return {"gauge source", "NI 6210", "C1", "", Origin::kSimulated}; }

 private:
  int channels_;
  GaugeSamples told_;
};

AtiCalibration invented(const char* more = "") {
  InventedCalibration calibration;
  calibration.more = more;
  return parse_ati_calibration(calibration.text(), "test.cal");
}

std::string read_of(int channels, GaugeSamples told, int asked = 1, DaqFtOptions options = {}) {
  DaqFt sensor(std::make_unique<ToldGauges>(channels, std::move(told)), invented(), std::move(options));
  return fault_id_of([&] { (void)sensor.read(asked); });
}

GaugeSamples one_of(std::vector<double> volts) {
  const int channels = static_cast<int>(volts.size());
  return {1, channels, std::move(volts), Nanoseconds(0)};
}

}  // namespace

TEST_CASE("DAQ F/T: samples, channels and values have to be as many as were asked for, each of them") {
  const std::vector<double> twelve(12, 0.25), fourteen(14, 0.25);
  CHECK(read_of(6, {2, 6, twelve, {}}, 2) == "none");
  CHECK(read_of(6, {1, 6, twelve, {}}, 2) == "TB-FORCE-PROTOCOL");
  CHECK(read_of(6, {2, 7, twelve, {}}, 2) == "TB-FORCE-PROTOCOL");
  CHECK(read_of(6, {2, 6, fourteen, {}}, 2) == "TB-FORCE-PROTOCOL");
  CHECK(read_of(6, {2, 6, {}, {}}, 2) == "TB-FORCE-PROTOCOL");
}

TEST_CASE("DAQ F/T: six gauges are enough unless the temperature is compensated, seven always") {
  const auto opened = [](int channels, const AtiCalibration& calibration, bool compensated) {
    DaqFtOptions options;
    options.temperature_compensation = compensated;
    return fault_id_of([&] { DaqFt(std::make_unique<ToldGauges>(channels, GaugeSamples{}), calibration, options); });
  };
  for (const bool compensated : {false, true}) {
    CHECK(opened(6, invented(), compensated) == "none");
    CHECK(opened(7, invented(), compensated) == "none");
    CHECK(opened(7, invented(kInventedTemperature), compensated) == "none");
    CHECK(opened(5, invented(), compensated) == "TB-FORCE-GAUGES");
    CHECK(opened(8, invented(), compensated) == "TB-FORCE-GAUGES");
  }
  CHECK(opened(6, invented(kInventedTemperature), false) == "none");
  CHECK(opened(6, invented(kInventedTemperature), true) == "TB-FORCE-GAUGES");
}

TEST_CASE("DAQ F/T: a gauge saturates at its share of the converter's limit, the thermistor nowhere") {
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
  }
}

TEST_CASE("DAQ F/T: a thermistor is reported where nothing is compensated, and the card is named") {
  const GaugeSamples told{
      2, 7, {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 1.5, 0.3, 0.2, 0.1, 0.0, -0.1, -0.2, 2.5}, Nanoseconds(9)};
  DaqFt sensor(std::make_unique<ToldGauges>(7, told), invented(), {});
  const ForceReading reading = sensor.read(2);
  REQUIRE(reading.thermistor_v);
  CHECK(*reading.thermistor_v == Approx(2.0));
  CHECK((reading.raw[0] == Approx(0.2) && reading.raw[5] == Approx(0.2) && reading.raw[3] == Approx(0.2)));
  CHECK((reading.time == Nanoseconds(9) && reading.records == 2));
  const Identity identity = sensor.identity();
  CHECK((identity.role == "force sensor" && identity.serial == "FT99901" && identity.firmware == "NI 6210 C1"));
}
