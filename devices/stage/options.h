// Options of the stage, as a bench file states them: of any, and of three Zaber T-Series actuators on one daisy chain.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string>

#include "devices/clock.h"
#include "devices/device.h"
#include "devices/units.h"
#include "devices/wire/options.h"

namespace tactbench::devices {

// Names of a stage's axes.
enum class Axis { kX, kY, kZ };
inline constexpr int kAxes = 3;

struct AxisOptions {
  Millimetres low{0.0};  // limits, inclusive
  Millimetres high{60.0};
  MillimetresPerSecond maximum_speed{4.0};  // also used when a move names no speed
  Nanoseconds home_timeout = std::chrono::seconds(120);
  std::string model, serial;  // maker and model, empty: not known; the device does not report its serial number
};

struct ZaberAxisOptions : AxisOptions {
  std::uint8_t device = 1;      // number on the chain
  std::int32_t device_id = 60;  // expected; arm() refuses another
  std::int32_t firmware_low = 500;
  std::int32_t firmware_high = 599;  // firmware 6 has other units
};

struct ZaberStageOptions {
  std::array<ZaberAxisOptions, kAxes> axes;
  bool renumber = false;  // arm() numbers the devices 1, 2, 3 from the computer's end first
  bool knob_off = true;
  Nanoseconds reply_timeout = std::chrono::milliseconds(300);  // real time; a query is sent twice before it is a fault
  Nanoseconds frame_silence = std::chrono::milliseconds(40);
  Nanoseconds poll_interval = std::chrono::milliseconds(100);  // process time between two queries during a move
  Nanoseconds move_margin = std::chrono::seconds(2);           // added to the expected time of a move
  Nanoseconds halt_timeout = std::chrono::seconds(2);
  Origin origin = Origin::kHardware;
};

enum class StageKind { kZaber };  // a row each in bench/config/config_stage.cpp

struct StageOptions {
  StageKind kind = StageKind::kZaber;
  SerialAddress address;  // the dead-man opens it for the driver
  ZaberStageOptions options;
  [[nodiscard]] const AxisOptions& axis(std::size_t i) const { return options.axes.at(i); }  // x, y, z
};

}  // namespace tactbench::devices
