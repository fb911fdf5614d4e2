// The dynamic model and the linearised output from the command line, on a sensor that nothing was chosen on.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "tests/support/paths.h"
#include "tests/support/process.h"
#include "tests/support/run_recipe.h"

using namespace tactbench::tests;
using nlohmann::json;

namespace {

constexpr const char* kSensorSeed = "41";

Finished measure(const TemporaryFolder& folder, const std::vector<std::string>& recipes, const char* seed,
                 const std::vector<std::string>& set = {}) {
  std::vector<std::string> words = {"run"};
  words.insert(words.end(), recipes.begin(), recipes.end());
  words.insert(words.end(), {"--bench", "bench.toml", "--sensor", "S-1", "--operator", "tester", "-q", "--no-seating",
                             "--sensor-seed", kSensorSeed, "--seed", seed});
  for (const std::string& one : set) words.insert(words.end(), {"--set", one});
  return call(folder, words);
}

void begin_small(const TemporaryFolder& folder) {
  init_small_array(folder);
  REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}).code == 0);
  write_file(folder.path("wide.toml"),
             "schema = 1\nname = \"wide\"\nrule = \"simple\"\nmean_compensation_error_psi = 60\n"
             "worst_taxel_error_psi = 60\ndistance_of_mean_percent_fs = 100\nunfit_taxels = 64\n");
}

// Runs 1 to 4: the paper's sequences, rate, creep-levels, random reversals.
void four_runs(const TemporaryFolder& folder) {
  begin_small(folder);
  REQUIRE(measure(folder, {"descending", "ascending"}, "1", {"recipe.repeats=2"}).code == 0);
  REQUIRE(measure(folder, {"rate"}, "2").code == 0);
  REQUIRE(measure(folder, {"creep-levels"}, "3").code == 0);
  REQUIRE(measure(folder, {"random-reversal"}, "4").code == 0);
}

double held_out_error(const Finished& fit) {
  INFO(fit.err);
  REQUIRE(fit.code == 0);
  return json::parse(fit.out)["evaluations"].at(1)["mean_error_psi"].get<double>();
}

}  // namespace

TEST_CASE("dynamic model: is fitted from three runs, judged, verified, shown and streamed") {
  const TemporaryFolder folder;
  four_runs(folder);
  const double elam = held_out_error(call(folder, {"fit", "1", "--model", "elam"}, {"judge", "1", "4", "--json"}));
  const double plain = held_out_error(call(folder, {"fit", "1", "--model", "mpi"}, {"judge", "1:2", "4", "--json"}));
  const double linearised =
      held_out_error(call(folder, {"fit", "1", "--model", "mpi", "--linearise"}, {"judge", "1:3", "4", "--json"}));
  const double dynamic = held_out_error(call(folder, {"fit", "1", "--rate", "2", "--creep", "3", "-o", "d.json"},
                                             {"judge", "1", "4", "--limits", "wide.toml", "--json"}));
  INFO("psi: ELAM " << elam << ", MPI " << plain << ", linearised " << linearised << ", dynamic " << dynamic);
  CHECK(linearised < 0.7 * plain);
  CHECK(dynamic < 0.35 * elam);
  CHECK(dynamic < 0.25);

  CHECK(call(folder, {"verify", "1"}).code == 0);
  CHECK(call(folder, {"verify", "4"}).code == 0);  // its verdicts

  CHECK(call(folder, {"model", "show", "1:4"}).code == 0);
  CHECK(json::parse(read_file(folder.path("d.json")))["dynamics"]["rate"]["run"] == 2);
  CHECK(call(folder, {"model", "diff", "1:4", "d.json"}).code == 0);
  const Finished live = call(folder, {"live", "--bench", "bench.toml", "--model", "1:4", "--frames", "3", "--json"});
  REQUIRE(live.code == 0);
  CHECK(json::parse(live.out)["last_frame"]["dead"] == 0);
  CHECK(call(folder, {"report", "1", "--model", "1:4", "--format", "json", "-o", "dynamic.json"}).code == 0);
  CHECK_THAT(read_file(folder.path("dynamic.json")), Catch::Contains("\"dynamic\"") &&
                                                         Catch::Contains("\"creep_share\"") &&
                                                         Catch::Contains("\"creep_scale\""));
  CHECK_THAT(call(folder, {"report", "1", "--model", "1:4", "--held-out", "3", "-o", "x.html"}).err,
             Catch::Contains("TB-RUN-OWN"));

  // A table needs times.
  write_file(folder.path("timed.csv"), "time_s,output\n0,0.02\n2,0.5\n4,1.2\n");
  write_file(folder.path("back.csv"), "time_s,output\n0,0.02\n2,0.5\n1,1.2\n");
  write_file(folder.path("timeless.csv"), "output\n0.02\n0.5\n");
  const Finished timed = call(folder, {"compensate", "1:4", "timed.csv", "--taxel", "mean", "--conditioned", "60"});
  INFO(timed.err);
  CHECK(timed.code == 0);
  CHECK_THAT(timed.out, Catch::StartsWith("time_s,output,compensated,uncertainty,flags\n0,0.02,"));
  CHECK_THAT(call(folder, {"compensate", "1:4", "back.csv", "--taxel", "mean"}).err, Catch::Contains("TB-TABLE-TIME"));
  CHECK_THAT(call(folder, {"compensate", "1:4", "timeless.csv", "--taxel", "mean"}).err,
             Catch::Contains("TB-TABLE-COLUMN"));

  // On random reversals of the same day it is still good; adjusted by them it stays a dynamic model that streams.
  CHECK(call(folder, {"model", "check", "d.json", "4"}).code == 0);
  CHECK(call(folder, {"model", "adjust", "d.json", "4", "--zero", "--gain", "-o", "child.json"}).code == 0);
  CHECK(call(folder, {"model", "diff", "d.json", "child.json"}).code == 1);
  // Of the run alone, and scored.
  const Finished alone = call(folder, {"fit", "1", "--model", "dynamic", "--score", "4", "-o", "alone.json", "--json"});
  INFO(alone.err);
  REQUIRE(alone.code == 0);
  const double compensated =
      json::parse(alone.out)["models"].at(0)["scores"].at(0)["all"]["compensated"]["mean"].get<double>();
  INFO("psi: dynamic, with the creep of the fitted run " << compensated);
  CHECK(compensated < 0.45 * elam);
  CHECK(call(folder, {"compensate", "alone.json", "timed.csv", "--taxel", "mean"}).code == 0);

  // The run that creep was taken from is no evidence.
  const Finished own =
      call(folder, {"report", "3", "--model", "1:4", "--limits", "wide.toml", "-o", "own.html", "--json"});
  INFO(own.err << own.out);
  CHECK(own.code == 6);
  const json judged = json::parse(own.out);
  CHECK(judged["judgement"]["overall"] == "inconclusive");
  CHECK_FALSE(judged["verdicts"].empty());
  for (const json& verdict : judged["verdicts"]) CHECK(verdict["verdict"] == "inconclusive");

  // Void, it takes the verdicts on the models with it.
  const auto standing = [&] {
    return json::parse(call(folder, {"runs", "show", "1", "--json"}).out)["verdicts"].size();
  };
  CHECK(standing() > 0);
  REQUIRE(call(folder, {"runs", "void", "3", "--reason", "spilled", "--by", "me"}).code == 0);
  CHECK(standing() == 0);
  const Finished gone = call(folder, {"report", "1", "--model", "1:4", "-o", "gone.html"});
  CHECK(gone.code == 6);
  CHECK_THAT(gone.out, Catch::Contains("3 was declared void"));
}

