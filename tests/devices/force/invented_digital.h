// An invented calibration of a Digital F/T: a force count is four gauge counts, axis by axis, gauges crossed so that a
// wrong order shows.
#pragma once

#include "devices/force/digital_record.h"

namespace tactbench::devices {

inline DigitalCalibration invented_digital() {
  DigitalCalibration calibration;
  calibration.serial = "FT99902";
  calibration.part_number = "SI-25-0.25";
  calibration.date = "2020/02/30";
  for (std::size_t row = 0; row < 6; ++row) calibration.matrix[row][(row + 1) % 6] = row < 3 ? 4.0F : -8.0F;
  calibration.range = {25.0F, 25.0F, 35.0F, 0.25F, 0.25F, 0.25F};
  calibration.counts_per_force = 1000;        // 0.004 N a gauge count
  calibration.counts_per_torque = 1'000'000;  // -0.008 N*mm a gauge count
  for (std::size_t i = 0; i < 12; ++i) calibration.gains_and_offsets[i] = static_cast<std::uint16_t>(1000 + i);
  return calibration;
}

}  // namespace tactbench::devices
