// `fit` and the verbs that use models treat every model that can be inverted like ELAM.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/bench/cli/small_bench.h"
#include "tests/support/small_array.h"

using namespace tactbench::tests;
using nlohmann::json;

TEST_CASE("every model is judged, verified, adjusted, streamed and stands as found in a report") {
  const TemporaryFolder folder;
  init_small_array(folder);
  well(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}));
  write_file(folder.path("small.toml"), small_loop_text(10));
  write_file(folder.path("wide.toml"), limits_text("simple", 60));
  for (const char* seed : {"1", "2"}) measure_small(folder, seed);
  REQUIRE(call(folder, {"fit", "1", "--model", "elam"}).code == 0);
  int fits = 1;
  for (const std::string model : {"gpi", "mpi", "poly", "preisach"}) {
    INFO(model);
    const std::string own = "1:" + std::to_string(fits + 1);
    const json document = json::parse(well(call(folder, {"fit", "1", "--model", model, "--starts", "1"},
                                                {"judge", own, "2", "--limits", "wide.toml", "--json"}))
                                          .out);
    CHECK(document["model"] == model);
    CHECK(document["evaluations"].size() == 2);
    CHECK(document["verdicts"].size() == 4);
    const std::string name = "1:" + std::to_string(++fits);
    well(call(folder, {"verify", "1"}));
    CHECK(call(folder, {"verify", "2"}).code == 0);
    REQUIRE(call(folder, {"model", "adjust", name, "2", "--zero", "-o", model + ".json"}).code == 0);
    // The report is of ELAM, which was not judged: it needs its own evidence.
    CHECK(call(folder, {"report", "1", "--held-out", "2", "--previous", model + ".json", "-o", "r.html"}).code == 0);
    const Finished live =
        call(folder, {"live", "--bench", "bench.toml", "--model", model + ".json", "--frames", "3", "--json"});
    INFO(live.err);
    CHECK(live.code == 0);
    CHECK(json::parse(live.out)["frames"] == 3);
  }
}
