#include "bench/instruments/live.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <thread>

#include "analysis/counted.h"
#include "analysis/error.h"
#include "analysis/export/quantise.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/statistics/numbers/moments.h"
#include "bench/common/error.h"
#include "bench/common/process_time.h"
#include "bench/common/standard_streams.h"
#include "bench/common/stop_request.h"
#include "bench/common/terminal.h"
#include "bench/instruments/check.h"
#include "bench/rig/rig.h"
#include "db/record.h"
#include "devices/device.h"

namespace tactbench::bench {
namespace {

using RealClock = std::chrono::steady_clock;

constexpr int kMostLostInARow = 10;
constexpr std::size_t kMostLatencies = 1'000'000;  // kept for the percentiles; later ones count only for the worst

double microseconds_since(RealClock::time_point start) {
  return std::chrono::duration<double, std::micro>(RealClock::now() - start).count();
}

double percentile(const std::vector<double>& values, double share) {
  return values.empty() ? 0.0 : analysis::quantile_of(values, share);
}

// A frame by the integers of a device.
class FixedLive {
 public:
  FixedLive(const analysis::SensorModel& model, const LiveOptions& options, double per_count)
      : frames_(of(model, options, per_count)) {
    counts_.resize(frames_.model().taxels);
    words_.resize(frames_.model().taxels);
  }
  void frame(std::span<const double> means, bool outside, const analysis::FrameCompensator::Output& output) {
    std::ranges::transform(means, counts_.begin(),
                           [](double mean) { return static_cast<std::uint16_t>(std::lround(mean)); });
    frames_.frame(counts_, words_, output.status);
    put(outside, output);
  }
  void lost_frame(bool outside, const analysis::FrameCompensator::Output& output) {
    frames_.lost_frame(words_, output.status);
    put(outside, output);
  }

 private:
  static std::shared_ptr<const analysis::FixedModel> of(const analysis::SensorModel& model, const LiveOptions& options,
                                                        double per_count) {
    analysis::FixedOptions own = *options.fixed;
    own.per_count = per_count;
    own.scans = options.scans;
    if (model.dynamics && !(options.interval_s > 0.0))
      throw Error("TB-USAGE", "the model undoes creep and lag, and a device's integers have one pace", "--interval",
                  "name the seconds between two frames, 0.0001 to 0.2");
    if (own.frame_rate_hz == 0.0 && options.interval_s > 0.0) own.frame_rate_hz = 1.0 / options.interval_s;
    return std::make_shared<const analysis::FixedModel>(analysis::quantised(model, own));
  }
  void put(bool outside, const analysis::FrameCompensator::Output& output) const {
    for (std::size_t t = 0; t < words_.size(); ++t) {
      output.pressure_psi[t] = static_cast<float>(frames_.model().pressure(words_[t]));
      output.uncertainty_psi[t] = std::numeric_limits<float>::quiet_NaN();
      if (outside && output.status[t] != analysis::kTaxelDead)
        output.status[t] =
            static_cast<std::uint16_t>((output.status[t] & ~analysis::kTaxelValid) | analysis::kTaxelOutside);
    }
  }
  analysis::FixedFrames frames_;
  std::vector<std::uint16_t> counts_, words_;
};

}  // namespace

LiveSummary live_frames(const BenchConfig& config, const analysis::SensorModel& model, const LiveOptions& options,
                        const std::function<bool(const LiveFrame&)>& show) {
  Rig rig(config);
  rig.open_array();
  devices::TactileArray& array = rig.array();
  if (array.rows() != model.rows || array.columns() != model.columns)
    throw Error("TB-LIVE-SHAPE",
                fmt::format("the array has {} x {} taxels, the model {} x {}", array.rows(), array.columns(),
                            model.rows, model.columns),
                config.file);
  const double volts_per_count = array.volts_per_count().value();
  auto compensator = [&] {
    try {
      const double noisier = std::sqrt(static_cast<double>(model.scans) / options.scans);
      return analysis::frames_of(model, noisier, kMostLostInARow);
    } catch (const std::invalid_argument& error) {  // invalid numbers of a hand-edited model
      throw Error("TB-MODEL-COMPENSATOR", error.what(), model.source);
    }
  }();
  LiveSummary summary;
  summary.other_scanner = !model.scanner_serial.empty() && array.identity().serial != model.scanner_serial;
  if (summary.other_scanner)
    summary.outside.push_back(fmt::format("scanner {} (fitted on {})", analysis::or_not_stated(array.identity().serial),
                                          model.scanner_serial));
  const std::optional<analysis::Range>& box = model.validity.temperature_c;
  for (const EnvironmentReading& reading : rig.environment())
    if (box && reading.quantity == "temperature_c" && !box->contains(reading.value, analysis::kTemperatureSlack))
      summary.outside.push_back(
          fmt::format("temperature {:.1f} degC (fitted at {:.1f} to {:.1f})", reading.value, box->low, box->high));
  const bool outside = !summary.outside.empty();
  compensator.set_outside_validity(outside);
  std::optional<FixedLive> fixed;
  if (options.fixed) fixed.emplace(model, options, volts_per_count);

  const std::size_t taxels = compensator.taxels();
  std::vector<float> volts(taxels), pressure(taxels), uncertainty(taxels);
  std::vector<std::uint16_t> status(taxels);
  std::vector<double> means;  // counts of the last frame
  const analysis::FrameCompensator::Output output{pressure, uncertainty, status};
  std::vector<double> latencies, compensations;
  const StopRequest stop;
  const auto begun = RealClock::now();
  std::optional<devices::Nanoseconds> before;  // process time of the last frame, lost ones too
  for (int lost = 0; stop.signal() == 0 && (options.frames == 0 || summary.frames < options.frames);) {
    const auto asked = RealClock::now();
    const devices::Nanoseconds now = rig.clock().now();
    const double passed = before ? devices::in_seconds(now - *before) : 0.0;
    before = now;
    try {
      const devices::ScanSet scan = array.read(options.scans);
      const auto came = RealClock::now();
      means = db::scan_means(scan.counts, static_cast<std::size_t>(scan.scans), means);
      std::ranges::transform(means, volts.begin(),
                             [&](double mean) { return static_cast<float>(volts_per_count * mean); });
      if (fixed)
        fixed->frame(means, outside, output);
      else
        compensator.frame(volts, passed, output);
      compensations.push_back(microseconds_since(came));
      lost = 0;
    } catch (const devices::Fault& fault) {
      if (fault.id() == "TB-SCANNER-LOST" || ++lost >= kMostLostInARow) throw;
      ++summary.lost;
      if (fixed)
        fixed->lost_frame(outside, output);
      else
        compensator.lost_frame(passed, output);
    }
    const double latency = microseconds_since(asked);
    summary.worst_us = std::max(summary.worst_us, latency);
    if (latencies.size() < kMostLatencies) latencies.push_back(latency);
    const double time_s = std::chrono::duration<double>(asked - begun).count();
    const bool file_status_of = show({summary.frames, time_s, pressure, uncertainty, status, latency});
    ++summary.frames;
    if (!file_status_of) break;
    rig.clock().wait_until(rig.clock().now() + seconds(options.interval_s * config.rate));
    // A manual clock does not wait, but a person needs real time.
    if (config.in_process && options.interval_s > 0.0) std::this_thread::sleep_for(seconds(options.interval_s));
  }
  summary.median_us = percentile(latencies, 0.5);
  summary.p99_us = percentile(latencies, 0.99);
  summary.compensation_median_us = percentile(compensations, 0.5);
  return summary;
}

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
