// Driver of a Modbus analog module that a profile describes (devices/profiles/*.toml, read by
// bench/config/config_profile.h): writes output words and reads them back, reads input words, and keeps raw counts next
// to volts.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "devices/clock.h"
#include "devices/device.h"
#include "devices/pressure/module_profile.h"
#include "devices/units.h"
#include "devices/wire/modbus/modbus_link.h"
#include "devices/wire/modbus/modbus_value.h"

namespace tactbench::devices {

class AnalogModule {
 public:
  // `watchdog`: the timeout to set in a module that has a watchdog; zero for a module without one.
  AnalogModule(ModuleProfile profile, ModbusEndpoint endpoint, Nanoseconds watchdog, Clock& clock, Origin origin);
  // A module on the same line as another one.
  AnalogModule(ModuleProfile profile, const AnalogModule& line_of, int unit, Clock& clock, Origin origin);

  // Makes the module writable and discards earlier writes: the next feeding writes 0 V unless a command comes first.
  // Beckhoff: clears a fallback of an earlier run (0xBECF, 0xAFFE to 0x1121; not verified on hardware), then sets and
  // verifies by reading: 0x1124 = 0 (more than one writer), 0x1122 = 0 (fed by writes only), 0x1120 = the watchdog
  // time, 1 ms to 1 min. Moxa: clears a channel's safe mode and verifies that. Throws Fault TB-MODULE-WATCHDOG when a
  // register does not read back or a time was given for a module without a watchdog.
  void bring_up();
  // Reads inputs and outputs, writes nothing. Returns the counts at the outputs (empty: the module cannot read them
  // back).
  std::vector<std::uint16_t> read_all();
  // Writes the output word, reads the inputs (in the same exchange with FC 23), then reads the output back. Throws
  // Fault TB-MODULE-READBACK when the output still differs after the profile's deadline, TB-MODULE-WATCHDOG when the
  // module refuses because its watchdog has fallen back since bring_up(); only bring_up() makes it writable again.
  void write(int output, std::uint16_t counts);
  // Feeds the watchdog: reads the last written outputs back, then rewrites them and reads the inputs. Reading first
  // detects another master's write since the last feeding, which rewriting would hide. Throws as write().
  void feed();
  // Reads the outputs back. Throws Fault TB-MODULE-READBACK when another master has changed them. A module that cannot
  // be read back passes this check.
  void verify_outputs();
  // Reads the input image (one exchange) unless it is at most `max_age` old.
  void refresh(Nanoseconds max_age = Nanoseconds(0));
  void forget_image() { image_time_ = Nanoseconds(-1); }  // the next refresh() reads again

  // From the last image. Throws Fault TB-MODULE-INPUT when the channel's own status word reports that it is out of
  // range; the readings of the other channels remain valid.
  [[nodiscard]] RegisterValue input(int channel) const;
  [[nodiscard]] std::uint16_t output(int channel) const;  // raw counts last written and read back
  [[nodiscard]] Nanoseconds image_time() const { return image_time_; }
  [[nodiscard]] Nanoseconds last_write_time() const { return last_write_time_; }
  [[nodiscard]] Volts input_volts(int channel) const {
    return Volts(profile_.inputs.volts.physical(input(channel).value));
  }
  [[nodiscard]] std::uint16_t counts(Volts volts) const;  // counts of an output: nearest value, clipped to its span
  [[nodiscard]] std::uint64_t exchanges() const { return link_.exchanges(); }
  [[nodiscard]] Identity identity() const;
  [[nodiscard]] const ModuleProfile& profile() const { return profile_; }
  [[nodiscard]] const ModbusLink& link() const { return link_; }
  // From now on the resting voltage of this output is `volts` instead of 0 V; bring_up() and zero_outputs() set it.
  void rest_at(int output, Volts volts) { rest_.at(static_cast<std::size_t>(output)) = counts(volts); }
  // Writes the resting voltage, 0 V, to every output and reads it back; reconnects once if needed: at most two attempts
  // of two exchanges. True: every output was read back with that voltage.
  [[nodiscard]] bool zero_outputs() noexcept;
  // The dump valve on the profile's coil (FC 5, energised = closed). If there is no such valve, both functions do
  // nothing. close_dump() writes only if the valve is not known to be closed, and throws Fault; open_dump() tries
  // twice. True: the module echoed the command (a coil is not read back), or there is no valve. Not verified on
  // hardware.
  void close_dump();
  [[nodiscard]] bool open_dump() noexcept;

 private:
  void prepare();
  void send_first(const std::vector<std::uint16_t>& image);
  void write_image(std::vector<std::uint16_t> image);
  void blame_watchdog(const Fault& fault, Nanoseconds time);
  void send_outputs(const std::vector<std::uint16_t>& image);
  void put_outputs(const std::vector<std::uint16_t>& image);
  std::vector<std::uint16_t> read_outputs();
  [[nodiscard]] bool same(const std::vector<std::uint16_t>& stands, const std::vector<std::uint16_t>& wanted) const;
  void read_inputs();
  void set_register(int address, std::uint16_t value);
  void set_watchdog();
  void clear_safe_mode();
  std::uint16_t fallbacks();
  ModuleProfile profile_;
  Nanoseconds watchdog_;
  Clock& clock_;
  Origin origin_;
  ModbusLink link_;
  std::vector<std::uint16_t> inputs_;
  std::vector<std::uint16_t> outputs_;  // only values that were read back
  std::vector<std::uint16_t> rest_;
  std::uint16_t fallbacks_at_start_ = 0;
  Nanoseconds image_time_{-1};
  Nanoseconds last_write_time_{-1};
  bool dump_closed_ = false;  // according to our last command
};

}  // namespace tactbench::devices
