#include "bench/instruments/watch.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <thread>

#include "analysis/counted.h"
#include "bench/common/process_time.h"
#include "bench/common/standard_streams.h"
#include "bench/common/stop_request.h"
#include "bench/common/terminal_safe.h"
#include "bench/instruments/check.h"
#include "bench/rig/rig.h"
#include "devices/device.h"

namespace tactbench::bench {

namespace {

// Eight steps of grey, dark to bright, for the array's picture.
constexpr const char* kGreys[] = {" ", "░", "░", "▒", "▒", "▓", "▓", "█"};

constexpr std::uint16_t kFaintest = 6554;  // a tenth of the range: an unloaded array stays dark

std::string or_fault(const std::function<std::string()>& read) {
  try {
    return read();
  } catch (const devices::Fault& fault) {
    return fmt::format("-- {} ({})", fault.id(), fault.what());
  }
}

// Two columns a taxel, since a terminal's cell is twice as high as wide.
std::string picture(const devices::ScanSet& scan) {
  const auto highest = std::max(kFaintest, *std::max_element(scan.counts.begin(), scan.counts.end()));
  std::string text;
  for (int row = 0; row < scan.rows; ++row) {
    text += "  ";
    for (int column = 0; column < scan.columns; ++column) {
      const unsigned count = scan.counts[static_cast<std::size_t>(row * scan.columns + column)];
      const char* shade = kGreys[count * 7U / highest];
      text += shade;
      text += shade;
    }
    text += '\n';
  }
  return text;
}

std::string array_text(Rig& rig, bool with_picture) {
  if (!rig.has_array()) rig.open_array();
  try {
    const devices::ScanSet scan = rig.array().read(1);
    return fmt::format("{}, status 0x{:02X}{}", array_summary(scan, rig.array().volts_per_count()), scan.status,
                       with_picture ? fmt::format("\n{}", picture(scan)) : std::string());
  } catch (const devices::Fault&) {
    rig.close_array();
    throw;
  }
}

std::string stage_text(Rig& rig) {
  std::string text;
  for (const devices::AxisIdentity& axis : rig.stage()->identify()) {
    const std::string where = !axis.present    ? "absent"
                              : !axis.position ? analysis::counted(axis.microsteps, "microstep")
                                               : fmt::format("{:.4f} mm", axis.position->value());
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", "xyz"[static_cast<int>(axis.axis)], where);
  }
  return text;
}

std::string pressure_text(double psi, analysis::PressureUnit unit) {
  return fmt::format("{:>8} {}", unit.fixed(psi, 3), unit.symbol());
}

std::string lines_of(Rig& rig, devices::ForceSensor*& force, const WatchOptions& options) {
  std::string text = fmt::format("time       {:.2f} s\n", static_cast<double>(rig.clock().now().count()) * 1e-9);
  const auto line = [&](const char* name, const std::function<std::string()>& read) {
    text += fmt::format("{:<10} {}\n", name, or_fault(read));
  };
  line("feedback", [&] { return pressure_text(rig.source().feedback().pressure.value(), options.unit); });
  line("reference", [&] { return pressure_text(rig.reference().read().pressure.value(), options.unit); });
  for (std::size_t i = 0; i < rig.config().environment.size(); ++i) {
    line(rig.config().environment[i].quantity.c_str(), [&] { return fmt::format("{:.2f}", rig.environment(i).value); });
  }
  if (rig.stage() != nullptr) line("stage", [&] { return stage_text(rig); });
  if (rig.config().force) {
    line("force", [&] {
      if (force == nullptr) force = &rig.open_force();
      const auto f = force->read(rig.config().force->records).wrench.force_n;
      return fmt::format("{:8.3f} {:8.3f} {:8.3f} N", f[0], f[1], f[2]);
    });
  }
  line("array", [&] { return array_text(rig, options.terminal); });
  return text;
}

}  // namespace

void watch_devices(const BenchConfig& config, const WatchOptions& options) {
  Rig rig(config);
  const StopRequest stop;
  devices::ForceSensor* force = nullptr;
  for (long done = 0; stop.signal() == 0 && !output_is_lost() && (options.count == 0 || done < options.count); ++done) {
    const std::string text = lines_of(rig, force, options);
    if (options.terminal) {
      tty::clear_screen();
      tty::print("{} ({}), every {:g} s, Ctrl-C ends\n", config.id,
                 config.origin == devices::Origin::kSimulated ? "simulated" : "hardware", options.interval_s);
    }
    tty::print("{}{}", text, options.terminal ? "" : "\n");
    std::fflush(stdout);
    rig.clock().wait_until(rig.clock().now() + seconds(options.interval_s * config.rate));
    // A manual clock does not wait, but a person needs real time.
    if (config.in_process) std::this_thread::sleep_for(seconds(options.interval_s));
  }
}

}  // namespace tactbench::bench
