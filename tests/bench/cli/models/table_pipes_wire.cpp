// Tables through pipes, and predict where what it writes cannot be written.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/bench/cli/verb_here.h"
#include "tests/support/paths.h"

using namespace tactbench::tests;

namespace {

const char* const kLoopTable = "input,output\n0,0\n1,1.5\n2,2.5\n3,4\n2,3.5\n1,2\n0,0.1\n1,1.4\n2,2.6\n1,2.1\n0,0\n";

}  // namespace

TEST_CASE("table input: a table read through a pipe gives the same hash and results as the file") {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), kLoopTable);
  const auto shell = [&](const std::string& line) { return run_program("/bin/bash", {"-c", line}, folder.path()); };
  const std::string program = program_path();
  REQUIRE(shell(program + " runs import t.csv && " + program + " runs import <(cat t.csv)").code == 0);
  const auto sha = [&](const std::string& run) {
    const auto shown = nlohmann::json::parse(call(folder, {"runs", "show", run, "--json"}).out);
    return shown["devices"][0]["serial"].get<std::string>();
  };
  CHECK(sha("1") == sha("2"));
  REQUIRE(shell(program + " fit t.csv --model poly -o m.json").code == 0);
  const Finished direct = shell(program + " compensate m.json t.csv");
  CHECK(direct.code == 0);
  CHECK(shell("cat t.csv | " + program + " compensate m.json -").out == direct.out);
  CHECK(shell(program + " compensate m.json <(cat t.csv)").out == direct.out);
  CHECK(shell("head -c 3000000 /dev/zero | tr '\\0' 'x' | " + program + " compensate m.json -").code == 2);
  CHECK(shell(program + " compensate m.json /dev/zero").code == 2);
  CHECK(shell(program + " model check <(cat m.json) t.csv").code == 2);  // a document is a file
}

TEST_CASE("predict: a table that cannot be written to standard output is an error") {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"), kLoopTable);
  REQUIRE(call(folder, {"fit", "t.csv", "--model", "poly", "-q", "-o", "m.json"}).code == 0);
  check_refusal(
      run_program("/bin/sh", {"-c", std::string(program_path()) + " predict m.json t.csv >/dev/full"}, folder.path()),
      2, "TB-FILE-WRITE", "standard output");
}
