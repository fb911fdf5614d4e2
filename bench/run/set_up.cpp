#include "bench/run/set_up.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "analysis/json_io.h"
#include "analysis/read_whole_file.h"
#include "analysis/statistics/numbers/moments.h"
#include "bench/common/error.h"
#include "bench/common/process_time.h"
#include "bench/rig/rig.h"
#include "bench/run/control/status_board.h"
#include "bench/run/seating.h"
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

void prepare_sensor(Sequencer& sequencer, Recorder& recorder, const db::RunStore& store, const RunRequest& request,
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
