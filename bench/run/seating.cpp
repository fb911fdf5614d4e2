#include "bench/run/seating.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <optional>

#include "analysis/json_fields.h"
#include "analysis/json_io.h"
#include "analysis/pressure_unit.h"
#include "analysis/statistics/sensor/seating.h"
#include "bench/common/error.h"
#include "bench/run/control/status_board.h"
#include "db/run_store.h"

namespace tactbench::bench {

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
std::optional<analysis::SeatingFrames> last_seating(const db::RunStore& store, const RunRequest& request,
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

}  // namespace

void check_seat(Sequencer& sequencer, Recorder& recorder, const db::RunStore& store, const RunRequest& request,
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

}  // namespace tactbench::bench
