// `fit` and the verbs that use models treat every model that can be inverted like ELAM.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/bench/cli/check_refusal.h"
#include "tests/support/process.h"
#include "tests/support/small_array.h"

using namespace tactbench::tests;
using nlohmann::json;

namespace {

// Two runs of one sensor.
void two_runs(const TemporaryFolder& folder) {
  init_small_array(folder);
  write_file(folder.path("small.toml"),
             "schema = 1\nname = \"small\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 10\n"
             "repeats = 1\ndwell_s = 1.0\n");
  REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}).code == 0);
  for (const char* seed : {"1", "2"})
    REQUIRE(call(folder, {"run", "small.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "tester", "-q",
                          "--seed", seed})
                .code == 0);
  write_file(folder.path("wide.toml"),
             "schema = 1\nname = \"wide\"\nrule = \"simple\"\nmean_compensation_error_psi = 60\n"
             "worst_taxel_error_psi = 60\ndistance_of_mean_percent_fs = 100\nunfit_taxels = 64\n");
}

}  // namespace

TEST_CASE("a mount changes nothing of what fit prints and is kept with the model") {
  const TemporaryFolder folder;
  two_runs(folder);
  const Finished plain = call(folder, {"fit", "1", "--held-out", "2", "--limits", "wide.toml"});
  const Finished mounted =
      call(folder, {"fit", "1", "--held-out", "2", "--limits", "wide.toml", "--mount", "film", "-o", "m.json"});
  INFO(plain.err << mounted.err);
  REQUIRE(plain.code == 0);
  CHECK(mounted.code == 0);
  CHECK(mounted.out == plain.out);
  CHECK(json::parse(read_file(folder.path("m.json")))["validity"]["mount"] == "film");
}

TEST_CASE("every model is judged, verified, adjusted, streamed and stands as found in a report") {
  const TemporaryFolder folder;
  two_runs(folder);
  REQUIRE(call(folder, {"fit", "1", "--model", "elam"}).code == 0);
  int fits = 1;
  for (const std::string model : {"gpi", "mpi", "poly", "preisach"}) {
    INFO(model);
    const json document = json::parse(well(call(folder, {"fit", "1", "--model", model, "--starts", "1", "--held-out",
                                                         "2", "--limits", "wide.toml", "--json"}))
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
