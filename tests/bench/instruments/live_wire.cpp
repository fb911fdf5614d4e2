// `live` over the simulated scanner's wire: its pressures, its lost frames, its end.
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <filesystem>

#include "analysis/compensate/frame_compensator.h"
#include "bench/instruments/live.h"
#include "bench/reporting/evaluation.h"
#include "devices/fault.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// A fitted run of the small recipe up to 60 psi.
std::int64_t fitted_run(const std::string& path) {
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  bench::RunRequest request = small_request();
  request.recipes = {sequences::parse_recipe(sequences::TomlDocument::from_text(
      "schema = 1\nname = \"small\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 10\nrepeats = 1\n"
      "[conditioning]\ncycles = 1\npeak = 60\n",
      "small.toml"))};
  const bench::RunResult result = run_small(request, store);
  if (result.error) FAIL(result.error->what());
  bench::fit_run(store, analysis::load_dataset(store, result.run));
  return result.run;
}

}  // namespace

TEST_CASE("live: frames of an unloaded array are near zero, its latency is measured, lost frames are counted") {
  const TemporaryFolder folder;
  const std::int64_t run = fitted_run(folder.path("runs.db"));
  const db::RunStore store = db::RunStore::open_read_only(folder.path("runs.db"));
  const analysis::SensorModel model = analysis::load_model(std::to_string(run), &store);
  CHECK(model.taxels.size() == 257);
  CHECK(model.scans == 2);
  long shown = 0;
  double highest = 0.0;
  const auto see = [&](const bench::LiveFrame& frame) {
    CHECK(frame.number == shown++);
    CHECK(frame.latency_us > 0.0);
    for (std::size_t t = 0; t < frame.status.size(); ++t)
      if ((frame.status[t] & analysis::kTaxelValid) != 0)
        highest = std::max(highest, static_cast<double>(frame.pressure_psi[t]));
    return true;
  };
  const bench::LiveSummary summary =
      bench::live_frames(small_request().bench, model, {.frames = 50, .interval_s = 0.0}, see);
  CHECK(summary.frames == 50);
  CHECK(shown == 50);
  CHECK(summary.lost == 0);
  CHECK_FALSE(summary.other_scanner);
  CHECK(highest < 5.0);
  CHECK(summary.median_us > 0.0);
  CHECK(summary.median_us <= summary.p99_us);
  CHECK(summary.p99_us <= summary.worst_us);
  CHECK(summary.compensation_median_us < summary.median_us);
  WARN("request to compensated values: median " << summary.median_us << " us, p99 " << summary.p99_us << ", worst "
                                                << summary.worst_us << ", compensation "
                                                << summary.compensation_median_us);

  shown = 0;
  const bench::BenchConfig silent =
      small_request({{"simulation.wire_faults.scanner_silent_after_scans", "3"}, {"scanner.frame_timeout_ms", "20"}})
          .bench;
  CHECK_THROWS_AS(bench::live_frames(silent, model, {.frames = 50, .interval_s = 0.0}, see), devices::Fault);
  CHECK(shown == 3 + 9);  // the tenth loss in a row ends it

  analysis::SensorModel other = analysis::load_model(std::to_string(run), &store);
  other.scanner_serial = "ANOTHER";
  bool valid = false;
  const auto outside = bench::live_frames(small_request().bench, other, {.frames = 2, .interval_s = 0.0},
                                          [&](const bench::LiveFrame& frame) {
                                            for (const unsigned bits : frame.status)
                                              valid = valid || (bits & analysis::kTaxelValid) != 0;
                                            return true;
                                          });
  CHECK(outside.other_scanner);
  CHECK_FALSE(valid);
  // Nobody looks any more.
  const auto once = [](const bench::LiveFrame&) { return false; };
  CHECK(bench::live_frames(small_request().bench, model, {.frames = 0, .interval_s = 0.0}, once).frames == 1);
  other.rows = 8;
  CHECK_THROWS_AS(bench::live_frames(small_request().bench, other, {}, see), bench::Error);
}

TEST_CASE("live: the verb prints JSON and writes a table, Ctrl-C ends it cleanly") {
  const TemporaryFolder folder;
  const std::int64_t run = fitted_run(folder.path("runs.db"));
  const Finished done = run_program(program_path(),
                                    {"live", "--bench", "simulated.toml", "--model", std::to_string(run), "--db",
                                     "runs.db", "--frames", "5", "--csv", "live.csv", "--json"},
                                    folder.path());
  INFO(done.out << done.err);
  CHECK(done.code == 0);
  CHECK_THAT(done.out, Catch::Contains("\"frames\": 5"));
  const std::string table = read_file(folder.path("live.csv"));
  CHECK(std::count(table.begin(), table.end(), '\n') == 1 + 5 * 256);
  const Finished stopped = run_program(
      program_path(),
      {"live", "--bench", "simulated.toml", "--model", std::to_string(run), "--db", "runs.db", "--csv", "endless.csv"},
      folder.path(), {SIGINT, [&] {
                        std::error_code not_yet;
                        const auto size = std::filesystem::file_size(folder.path("endless.csv"), not_yet);
                        return !not_yet && size > 10'000;  // frames, not the heading alone
                      }});
  INFO(stopped.out << stopped.err);
  CHECK(stopped.code == 0);
  CHECK_THAT(stopped.out, Catch::Contains("request to compensated values"));
  const Finished wrong = run_program(
      program_path(), {"live", "--bench", "simulated.toml", "--model", "seven", "--db", "runs.db"}, folder.path());
  CHECK(wrong.code == 2);
}
