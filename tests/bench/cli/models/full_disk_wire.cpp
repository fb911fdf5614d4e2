// predict and live where what they write cannot be written.
#include <catch2/catch.hpp>
#include <string>

#include "tests/bench/cli/check_refusal.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::tests;

TEST_CASE("predict: a table that cannot be written to standard output is an error") {
  const TemporaryFolder folder;
  write_file(folder.path("t.csv"),
             "input,output\n0,0\n1,1.5\n2,2.5\n3,4\n2,3.5\n1,2\n0,0.1\n1,1.4\n2,2.6\n1,2.1\n0,0\n");
  REQUIRE(call(folder, {"fit", "t.csv", "--model", "poly", "-q", "-o", "m.json"}).code == 0);
  check_refusal(
      run_program("/bin/sh", {"-c", std::string(program_path()) + " predict m.json t.csv >/dev/full"}, folder.path()),
      2, "TB-FILE-WRITE", "standard output");
}
