// The verb itself, in its own process, with the processes that it starts.
#include <catch2/catch.hpp>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "db/run_store.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

const char* const kSuite = R"(schema = 1
name = "small"
[[scenario]]
name = "whole"
about = "nothing is wrong"
recipes = ["equilibration"]
fits = false
[scenario.figures]
frames = [60, 60.5]
[[scenario]]
name = "unseen-defect"
about = "a dead taxel that this scenario knows nothing of"
set = ["recipe.repeats=1", 'simulation.defect=[{kind="dead",row=3,column=4}]']
[[scenario]]
name = "misspelt"
about = "a recipe that does not exist"
recipes = ["no-such"]
)";

nlohmann::json night_json(const Finished& finished) { return nlohmann::json::parse(finished.out); }

}  // namespace

TEST_CASE("a night: green is reported, red states the reason, a broken scenario does not end the others") {
  const TemporaryFolder folder;
  write_file(folder.path("small.toml"), kSuite);
  const Finished night = call(folder, {"nightly", "./small.toml", "--json", "--junit", "night.xml", "--metrics",
                                       "night.prom", "--html", "night.html", "--stores", "kept"});
  CHECK(night.code == 1);
  CHECK_THAT(read_file(folder.path("night.prom")), Catch::Contains("tactbench_nightly_green{scenario=\"whole\"} 1\n"));
  CHECK(run_program("/usr/bin/xmllint", {"--noout", "night.html"}, folder.path()).code == 0);
  const nlohmann::json result = night_json(night);
  CHECK(result.at("red") == 2);
  CHECK(result.at("scenarios").at(0).at("wrong").empty());
  CHECK_THAT(result.at("scenarios").at(1).at("wrong").at(0).get<std::string>(), Catch::Contains("52"));
  CHECK_THAT(result.at("scenarios").at(2).at("wrong").at(0).get<std::string>(), Catch::Contains("exit code 2"));
  CHECK(read_file(folder.path("night.xml")).find("failures=\"2\" errors=\"0\"") != std::string::npos);
  CHECK(std::filesystem::exists(folder.path("kept/whole.db")));
}

TEST_CASE("nights are kept in one store, compared with a baseline, and changes are named") {
  const TemporaryFolder folder;
  const std::string head =
      "schema = 1\nname = \"kept\"\n[[scenario]]\nname = \"short\"\nabout = \"one repeat\"\nset = "
      "[\"recipe.repeats=1\"";
  write_file(folder.path("suite.toml"), head + "]\n");
  write_file(folder.path("noisy.toml"), head + ", \"simulation.front_end.noise_v=0.02\"]\n");
  const auto call = [&](const std::vector<std::string>& words) { return tests::call(folder, words); };
  const Finished seeds = call({"nightly", "./suite.toml", "--db", "nights.db", "--seeds", "8", "--json"});
  INFO(seeds.err << seeds.out);
  REQUIRE(seeds.code == 0);
  CHECK(night_json(seeds).at("scenarios").at(3).at("name") == "short-seed-4");
  CHECK(night_json(seeds).at("scenarios").at(3).at("runs").at(0).at("run") == 4);
  CHECK(call({"trend", "accept", "1-8", "--db", "nights.db", "--by", "K. Lee"}).code == 2);
  REQUIRE(call({"trend", "accept", "1-8", "--db", "nights.db", "--by", "K. Lee", "--reason", "as made"}).code == 0);
  const Finished same = call({"nightly", "./suite.toml", "--db", "nights.db", "--json", "--html", "night.html"});
  INFO(same.err << same.out);
  CHECK(same.code == 0);
  CHECK_THAT(night_json(same).at("scenarios").at(0).at("compared").get<std::string>(), Catch::EndsWith("run 1"));
  CHECK(run_program("/usr/bin/xmllint", {"--noout", "night.html"}, folder.path()).code == 0);
  {  // another program's analysis of the same frames
    db::RunStore store = db::RunStore::open(folder.path("nights.db"));
    std::map<std::string, double> figures;
    for (const db::FigureRecord& figure : store.figures("nightly/short"))
      if (figure.run == 9) figures[figure.name] = figure.value;
    figures.at("mean_error_psi") += 1e-6;
    store.replace_figures(9, "nightly/short", figures);
  }
  const Finished moved = call({"nightly", "./suite.toml", "--db", "nights.db", "--json"});
  CHECK(moved.code == 6);
  CHECK_THAT(night_json(moved).at("scenarios").at(0).at("remarks").at(0).get<std::string>(),
             Catch::StartsWith("mean_error_psi ") && Catch::Contains("run 9"));
  const Finished noisy = call({"nightly", "./noisy.toml", "--db", "nights.db", "--junit", "night.xml", "--json"});
  CHECK(noisy.code == 1);
  const nlohmann::json result = night_json(noisy).at("scenarios").at(0);
  CHECK_THAT(result.at("compared").get<std::string>(), Catch::Contains("run 10 "));
  const std::string junit = read_file(folder.path("night.xml"));
  CHECK_THAT(junit, Catch::Contains("noisiest_taxel_mv "));
  const Finished trend = call({"trend", "--subject", "nightly/short", "--figure", "noisiest_taxel_mv", "--db",
                               "nights.db", "--check", "--json"});
  CHECK(trend.code == 1);
  CHECK(night_json(trend).at("subjects").at(0).at("figures").at(0).at("values").size() == 11);
  CHECK(call({"trend", "--subject", "nightly/none", "--db", "nights.db"}).code == 2);
  CHECK(call({"verify", "--db", "nights.db"}).code == 0);
}
