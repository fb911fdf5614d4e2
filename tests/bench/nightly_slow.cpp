// The verb itself, in its own process, with the processes that it starts.
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "tests/support/process.h"

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

nlohmann::json json_of(const Finished& finished) { return nlohmann::json::parse(finished.out); }

}  // namespace

TEST_CASE("a night: the green is green, the red says why, the broken does not end the others") {
  const TemporaryFolder folder;
  write_file(folder.path("small.toml"), kSuite);
  const Finished night =
      run_program(TACTBENCH_PROGRAM, {"nightly", "./small.toml", "--json", "--junit", "night.xml", "--stores", "kept"},
                  folder.path());
  CHECK(night.code == 1);
  const nlohmann::json json = json_of(night);
  CHECK(json.at("red") == 2);
  CHECK(json.at("scenarios").at(0).at("wrong").empty());
  CHECK(json.at("scenarios").at(1).at("wrong").at(0) == "the list of dead taxels is 52, must be none");
  CHECK(json.at("scenarios").at(2).at("wrong").at(0) == "its process ended with exit code 2 and left no result");
  CHECK(read_file(folder.path("night.xml")).find("failures=\"2\" errors=\"0\"") != std::string::npos);
  CHECK(std::filesystem::exists(folder.path("kept/whole.db")));
}

TEST_CASE("one scenario again with the same seed has the same content, with another seed another") {
  const TemporaryFolder folder;
  write_file(folder.path("small.toml"), kSuite);
  const auto hash = [&](const std::string& seed) {
    const Finished night = run_program(
        TACTBENCH_PROGRAM, {"nightly", "./small.toml", "--only", "whole", "--seed", seed, "--json"}, folder.path());
    REQUIRE(night.code == 0);
    return json_of(night).at("scenarios").at(0).at("runs").at(0).at("content_sha256").get<std::string>();
  };
  const std::string first = hash("7");
  CHECK(first.size() == 64);
  CHECK(hash("7") == first);
  CHECK(hash("8") != first);
}

TEST_CASE("a scenario that does not end in time is killed and red, and none is started after it on request") {
  const TemporaryFolder folder;
  write_file(folder.path("small.toml"), kSuite);
  const Finished night = run_program(
      TACTBENCH_PROGRAM, {"nightly", "./small.toml", "--jobs", "1", "--limit", "0.05", "--stop-on-red", "--json"},
      folder.path());
  CHECK(night.code == 1);
  const nlohmann::json json = json_of(night);
  CHECK(json.at("not_run") == 2);
  CHECK(json.at("scenarios").at(0).at("wrong").at(0).get<std::string>().find("was killed") != std::string::npos);
}
