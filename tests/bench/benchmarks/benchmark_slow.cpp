// `tactbench benchmark X` prints each goal right after its figure. Of the figures only the order of magnitude is
// tested: other work on the machine would fail more.
#include <catch2/catch.hpp>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench::tests;

namespace {

struct Lines {
  std::vector<std::string> names, units;
  std::vector<double> values;
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
    lines.values.push_back(value);
  }
  CHECK(stream.eof());
  return lines;
}

// None takes a second a frame, a call or a taxel.
Lines benchmarked(const std::string& benchmark) {
  const TemporaryFolder folder;
  const Finished finished = run_program(program_path(), {"benchmark", benchmark, "--rounds", "1"}, folder.path());
  INFO(finished.err);
  REQUIRE(finished.code == 0);
  Lines lines = figures_of(finished.out);
  for (std::size_t i = 0; i < lines.names.size(); ++i) {
    INFO(lines.names[i]);
    CHECK(lines.values[i] >= 0.0);
    if (lines.units[i].starts_with("us")) CHECK(lines.values[i] < 1e6);
    if (lines.units[i].starts_with("ns")) CHECK(lines.values[i] < 1e6);
  }
  return lines;
}

// Goals by what they are of; each has its figure before it.
std::map<std::string, double> goals_of(const std::string& benchmark, const Lines& lines) {
  std::map<std::string, double> goals;
  for (std::size_t i = 0; i < lines.names.size(); ++i) {
    INFO(lines.names[i]);
    CHECK(lines.names[i].rfind(benchmark + "_", 0) == 0);
    const auto goal = lines.names[i].find("_goal_at_");
    if (goal == std::string::npos) continue;
    REQUIRE(i > 0);
    CHECK(lines.names[i - 1] == lines.names[i].substr(0, goal));
    CHECK(lines.units[i - 1] == lines.units[i]);
    CHECK(goals.emplace(lines.names[i].substr(benchmark.size() + 1), lines.values[i]).second);
  }
  return goals;
}
// Without goals and what is measured on some processors alone.
std::string names_of(const Lines& lines) {
  std::string names;
  for (const std::string& name : lines.names)
    if (name.find("_goal_at_") == std::string::npos && name.find("_avx") == std::string::npos)
      names += name.substr(name.find('_') + 1) + " ";
  return names;
}
std::map<std::string, double> goals_of(const std::string& benchmark) {
  return goals_of(benchmark, benchmarked(benchmark));
}

}  // namespace

TEST_CASE("benchmark identify prints its goals beside its figures") {
  std::map<std::string, double> goals = goals_of("identify");
  // One for each vector level of this processor.
  CHECK(goals["elam_base_in_plain_j_goal_at_most"] == 100.0);
  std::erase_if(goals, [](const auto& goal) { return goal.first.rfind("elam_", 0) == 0 && goal.second >= 50.0; });
  CHECK(goals == std::map<std::string, double>{{"array_over_floor_goal_at_most", 1.5},
                                               {"two_threads_speedup_goal_at_least", 1.7},
                                               {"dynamic_array_goal_at_most", 1.0}});
}
TEST_CASE("benchmark store prints its goals beside its figures") {
  const Lines lines = benchmarked("store");
  CHECK(names_of(lines) ==
        "append_and_fdatasync full full_over_floor bare_insert normal normal_over_bare bare_insert_groups_of_100 "
        "bare_read read read_over_bare ");
  CHECK(goals_of("store", lines) == std::map<std::string, double>{{"full_over_floor_goal_at_most", 1.5},
                                                                  {"normal_over_bare_goal_at_most", 1.25},
                                                                  {"read_over_bare_goal_at_most", 1.3}});
}
TEST_CASE("benchmark report prints its goals beside its figures") {
  const std::map<std::string, double> goals = goals_of("report");
  CHECK(goals.size() == 2);
  CHECK(goals.contains("rendered_and_written_goal_at_most"));
  CHECK(goals.contains("over_write_alone_goal_at_most"));
}
TEST_CASE("benchmark compensate prints its goals beside its figures") {
  const Lines lines = benchmarked("compensate");
  CHECK(names_of(lines) ==
        "scale_only straightforward bare_scalar fast_base fast_median fast_p99 fast_worst turning_fast "
        "turning_straightforward turning_bare_scalar turning_p99 turning_worst unknown_start_median "
        "growth_16x16_per_taxel growth_32x32_per_taxel growth_64x64_per_taxel speedup speedup_over_bare "
        "over_scale_only turning_slowdown turning_slowdown_over_bare ");
  CHECK(goals_of("compensate", lines) ==
        std::map<std::string, double>{{"speedup_over_bare_goal_at_least", 3.0},
                                      {"over_scale_only_goal_at_most", 25.0},
                                      {"turning_slowdown_over_bare_goal_at_most", 2.5}});
}
TEST_CASE("benchmark array and benchmark sequence print figures") {
  const Lines array = benchmarked("array");
  CHECK(goals_of("array", array).empty());
  CHECK(names_of(array) ==
        "plain_plays specimen_moved_and_read specimen_over_plain_plays counts_with_noise frame_on_the_wire "
        "share_of_the_wire ");
  const Lines sequence = benchmarked("sequence");
  CHECK(goals_of("sequence", sequence).empty());
  CHECK(names_of(sequence) == "steps run bare_exchanges bare_store ratio ");
  CHECK(sequence.values.at(0) == 210.0);
}
TEST_CASE("benchmark page and benchmark compensate-dynamic print their goals beside their figures") {
  CHECK(goals_of("page") == std::map<std::string, double>{{"core_goal_at_most", 1.0},
                                                          {"resident_goal_at_most", 20.0},
                                                          {"stored_to_viewer_p95_goal_at_most", 150.0},
                                                          {"step_with_viewers_goal_at_most", 1.02}});
  std::map<std::string, double> goals = goals_of("compensate-dynamic");
  CHECK(goals["memory_a_taxel_goal_at_most"] == 2048.0);
  // Beside the memory those of one vector level, which older processors have not.
  goals.erase("memory_a_taxel_goal_at_most");
  if (!goals.empty())
    CHECK(goals == std::map<std::string, double>{{"slow_avx2_goal_at_most", 2.0}, {"turning_avx2_goal_at_most", 12.0}});
}