TEST_CASE("ELAM on linearised output: is stored as a further fit, the plain ELAM fit remains the model of the run") {
  const TemporaryFolder folder;
  begin_small(folder);
  REQUIRE(measure(folder, {"descending", "ascending"}, "1", {"recipe.repeats=1"}).code == 0);
  REQUIRE(measure(folder, {"random-reversal"}, "2").code == 0);
  const double plain = held_out_error(call(folder, {"fit", "1", "--model", "elam"}, {"judge", "1", "2", "--json"}));
  const double linearised = held_out_error(call(folder, {"fit", "1", "--linearise"}, {"judge", "1", "2", "--json"}));
  INFO("psi: " << plain << ", linearised " << linearised);
  CHECK(linearised < 0.75);
  CHECK(call(folder, {"verify", "1"}).code == 0);
  CHECK_THAT(call(folder, {"model", "show", "1"}).out, !Catch::Contains("linearised"));  // the paper's stands
  CHECK_THAT(call(folder, {"model", "show", "1:2"}).out, Catch::Contains("linearised"));
  CHECK(call(folder, {"live", "--bench", "bench.toml", "--model", "1:2", "--frames", "3", "--json"}).code == 0);
}

TEST_CASE("dynamic model: missing or unsuitable inputs are rejected before anything is stored") {
  const TemporaryFolder folder;
  four_runs(folder);
  const auto fails = [&](std::vector<std::string> words, int code, const std::string& id) {
    words.insert(words.begin(), {"fit", "1", "--model", "dynamic"});
    const Finished fit = call(folder, words);
    INFO(fit.err);
    CHECK(fit.code == code);
    CHECK_THAT(fit.err, Catch::Contains(id));
  };
  fails({"--rate", "2"}, 2, "TB-USAGE");
  fails({"--rate", "2", "--creep", "3", "--fit", "ascending"}, 2, "TB-USAGE");
  fails({"--rate", "2", "--creep", "3", "--starts", "3"}, 2, "TB-USAGE");
  fails({"--rate", "2", "--creep", "9"}, 2, "TB-STORE-NOT-FOUND");
  fails({"--rate", "2", "--creep", "2"}, 6, "TB-ANALYSIS-DYNAMICS");
  fails({"--rate", "4", "--creep", "3"}, 6, "TB-ANALYSIS-DYNAMICS");
  CHECK(call(folder, {"fit", "1", "--rate", "2"}).code == 2);
  REQUIRE(call(folder, {"runs", "void", "3", "--reason", "spilled", "--by", "me"}).code == 0);
  fails({"--rate", "2", "--creep", "3"}, 2, "TB-RUN-VOID");
  CHECK(json::parse(call(folder, {"runs", "show", "1", "--json"}).out)["models"].empty());
}

