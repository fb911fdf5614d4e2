// `live` over the simulated scanner's wire: its pressures, its lost frames, its end.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "analysis/compensate/compensator.h"
#include "bench/instruments/live.h"
#include "bench/reporting/evaluation.h"
#include "devices/device.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// A fitted run of the small recipe up to 60 psi.
std::int64_t fitted_run(const std::string& path, const std::vector<sequences::Override>& overrides = {}) {
  db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
  bench::RunRequest request = small_request(overrides);
  request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 10\nrepeats = 1\n"
                "[conditioning]\ncycles = 1\npeak = 60\n")};
  const bench::RunResult result = run_small(request, store);
  if (result.error) FAIL(result.error->what());
  bench::fit_run(store, analysis::load_dataset(store, result.run));
  return result.run;
}

// Of the last frame in the table that `live --csv` wrote, what its lines say.
struct LastFrame {
  int flat = 0, unknown = 0, out_of_range = 0, dead = 0, outside = 0, lost = 0, taxels = 0;
  double sum_psi = 0.0, highest_psi = 0.0;
};
LastFrame last_frame_of(const std::string& table, int frame) {
  LastFrame last;
  std::istringstream lines(table);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(std::to_string(frame) + ",")) continue;
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    const unsigned bits = static_cast<unsigned>(std::stoul(cells.at(5)));
    const double psi = std::stod(cells.at(3));
    const auto has = [&](unsigned bit) { return (bits & bit) != 0 ? 1 : 0; };
    last.flat += has(analysis::kTaxelFlat);
    last.unknown += has(analysis::kTaxelUnknown);
    last.out_of_range += has(analysis::kTaxelOutOfRange);
    last.dead += has(analysis::kTaxelDead);
    last.outside += has(analysis::kTaxelOutside);
    last.lost += has(analysis::kTaxelLost);
    if (has(analysis::kTaxelDead) != 0) continue;
    ++last.taxels;
    last.sum_psi += psi;
    last.highest_psi = last.taxels == 1 ? psi : std::max(last.highest_psi, psi);
  }
  return last;
}

}  // namespace

TEST_CASE("live: its summary of the last frame agrees with the written table") {
  const TemporaryFolder folder;
  const std::int64_t run =
      fitted_run(folder.path("runs.db"), {{"simulation.defect", "[{kind=\"dead\",row=2,column=5}]"}});
  const auto live = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"live",    "--bench", "simulated.toml", "--model", std::to_string(run),
                                      "--db",    "runs.db", "--interval",     "0",       "--csv",
                                      "live.csv"};
    words.insert(words.end(), more.begin(), more.end());
    return run_program(program_path(), words, folder.path());
  };
  for (const bool elsewhere : {false, true}) {
    std::vector<std::string> words = {"--frames", "3", "--json"};
    if (elsewhere) words.insert(words.end(), {"--set", "simulation.scanner_serial=\"ANOTHER\""});
    const Finished done = live(words);
    INFO(done.err);
    REQUIRE(done.code == 0);
    const std::string table = read_file(folder.path("live.csv"));
    CHECK(table.starts_with("frame,time_s,taxel,pressure_psi,uncertainty_psi,status\n0,"));
    const LastFrame last = last_frame_of(table, 2);
    CHECK(last.dead == 1);
    CHECK(last.taxels == 255);
    CHECK((last.outside > 0) == elsewhere);
    const auto printed = nlohmann::json::parse(done.out);
    CHECK(printed.at("frames") == 3);
    CHECK(printed.at("lost_frames") == 0);
    CHECK(printed.at("origin") == "simulated");
    CHECK(printed.at("outside_validity").empty() == !elsewhere);
    const auto& frame = printed.at("last_frame");
    CHECK(frame.at("mean_psi").get<double>() == Approx(last.sum_psi / 255).margin(1e-3));
    CHECK(frame.at("highest_psi").get<double>() == Approx(last.highest_psi).margin(1e-3));
    CHECK(frame.at("flat") == last.flat);
    CHECK(frame.at("unknown") == last.unknown);
    CHECK(frame.at("out_of_range") == last.out_of_range);
    CHECK(frame.at("dead") == 1);
    CHECK(frame.at("outside_validity") == last.outside);
    CHECK(frame.at("lost") == last.lost);
  }
  const Finished by_integers = live({"--frames", "3", "--json", "--as", "fixed"});
  REQUIRE(by_integers.code == 0);
  const std::string table = read_file(folder.path("live.csv"));
  const LastFrame last = last_frame_of(table, 2);
  CHECK(last.dead == 1);
  CHECK(last.unknown == 0);  // unloaded, at its zero
  CHECK(last.sum_psi / 255 == Approx(0.0).margin(1.0));
  CHECK_THAT(table, Catch::Contains(",nan,"));  // without uncertainty
  const Finished elsewhere = live({"--frames", "1", "-q", "--set", "simulation.scanner_serial=\"ANOTHER\""});
  CHECK_THAT(elsewhere.err, Catch::Contains("ANOTHER"));
  const Finished wrong = run_program(
      program_path(), {"live", "--bench", "simulated.toml", "--model", "seven", "--db", "runs.db"}, folder.path());
  CHECK(wrong.code == 2);
}

