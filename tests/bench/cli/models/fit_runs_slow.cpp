// `fit` of runs that the simulated rig made in seconds: figures, judgement, scores, limits of the profile, many runs.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/common/build_info.h"
#include "db/run_store.h"
#include "tests/bench/cli/small_bench.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

using FitRunWords = std::vector<std::string>;

// Runs 1 and 2 of one recipe with an inner loop, and run 3 of one without.
struct FolderOfRuns {
  FolderOfRuns() {
    REQUIRE(call(folder, {"init", "--operator", "tester"}).code == 0);
    REQUIRE(call(folder, {"sensors", "add", "S-1"}).code == 0);
    const std::string head = "schema = 1\nunit = \"psi\"\nstep = 10\nrepeats = 1\ndwell_s = 1.0\n";
    write_file(folder.path("a.toml"), head + "name = \"small\"\nturning_points = [0, 60, 20, 60, 0]\n");
    write_file(folder.path("b.toml"), head + "name = \"loop\"\nturning_points = [0, 60, 0]\n");
    for (const char* recipe : {"./a.toml", "./a.toml", "./b.toml"})
      REQUIRE(call(folder, {"run", recipe, "--bench", "bench.toml", "--sensor", "S-1", "-q", "--no-seating"}).code ==
              0);
    write_file(folder.path("wide.toml"), limits_text("simple", 60));
    write_file(folder.path("strict.toml"), limits_text("simple", 0.001));
  }
  Finished fit(FitRunWords words) const {
    words.insert(words.begin(), "fit");
    return call(folder, words);
  }
  nlohmann::json told(FitRunWords words) const {
    words.emplace_back("--json");
    const Finished finished = fit(std::move(words));
    INFO(finished.err);
    REQUIRE_FALSE(finished.out.empty());
    return nlohmann::json::parse(finished.out);
  }
  std::size_t models() const {
    const db::RunStore store = db::RunStore::open_read_only(folder.path("runs.db"));
    std::size_t count = 0;
    for (const db::RunRecord& run : store.runs()) count += store.fits(run.run).size();
    return count;
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("fit and judge of runs: one model, its verdict as JSON and by the exit code") {
  const FolderOfRuns of;
  CHECK(of.fit({"1", "--model", "mpi", "-o", "m.json"}).code == 0);
  CHECK(of.models() == 1);
  const nlohmann::json document = nlohmann::json::parse(read_file(of.folder.path("m.json")));
  CHECK(document.at("model") == "mpi");
  CHECK(document.at("program_version") == bench::build_info().version);
  const auto judge = [&](const FitRunWords& more) { return call(of.folder, joined_words({"judge", "1:1"}, more)); };
  CHECK(judge({"2", "--limits", "./wide.toml"}).code == 0);
  CHECK(judge({"2", "--limits", "./strict.toml"}).code == 1);
  const nlohmann::json strict = nlohmann::json::parse(judge({"2", "--limits", "./strict.toml", "--json"}).out);
  CHECK(strict.at("model") == "mpi");
  CHECK((strict.at("taxels") == 256 && strict.at("fitted_taxels") == 256));
  REQUIRE(strict.at("evaluations").size() == 2);
  CHECK((strict.at("evaluations").at(0).at("run") == 1 && strict.at("evaluations").at(1).at("run") == 2));
  CHECK(strict.at("verdicts").size() == 4);
  CHECK(strict.at("judgement").at("overall") == "fail");
  CHECK(judge({}).code == 2);
  CHECK(judge({"2", "2"}).code == 2);
  CHECK(judge({"1"}).code == 2);
  CHECK(judge({"2", "--lab", "none.toml", "--limits", "./wide.toml"}).code == 2);
  CHECK(judge({"2", "--limits", "none.toml"}).code == 2);
  CHECK_THAT(of.fit({"9", "--model", "mpi"}).err, Catch::Contains("[TB-STORE-NOT-FOUND]"));
  CHECK_THAT(call(of.folder, {"judge", "1:9", "2"}).err, Catch::Contains("[TB-STORE-NOT-FOUND]"));
  CHECK(of.models() == 1);
}

TEST_CASE("compare of runs: several models, stored, with scores") {
  const FolderOfRuns of;
  const FitRunWords words = {"compare", "1", "--models", "mpi,poly", "--score", "2,3"};
  CHECK(call(of.folder, joined_words(words, {"--html", "c.html"})).code == 0);
  CHECK(of.models() == 2);
  CHECK_THAT(read_file(of.folder.path("c.html")), Catch::StartsWith("<!DOCTYPE html>"));
  const nlohmann::json compared = nlohmann::json::parse(call(of.folder, joined_words(words, {"--json"})).out);
  REQUIRE(compared.at("models").size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const nlohmann::json& model = compared.at("models").at(i);
    CHECK(model.at("fit") == 3 + i);
    REQUIRE(model.at("scores").size() == 2);
    CHECK((model.at("scores").at(0).at("on") == "run 2" && model.at("scores").at(1).at("on") == "run 3"));
    CHECK(model.at("scores").at(0).at("taxels") == 256);
  }
  CHECK((compared.at("origin") == "simulated" && compared.at("source") == "run 1"));
  CHECK_THAT(of.fit({"1", "--model", "mpi", "--score", "2,02"}).err, Catch::Contains("[TB-RUN-TWICE]"));
}

TEST_CASE("fit of runs: the dynamic model where none is named, ELAM without inner branches, and the runs of its time") {
  const FolderOfRuns of;
  CHECK(of.fit({"1", "-o", "m.json"}).code == 0);
  const nlohmann::json document = nlohmann::json::parse(read_file(of.folder.path("m.json")));
  CHECK(document.at("dynamics").at("rate").at("run") == 0);
  CHECK(document.at("program_version") == bench::build_info().version);
  const nlohmann::json run = nlohmann::json::parse(call(of.folder, {"runs", "show", "1", "--json"}).out);
  CHECK_THAT(document.dump(), Catch::Contains(run.at("content_sha256").get<std::string>()));
  const nlohmann::json scored = of.told({"1", "--score", "2"});
  CHECK(scored.at("models").at(0).at("model") == "dynamic");
  CHECK(scored.at("models").at(0).at("scores").size() == 1);
  CHECK_FALSE(scored.at("models").at(0).at("shown_taxel").contains("cross_validated"));
  CHECK(of.told({"3"}).at("model") == "elam");
  CHECK(of.fit({"3", "--model", "dynamic"}).code == 0);
  CHECK(of.fit({"3", "-q"}).err.empty());
  CHECK_THAT(of.fit({"1", "--rate", "9", "--creep", "2"}).err, Catch::Contains("[TB-STORE-NOT-FOUND]"));
}

TEST_CASE("fit of many runs: each with its own model, and what cannot be fitted") {
  const FolderOfRuns of;
  CHECK(of.fit({"1-3", "--model", "mpi"}).code == 0);
  const nlohmann::json told = of.told({"1,3", "--model", "mpi"});
  CHECK(told.at("schema") == "tactbench.fit.runs");
  CHECK(told.at("store") == "runs.db");
  REQUIRE(told.at("runs").size() == 2);
  CHECK((told.at("runs").at(0).at("run") == 1 && told.at("runs").at(0).at("fit") == 4));
  CHECK((told.at("runs").at(1).at("run") == 3 && told.at("runs").at(1).at("taxels") == 256));
  const nlohmann::json single = of.told({"3", "--model", "mpi"});
  CHECK(told.at("runs").at(1).at("mean_error_psi") == single.at("evaluations").at(0).at("mean_error_psi"));
  CHECK(of.models() == 6);
  CHECK(of.fit({"1-3", "--model", "poly", "--fit", "small"}).code == 6);
  CHECK(of.fit({"1-2", "--model", "poly", "--mean-taxel"}).code == 2);
  // Some sequences of a run that has several.
  REQUIRE(call(of.folder, {"run", "./a.toml", "./b.toml", "--bench", "bench.toml", "--sensor", "S-1", "-q"}).code == 0);
  CHECK(of.fit({"4-4", "--model", "poly", "--fit", "loop"}).code == 0);
  const nlohmann::json failed = of.told({"3-3", "--model", "poly", "--fit", "small"});
  CHECK(failed.at("runs").at(0).at("error").get<std::string>().starts_with("TB-"));
  CHECK_FALSE(failed.at("runs").at(0).contains("fit"));
}
