// Verbs that find nothing to work on: which error, where, and what would help.
#include <catch2/catch.hpp>

#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::tests;

TEST_CASE("cli: verbs that need a model, figures or runs say that there are none, and how to come by them") {
  const TemporaryFolder folder;
  REQUIRE(call(folder, {"init"}).code == 0);
  write_file(folder.path("small.toml"),
             "schema = 1\nname = \"small\"\nunit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 20\nrepeats = 1\n"
             "dwell_s = 0.2\n");
  REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}).code == 0);
  REQUIRE(call(folder, {"run", "small.toml", "--bench", "bench.toml", "--sensor", "S-1", "--operator", "tester", "-q"})
              .code == 0);
  const struct {
    std::vector<std::string> words;
    int code;
    std::string said;
  } rows[] = {
      {{"model", "show", "1"},
       6,
       "error: run 1 has no stored fit [TB-ANALYSIS-NO-FIT]\n  try: make one: tactbench fit 1\n"},
      {{"trend"},
       2,
       "error: there are no such figures [TB-TREND-NONE]\n  at: runs.db\n"
       "  try: fit, nightly --db and rig check store figures\n"},
      {{"fit", "2-9"},
       2,
       "error: of the runs 2-9 none can be fitted [TB-FIT-NONE]\n  at: runs.db\n"
       "  try: tactbench runs list shows what there is; void runs are taken with --void-too\n"},
  };
  for (const auto& row : rows) {
    INFO(row.words.front());
    const Finished done = call(folder, row.words);
    CHECK(done.code == row.code);
    CHECK(done.err == row.said);
    CHECK(done.out.empty());
  }
  REQUIRE(call(folder, {"runs", "void", "1", "--reason", "a test", "--by", "tester"}).code == 0);
  CHECK(call(folder, {"fit", "1-9"}).code == 2);  // void runs are not taken unasked
}
