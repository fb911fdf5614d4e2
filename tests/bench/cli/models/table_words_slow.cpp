// Messages of the verbs of tables and models on names that are missing, outputs outside the loop, and pipes.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/bench/cli/check_refusal.h"
#include "tests/bench/cli/play_table.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::tests;

namespace {

// One history, two cycles; the last column names a sequence where `sequence` is given.
std::string history_table(const std::string& sequence = {}, double scale = 1.0) {
  std::string text = sequence.empty() ? "step,input,output\n" : "step,input,output,sequence\n";
  for (const PlaySample& sample : play_samples({0, 10, 0, 10, 5, 10, 0}))
    text += std::to_string(sample.step) + "," + std::to_string(sample.input) + "," +
            std::to_string(scale * sample.output) + (sequence.empty() ? "\n" : "," + sequence + "\n");
  return text;
}

}  // namespace

TEST_CASE("outside the loop the uncertainty of a compensated value is not a number, inside it is one") {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), history_table());
  write_file(folder.path("out.csv"), "output\n-5\n3\n1000\n");
  REQUIRE(call(folder, {"fit", "t.csv", "-o", "m.json"}).code == 0);
  const Finished finished = call(folder, {"compensate", "m.json", "out.csv"});
  REQUIRE(finished.code == 0);
  std::istringstream lines(finished.out);
  std::string head, below, inside, above;
  REQUIRE((std::getline(lines, head) && std::getline(lines, below) && std::getline(lines, inside) &&
           std::getline(lines, above)));
  CHECK(head == "output,compensated,uncertainty,flags");
  CHECK_THAT(below, Catch::Contains(",nan,range"));
  CHECK_THAT(above, Catch::Contains(",nan,range"));
  CHECK_THAT(inside, !Catch::Contains("nan") && !Catch::Contains("range"));
}

TEST_CASE("a table read through a pipe gives the same hash and the same results as the file") {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), history_table());
  const auto shell = [&](const std::string& line) { return run_program("/bin/bash", {"-c", line}, folder.path()); };
  const std::string program = program_path();
  REQUIRE(shell(program + " import t.csv && " + program + " import <(cat t.csv)").code == 0);
  const auto sha = [&](const std::string& run) {
    const auto shown = nlohmann::json::parse(call(folder, {"runs", "show", run, "--json"}).out);
    return shown["devices"][0]["serial"].get<std::string>();
  };
  CHECK(sha("1") == sha("2"));
  REQUIRE(shell(program + " fit t.csv -o m.json").code == 0);
  const Finished direct = shell(program + " compensate m.json t.csv");
  CHECK(direct.code == 0);
  CHECK(shell("cat t.csv | " + program + " compensate m.json -").out == direct.out);
  CHECK(shell(program + " compensate m.json <(cat t.csv)").out == direct.out);
  CHECK(shell("head -c 3000000 /dev/zero | tr '\\0' 'x' | " + program + " compensate m.json -").code == 2);
  CHECK(shell(program + " compensate m.json /dev/zero").code == 2);
  CHECK(shell(program + " fit t.csv --check <(cat m.json)").code == 2);  // a document is a file
}

TEST_CASE("an overlong run or taxel number is refused with the error for runs or taxels") {
  const TemporaryFolder folder;
  const std::string huge(20, '9');
  write_file(folder.path("t.csv"), history_table());
  CHECK(call(folder, {"fit", huge}).code == 2);
  CHECK(call(folder, {"predict", huge, "t.csv"}).code == 2);
  REQUIRE(call(folder, {"fit", "t.csv", "--model", "elam", "-o", "m.json"}).code == 0);
  check_refusal(call(folder, {"predict", "m.json", "t.csv", "--taxel", huge}), 2, "TB-MODEL-TAXEL");
}