TEST_CASE("live: Ctrl-C ends it cleanly") {
  const TemporaryFolder folder;
  const std::int64_t run = fitted_run(folder.path("runs.db"));
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
}

TEST_CASE("live: an unloaded array reads near zero, latency is measured, lost frames are counted") {
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

  shown = 0;
  const bench::BenchConfig silent =
      small_request({{"simulation.wire_faults.scanner_silent_after_scans", "3"}, {"scanner.frame_timeout_ms", "200"}})
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
  try {
    (void)bench::live_frames(small_request().bench, other, {}, see);
    FAIL("a model of another array was taken");
  } catch (const bench::Error& error) {
    CHECK(error.id() == "TB-LIVE-SHAPE");
    CHECK(error.code() == bench::ExitCode::kUsage);
  }
}

TEST_CASE("live: a damaged scan is counted as a lost frame, and temperature includes the U of its thermometer") {
  const TemporaryFolder folder;
  const std::int64_t run = fitted_run(folder.path("runs.db"));
  const db::RunStore store = db::RunStore::open_read_only(folder.path("runs.db"));
  analysis::SensorModel model = analysis::load_model(std::to_string(run), &store);
  const auto carried = [&](const std::vector<sequences::Override>& changes, const bench::LiveOptions& options,
                           bench::LiveSummary& summary) {
    std::vector<int> valid;
    double last_s = -1.0;
    summary = bench::live_frames(small_request(changes).bench, model, options, [&](const bench::LiveFrame& frame) {
      CHECK(frame.time_s > last_s);
      last_s = frame.time_s;
      valid.push_back(static_cast<int>(
          std::ranges::count_if(frame.status, [](unsigned bits) { return (bits & analysis::kTaxelValid) != 0; })));
      return true;
    });
    return valid;
  };
  bench::LiveSummary summary;
  CHECK(carried({{"simulation.wire_faults.scanner_corrupt_scan", "1"}, {"scanner.frame_timeout_ms", "2000"}},
                {.frames = 4, .interval_s = 0.0}, summary) == std::vector<int>{256, 0, 256, 256});
  CHECK((summary.frames == 4 && summary.lost == 1 && summary.outside.empty()));
  CHECK(carried({}, {.frames = 2, .interval_s = 0.001, .scans = 4}, summary) == std::vector<int>{256, 256});
  const std::vector<sequences::Override> warm = {
      {"environment.sensor", "[{quantity = 'temperature_c', unit = 9, address = 7, type = 'f32'}]"},
      {"simulation.temperature_c", "25.5"}};
  model.validity.temperature_c = analysis::Range{20.0, 25.0};  // within what a thermometer may differ by
  CHECK(carried(warm, {.frames = 1, .interval_s = 0.0}, summary) == std::vector<int>{256});
  model.validity.temperature_c = analysis::Range{20.0, 21.0};
  CHECK(carried(warm, {.frames = 1, .interval_s = 0.0}, summary) == std::vector<int>{0});
  REQUIRE(summary.outside.size() == 1);
  CHECK_THAT(summary.outside[0], Catch::Contains("25.5") && Catch::Contains("21.0"));
}
