#include "devices/force/daq_ft.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/devices/force/invented_calibration.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;

namespace {

using Rows = std::vector<std::vector<double>>;

// Gives rows in turn, in the shape requested; `shape_lie` leaves one value out.
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
    if (shape_lie) set.volts.pop_back();
    ++reads_;
    return set;
  }
  [[nodiscard]] int channels() const override { return static_cast<int>(rows_.front().size()); }
  [[nodiscard]] std::uint64_t exchanges() const override { return reads_; }
  [[nodiscard]] Identity identity() const override { return {"analog input", "card", "C1", "", Origin::kSimulated}; }
  bool broken = false;
  bool shape_lie = false;

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

TEST_CASE("DAQ F/T: the mean of the samples through the matrix, volts beside it") {
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

TEST_CASE("DAQ F/T: bias is a vector of volts, the tool's frame applies to the rest") {
  DaqFtOptions options;
  options.tool = {{0, 0, 10}, {0, 0, 90}};
  DaqFt sensor(std::make_unique<Gauges>(Rows{kOne, kTwo}), calibration(), options);
  const Matrix6 matrix = wrench_transform(options.tool) * working_matrix(calibration());
  CHECK((axes_of(sensor.bias(1)) - matrix * vector(kOne)).cwiseAbs().maxCoeff() < 1e-9);
  const auto reading = sensor.read(1);
  CHECK((axes_of(reading.wrench) - matrix * (vector(kTwo) - vector(kOne))).cwiseAbs().maxCoeff() < 1e-9);
  CHECK(reading.raw[0] == 0.3);
}

TEST_CASE("DAQ F/T: temperature is compensated where file and thermistor allow it") {
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

  CHECK(fault_id_of([&] { DaqFt(std::make_unique<Gauges>(Rows{kOne}), with, {}); }) == "TB-FORCE-GAUGES");
  DaqFtOptions off;
  off.temperature_compensation = false;
  DaqFt plain(std::make_unique<Gauges>(Rows{kOne}), with, off);
  CHECK((axes_of(plain.read(1).wrench) - working_matrix(with) * vector(kOne)).cwiseAbs().maxCoeff() < 1e-9);
  CHECK(fault_id_of([&] { DaqFt(std::make_unique<Gauges>(Rows{std::vector<double>(5)}), with, off); }) ==
        "TB-FORCE-GAUGES");
}

TEST_CASE("DAQ F/T: a gauge at the converter's limit is a fault that names it") {
  for (const double volts : {9.995, -10.0, std::nan("")}) {
    auto railed = kOne;
    railed[3] = volts;
    DaqFt sensor(std::make_unique<Gauges>(Rows{kOne, railed}), calibration(), {});
    CHECK(fault_id_of([&] { (void)sensor.read(1); }) == "none");
    check_fault([&] { (void)sensor.read(1); }, "TB-FORCE-SATURATED", {}, "G3");
  }
}

TEST_CASE("DAQ F/T: overload is judged for every sample, in the transducer's frame, from the bias on") {
  const std::vector<double> heavy{0, 0, 3, 0, 3, 3};  // Fz = (22.25 + 24.125 - 1.25) * 3 / 2.75 = 49.2 N
  const std::vector<double> heavier{0, 0, 5, 0, 5, 5};
  DaqFt sensor(std::make_unique<Gauges>(Rows{heavy, heavier}), calibration(), {});
  CHECK(sensor.read(1).wrench.force_n[2] == Approx(49.227).margin(0.001));
  check_fault([&] { (void)sensor.read(1); }, "TB-FORCE-OVERLOAD", {}, "82.05 N");
  DaqFt biased(std::make_unique<Gauges>(Rows{heavy, heavier}), calibration(), {});
  biased.bias(1);
  CHECK(fault_id_of([&] { (void)biased.read(1); }) == "none");
}

TEST_CASE("DAQ F/T: a source's faults pass through, data of the wrong shape do not") {
  auto gauges = std::make_unique<Gauges>(Rows{kOne});
  Gauges& source = *gauges;
  DaqFt sensor(std::move(gauges), calibration(), {});
  source.broken = true;
  CHECK(fault_id_of([&] { (void)sensor.read(1); }) == "TB-DAQMX-ERROR");
  source.broken = false;
  source.shape_lie = true;
  CHECK(fault_id_of([&] { (void)sensor.read(1); }) == "TB-FORCE-PROTOCOL");
  DaqFtOptions options;
  options.expected_serial = "FT00000";
  CHECK(fault_id_of([&] { DaqFt(std::make_unique<Gauges>(Rows{kOne}), calibration(), options); }) == "TB-FORCE-SERIAL");
}
