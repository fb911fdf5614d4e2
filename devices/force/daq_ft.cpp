#include "devices/force/daq_ft.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "devices/device.h"

namespace tactbench::devices {
namespace {

SixAxes six_axes(const Vector6& vector) {
  SixAxes axes{};
  Vector6::Map(axes.data()) = vector;
  return axes;
}

}  // namespace

DaqFt::DaqFt(std::unique_ptr<GaugeSource> source, AtiCalibration calibration, DaqFtOptions options)
    : source_(std::move(source)),
      calibration_(std::move(calibration)),
      options_(std::move(options)),
      matrix_(working_matrix(calibration_)),
      tool_(wrench_transform(options_.tool)),
      range_(rated_range(calibration_)) {
  check_serial(options_.expected_serial, calibration_.serial, "the .cal file");
  const int channels = source_->channels();
  const bool compensate = options_.temperature_compensation && calibration_.temperature;
  if (channels == 7 || (channels == 6 && !compensate)) return;
  throw Fault(
      "TB-FORCE-GAUGES", kForceDevice,
      fmt::format("transducer {} needs {}, {} has {} channels", calibration_.serial,
                  compensate ? "six gauges and the thermistor" : "six gauges", source_->identity().model, channels),
      "List the six gauge channels (and the thermistor's as the seventh) in the bench file; without a "
      "thermistor turn temperature compensation off.");
}

DaqFt::Means DaqFt::acquire(int records, const Vector6& bias) {
  check_records(records);
  const GaugeSamples samples = source_->read(records);
  const auto channels = static_cast<std::size_t>(source_->channels());
  if (samples.samples != records || static_cast<std::size_t>(samples.channels) != channels ||
      samples.volts.size() != channels * static_cast<std::size_t>(records)) {
    throw Fault("TB-FORCE-PROTOCOL", kForceDevice,
                fmt::format("{} samples of {} channels were requested from {}, {} of {} came", records, channels,
                            source_->identity().model, samples.samples, samples.channels),
                "Try again; if it persists, the analog input card does not do what its driver reports.");
  }
  Means means{{}, Vector6::Zero()};
  means.reading.records = records;
  means.reading.time = samples.time;
  const double limit = options_.saturation_share * options_.converter_limit.value();
  Vector6 raw = Vector6::Zero();
  double thermistor = 0.0;
  ForceSpread spread;
  for (std::size_t sample = 0; sample < static_cast<std::size_t>(records); ++sample) {
    const double* row = samples.volts.data() + sample * channels;
    for (int gauge = 0; gauge < 6; ++gauge) {
      if (std::abs(row[gauge]) < limit) continue;  // NaN is not a voltage either
      throw Fault("TB-FORCE-SATURATED", kForceDevice,
                  fmt::format("gauge G{} of transducer {} reads {:.4g} V, at or beyond {:.4g} V", gauge,
                              calibration_.serial, row[gauge], limit),
                  "Take the load off; if it persists, a gauge, its wire or the transducer's supply is broken.");
    }
    const Vector6 gauges = Vector6::Map(row);
    raw += gauges;
    if (channels == 7) thermistor += row[6];
    const bool compensate = options_.temperature_compensation && calibration_.temperature;
    const Vector6 used = compensate ? compensated(*calibration_.temperature, gauges, row[6]) : gauges;
    means.gauges += used;
    const Wrench load = wrench_of(six_axes(matrix_ * (used - bias)));
    check_overload(load, range_, options_.overload_share);
    spread.add(load);
  }
  means.reading.spread_n = spread.standard_deviation_n();
  means.gauges /= records;
  means.reading.raw = six_axes(raw / records);
  if (channels == 7) means.reading.thermistor_v = thermistor / records;
  return means;
}

ForceReading DaqFt::read(int records) {
  Means means = acquire(records, bias_);
  means.reading.wrench = wrench_of(six_axes(tool_ * (matrix_ * (means.gauges - bias_))));
  return means.reading;
}

ForceReading DaqFt::bias(int records) {
  Means means = acquire(records, Vector6::Zero());
  bias_ = means.gauges;
  means.reading.wrench = wrench_of(six_axes(tool_ * (matrix_ * bias_)));
  return means.reading;
}

Identity DaqFt::identity() const {
  const Identity card = source_->identity();
  return {"force sensor", options_.model, calibration_.serial, card.model + " " + card.serial, card.origin};
}

}  // namespace tactbench::devices
