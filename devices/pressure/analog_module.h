// A Modbus analog module as data (profile) and as process image: output words written, input words read, raw counts
// kept beside volts. First profile: Beckhoff EK9000 with EL4xxx/EL3xxx terminals (input words from 0x0000, output
// words from 0x0800, watchdog registers 0x1120-0x1124; 0x7FFF = +10 V).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "devices/clock.h"
#include "devices/device.h"
#include "devices/units.h"
#include "devices/wire/modbus_link.h"

namespace tactbench::devices {

struct ModuleProfile {
  std::string name;                    // "beckhoff-ek9000"
  std::string model;                   // printed and stored: "Beckhoff EK9000 + EL4xxx/EL3xxx"
  int input_address = 0x0000;          // FC 4
  int output_address = 0x0800;         // FC 16/23, read back by FC 3
  int inputs = 2;                      // words in the input image
  int outputs = 1;                     // words in the output image
  std::int32_t raw_full_scale = 0x7FFF;
  Volts volts_full_scale{10.0};
  int watchdog_address = -1;           // 0x1120 on the EK9000; -1: the module has none
};

// Throws Fault TB-MODULE-PROFILE naming the known profiles.
ModuleProfile module_profile(const std::string& name);

class AnalogModule {
 public:
  AnalogModule(ModuleProfile profile, ModbusEndpoint endpoint, Nanoseconds watchdog, Clock& clock, Origin origin);

  // Sets and verifies by reading: 0x1124 = 0 (more than one writer), 0x1122 = 0 (fed by writes only), 0x1120 = the
  // watchdog time. Throws Fault TB-MODULE-WATCHDOG when a register does not read back.
  void bring_up();
  // Writes the output word, reads the inputs in the same exchange (FC 23), then reads the output back (FC 3): two
  // exchanges. Throws Fault TB-MODULE-READBACK when another value stands there.
  void write(int output, std::uint16_t counts);
  // Rewrites the last value of every output: feeds the watchdog. As write().
  void feed();
  // Reads the input image (FC 4, one exchange) unless it is younger than `max_age`.
  void refresh(Nanoseconds max_age = Nanoseconds(0));

  [[nodiscard]] std::int16_t input(int channel) const;      // raw counts of the last image
  [[nodiscard]] std::uint16_t output(int channel) const;    // raw counts last written and read back
  [[nodiscard]] Nanoseconds image_time() const { return image_time_; }
  [[nodiscard]] Nanoseconds last_write_time() const { return last_write_time_; }
  [[nodiscard]] Volts volts(std::int32_t counts) const;
  [[nodiscard]] std::uint16_t counts(Volts volts) const;    // nearest, clipped to 0..full scale
  [[nodiscard]] std::uint64_t exchanges() const { return link_.exchanges(); }
  [[nodiscard]] Identity identity() const;
  [[nodiscard]] const ModuleProfile& profile() const { return profile_; }
  // One bounded attempt to write 0 to every output and read it back, connecting anew if need be.
  [[nodiscard]] bool zero_outputs() noexcept;

 private:
  void write_image();
  ModuleProfile profile_;
  Nanoseconds watchdog_;
  Clock& clock_;
  Origin origin_;
  ModbusLink link_;
  std::vector<std::uint16_t> inputs_;
  std::vector<std::uint16_t> outputs_;
  Nanoseconds image_time_{-1};
  Nanoseconds last_write_time_{-1};
};

}  // namespace tactbench::devices
