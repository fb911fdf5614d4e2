// A Modbus analog module as data (profile) and as process image: output words written, input words read, raw counts
// kept beside volts. First profile: Beckhoff EK9000 with EL4xxx/EL3xxx terminals (input words from 0x0000, output
// words from 0x0800, watchdog registers 0x1120-0x1124; 0x7FFF = +10 V).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "devices/clock.h"
#include "devices/device.h"
#include "devices/fault.h"
#include "devices/units.h"
#include "devices/wire/modbus_link.h"

namespace tactbench::devices {

struct ModuleProfile {
  std::string name;             // "beckhoff-ek9000"
  std::string model;            // printed and stored: "Beckhoff EK9000 + EL4xxx/EL3xxx"
  int input_address = 0x0000;   // FC 4
  int output_address = 0x0800;  // FC 16/23, read back by FC 3
  int inputs = 2;               // words in the input image
  int outputs = 1;              // words in the output image
  std::int32_t raw_full_scale = 0x7FFF;
  Volts volts_full_scale{10.0};
  int watchdog_address = -1;   // 0x1120 on the EK9000; -1: the module has none
  int fallbacks_address = -1;  // 0x1021 on the EK9000: how often the watchdog fell back; -1: not told
};

// Throws Fault TB-MODULE-PROFILE naming the known profiles.
ModuleProfile module_profile(const std::string& name);

class AnalogModule {
 public:
  AnalogModule(ModuleProfile profile, ModbusEndpoint endpoint, Nanoseconds watchdog, Clock& clock, Origin origin);

  // Clears a fallback of an earlier run (0xBECF, 0xAFFE to 0x1121; not verified on hardware), then sets and verifies
  // by reading: 0x1124 = 0 (more than one writer), 0x1122 = 0 (fed by writes only), 0x1120 = the watchdog time, 1 ms
  // to 1 min. Throws Fault TB-MODULE-WATCHDOG when a register does not read back or the module has no watchdog.
  void bring_up();
  // Writes the output word, reads the inputs in the same exchange (FC 23), then reads the output back (FC 3): two
  // exchanges. Throws Fault TB-MODULE-READBACK when another value stands there, TB-MODULE-WATCHDOG when the module
  // refuses because its watchdog has fallen back since bring_up(): only bring_up() makes it writable again.
  void write(int output, std::uint16_t counts);
  // Reads the last written outputs back (FC 3), then rewrites them and reads the inputs (FC 23): feeds the watchdog.
  // Reading first finds another master's write since the last feeding, which rewriting would hide. As write().
  void feed();
  // Reads the outputs back (FC 3, one exchange); Fault TB-MODULE-READBACK when another master has changed them.
  void verify_outputs();
  // Reads the input image (FC 4, one exchange) unless it is at most `max_age` old.
  void refresh(Nanoseconds max_age = Nanoseconds(0));

  [[nodiscard]] std::int16_t input(int channel) const;    // raw counts of the last image
  [[nodiscard]] std::uint16_t output(int channel) const;  // raw counts last written and read back
  [[nodiscard]] Nanoseconds image_time() const { return image_time_; }
  [[nodiscard]] Nanoseconds last_write_time() const { return last_write_time_; }
  [[nodiscard]] Volts volts(std::int32_t counts) const;
  [[nodiscard]] std::uint16_t counts(Volts volts) const;  // nearest, clipped to 0..full scale
  [[nodiscard]] std::uint64_t exchanges() const { return link_.exchanges(); }
  [[nodiscard]] Identity identity() const;
  [[nodiscard]] const ModuleProfile& profile() const { return profile_; }
  // Writes 0 to every output and reads it back, connecting anew once if need be: at most two attempts of two
  // exchanges. True: every output read back as 0.
  [[nodiscard]] bool zero_outputs() noexcept;

 private:
  void write_image(std::vector<std::uint16_t> image);
  void blame_watchdog(const Fault& fault, Nanoseconds time);
  void send_outputs(const std::vector<std::uint16_t>& image);
  void set_register(int address, std::uint16_t value);
  std::uint16_t fallbacks();
  ModuleProfile profile_;
  Nanoseconds watchdog_;
  Clock& clock_;
  Origin origin_;
  ModbusLink link_;
  std::vector<std::uint16_t> inputs_;
  std::vector<std::uint16_t> outputs_;  // only what was read back
  std::uint16_t fallbacks_at_start_ = 0;
  Nanoseconds image_time_{-1};
  Nanoseconds last_write_time_{-1};
};

}  // namespace tactbench::devices
