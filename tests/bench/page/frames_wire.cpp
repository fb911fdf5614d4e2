// The page's picture, loops and safe state from the store of a real run on the simulated rig.
#include "bench/page/frames.h"

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "bench/page/lists.h"
#include "bench/page/run_on_show.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("page frames: loops hold every frame that counts, and go on behind a place") {
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  const bench::RunResult result = run_small(small_request(), store);
  REQUIRE(result.outcome == db::Outcome::kCompleted);
  const auto frames = store.frames(result.run);
  const nlohmann::json mean = bench::loop_points(store, result.run, -1, 0);
  REQUIRE(mean["x"].size() == frames.size());
  CHECK(mean["last"] == frames.size());
  CHECK(mean["axis"] == "psi");
  const double scale = bench::array_basis(store, store.run(result.run))->volts_per_count;
  for (const std::size_t i : {std::size_t{0}, frames.size() / 2, frames.size() - 1}) {
    double sum = 0.0;
    for (const std::uint16_t count : frames[i].counts) sum += count;
    CHECK(mean["y"][i].get<double>() ==
          Approx(sum / static_cast<double>(frames[i].counts.size()) * scale).margin(1e-5));
    CHECK(mean["x"][i].get<double>() == Approx(frames[i].reference_psi).margin(1e-3));
  }
  const nlohmann::json taxel = bench::loop_points(store, result.run, 17, 10);
  CHECK(taxel["x"].size() == frames.size() - 10);
  CHECK(bench::loop_points(store, result.run, 9999, 0)["x"].empty());

  bench::RunFrames shown(store, store.run(result.run));
  CHECK(shown.advance());
  CHECK_FALSE(shown.advance());
  const nlohmann::json picture = shown.picture();
  CHECK(picture["position"] == frames.size());
  CHECK((picture["rows"] == 16 && picture["columns"] == 16));
  CHECK(picture["counts"].get<std::string>().size() == 4 * ((512 + 2) / 3));
  CHECK_FALSE(picture.contains("psi"));  // there are no models yet

  bench::RunOnShow show(folder.path("runs.db"), "");
  show.look(nullptr);
  const nlohmann::json state = show.state(nullptr, 0.0);
  CHECK(state["live"] == false);
  CHECK(state["origin"] == "simulated");
  CHECK(state["safe"]["state"] == "proved");
  CHECK(state["view"]["run"] == result.run);
  CHECK_FALSE(state["events"].empty());
  CHECK(bench::runs_list(store)["runs"][0]["verdict"] == "-");
  CHECK(bench::sensors_list(store)["sensors"][0]["runs"][0] == result.run);
}
