// Interfaces of the chamber's instruments: a PressureSource sets the pressure, an independent PressureReference
// measures it.
#pragma once

#include <cstdint>

#include "devices/clock.h"
#include "devices/device.h"
#include "devices/units.h"

namespace tactbench::devices {

struct PressureReading {
  Psi pressure;
  Volts voltage;            // 0 if the instrument reports pressure directly
  std::int32_t counts = 0;  // as read; for a float its bit pattern
  Nanoseconds time{0};
};

class PressureSource : public Actuator {
 public:
  // Sets the pressure and reads the set-point back. Returns the raw counts written. Throws Fault.
  virtual std::uint16_t command(Psi pressure) = 0;
  // Rewrites the set-point and reads it back if the last write is at least `feed interval` old; otherwise, and when
  // disarmed, only reads. Call it at least once per feed interval.
  virtual void keep_alive() = 0;
  [[nodiscard]] virtual PressureReading feedback() = 0;
  // Process time of the last write that was read back; the next feeding is due one feed interval later.
  [[nodiscard]] virtual Nanoseconds last_fed() const = 0;
  // Commands 0 psi; bounded in time, callable twice and in any state, armed or not. True: the command was read back.
  [[nodiscard]] virtual bool vent() noexcept = 0;
  [[nodiscard]] virtual Identity identity() const = 0;
  [[nodiscard]] virtual std::uint64_t exchanges()
      const = 0;  // exchanges on the source's own line; an analog module counts its own
};

class PressureReference {
 public:
  virtual ~PressureReference() = default;
  [[nodiscard]] virtual PressureReading read() = 0;
  [[nodiscard]] virtual Identity identity() const = 0;
};

}  // namespace tactbench::devices
