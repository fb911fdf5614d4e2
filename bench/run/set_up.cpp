#include "bench/run/set_up.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "analysis/json_io.h"
#include "analysis/statistics/numbers/moments.h"
#include "bench/common/process_time.h"
#include "bench/run/control/status_board.h"
#include "bench/run/seating.h"
#include "db/run_store.h"
#include "devices/fault.h"

namespace tactbench::bench {

namespace {

constexpr double kPollInterval = 15.0;  // s between two unloaded frames of the warm-up
constexpr double kConverterRange = 65535.0;

// Waits until the unloaded output drifts less than required, or the time is up. Returns the newest unloaded frame;
// `cold` where there is nothing to wait for.
Baseline warm_up(Sequencer& sequencer, Recorder& recorder, const sequences::WarmUp& rule, const Baseline& cold,
                 StatusBoard& board) {
  if (rule.at_most_s <= 0.0) return cold;
  board.phase(fmt::format("warming up, at most {:.0f} min", rule.at_most_s / 60.0));
  Rig& rig = sequencer.rig();
  const devices::Nanoseconds start = rig.clock().now();
  std::vector<double> drifts;
  std::string flags;
  Baseline frame = baseline_of(sequencer.read_array(flags));
  double before = analysis::mean_of(frame);
  bool calm = false;
  while (!calm && rig.clock().now() - start < seconds(rule.at_most_s)) {
    sequencer.hold_vented(kPollInterval);
    frame = baseline_of(sequencer.read_array(flags));
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
                       "connect the registered scanner, or register the pair as a sensor of its own: swapped read-out "
                       "electronics change the calibration");
}

void prepare_sensor(Sequencer& sequencer, Recorder& recorder, const db::RunStore& store, const RunRequest& request,
                    const Baseline& baseline, StatusBoard& board) {
  (void)sequencer.times().start(Spent::kSetup);
  const Baseline unloaded = warm_up(sequencer, recorder, request.recipes.front().warm_up, baseline, board);
  check_seat(sequencer, recorder, store, request, unloaded, board);
}

}  // namespace tactbench::bench
