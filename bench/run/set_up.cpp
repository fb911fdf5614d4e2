#include "bench/run/set_up.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "analysis/pressure_unit.h"
#include "analysis/read_whole_file.h"
#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/sensor/seating.h"
#include "bench/common/error.h"
#include "bench/common/process_time.h"
#include "bench/rig/rig.h"
#include "bench/run/control/control.h"
#include "bench/simulation/plant.h"
#include "db/run_store.h"
#include "devices/device.h"

namespace tactbench::bench {
namespace {

constexpr double kPollInterval = 15.0;  // s between two unloaded frames of the warm-up
constexpr double kConverterRange = 65535.0;

// Waits until the unloaded output drifts less than required, or the time is up. Returns the newest unloaded frame;
// `cold` where there is nothing to wait for.
UnloadedFrame warm_up(Sequencer& sequencer, Recorder& recorder, const sequences::WarmUp& rule,
                      const UnloadedFrame& cold, StatusBoard& board) {
  if (rule.at_most_s <= 0.0) return cold;
  board.phase(fmt::format("warming up, at most {:.0f} min", rule.at_most_s / 60.0));
  Rig& rig = sequencer.rig();
  const devices::Nanoseconds start = rig.clock().now();
  std::vector<double> drifts;
  std::string flags;
  UnloadedFrame frame = unloaded_frame_of(sequencer.read_array(flags));
  double before = analysis::mean_of(frame);
  bool calm = false;
  while (!calm && rig.clock().now() - start < seconds(rule.at_most_s)) {
    sequencer.hold_vented(kPollInterval);
    frame = unloaded_frame_of(sequencer.read_array(flags));
    const double now = analysis::mean_of(frame);
    drifts.push_back(100.0 * std::abs(now - before) / kConverterRange * 60.0 / kPollInterval);
    before = now;
    calm = drifts.back() < rule.drift_percent_per_min;
  }
  const double took_s = std::chrono::duration<double>(rig.clock().now() - start).count();
  const nlohmann::ordered_json detail = {{"took_s", took_s},
                                         {"last_drift_percent_per_min", drifts.empty() ? 0.0 : drifts.back()},
                                         {"limit_percent_per_min", rule.drift_percent_per_min},
                                         {"at_most_s", rule.at_most_s}};
  recorder.check("warm-up", calm ? "pass" : "warning", analysis::json_line(detail), drifts);
  return frame;
}

}  // namespace

void record_environment(Rig& rig, Recorder& recorder) {
  for (const EnvironmentReading& reading : rig.environment()) {
    recorder.event("environment", reading.quantity, fmt::format("{:.3f}", reading.value));
  }
}

void check_scanner(const RunRequest& request, const std::string& serial) {
  if (request.sensor.scanner_serial.empty() || serial == request.sensor.scanner_serial) return;
  throw devices::Fault("TB-SCANNER-SERIAL", "tactile scanner",
                       fmt::format("scanner '{}' answers, but sensor '{}' is registered with scanner '{}'", serial,
                                   request.sensor.serial, request.sensor.scanner_serial),
                       "connect the registered scanner, or register the pair as a separate sensor: swapped read-out "
                       "electronics change the calibration");
}

namespace {

constexpr double kHighestPsi = 8.0;
constexpr double kLowestPsi = 5.0;  // below, weak taxels do not respond
// Fast creep is over after 20 s; after the vent the film rests for 10 s.
constexpr double kLoadedDwell = 20.0, kVentedDwell = 10.0;

sequences::Step at_level(double psi, double dwell_s) {
  sequences::Step step;
  step.kind = sequences::StepKind::kConditioning;
  step.branch = -1;
  step.setpoint = devices::Psi(psi);
  step.dwell_s = dwell_s;
  return step;
}

std::vector<double> in_volts(const double* counts, std::size_t taxels, double volts_per_count) {
  std::vector<double> volts(counts, counts + taxels);
  for (double& value : volts) value *= volts_per_count;
  return volts;
}

// Empty where no check has this shape.
std::optional<analysis::SeatingFrames> last_seating(const db::RunReader& store, const RunRequest& request,
                                                    std::int64_t run, std::size_t taxels) {
  for (const char* verdict : {"pass", "warning"}) {
    // A resumed run is compared with its own first seating.
    const std::optional<db::CheckRecord> check = store.last_check(request.sensor.serial, "seating", verdict, run + 1);
    if (!check || check->data.size() != 2 * taxels) continue;
    const nlohmann::json detail = analysis::parse_json(check->detail_json);
    const double volts_per_count = detail.at("volts_per_count");
    analysis::SeatingFrames frames;
    frames.pressure_psi = detail.at("pressure_psi");
    frames.unloaded_v = in_volts(check->data.data(), taxels, volts_per_count);
    frames.loaded_v = in_volts(check->data.data() + taxels, taxels, volts_per_count);
    return frames;
  }
  return std::nullopt;
}

// Only what this run measured and found: the same run in another store has the same content.
std::string detail_of(const analysis::SeatingResult& result, const analysis::SeatingFrames& now, int rows, int columns,
                      double volts_per_count) {
  nlohmann::ordered_json json = {{"pressure_psi", now.pressure_psi},
                                 {"rows", rows},
                                 {"columns", columns},
                                 {"volts_per_count", volts_per_count},
                                 JSON_FIELDS(result, mean_response_v, dead_taxels),
                                 {"findings", nlohmann::ordered_json::array()}};
  for (const analysis::SeatingFinding& finding : result.findings) {
    json["findings"].push_back({JSON_FIELDS(finding, kind, verdict, rows, columns, text)});
  }
  return analysis::json_line(json);
}

std::string why_not(const RunRequest& request, const sequences::Extremes& extremes, double psi) {
  if (!request.check_seating) return "skipped as requested (--no-seating)";
  if (!extremes.pressurizes) return "skipped: no recipe puts pressure on the array";
  if (psi < kLowestPsi) return "skipped: the recipes stay below " + analysis::both_units(kLowestPsi);
  return {};
}

// Seating check of a run: loads the array lightly, evaluates the seating (analysis) and stores the result.
// About half a minute at 8 psi or the recipes' highest level, if that is lower, then vented. The result is compared
// with the sensor's last passed seating, else with its last seating marked as a warning. Stores a check "seating"; its
// data are the unloaded and then the loaded mean counts, rows x columns each. Skipped, with an event, if the request or
// the recipes use no pressure. Warnings go to `board`. Throws Error TB-SEATING and the exceptions of the sequencer.
void check_seat(Sequencer& sequencer, Recorder& recorder, const db::RunReader& store, const RunRequest& request,
                const UnloadedFrame& unloaded, StatusBoard& board) {
  const sequences::Extremes extremes = sequences::extremes(sequences::compile(request.recipes));
  const double psi = std::min(kHighestPsi, extremes.highest.value());
  if (const std::string reason = why_not(request, extremes, psi); !reason.empty()) {
    return recorder.event("seating", "", reason);
  }
  Rig& rig = sequencer.rig();
  const double volts_per_count = rig.array().volts_per_count().value();
  analysis::SeatingFrames now;
  const devices::ScanSet scans = [&] {
    const TimeSpent::Stretch stretch(sequencer.times(), Spent::kSetup);
    board.phase("checking the seating at " + analysis::both_units(psi));
    sequencer.chamber_step(at_level(psi, kLoadedDwell));
    now.pressure_psi = sequencer.last().reference.pressure.value();
    std::string flags;
    devices::ScanSet read = sequencer.read_array(flags);
    board.phase("checking the seating: without pressure again");
    sequencer.chamber_step(at_level(0.0, kVentedDwell));
    return read;
  }();
  const UnloadedFrame loaded = unloaded_frame_of(scans);
  now.unloaded_v = in_volts(unloaded.data(), unloaded.size(), volts_per_count);
  now.loaded_v = in_volts(loaded.data(), loaded.size(), volts_per_count);
  const auto last = last_seating(store, request, recorder.run(), loaded.size());
  const analysis::SeatingResult result = analysis::check_seating(scans.rows, scans.columns, now, last);
  UnloadedFrame data = unloaded;
  data.insert(data.end(), loaded.begin(), loaded.end());
  recorder.check("seating", result.verdict, detail_of(result, now, scans.rows, scans.columns, volts_per_count),
                 std::move(data));
  std::vector<std::string> failed;
  for (const analysis::SeatingFinding& finding : result.findings) {
    if (finding.verdict == "fail") {
      failed.push_back(finding.text);
    } else {
      recorder.event("warning", "TB-SEATING", finding.text);
      board.note("seating: " + finding.text);
    }
  }
  if (failed.empty()) return;
  throw Error(
      "TB-SEATING", fmt::format("{}", fmt::join(failed, "; ")),
      fmt::format("sensor {}, seating check at {}", request.sensor.serial, analysis::both_units(now.pressure_psi, 1)));
}

}  // namespace

void prepare_sensor(Sequencer& sequencer, Recorder& recorder, const db::RunReader& store, const RunRequest& request,
                    const UnloadedFrame& baseline, StatusBoard& board) {
  (void)sequencer.times().start(Spent::kSetup);
  const UnloadedFrame unloaded = warm_up(sequencer, recorder, request.recipes.front().warm_up, baseline, board);
  check_seat(sequencer, recorder, store, request, unloaded, board);
}

void load_specimen(Rig& rig, const std::string& file) {
  if (file.empty() || rig.plant() == nullptr || !std::filesystem::exists(file)) return;
  constexpr std::size_t kLargestState = 256'000'000;  // bytes; 64 x 64 taxels need about a hundredth
  try {
    rig.plant()->set_specimen_state(analysis::read_whole_file(file, {kLargestState}, "TB-SPECIMEN-STATE", ""));
  } catch (const std::exception& error) {
    throw Error("TB-SPECIMEN-STATE", fmt::format("not a specimen state: {}", error.what()), file);
  }
}

void save_specimen(Rig& rig, const std::string& file) {
  if (file.empty() || rig.plant() == nullptr) return;
  std::ofstream stream(file);
  stream << rig.plant()->specimen_state();
  if (!stream.flush()) {
    throw Error("TB-SPECIMEN-STATE", "cannot write the specimen state", file, "check folder and space");
  }
}

// A rig simulated in this process gets the recipe's object on its stage.
BenchConfig with_object(BenchConfig bench, const std::vector<sequences::Recipe>& recipes) {
  if (!bench.simulation) return bench;
  constexpr std::array<std::pair<const char*, Footprint>, 3> kObjects = {
      {{"ring", Footprint::kRing}, {"point", Footprint::kPoint}, {"flat", Footprint::kFlat}}};
  for (const sequences::Recipe& recipe : recipes) {
    for (const auto& [word, footprint] : kObjects) {
      if (recipe.press.object != word) continue;
      bench.simulation->plant.contact.object = footprint;
      return bench;
    }
  }
  return bench;
}

}  // namespace tactbench::bench
