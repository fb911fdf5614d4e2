#include "devices/pressure/analog_module.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "devices/fault.h"

namespace tactbench::devices {
namespace {

// Offsets from the EK9000's watchdog time register (0x1120).
constexpr int kReset = 1;
constexpr int kType = 2;
constexpr int kWriteLock = 4;
constexpr std::uint16_t kFedByWrites = 0;
constexpr std::array<std::uint16_t, 2> kResetWords{0xBECF, 0xAFFE};

constexpr const char* kDevice = "analog module";

}  // namespace

ModuleProfile module_profile(const std::string& name) {
  if (name == "beckhoff-ek9000") {
    ModuleProfile profile;
    profile.name = name;
    profile.model = "Beckhoff EK9000 + EL4xxx/EL3xxx";
    profile.watchdog_address = 0x1120;
    profile.fallbacks_address = 0x1021;
    return profile;
  }
  throw Fault("TB-MODULE-PROFILE", kDevice, fmt::format("no module profile is named '{}'", name),
              "Known profiles: beckhoff-ek9000.");
}

AnalogModule::AnalogModule(ModuleProfile profile, ModbusEndpoint endpoint, Nanoseconds watchdog, Clock& clock,
                           Origin origin)
    : profile_(std::move(profile)),
      watchdog_(watchdog),
      clock_(clock),
      origin_(origin),
      link_(std::move(endpoint), kDevice, clock),
      inputs_(static_cast<std::size_t>(profile_.inputs)),
      outputs_(static_cast<std::size_t>(profile_.outputs)) {}

void AnalogModule::bring_up() {
  const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(watchdog_).count();
  if (profile_.watchdog_address < 0 || milliseconds < 1 || milliseconds > 60'000) {
    throw Fault("TB-MODULE-WATCHDOG", kDevice,
                fmt::format("a watchdog of {} ms was asked of {}, which {}", milliseconds, link_.peer(),
                            profile_.watchdog_address < 0 ? "has none" : "takes 1 to 60000 ms"),
                "Correct the watchdog time in the bench file, or choose a module with a watchdog.");
  }
  for (const std::uint16_t word : kResetWords) {
    link_.write_registers(profile_.watchdog_address + kReset, std::span(&word, 1));
  }
  set_register(profile_.watchdog_address + kWriteLock, 0);
  set_register(profile_.watchdog_address + kType, kFedByWrites);
  set_register(profile_.watchdog_address, static_cast<std::uint16_t>(milliseconds));
  fallbacks_at_start_ = fallbacks();
}

void AnalogModule::set_register(int address, std::uint16_t value) {
  link_.write_registers(address, std::span(&value, 1));
  std::uint16_t stands = 0;
  link_.read_holding_registers(address, std::span(&stands, 1));
  if (stands == value) return;
  throw Fault("TB-MODULE-WATCHDOG", kDevice,
              fmt::format("setting watchdog register 0x{:04X} of {} to {}: it reads back {}", address, link_.peer(),
                          value, stands),
              "Check that the profile in the bench file fits the module and that no other master sets it.");
}

std::uint16_t AnalogModule::fallbacks() {
  std::uint16_t count = 0;
  if (profile_.fallbacks_address >= 0) link_.read_holding_registers(profile_.fallbacks_address, std::span(&count, 1));
  return count;
}

void AnalogModule::write(int output, std::uint16_t counts) {
  auto image = outputs_;
  image.at(static_cast<std::size_t>(output)) = counts;
  write_image(std::move(image));
}

void AnalogModule::feed() {
  if (last_write_time_ < Nanoseconds(0)) {
    write_image(outputs_);  // what an earlier owner left standing is no fault
    return;
  }
  const Nanoseconds time = clock_.now();
  try {
    verify_outputs();
  } catch (const Fault& fault) {
    blame_watchdog(fault, time);
    throw;
  }
  send_outputs(outputs_);
}

// Throws TB-MODULE-WATCHDOG instead of `fault` when the watchdog has fallen back since the start.
void AnalogModule::blame_watchdog(const Fault& fault, Nanoseconds time) {
  const bool possible = fault.id() == "TB-MODBUS-EXCEPTION" || fault.id() == "TB-MODULE-READBACK";
  if (!possible || fallbacks() == fallbacks_at_start_) return;
  throw Fault("TB-MODULE-WATCHDOG", kDevice,
              fmt::format("{}; its watchdog ({:g} ms) has fallen back since the start, the last write is {:g} ms old",
                          fault.what(), std::chrono::duration<double, std::milli>(watchdog_).count(),
                          std::chrono::duration<double, std::milli>(time - last_write_time_).count()),
              "The outputs stand at zero. Find out why the set-point was not rewritten in time, then start anew.");
}

void AnalogModule::write_image(std::vector<std::uint16_t> image) {
  send_outputs(image);
  image.swap(outputs_);  // `image` now keeps what stood before
  try {
    verify_outputs();
  } catch (...) {
    outputs_ = std::move(image);
    throw;
  }
}

void AnalogModule::send_outputs(const std::vector<std::uint16_t>& image) {
  const Nanoseconds time = clock_.now();
  try {
    link_.write_and_read_registers(profile_.output_address, image, profile_.input_address, inputs_);
  } catch (const Fault& fault) {
    blame_watchdog(fault, time);
    throw;
  }
  image_time_ = time;
  last_write_time_ = time;
}

void AnalogModule::verify_outputs() {
  std::vector<std::uint16_t> stands(outputs_.size());
  link_.read_holding_registers(profile_.output_address, stands);
  if (stands == outputs_) return;
  throw Fault("TB-MODULE-READBACK", kDevice,
              fmt::format("reading the outputs of {} back: counts {} were written, {} stand there", link_.peer(),
                          fmt::join(outputs_, " "), fmt::join(stands, " ")),
              "Another program may be writing to the module: stop it. Otherwise check the profile in the bench file.");
}

void AnalogModule::refresh(Nanoseconds max_age) {
  const Nanoseconds time = clock_.now();
  if (image_time_ >= Nanoseconds(0) && time - image_time_ <= max_age) return;
  link_.read_input_registers(profile_.input_address, inputs_);
  image_time_ = time;
}

std::int16_t AnalogModule::input(int channel) const {
  return static_cast<std::int16_t>(inputs_.at(static_cast<std::size_t>(channel)));
}

std::uint16_t AnalogModule::output(int channel) const { return outputs_.at(static_cast<std::size_t>(channel)); }

Volts AnalogModule::volts(std::int32_t counts) const {
  return Volts(counts * profile_.volts_full_scale.value() / profile_.raw_full_scale);
}

std::uint16_t AnalogModule::counts(Volts volts) const {
  const double exact = volts / profile_.volts_full_scale * profile_.raw_full_scale;
  if (!(exact > 0.0)) return 0;  // NaN too
  return static_cast<std::uint16_t>(std::lround(std::min(exact, static_cast<double>(profile_.raw_full_scale))));
}

Identity AnalogModule::identity() const { return {"analog module", profile_.model, "", "", origin_}; }

bool AnalogModule::zero_outputs() noexcept {
  for (int attempt = 0; attempt < 2; ++attempt) {
    try {
      const std::vector<std::uint16_t> zeros(outputs_.size(), 0);
      const Nanoseconds time = clock_.now();
      try {
        link_.write_registers(profile_.output_address, zeros);
        last_write_time_ = time;
      } catch (const Fault& fault) {
        // A module whose watchdog has tripped refuses the write, but stands at zero: the reading decides.
        if (fault.id() != "TB-MODBUS-EXCEPTION") throw;
      }
      std::vector<std::uint16_t> stands(outputs_.size(), 1);
      link_.read_holding_registers(profile_.output_address, stands);
      if (stands == zeros) {
        outputs_ = zeros;
        return true;
      }
    } catch (...) {
      link_.close();
    }
  }
  return false;
}

}  // namespace tactbench::devices