TEST_CASE("fit: defaults to the dynamic model of one run, uses ELAM if that is impossible, and reports it") {
  const TemporaryFolder folder;
  begin_small(folder);
  REQUIRE(measure(folder, {"production"}, "1").code == 0);
  REQUIRE(measure(folder, {"random-reversal"}, "2").code == 0);
  std::string said;
  const auto kind = [&](std::vector<std::string> words) {
    const std::string run = words.front().substr(words.front().find('-') + 1);
    words.insert(words.begin(), "fit");
    const Finished fit = call(folder, words);
    INFO(fit.err);
    CHECK(fit.code == 0);
    said = fit.err;
    const json listed = json::parse(call(folder, {"runs", "show", run, "--json"}).out)["models"];
    const auto newest =
        std::ranges::max_element(listed, {}, [](const json& model) { return model["fit"].get<std::int64_t>(); });
    return newest == listed.end() ? std::string() : (*newest)["kind"].get<std::string>();
  };
  CHECK(kind({"1", "--model", "elam"}) == "elam");
  const auto mean_error = [&](const char* subject) {
    const json printed =
        json::parse(call(folder, {"trend", "--subject", subject, "--figure", "mean error", "--json"}).out);
    return printed["subjects"].back()["figures"][0]["values"].back().get<double>();
  };
  const double of_elam = mean_error("sensor/S-1/");
  CHECK(kind({"1"}) == "dynamic");
  CHECK_THAT(call(folder, {"report", "1", "--format", "json", "-o", "r.json"}).err, !Catch::Contains("error"));
  CHECK_THAT(read_file(folder.path("r.json")), Catch::Contains("\"dynamic\""));
  // Each model is followed by itself.
  CHECK(mean_error("sensor/S-1/loops+inner-loops+hold/dynamic") < of_elam);
  CHECK(json::parse(call(folder, {"trend", "--sensor", "S-1", "--json"}).out)["subjects"].size() == 2);
  CHECK(kind({"1-2"}) == "dynamic");
  CHECK(kind({"1", "--fit", "inner-loops"}) == "elam");
  CHECK(kind({"1", "--mean-taxel"}) == "elam");
  CHECK(kind({"1", "--memory"}) == "elam, memory");
  CHECK(kind({"1", "--linearise"}) == "elam, linearised");
  write_file(folder.path("t.csv"),
             "sequence,step,input,output\nfull,0,0,0\nfull,1,2,1\nfull,2,4,3\nfull,3,2,2\nfull,4,4,3\nfull,5,2,2\n"
             "full,6,0,0\n");
  CHECK(json::parse(call(folder, {"fit", "t.csv", "--json"}).out)["models"].at(0)["model"] == "elam");
  REQUIRE(call(folder, {"runs", "import", "t.csv"}).code == 0);
  CHECK(kind({"3"}).starts_with("elam"));
  CHECK_THAT(said, Catch::Contains("run 3"));
  CHECK(call(folder, {"fit", "3", "--model", "dynamic"}).code == 2);
  REQUIRE(measure(folder, {"loops"}, "4").code == 0);
  CHECK(kind({"4"}) == "elam");
  CHECK_THAT(said, Catch::Contains("run 4"));

  // What short dwells and one hold of a minute tell of creep is no evidence of longer holds.
  const json judged = json::parse(call(folder, {"fit", "1"}, {"judge", "1", "2", "--limits", "wide.toml", "--json"})
                                      .out)["judgement"]["not_assessed"];
  CHECK(std::ranges::any_of(judged, [](const json& own) { return own["source"] == "creep"; }));
}

TEST_CASE("dynamic model of one run: small error after the recipe production, accepts a run that starts above 0 psi") {
  const TemporaryFolder folder;
  begin_small(folder);
  REQUIRE(measure(folder, {"production"}, "1").code == 0);
  REQUIRE(measure(folder, {"random-reversal"}, "2").code == 0);
  const double elam = held_out_error(call(folder, {"fit", "1", "--model", "elam"}, {"judge", "1", "2", "--json"}));
  const double dynamic = held_out_error(call(folder, {"fit", "1"}, {"judge", "1", "2", "--json"}));
  INFO("psi: ELAM " << elam << ", dynamic " << dynamic);
  CHECK(dynamic < 0.8);
  REQUIRE(measure(folder, {"loops"}, "3",
                  {"recipe.turning_points=[10, 60, 10, 40, 10, 60, 20, 60, 10]", "recipe.step=2", "recipe.dwell_s=1"})
              .code == 0);
  const Finished above = call(folder, {"fit", "3", "--json"});
  INFO(above.err);
  REQUIRE(above.code == 0);
  CHECK(json::parse(above.out)["evaluations"].at(0)["mean_error_psi"].get<double>() < 1.0);
}
