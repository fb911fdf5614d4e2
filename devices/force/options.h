// Options of the force sensor, as a bench file states them: an ATI transducer behind its Net, DAQ or Digital interface.
#pragma once

#include <array>
#include <chrono>
#include <optional>
#include <string>

#include "devices/clock.h"
#include "devices/device.h"
#include "devices/units.h"
#include "devices/wire/options.h"

namespace tactbench::devices {

using SixAxes = std::array<double, 6>;  // Fx, Fy, Fz, Tx, Ty, Tz

struct FtOptions {  // of every interface
  std::string model = "ATI Nano17";
  std::string expected_serial;  // of the transducer or its calibration; empty: any
  double overload_share = 1.0;  // of the range
  Origin origin = Origin::kHardware;
};

struct NetFtOptions : FtOptions {
  std::string host = "192.168.1.1";  // numeric address
  int port = 49152;
  int http_port = 80;
  std::string page_file;         // a saved netftapi2.xml, read instead of the sensor's page; empty: read the sensor's
  std::optional<SixAxes> range;  // N, N*mm; used when the page does not state it
  Nanoseconds reply_timeout = std::chrono::milliseconds(500);  // on top of the time that the records themselves take
  Nanoseconds page_timeout = std::chrono::seconds(3);
};

// Position of a second frame relative to a first: displaced along the first frame's axes, then turned about x, then
// about the new y, then about the new z.
struct AtiTransform {
  std::array<double, 3> displacement_mm{};
  std::array<double, 3> rotation_deg{};
  bool operator==(const AtiTransform&) const = default;
};

struct DaqFtOptions : FtOptions {        // its origin is the gauge source's
  AtiTransform tool;                     // the wrench is reported in this frame, given relative to the transducer's
  bool temperature_compensation = true;  // if the .cal file has it; needs the thermistor on channel 7
  Volts converter_limit{10.0};
  double saturation_share = 0.999;  // of the converter's limit
};

struct DaqmxGaugesOptions {
  std::string library;  // empty: NI's own (daqmx_api.h)
  std::string device = "Dev1";
  std::string expected_serial;            // of the card, hexadecimal; empty: any
  std::string channels = "Dev1/ai16:21";  // gauges in the calibration's order, then the thermistor
  DaqmxTerminal terminal = DaqmxTerminal::kDifferential;
  Volts range{10.0};
  double sample_rate_hz = 10'000;
  Nanoseconds timeout = std::chrono::milliseconds(500);  // beyond the time that the samples take
  Origin origin = Origin::kHardware;                     // a device simulated by NI's driver is kSimulated in any case
};

struct DigitalFtOptions : FtOptions {
  int unit = 10;                // Modbus
  bool low_word_first = false;  // of 32-bit values in the calibration registers: not verified
  bool local_echo = false;      // the adapter returns what is sent; that much is read first and compared
  double samples_per_second = 7000.0;
  Nanoseconds reply_timeout = std::chrono::milliseconds(500);  // plus the time that the samples take
  Nanoseconds quiet = std::chrono::milliseconds(20);           // no byte for this long: the stream has stopped
};

enum class ForceKind { kNet, kDaq, kDigital };  // a row each in bench/config/config_force.cpp

struct ForceOptions : FtOptions {
  ForceKind kind = ForceKind::kNet;
  int records = 50;  // averaged into one reading
  NetFtOptions net;
  std::string calibration_file;  // DAQ: the .cal file
  DaqFtOptions daq;
  DaqmxGaugesOptions gauges;
  SerialAddress address;  // Digital
  DigitalFtOptions digital;
};

}  // namespace tactbench::devices
