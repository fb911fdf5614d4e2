#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench/cli/session.h"
#include "bench/common/output_file.h"
#include "bench/common/overrides.h"
#include "bench/common/process_time.h"
#include "bench/common/stop_request.h"
#include "bench/common/utc.h"
#include "bench/instruments/reference_calibration.h"
#include "bench/rig/rig.h"
#include "bench/run/control/locks.h"
#include "bench/run/dead_man_news.h"
#include "bench/safety/ramp.h"
#include "bench/safety/safe_state.h"
#include "devices/fault.h"

namespace tactbench::bench {

namespace {

struct CalibrationOptions {
  std::string bench, gauge, output;
  std::vector<std::string> set;
  std::vector<double> levels{0, 10, 20, 30, 40, 50, 60};
  double uncertainty_psi = 0.0, resolution_psi = 0.1;
};

[[noreturn]] void stopped(const std::string& why) {
  throw Error(ExitCode::kStopped, "TB-CALIBRATION-STOPPED", why, "calibrate-reference",
              "nothing was written; start again when ready");
}

// Called in every wait of this verb while it controls the chamber.
void check_interruptions(Rig& rig, const StopRequest& stop) {
  tell_dead_man_news(rig);
  check_dead_man(rig);
  if (stop.signal() != 0) stopped("stopped by a signal");
}

// Reads a line from the operator and feeds the module meanwhile. Without the line end; a turned clock does not advance
// here.
class Prompt {
 public:
  Prompt(Rig& rig, const StopRequest& stop) : rig_(rig), stop_(stop) {}
  double number(const std::string& question) {
    for (;;) {
      tty::print(stderr, "{}", question);
      const std::string text = line();
      if (text == "q") stopped("ended by the operator");
      double value = 0.0;
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
      if (error == std::errc() && end == text.data() + text.size() && std::isfinite(value)) return value;
      tty::print(stderr, "'{}' is not a number; the gauge's reading in psi, or q to end\n", text);
    }
  }

