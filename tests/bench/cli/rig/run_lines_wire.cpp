// run: the time that it estimates, the lines of a run that completed, and its document.
#include <catch2/catch.hpp>
#include <csignal>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::tests;

namespace {

// A frame at 0, 10, 20, 10 and 0 psi after 1.1 s each: 0.5 s of ramp between two, and 0.65 s to settle.
struct FolderToRun {
  FolderToRun() {
    REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}).code == 0);
    write_file(folder.path("steps.toml"),
               "schema = 1\nname = \"steps\"\nunit = \"psi\"\nturning_points = [0, 20, 0]\nstep = 10\ndwell_s = 1.1\n");
    write_file(folder.path("asks.toml"),
               "schema = 1\nname = \"asks\"\nunit = \"psi\"\nturning_points = [0, 20, 0]\nstep = 10\ndwell_s = 1.1\n"
               "[prompt]\nbefore = \"Ready?\"\n");
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

TEST_CASE("run: its lines on standard output, and before them the estimate, by the model and learned") {
  const FolderToRun of;
  const std::string model = "0:00:11 (0:00:10 to 0:00:14, by the model)";
  const Finished first = of.run({"./steps.toml"}, {"--no-seating"});
  INFO(first.out << first.err);
  REQUIRE(first.code == 0);
  CHECK_THAT(first.err, Catch::Contains("estimated, h:mm:ss of process time: " + model));
  CHECK_THAT(first.out, Catch::StartsWith("run 1: completed, 5 frames in 0 min of process time; vented, verified "
                                          "(feedback 0.0 psi, reference 0.0 psi)\ntook 0:00:") &&
                            Catch::Contains(" of process time, estimated " + model + "\n") &&
                            !Catch::Contains("waiting, "));
  const Finished second = of.run({"./steps.toml"}, {"--no-seating", "-q", "--units", "kPa"});
  CHECK_THAT(second.err, !Catch::Contains("estimated"));
  CHECK_THAT(second.out,
             Catch::Contains("(feedback 0.0 kPa, reference 0.0 kPa)\n") && Catch::Contains(", learned from 1 run)\n"));
  const nlohmann::json third = nlohmann::json::parse(of.run({"./steps.toml"}, {"--no-seating", "--json"}).out);
  CHECK(third.at("schema") == "tactbench.run");
  CHECK((third.at("run") == 3 && third.at("frames") == 5 && third.at("branches_redone") == 0));
  CHECK(third.at("process_seconds").get<double>() > 8.0);
  CHECK(third.at("waiting_seconds") == 0.0);
  CHECK(third.at("most_exchanges_a_step").get<int>() > 0);
  CHECK_FALSE(third.at("time_spent").get<std::string>().empty());
  CHECK_THAT(of.run({"./steps.toml"}, {"--no-seating", "-q"}).out, Catch::Contains(", learned from 3 runs)\n"));
}

TEST_CASE("run: prompts stand beside the estimate, unless they are answered beforehand") {
  const FolderToRun of;
  // What is said before the question, on which the run waits until it is ended.
  const auto estimate = [&](const std::string& recipes) {
    const std::string said = of.folder.path("said");
    write_file(said, "");
    (void)run_program("/bin/sh",
                      {"-c", "exec '" + std::string(program_path()) + "' run " + recipes +
                                 " --bench simulated.toml --sensor S-1 --operator t --no-seating 2>said"},
                      of.folder.path(), {SIGTERM, [&] { return read_file(said).find(")\n") != std::string::npos; }});
    const std::string text = read_file(said);
    const std::size_t at = text.find("estimated, h:mm:ss of process time: ");
    return at == std::string::npos ? text : text.substr(at + 36, text.find('\n', at) - at - 36);
  };
  CHECK(estimate("./asks.toml") == "0:00:11 + 1 prompt (0:00:10 to 0:00:14, by the model)");
  CHECK_THAT(estimate("./asks.toml ./asks.toml"),
             Catch::StartsWith("0:00:2") && Catch::Contains(" + 2 prompts (0:00:"));
  const Finished answered = of.run({"./asks.toml"}, {"--no-seating", "--yes"});
  CHECK(answered.code == 0);
  CHECK_THAT(answered.err, Catch::Contains("estimated, h:mm:ss of process time: 0:00:11 (0:00:10 to "));
}
