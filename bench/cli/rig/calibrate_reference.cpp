#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/json_fields.h"
#include "bench/cli/session.h"
#include "bench/common/output_file.h"
#include "bench/common/overrides.h"
#include "bench/common/process_time.h"
#include "bench/common/stop_request.h"
#include "bench/common/utc.h"
#include "bench/instruments/reference_calibration.h"
#include "bench/rig/rig.h"
#include "bench/run/control/locks.h"
#include "bench/run/recorder.h"
#include "bench/safety/ramp.h"
#include "bench/safety/safe_state.h"
#include "devices/device.h"
#include "sequences/toml/pressure_text.h"

namespace tactbench::bench {

namespace {

struct CalibrationOptions {
  std::string bench, gauge, output;
  std::vector<std::string> set;
  std::vector<double> levels{0, 10, 20, 30, 40, 50, 60};
  double uncertainty_psi = 0.0, resolution_psi = 0.1;
};

// "20kPa" -> "2.90075", which the option then reads.
CLI::Validator as_psi() {
  return {[](std::string& text) {
            text = sequences::as_number_in("psi", text);
            return std::string();
          },
          ""};
}

[[noreturn]] void stopped(const std::string& why) { throw Error("TB-CALIBRATION-STOPPED", why, "calibrate-reference"); }

// Called in every wait of this verb while it controls the chamber.
void check_interruptions(Rig& rig, const StopRequest& stop) {
  print_dead_man_notices(rig);
  check_dead_man(rig);
  rig.guard().check_witnesses();
  if (stop.signal() != 0) stopped("stopped by a signal");
}

// Reads a line from the operator and feeds the module meanwhile. Without the line end; a manual clock does not advance
// here.
class Prompt {
 public:
  Prompt(Rig& rig, const StopRequest& stop, analysis::PressureUnit unit) : rig_(rig), stop_(stop), unit_(unit) {}
  // A bare number is in the unit that the question names.
  double pressure_psi(const std::string& question) {
    for (;;) {
      tty::print(stderr, "{}", question);
      const std::string text = line();
      if (text == "q") stopped("ended by the operator");
      std::optional<double> psi = sequences::typed_pressure_psi(text);
      if (!psi) psi = sequences::typed_pressure_psi(text + unit_.symbol());
      if (psi) return *psi;
      tty::print(stderr, "'{}' is not a pressure; the gauge's reading in {}, or with its own unit, or q to end\n", text,
                 unit_.symbol());
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
  analysis::PressureUnit unit_;
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
      throw devices::Fault("TB-CHAMBER-TIMEOUT", "chamber",
                           fmt::format("{} not reached within {:g} s; feedback {}", analysis::both_units(level),
                                       settling.timeout_s, analysis::both_units(feedback, 2)),
                           "check supply and leaks");
    }
  }
}

std::vector<GaugePoint> measure(Rig& rig, const CalibrationOptions& options, const StopRequest& stop,
                                analysis::PressureUnit unit) {
  std::vector<std::pair<double, bool>> course;
  for (const double level : options.levels) course.emplace_back(level, true);
  for (std::size_t i = options.levels.size(); i-- > 0;) course.emplace_back(options.levels[i], false);
  Prompt prompt(rig, stop, unit);
  std::vector<GaugePoint> points;
  for (const auto& [level, rising] : course) {
    settle(rig, level, stop);
    GaugePoint point{level, rising, 0.0, 0.0};
    for (bool likely = false; !likely;) {
      point.gauge_psi = prompt.pressure_psi(
          fmt::format("{:>2} of {}: {}, {}. Hand gauge reads [{}, q ends]: ", points.size() + 1, course.size(),
                      unit.short_text(level), rising ? "increasing" : "decreasing", unit.symbol()));
      point.reference_psi = mean_reference(rig, stop);
      const double feedback_psi = rig.source().feedback().pressure.value(), most = rig.config().limits.disagreement_psi;
      likely =
          std::min(std::abs(point.gauge_psi - point.reference_psi), std::abs(point.gauge_psi - feedback_psi)) <= most;
      if (!likely)
        tty::print(stderr,
                   "{}? the reference reads {} and the regulator's feedback {}: both differ by more than [limits] "
                   "disagreement_psi ({}). Read the gauge again, or q to end\n",
                   unit.text(point.gauge_psi, 1), unit.text(point.reference_psi, 1), unit.text(feedback_psi, 1),
                   unit.text(most, 1));
    }
    points.push_back(point);
    // A reference that does not rise is reported now, not after the last reading.
    if (points.size() > 1) calibrate_reference(points, options.uncertainty_psi, options.resolution_psi);
  }
  return points;
}

void calibrate(const CalibrationOptions& options, const Session& session) {
  BenchConfig config = read_bench(find_config(options.bench), split_overrides(options.set).bench);
  if (!config.reference_independent) {
    throw Error("TB-USAGE", "this bench has no independent reference to calibrate", options.bench,
                "set [reference] independent = true and describe the transducer or gauge");
  }
  if (options.levels.size() < 2) {
    throw Error("TB-USAGE", "a calibration needs readings at two levels or more", "--levels",
                "give rising levels within the command limit");
  }
  for (std::size_t i = 0; i < options.levels.size(); ++i) {
    const double level = options.levels[i];
    if (level >= 0.0 && level <= config.limits.command_psi && (i == 0 || level > options.levels[i - 1])) continue;
    throw Error("TB-USAGE",
                fmt::format("level {} does not rise, or is beyond {}", analysis::both_units(level),
                            analysis::both_units_span(0.0, config.limits.command_psi)),
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
    points = measure(rig, options, stop, session.unit());
  } catch (...) {
    failed = std::current_exception();
  }
  const SafeProof proof = make_safe(rig, {});
  if (proof.state == db::SafeState::kVerified) rig.dismiss_dead_man();
  print_dead_man_notices(rig);
  const std::string safe = proof.text.in(session.unit());
  tty::print(stderr, "{}\n", safe);
  if (failed) {
    throw as_error(failed, "calibrate-reference").with_rig_state(safe, proof.state == db::SafeState::kVerified);
  }
  if (proof.state != db::SafeState::kVerified) {
    throw Error("TB-SAFE-UNVERIFIED", "the safe state could not be proved", "calibrate-reference", {}, safe);
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
                JSON_FIELDS(calibration.correction, reading_psi, correction_psi, expanded_uncertainty_psi),
                JSON_FIELDS(calibration, largest_residual_psi, hysteresis_psi)});
    return;
  }
  const analysis::PressureUnit unit = session.unit();
  analysis::doc::Table table{
      .columns = {{fmt::format("reading, {}", unit.symbol()), true}, {"correction", true}, {"U (k = 2)", true}}};
  for (std::size_t i = 0; i < calibration.correction.reading_psi.size(); ++i) {
    const double correction = calibration.correction.correction_psi[i];
    table.rows.push_back({{unit.fixed(calibration.correction.reading_psi[i], 3),
                           (correction < 0.0 ? "" : "+") + unit.fixed(correction, 3),
                           unit.fixed(calibration.correction.expanded_uncertainty_psi[i], 3)}});
  }
  print_table(std::move(table));
  tty::print(
      "largest residual {}; increasing and decreasing differ by at most {}\n{} written (in psi); to use it: "
      "[reference] "
      "correction_file = \"{}\"\n",
      unit.text(calibration.largest_residual_psi, 3), unit.text(calibration.hysteresis_psi, 3), output, output);
}

}  // namespace

