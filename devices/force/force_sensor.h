// A six-axis force and torque sensor (ATI Nano17) with any of its interfaces. Each call returns one averaged reading:
// the scaled wrench and the raw counts or gauge voltages.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "devices/clock.h"
#include "devices/device.h"

namespace tactbench::devices {

struct Wrench {                        // in the sensor's frame, or the tool's when a tool transform is given
  std::array<double, 3> force_n{};     // Fx, Fy, Fz
  std::array<double, 3> torque_nmm{};  // Tx, Ty, Tz
};

struct ForceReading {
  Wrench wrench;                          // mean of the records, bias removed
  std::array<double, 6> raw{};            // mean as acquired: counts (Net, Digital) or gauge volts (DAQ)
  double spread_n = 0.0;                  // standard deviation of the records, of the force axis with the largest
  int records = 0;                        // number averaged
  std::uint32_t status = 0;               // of all records, or-ed; 0: healthy
  std::uint64_t lost = 0, reordered = 0;  // records, since the sensor was opened
  Nanoseconds time{0};                    // process time when the reading was requested
  std::optional<double> thermistor_v;     // DAQ with a thermistor: its mean, needed to scale the raw volts
};

inline constexpr int kMaxForceRecords = 100'000;

class ForceSensor {
 public:
  virtual ~ForceSensor() = default;
  // Requests `records` fresh records and averages them; nothing from a queue is used. Bounded by the reply timeout.
  // Throws Fault TB-FORCE-TIMEOUT, TB-FORCE-STATUS (the sensor reports an error; the bits are named), TB-FORCE-STALL
  // (its counter does not advance), TB-FORCE-SATURATED (a converter at its limit: the values are invalid),
  // TB-FORCE-OVERLOAD (an axis of any record beyond the calibration's range after software bias, naming axis and
  // amount), TB-FORCE-PROTOCOL (a reply that is not a record), TB-FORCE-RECORDS (outside 1 to 100 000), and the
  // transport's own (TB-UDP-LOST, TB-SERIAL-LOST, a gauge source's).
  [[nodiscard]] virtual ForceReading read(int records) = 0;
  // Uses the mean of `records` as zero from now on (software bias; raw values are not changed). Returns the reading
  // that is removed. Call it without load: the offset of an unloaded transducer can be a large part of the range, and
  // overload is judged relative to it.
  virtual ForceReading bias(int records) = 0;
  // Rated range of each axis, N and N*mm, from the calibration in use: Fx, Fy, Fz, Tx, Ty, Tz.
  [[nodiscard]] virtual std::array<double, 6> range() const = 0;
  [[nodiscard]] virtual std::string calibration_serial() const = 0;
  [[nodiscard]] virtual std::uint64_t exchanges() const = 0;
  [[nodiscard]] virtual Identity identity() const = 0;
};

// Interface from a simulated force sensor to the physics; called from the sensor's thread while the clock does not
// advance.
class ForcePort {
 public:
  virtual ~ForcePort() = default;
  [[nodiscard]] virtual Wrench wrench() = 0;  // noise included
};

}  // namespace tactbench::devices