 private:
  std::string line() {
    for (;;) {
      const std::size_t end = waiting_.find('\n');
      if (end != std::string::npos) {
        std::string text = waiting_.substr(0, end);
        waiting_.erase(0, end + 1);
        return text;
      }
      check_interruptions(rig_, stop_);
      rig_.source().keep_alive();
      pollfd input{STDIN_FILENO, POLLIN, 0};
      if (::poll(&input, 1, 50) <= 0) continue;
      char bytes[256];
      const ssize_t got = ::read(STDIN_FILENO, bytes, sizeof bytes);
      if (got == 0) stopped("the input ended before the last reading");
      if (got > 0) waiting_.append(bytes, static_cast<std::size_t>(got));
    }
  }
  Rig& rig_;
  const StopRequest& stop_;
  std::string waiting_;
};

double mean_reference(Rig& rig, const StopRequest& stop) {
  constexpr int kReadings = 10;
  double sum = 0.0;
  for (int i = 0; i < kReadings; ++i) {
    rig.clock().wait_until(rig.clock().now() + seconds(0.05));
    check_interruptions(rig, stop);
    rig.source().keep_alive();
    sum += rig.reference().read().pressure.value();
  }
  return sum / kReadings;
}

void settle(Rig& rig, double level, const StopRequest& stop) {
  const Settling& settling = rig.config().settling;
  ramp_to(rig, devices::Psi(level), [&] { check_interruptions(rig, stop); });
  const devices::Nanoseconds deadline = rig.clock().now() + seconds(settling.timeout_s);
  for (int in_band = 0; in_band < 5;) {  // a second in the band
    check_interruptions(rig, stop);
    rig.clock().wait_until(rig.clock().now() + seconds(0.2));
    rig.source().keep_alive();
    const double feedback = rig.source().feedback().pressure.value();
    in_band = std::abs(feedback - level) <= settling.band_psi ? in_band + 1 : 0;
    if (rig.clock().now() > deadline && in_band == 0) {
      throw devices::Fault(
          "TB-CHAMBER-TIMEOUT", "chamber",
          fmt::format("{:g} psi not reached within {:g} s; feedback {:.2f} psi", level, settling.timeout_s, feedback),
          "check supply and leaks");
    }
  }
}

std::vector<GaugePoint> measure(Rig& rig, const CalibrationOptions& options, const StopRequest& stop) {
  std::vector<std::pair<double, bool>> course;
  for (const double level : options.levels) course.emplace_back(level, true);
  for (std::size_t i = options.levels.size(); i-- > 0;) course.emplace_back(options.levels[i], false);
  Prompt prompt(rig, stop);
  std::vector<GaugePoint> points;
  for (const auto& [level, rising] : course) {
    settle(rig, level, stop);
    GaugePoint point{level, rising, 0.0, 0.0};
    point.gauge_psi =
        prompt.number(fmt::format("{:>2} of {}: {:g} psi, {}. Hand gauge reads [psi, q ends]: ", points.size() + 1,
                                  course.size(), level, rising ? "up" : "down"));
    point.reference_psi = mean_reference(rig, stop);
    points.push_back(point);
  }
  return points;
}

void calibrate(const CalibrationOptions& options, const Session& session) {
  BenchConfig config = read_bench(find_config(options.bench), split_overrides(options.set).bench);
  if (!config.reference_independent) {
    throw Error(ExitCode::kUsage, "TB-USAGE", "this bench has no reference of its own to calibrate", options.bench,
                "set [reference] independent = true and describe the transducer or gauge");
  }
  for (std::size_t i = 0; i < options.levels.size(); ++i) {
    const double level = options.levels[i];
    if (level >= 0.0 && level <= config.limits.command_psi && (i == 0 || level > options.levels[i - 1])) continue;
    throw Error(
        ExitCode::kUsage, "TB-USAGE",
        fmt::format("level {:g} psi does not rise, or is beyond 0 to {:g} psi", level, config.limits.command_psi),
        "--levels", "give rising levels within the command limit");
  }
  config.reference_correction = {};  // the uncorrected reading is calibrated
  const std::string output =
      options.output.empty() ? fmt::format("reference-{}.toml", config.reference.serial) : options.output;
  check_output(output, "a correction of a reference", session.replace);
  const BenchLock lock(config);
  Rig rig(config);
  const StopRequest stop;
  std::vector<GaugePoint> points;
  std::exception_ptr failed;
  try {
    rig.open();
    points = measure(rig, options, stop);
  } catch (...) {
    failed = std::current_exception();
  }
  const SafeProof proof = make_safe(rig, {});
  if (proof.state == db::SafeState::kVerified) rig.dismiss_dead_man();
  tell_dead_man_news(rig);
  tty::print(stderr, "{}\n", proof.text);
  if (failed) {
    throw as_error(failed, "calibrate-reference").with_rig_state(proof.text, proof.state == db::SafeState::kVerified);
  }
  if (proof.state != db::SafeState::kVerified) {
    throw Error(ExitCode::kUnsafe, "TB-SAFE-UNVERIFIED", "the safe state could not be proved", "calibrate-reference",
                "read the chamber's own gauge before touching the rig", proof.text);
  }
  const ReferenceCalibration calibration = calibrate_reference(points, options.uncertainty_psi, options.resolution_psi);
  const std::string heading =
      fmt::format("{}correction of {} serial {} against hand gauge '{}' (U {:g} psi, k = 2, resolution {:g} psi), {}",
                  config.origin == devices::Origin::kSimulated ? "SIMULATED " : "", config.reference.model,
                  config.reference.serial, options.gauge, options.uncertainty_psi, options.resolution_psi, utc_now());
  write_output(output, correction_toml(calibration, points, heading), session.replace);
  if (session.json) {
    print_json("devices.calibrate-reference",
               {{"file", output},
                {"reading_psi", calibration.correction.reading_psi},
                {"correction_psi", calibration.correction.correction_psi},
                {"expanded_uncertainty_psi", calibration.correction.expanded_uncertainty_psi},
                {"largest_residual_psi", calibration.largest_residual_psi},
                {"hysteresis_psi", calibration.hysteresis_psi}});
    return;
  }
  tty::print("{:>10} {:>12} {:>8}\n", "reading", "correction", "U (k=2)");
  for (std::size_t i = 0; i < calibration.correction.reading_psi.size(); ++i) {
    tty::print("{:>10.3f} {:>+12.3f} {:>8.3f}  psi\n", calibration.correction.reading_psi[i],
               calibration.correction.correction_psi[i], calibration.correction.expanded_uncertainty_psi[i]);
  }
  tty::print(
      "largest residual {:.3f} psi; up and down differ by at most {:.3f} psi\n{} written; to use it: [reference] "
      "correction_file = \"{}\"\n",
      calibration.largest_residual_psi, calibration.hysteresis_psi, output, output);
}

}  // namespace

void add_calibrate_reference(CLI::App& devices, Session& session) {
  auto options = std::make_shared<CalibrationOptions>();
  CLI::App* verb = devices.add_subcommand(
      "calibrate-reference",
      "approach levels upward and downward, ask for a hand gauge's readings, write the reference's correction");
  session.profile.add_bench(*verb, options->bench);
  verb->add_option("--gauge", options->gauge, "the hand gauge: model, serial, certificate; recorded")->required();
  verb->add_option("--uncertainty", options->uncertainty_psi, "the gauge's expanded uncertainty in psi, k = 2")
      ->required()
      ->check(CLI::Range(0.0, 10.0));
  verb->add_option("--resolution", options->resolution_psi, "the gauge's resolution in psi")->capture_default_str();
  verb->add_option("--levels", options->levels, "rising levels in psi")->delimiter(',')->capture_default_str();
  verb->add_option("--set", options->set, "override table.key=value of the bench file")->take_all();
  verb->add_option("-o,--output", options->output, "file to write; default reference-SERIAL.toml");
  add_replace(*verb, session);
  verb->add_flag("--json", session.json, "one JSON document on standard output");
  verb->callback([options, &session] { calibrate(*options, session); });
}

}  // namespace tactbench::bench