void add_calibrate_reference(CLI::App& devices, Session& session) {
  auto options = std::make_shared<CalibrationOptions>();
  CLI::App* verb =
      devices.add_subcommand("calibrate-reference", "calibrate the reference against a hand gauge, level by level");
  verb->add_option("--gauge", options->gauge, "the hand gauge: model, serial, certificate; recorded")->required();
  verb->add_option("--uncertainty", options->uncertainty_psi, "the gauge's expanded uncertainty, k = 2, at most 10 psi")
      ->required()
      ->transform(as_psi())
      ->check(CLI::Range(0.0, 10.0));
  verb->add_option("--resolution", options->resolution_psi, "the gauge's resolution")
      ->transform(as_psi())
      ->capture_default_str();
  verb->add_option("--levels", options->levels, "levels, increasing")
      ->delimiter(',')
      ->transform(as_psi())
      ->capture_default_str();
  verb->add_option("--set", options->set, "override table.key=value of the bench file")->take_all();
  verb->add_option("-o,--output", options->output, "file to write; default reference-SERIAL.toml");
  verb->footer(
      "Pressures of options: a number in psi, or with its unit (20kPa, 0.2bar). The gauge's readings: in the unit of "
      "--units, which the question names, or with a unit.");
  add_replace(*verb, session);
  verb->callback([options, &session] {
    options->bench = session.bench_file();
    calibrate(*options, session);
  });
}

}  // namespace tactbench::bench
