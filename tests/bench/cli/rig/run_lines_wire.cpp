// run: a run that completed, and its document.
#include <catch2/catch.hpp>
#include <csignal>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/process.h"

using namespace tactbench::tests;

namespace {

// A frame at 0, 10, 20, 10 and 0 psi after 1.1 s each: 0.5 s of ramp between two, and 0.65 s to settle.
struct FolderToRun {
  FolderToRun() {
    REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}).code == 0);
    write_file(folder.path("steps.toml"),
               "schema = 1\nname = \"steps\"\nunit = \"psi\"\nturning_points = [0, 20, 0]\nstep = 10\ndwell_s = 1.1\n");
  }
  [[nodiscard]] Finished run(const std::vector<std::string>& recipes, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> words = {"run", "--bench", "simulated.toml", "--sensor", "S-1", "--operator", "t"};
    words.insert(words.end(), recipes.begin(), recipes.end());
    words.insert(words.end(), more.begin(), more.end());
    return call(folder, words);
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("run: its document") {
  const FolderToRun of;
  const Finished first = of.run({"./steps.toml"}, {"--no-seating"});
  INFO(first.out << first.err);
  REQUIRE(first.code == 0);
  CHECK_THAT(first.out, Catch::Contains("vented, verified"));
  CHECK(of.run({"./steps.toml"}, {"--no-seating", "-q"}).code == 0);
  const nlohmann::json third = nlohmann::json::parse(of.run({"./steps.toml"}, {"--no-seating", "--json"}).out);
  CHECK(third.at("schema") == "tactbench.run");
  CHECK((third.at("run") == 3 && third.at("frames") == 5 && third.at("branches_redone") == 0));
  CHECK(third.at("process_seconds").get<double>() > 8.0);
  CHECK(third.at("waiting_seconds") == 0.0);
  CHECK(third.at("most_exchanges_a_step").get<int>() > 0);
  CHECK_FALSE(third.at("time_spent").get<std::string>().empty());
}
