// What the page's picture of a run holds, number by number, and which earlier run's models it is shown through.
#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "analysis/compensate/frame_compensator.h"
#include "analysis/dataset.h"
#include "bench/page/frames.h"
#include "bench/reporting/evaluation.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

std::vector<double> numbers_in(const std::string& text) {
  const std::string letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0, held = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6U | static_cast<unsigned>(letters.find(c));
    held += 6;
    if (held < 8) continue;
    held -= 8;
    bytes += static_cast<char>(bits >> held & 255U);
  }
  std::vector<double> numbers;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2)
    numbers.push_back(static_cast<unsigned char>(bytes[i]) + 256.0 * static_cast<unsigned char>(bytes[i + 1]));
  return numbers;
}

// Ends at 30 psi, on the way down from 60.
std::int64_t run_to_30_psi(db::RunStore& store, std::uint64_t seed) {
  bench::RunRequest request = small_request({}, {seed, 1});
  request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [0, 60, 0, 60, 30]\nstep = 10\nrepeats = 1\n[conditioning]\n"
                "cycles = 1\npeak = 60\n")};
  const bench::RunResult result = run_small(request, store);
  REQUIRE(result.outcome == db::Outcome::kCompleted);
  return result.run;
}

nlohmann::json picture_of(const db::RunStore& store, std::int64_t run) {
  bench::RunFrames frames(store, store.run(run));
  CHECK(frames.picture().is_null());
  CHECK(frames.advance());
  CHECK_FALSE(frames.advance());
  return frames.picture();
}

}  // namespace

TEST_CASE("page pictures: the newest frame's counts, pressures and times, and all points of loops") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  const std::int64_t run = run_to_30_psi(store, 1);
  const std::vector<db::FrameRecord> frames = store.frames(run);
  const db::FrameRecord& last = frames.back();
  const nlohmann::json picture = picture_of(store, run);
  CHECK(picture["run"] == run);
  CHECK(picture["position"] == frames.size());
  CHECK(picture["volts_per_count"].get<double>() == Approx(5.0 / 65535.0).epsilon(1e-6));
  CHECK(picture["time_s"].get<double>() == Approx(static_cast<double>(last.time_ns) / 1e9));
  CHECK(picture["setpoint_psi"] == 30.0);
  CHECK(picture["feedback_psi"] == last.feedback_psi);
  CHECK(picture["reference_psi"] == last.reference_psi);
  CHECK(picture["void"] == false);
  for (const char* none : {"press", "psi", "model", "unknown", "out_of_range"}) CHECK_FALSE(picture.contains(none));
  const std::vector<double> counts = numbers_in(picture["counts"]);
  REQUIRE(counts.size() == 256);
  REQUIRE(last.counts.size() % 256 == 0);
  const auto mean_of = [](const db::FrameRecord& frame, std::size_t taxel) {
    double sum = 0.0, scans = 0.0;
    for (std::size_t at = taxel; at < frame.counts.size(); at += 256, scans += 1.0) sum += frame.counts[at];
    return sum / scans;
  };
  for (std::size_t t = 0; t < 256; ++t) CHECK(std::abs(counts[t] - mean_of(last, t)) <= 0.5001);

  for (const int taxel : {0, 255}) {
    const nlohmann::json loop = bench::loop_points(store, run, taxel, 0);
    CHECK((loop["run"] == run && loop["taxel"] == taxel && loop["axis"] == "psi" && loop["last"] == frames.size()));
    REQUIRE((loop["x"].size() == frames.size() && loop["y"].size() == frames.size()));
    for (std::size_t i = 0; i < frames.size(); ++i) {
      CHECK(std::abs(loop["x"][i].get<double>() - frames[i].reference_psi) <= 0.00051);
      CHECK(std::abs(loop["y"][i].get<double>() -
                     mean_of(frames[i], static_cast<std::size_t>(taxel)) * 5.0 / 65535.0) <= 0.0000051);
      CHECK(std::abs(std::remainder(loop["x"][i].get<double>(), 0.001)) < 1e-9);
      CHECK(std::abs(std::remainder(loop["y"][i].get<double>(), 0.00001)) < 1e-9);
    }
  }
  CHECK(bench::loop_points(store, run, 256, 0)["x"].empty());
  CHECK(bench::loop_points(store, run, 256, 0)["last"] == frames.size());
  const auto end = static_cast<std::int64_t>(frames.size());
  CHECK(bench::loop_points(store, run, 0, end - 1)["x"].size() == 1);
  const nlohmann::json nothing = bench::loop_points(store, run, 0, end);
  CHECK((nothing["x"].empty() && nothing["last"] == end));
}

TEST_CASE("page pictures: pressures through the newest earlier run of the sensor that has models and counts") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  const std::int64_t first = run_to_30_psi(store, 1), second = run_to_30_psi(store, 2), shown = run_to_30_psi(store, 3);
  bench::fit_run(store, analysis::load_dataset(store, first));
  bench::fit_run(store, analysis::load_dataset(store, second));
  const nlohmann::json picture = picture_of(store, shown);
  CHECK(picture["model"] == "elam of run " + std::to_string(second));
  const std::vector<double> hundredths = numbers_in(picture["psi"]);
  REQUIRE(hundredths.size() == 256);
  double sum = 0.0, farthest = 0.0;
  for (const double psi : hundredths) {
    sum += psi / 256.0;
    farthest = std::max(farthest, std::abs(psi - 3000.0));
  }
  CHECK(sum == Approx(3000.0).margin(100.0));
  CHECK(farthest < 1000.0);
  CHECK(picture["out_of_range"] == 0);
  CHECK(picture["unknown"].get<int>() >= 0);
  // A void run's models count no more; neither do those of a later run, nor its own.
  store.void_run(second, "wrong sensor", "K. Lee", "2026-01-01T00:00:00Z");
  CHECK(picture_of(store, shown)["model"] == "elam of run " + std::to_string(first));
  CHECK_FALSE(picture_of(store, first).contains("model"));
  bench::fit_run(store, analysis::load_dataset(store, shown));
  CHECK(picture_of(store, shown)["model"] == "elam of run " + std::to_string(first));
  // Another sensor's run.
  bench::RunRequest other = small_request();
  other.sensor.serial = "S-2";
  const bench::RunResult of_other = run_small(other, store);
  CHECK_FALSE(picture_of(store, of_other.run).contains("psi"));
}
