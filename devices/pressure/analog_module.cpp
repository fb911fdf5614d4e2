#include "devices/pressure/analog_module.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "devices/device.h"

namespace tactbench::devices {
namespace {

// Pause between two readings of an output that has not yet followed.
constexpr Nanoseconds kReadbackPoll = std::chrono::milliseconds(20);

constexpr const char* kModuleDevice = "analog module";

std::size_t size(int count) { return static_cast<std::size_t>(count); }

}  // namespace

AnalogModule::AnalogModule(ModuleProfile profile, ModbusEndpoint endpoint, Nanoseconds watchdog, Clock& clock,
                           Origin origin)
    : profile_(std::move(profile)),
      watchdog_(watchdog),
      clock_(clock),
      origin_(origin),
      link_(std::move(endpoint), kModuleDevice, clock) {
  prepare();
}

AnalogModule::AnalogModule(ModuleProfile profile, const AnalogModule& line_of, int unit, Clock& clock, Origin origin)
    : profile_(std::move(profile)),
      watchdog_(0),
      clock_(clock),
      origin_(origin),
      link_(line_of.link_, unit, kModuleDevice) {
  prepare();
}

void AnalogModule::prepare() {
  const ModuleInputs& in = profile_.inputs;
  const std::size_t values = size(in.channels) * in.format.words();
  const std::size_t status = in.status_offset < 0 ? 0 : size(in.status_offset + in.channels);
  inputs_.resize(std::max(values, status));
  rest_.resize(size(profile_.outputs.channels), counts(Volts(0.0)));
  outputs_ = rest_;
}

std::vector<std::uint16_t> AnalogModule::read_all() {
  refresh();
  return profile_.outputs.channels > 0 && profile_.outputs.readback != 0 ? read_outputs()
                                                                         : std::vector<std::uint16_t>();
}

void AnalogModule::write(int output, std::uint16_t counts) {
  auto image = outputs_;
  image.at(size(output)) = counts;
  write_image(std::move(image));
}

void AnalogModule::feed() {
  if (last_write_time_ < Nanoseconds(0)) {
    write_image(outputs_);
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

// A watchdog left running by an earlier run may have fallen back while other instruments were opened. This interrupted
// nothing, because nothing was commanded yet, and the watchdog is set up again.
void AnalogModule::send_first(const std::vector<std::uint16_t>& image) {
  try {
    send_outputs(image);
  } catch (const Fault& fault) {
    if (fault.id() != "TB-MODULE-WATCHDOG") throw;
    set_watchdog();
    dump_closed_ = false;
    close_dump();
    send_outputs(image);
  }
}

void AnalogModule::write_image(std::vector<std::uint16_t> image) {
  if (last_write_time_ < Nanoseconds(0)) {
    send_first(image);
  } else {
    send_outputs(image);
  }
  image.swap(outputs_);  // `image` now keeps the previous outputs
  try {
    const Nanoseconds deadline = clock_.now() + profile_.outputs.deadline;
    while (profile_.outputs.readback != 0 && clock_.now() < deadline && !same(read_outputs(), outputs_)) {
      clock_.wait_until(std::min(deadline, clock_.now() + kReadbackPoll));
    }
    verify_outputs();
  } catch (...) {
    outputs_ = std::move(image);
    throw;
  }
}

void AnalogModule::send_outputs(const std::vector<std::uint16_t>& image) {
  const Nanoseconds time = clock_.now();
  try {
    put_outputs(image);
  } catch (const Fault& fault) {
    blame_watchdog(fault, time);
    throw;
  }
  last_write_time_ = time;
  if (profile_.outputs.function == 23) {
    image_time_ = time;
  } else if (profile_.inputs.channels > 0) {
    read_inputs();
    image_time_ = time;
  }
}

void AnalogModule::put_outputs(const std::vector<std::uint16_t>& image) {
  const ModuleOutputs& out = profile_.outputs;
  if (out.function == 23) {
    link_.write_and_read_registers(out.address, image, profile_.inputs.address, inputs_);
  } else if (out.function == 16) {
    link_.write_registers(out.address, image);
  } else {
    for (int i = 0; i < out.channels; ++i) link_.write_register(out.address + i, image[size(i)]);
  }
}

std::vector<std::uint16_t> AnalogModule::read_outputs() {
  const ModuleOutputs& out = profile_.outputs;
  std::vector<std::uint16_t> stands(outputs_.size());
  if (out.readback == 4) {
    link_.read_input_registers(out.address, stands);
  } else {
    link_.read_holding_registers(out.address, stands);
  }
  return stands;
}

bool AnalogModule::same(const std::vector<std::uint16_t>& stands, const std::vector<std::uint16_t>& wanted) const {
  return std::equal(stands.begin(), stands.end(), wanted.begin(), wanted.end(),
                    [&](int a, int b) { return std::abs(a - b) <= profile_.outputs.dead_band; });
}

void AnalogModule::verify_outputs() {
  if (profile_.outputs.readback == 0) return;
  const std::vector<std::uint16_t> stands = read_outputs();
  if (same(stands, outputs_)) return;
  throw Fault("TB-MODULE-READBACK", kModuleDevice,
              fmt::format("reading the outputs of {} back: counts {} were written, {} were read", link_.peer(),
                          fmt::join(outputs_, " "), fmt::join(stands, " ")),
              "Another program may be writing to the module: stop it. Otherwise check the profile in the bench file.");
}

void AnalogModule::refresh(Nanoseconds max_age) {
  const Nanoseconds time = clock_.now();
  if (profile_.inputs.channels == 0 || (image_time_ >= Nanoseconds(0) && time - image_time_ <= max_age)) return;
  read_inputs();
  image_time_ = time;
}

void AnalogModule::read_inputs() {
  const std::size_t readable = inputs_.size() + size(profile_.inputs.spare);
  if (profile_.inputs.function == 3) {
    link_.read_holding_registers(profile_.inputs.address, inputs_, readable);
  } else {
    link_.read_input_registers(profile_.inputs.address, inputs_, readable);
  }
}

RegisterValue AnalogModule::input(int channel) const {
  const ModuleInputs& in = profile_.inputs;
  const std::size_t words = in.format.words();
  if (channel < 0 || channel >= in.channels) throw std::out_of_range("AnalogModule::input");
  const unsigned status = in.status_offset < 0 ? 0U : inputs_[size(in.status_offset + channel)];
  if ((status & 7U) == 0) return decode_register(in.format, std::span(inputs_).subspan(size(channel) * words, words));
  throw Fault("TB-MODULE-INPUT", kModuleDevice,
              fmt::format("input {} of {} reports status 0x{:04X}:{}{}{}", channel, link_.peer(), status,
                          (status & 1U) != 0 ? " above its range" : "", (status & 2U) != 0 ? " below its range" : "",
                          (status & 4U) != 0 ? " calibration not valid" : ""),
              "Check the transducer's wiring and supply, and the input's range setting.");
}

std::uint16_t AnalogModule::output(int channel) const { return outputs_.at(size(channel)); }

std::uint16_t AnalogModule::counts(Volts volts) const {
  const LinearScale& scale = profile_.outputs.volts;
  const double exact = scale.raw(volts.value());
  if (!(exact > scale.raw_low)) return static_cast<std::uint16_t>(scale.raw_low);  // NaN too
  return static_cast<std::uint16_t>(std::lround(std::min(exact, scale.raw_high)));
}

Identity AnalogModule::identity() const { return {"analog module", profile_.model, "", "", origin_}; }

bool AnalogModule::zero_outputs() noexcept {
  if (profile_.outputs.channels == 0) return false;
  for (int attempt = 0; attempt < 2; ++attempt) {
    try {
      const Nanoseconds time = clock_.now();
      try {
        if (profile_.outputs.function == 6) {
          put_outputs(rest_);
        } else {
          link_.write_registers(profile_.outputs.address, rest_);
        }
        last_write_time_ = time;
      } catch (const Fault& fault) {
        // A module whose watchdog has tripped refuses the write, but its output is at rest: the readback decides.
        if (fault.id() != "TB-MODBUS-EXCEPTION") throw;
      }
      // If outputs cannot be read back, the acknowledged write is the only evidence.
      if (profile_.outputs.readback == 0 || same(read_outputs(), rest_)) {
        outputs_ = rest_;
        return true;
      }
    } catch (...) {
      link_.close();
    }
  }
  return false;
}

void AnalogModule::close_dump() {
  if (profile_.dump_coil < 0 || dump_closed_) return;
  link_.write_coil(profile_.dump_coil, true);
  dump_closed_ = true;
}

bool AnalogModule::open_dump() noexcept {
  if (profile_.dump_coil < 0) return true;
  for (int attempt = 0; attempt < 2; ++attempt) {
    try {
      link_.write_coil(profile_.dump_coil, false);
      dump_closed_ = false;
      return true;
    } catch (...) {
      link_.close();
    }
  }
  return false;
}

// The fail-safe side of AnalogModule: watchdog and safe mode, set up and verified by reading.

namespace {

// Offsets from the EK9000's watchdog time register (0x1120).
constexpr int kResetRegister = 1;
constexpr int kTypeRegister = 2;
constexpr int kWriteLockRegister = 4;
constexpr std::uint16_t kFedByWrites = 0;
constexpr std::array<std::uint16_t, 2> kResetWords{0xBECF, 0xAFFE};

constexpr const char* kFailSafeDevice = "analog module";

}  // namespace

void AnalogModule::bring_up() {
  if (profile_.fail_safe.watchdog_address >= 0 || watchdog_ != Nanoseconds(0)) set_watchdog();
  if (profile_.fail_safe.safe_mode_address >= 0) clear_safe_mode();
  outputs_ = rest_;
  last_write_time_ = Nanoseconds(-1);
  dump_closed_ = false;
  close_dump();
  refresh();
}

void AnalogModule::set_watchdog() {
  const ModuleFailSafe& safe = profile_.fail_safe;
  const auto milliseconds = std::chrono::duration_cast<std::chrono::milliseconds>(watchdog_).count();
  if (safe.watchdog_address < 0 || milliseconds < 1 || milliseconds > 60'000) {
    throw Fault("TB-MODULE-WATCHDOG", kFailSafeDevice,
                fmt::format("a watchdog of {} ms was requested of {}, which {}", milliseconds, link_.peer(),
                            safe.watchdog_address < 0 ? "has none" : "takes 1 to 60000 ms"),
                "Correct the watchdog time in the bench file, or choose a module with a watchdog.");
  }
  for (const std::uint16_t word : kResetWords) {
    link_.write_registers(safe.watchdog_address + kResetRegister, std::span(&word, 1));
  }
  set_register(safe.watchdog_address + kWriteLockRegister, 0);
  set_register(safe.watchdog_address + kTypeRegister, kFedByWrites);
  set_register(safe.watchdog_address, static_cast<std::uint16_t>(milliseconds));
  fallbacks_at_start_ = fallbacks();
}

void AnalogModule::set_register(int address, std::uint16_t value) {
  link_.write_registers(address, std::span(&value, 1));
  std::uint16_t stands = 0;
  link_.read_holding_registers(address, std::span(&stands, 1));
  if (stands == value) return;
  throw Fault("TB-MODULE-WATCHDOG", kFailSafeDevice,
              fmt::format("setting watchdog register 0x{:04X} of {} to {}: it reads back {}", address, link_.peer(),
                          value, stands),
              "Check that the profile in the bench file fits the module and that no other master sets it.");
}

void AnalogModule::clear_safe_mode() {
  const ModuleFailSafe& safe = profile_.fail_safe;
  const auto in_safe_mode = [&] {
    const auto channels = link_.read_discrete_inputs(safe.safe_mode_address, profile_.outputs.channels);
    return std::find(channels.begin(), channels.end(), true) != channels.end();
  };
  if (!in_safe_mode()) return;
  for (int i = 0; i < profile_.outputs.channels; ++i) link_.write_coil(safe.safe_mode_clear_address + i, true);
  if (!in_safe_mode()) return;
  throw Fault("TB-MODULE-WATCHDOG", kFailSafeDevice,
              fmt::format("{} stays in its safe mode when ordered to leave it", link_.peer()),
              "Check the module's own page for the cause (host connection watchdog), then start again.");
}

std::uint16_t AnalogModule::fallbacks() {
  std::uint16_t count = 0;
  const int address = profile_.fail_safe.fallbacks_address;
  if (address >= 0) link_.read_holding_registers(address, std::span(&count, 1));
  return count;
}

// Throws TB-MODULE-WATCHDOG instead of `fault` when the watchdog has fallen back since the start.
void AnalogModule::blame_watchdog(const Fault& fault, Nanoseconds time) {
  const bool possible = fault.id() == "TB-MODBUS-EXCEPTION" || fault.id() == "TB-MODULE-READBACK";
  if (!possible || fallbacks() == fallbacks_at_start_) return;
  throw Fault("TB-MODULE-WATCHDOG", kFailSafeDevice,
              fmt::format("{}; its watchdog ({:g} ms) has fallen back since the start, the last write is {:g} ms old",
                          fault.what(), in_milliseconds(watchdog_), in_milliseconds(time - last_write_time_)),
              "The outputs are at zero. Find out why the set-point was not rewritten in time, then start again.");
}

}  // namespace tactbench::devices
