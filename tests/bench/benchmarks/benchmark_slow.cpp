// `tactbench benchmark X` prints each goal right after its figure. What the figures are is not tested: other work on
// the machine would fail it.
#include <catch2/catch.hpp>
#include <sstream>

#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::tests;

namespace {

struct Lines {
  std::vector<std::string> names, units;
};

Lines figures_of(const std::string& text) {
  Lines lines;
  std::istringstream stream(text);
  std::string word, name, unit;
  double value = 0.0;
  while (stream >> word >> name >> value >> unit) {
    CHECK(word == "FIGURE");
    lines.names.push_back(name);
    lines.units.push_back(unit);
  }
  CHECK(stream.eof());
  return lines;
}

// How many goals there are; each has its figure before it.
int goals_of(const std::string& benchmark) {
  const TemporaryFolder folder;
  const Finished finished = run_program(program_path(), {"benchmark", benchmark, "--rounds", "1"}, folder.path());
  INFO(finished.err);
  REQUIRE(finished.code == 0);
  const Lines lines = figures_of(finished.out);
  int goals = 0;
  for (std::size_t i = 0; i < lines.names.size(); ++i) {
    INFO(lines.names[i]);
    CHECK(lines.names[i].rfind(benchmark + "_", 0) == 0);
    const auto goal = lines.names[i].find("_goal_at_");
    if (goal == std::string::npos) continue;
    ++goals;
    REQUIRE(i > 0);
    CHECK(lines.names[i - 1] == lines.names[i].substr(0, goal));
    CHECK(lines.units[i - 1] == lines.units[i]);
  }
  return goals;
}

}  // namespace

TEST_CASE("benchmark identify prints its goals beside its figures") { CHECK(goals_of("identify") >= 3); }
TEST_CASE("benchmark store prints its goals beside its figures") { CHECK(goals_of("store") == 3); }
TEST_CASE("benchmark report prints its goals beside its figures") { CHECK(goals_of("report") == 2); }
TEST_CASE("benchmark compensate prints its goals beside its figures") { CHECK(goals_of("compensate") == 3); }
TEST_CASE("benchmark array and benchmark sequence print figures") {
  CHECK(goals_of("array") == 0);
  CHECK(goals_of("sequence") == 0);
}
