// `live` in numbers: pressures of single frames as they were recorded, lost frames between them, and what lies outside
// the model's validity in words.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/compensate/frame_compensator.h"
#include "analysis/identify/stored/model_document.h"
#include "bench/instruments/live.h"
#include "bench/reporting/evaluation.h"
#include "tests/bench/run/recorded_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

analysis::SensorModel model_of_small_run() {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  bench::RunRequest request = small_request();
  request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 10\nrepeats = 1\n"
                "[conditioning]\ncycles = 1\npeak = 60\n")};
  const bench::RunResult result = run_small(request, store);
  if (result.error) FAIL(result.error->what());
  bench::fit_run(store, analysis::load_dataset(store, result.run));
  return analysis::load_model(std::to_string(result.run), &store);
}

// Of each frame: number, then over its valid taxels how many, mean and highest pressure, mean uncertainty; how many are
// lost.
std::vector<std::string> frames_of(const std::vector<sequences::Override>& changes, const analysis::SensorModel& model,
                                   const bench::LiveOptions& options) {
  std::vector<std::string> lines;
  double last_s = -1.0;
  const bench::LiveSummary summary =
      bench::live_frames(small_request(changes).bench, model, options, [&](const bench::LiveFrame& frame) {
        CHECK(frame.time_s > last_s);
        last_s = frame.time_s;
        double sum = 0.0, highest = 0.0, uncertainty = 0.0;
        int valid = 0, lost = 0;
        for (std::size_t t = 0; t < frame.status.size(); ++t) {
          lost += (frame.status[t] & analysis::kTaxelLost) != 0 ? 1 : 0;
          if ((frame.status[t] & analysis::kTaxelValid) == 0) continue;
          ++valid;
          sum += static_cast<double>(frame.pressure_psi[t]);
          highest = std::max(highest, static_cast<double>(frame.pressure_psi[t]));
          uncertainty += static_cast<double>(frame.uncertainty_psi[t]);
        }
        lines.push_back(fmt::format("{}: {} valid, {:.3f} {:.2f} +- {:.2f} psi, {} lost", frame.number, valid,
                                    sum / std::max(1, valid), highest, uncertainty / std::max(1, valid), lost));
        return true;
      });
  lines.push_back(fmt::format("{} frames, {} lost, {}", summary.frames, summary.lost,
                              summary.other_scanner ? "another scanner" : "the same scanner"));
  lines.insert(lines.end(), summary.outside.begin(), summary.outside.end());
  CHECK(summary.median_us <= summary.p99_us);
  CHECK(summary.worst_us >= summary.p99_us);
  return lines;
}

}  // namespace

TEST_CASE("live in numbers: frames of one scan and of four, lost frames, and what lies outside the model's validity") {
  analysis::SensorModel model = model_of_small_run();
  check_lines(frames_of({}, model, {.frames = 3, .interval_s = 0.0}), R"(
0: 256 valid, 0.024 0.37 +- 4.83 psi, 0 lost
1: 256 valid, 0.026 0.61 +- 4.86 psi, 0 lost
2: 256 valid, 0.024 0.33 +- 4.86 psi, 0 lost
3 frames, 0 lost, the same scanner
)");
  check_lines(frames_of({}, model, {.frames = 2, .interval_s = 0.001, .scans = 4}), R"(
0: 256 valid, 0.021 0.39 +- 4.83 psi, 0 lost
1: 256 valid, 0.021 0.33 +- 4.85 psi, 0 lost
2 frames, 0 lost, the same scanner
)");
  check_lines(frames_of({{"simulation.wire_faults.scanner_corrupt_scan", "1"}, {"scanner.frame_timeout_ms", "2000"}},
                        model, {.frames = 4, .interval_s = 0.0}),
              R"(
0: 256 valid, 0.024 0.37 +- 4.83 psi, 0 lost
1: 0 valid, 0.000 0.00 +- 0.00 psi, 256 lost
2: 256 valid, 0.024 0.33 +- 4.86 psi, 0 lost
3: 256 valid, 0.023 0.59 +- 4.87 psi, 0 lost
4 frames, 1 lost, the same scanner
)");
  const std::vector<sequences::Override> warm = {
      {"environment.sensor", "[{quantity = 'temperature_c', unit = 9, address = 7, type = 'f32'}]"},
      {"simulation.temperature_c", "25.5"}};
  model.validity.temperature_c = analysis::Range{20.0, 21.0};
  check_lines(frames_of(warm, model, {.frames = 1, .interval_s = 0.0}), R"(
0: 0 valid, 0.000 0.00 +- 0.00 psi, 0 lost
1 frames, 0 lost, the same scanner
temperature 25.5 degC (fitted at 20.0 to 21.0)
)");
  model.validity.temperature_c = analysis::Range{20.0, 25.0};  // within what a thermometer may differ by, or not
  model.scanner_serial = "ANOTHER";
  check_lines(frames_of(warm, model, {.frames = 1, .interval_s = 0.0}), R"(
0: 0 valid, 0.000 0.00 +- 0.00 psi, 0 lost
1 frames, 0 lost, another scanner
scanner SIM-SCANNER-1 (fitted on ANOTHER)
)");
}
