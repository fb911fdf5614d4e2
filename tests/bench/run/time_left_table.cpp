// The time left as it is shown from step to step: by the model's own times, and by stored runs of one recipe of two.
#include <fmt/format.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/run/time_estimate.h"
#include "tests/bench/run/stored_past.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using sequences::Recipe;

namespace {

// A prompt, two steps of conditioning and three frames; the frames of the other: five, after one of conditioning.
std::vector<Recipe> two_recipes() {
  const auto recipe = [](const std::string& text) {
    return sequences::parse_recipe(sequences::TomlDocument::from_text("schema = 1\nunit = \"psi\"\n" + text, "r.toml"));
  };
  return {recipe("name = \"one\"\nturning_points = [0, 8, 0]\nstep = 8\n[prompt]\nbefore = \"ready?\"\n"
                 "[conditioning]\ncycles = 1\npeak = 8\n"),
          recipe("name = \"two\"\nturning_points = [0, 8, 0]\nstep = 4\nrepeats = 2\n[prompt]\nbefore = \"now?\"\n")};
}

std::vector<std::string> shown_left(const TimeEstimate& estimate, std::size_t steps) {
  const auto line = [](const std::string& head, const TimeBand& band) {
    return fmt::format("{}: {:.3f} {:.3f} {:.3f} s, {} prompts, {} runs", head, band.p10_s, band.p50_s, band.p90_s,
                       band.prompts, band.runs);
  };
  std::vector<std::string> lines;
  for (std::size_t done = 0; done <= steps; ++done)
    lines.push_back(line(fmt::format("{} steps done", done), estimate.remaining(done)));
  lines.push_back(line("one", estimate.total_of(0)));
  lines.push_back(line("two", estimate.total_of(1)));
  lines.push_back(line("both", estimate.total()));
  return lines;
}

void check_left(const std::vector<std::string>& said, const std::string& expected) {
  std::string all = "\n";
  for (const std::string& line : said) all += line + "\n";
  CHECK(all == expected);
}

}  // namespace

TEST_CASE("time left: by the model's own times, step by step") {
  const std::vector<Recipe> recipes = two_recipes();
  const auto steps = sequences::compile(recipes);
  sequences::TimeModel model;
  model.rise_psi_per_s = 20.0;
  model.fall_psi_per_s = 10.0;
  model.settle_s = 1.0;
  model.prompt_s = 0.0;
  check_left(shown_left(TimeEstimate(recipes, steps, model), steps.size()), R"(
0 steps done: 46.446 49.800 60.980 s, 2 prompts, 0 runs
1 steps done: 46.446 49.800 60.980 s, 1 prompts, 0 runs
2 steps done: 43.169 46.400 57.170 s, 1 prompts, 0 runs
3 steps done: 39.468 42.600 53.040 s, 1 prompts, 0 runs
4 steps done: 36.541 39.600 49.798 s, 1 prompts, 0 runs
5 steps done: 33.185 36.200 46.250 s, 1 prompts, 0 runs
6 steps done: 29.400 32.400 42.400 s, 1 prompts, 0 runs
7 steps done: 29.400 32.400 42.400 s, 0 prompts, 0 runs
8 steps done: 26.700 29.400 38.400 s, 0 prompts, 0 runs
9 steps done: 23.800 26.200 34.200 s, 0 prompts, 0 runs
10 steps done: 20.900 23.000 30.000 s, 0 prompts, 0 runs
11 steps done: 17.800 19.600 25.600 s, 0 prompts, 0 runs
12 steps done: 14.700 16.200 21.200 s, 0 prompts, 0 runs
13 steps done: 12.000 13.200 17.200 s, 0 prompts, 0 runs
14 steps done: 9.100 10.000 13.000 s, 0 prompts, 0 runs
15 steps done: 6.200 6.800 8.800 s, 0 prompts, 0 runs
16 steps done: 3.100 3.400 4.400 s, 0 prompts, 0 runs
17 steps done: 0.000 0.000 0.000 s, 0 prompts, 0 runs
one: 15.900 17.400 22.400 s, 1 prompts, 0 runs
two: 29.400 32.400 42.400 s, 1 prompts, 0 runs
both: 46.446 49.800 60.980 s, 2 prompts, 0 runs
)");
}

TEST_CASE("time left: by two stored runs of the second recipe, step by step") {
  const std::vector<Recipe> recipes = two_recipes();
  const auto steps = sequences::compile(recipes);
  const TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  store.add_sensor({"S-1", "type", "", "", "", "", ""});
  Past past;
  past.growth_s = 0.5;
  store_run(store, {recipes[1]}, past);
  past.step_s = 4.0;
  store_run(store, {recipes[1]}, past);
  TimeEstimate shaped(recipes, steps, sequences::TimeModel()), flat = shaped;
  shaped.learn(db::RunStore::open_read_only(store.path()), "b", {}, true);
  check_left(shown_left(shaped, steps.size()), R"(
0 steps done: 76.395 109.783 154.113 s, 2 prompts, 0 runs
1 steps done: 50.448 79.783 109.282 s, 1 prompts, 0 runs
2 steps done: 47.671 77.000 106.434 s, 1 prompts, 0 runs
3 steps done: 44.892 74.217 103.600 s, 1 prompts, 0 runs
4 steps done: 42.245 71.567 100.914 s, 1 prompts, 0 runs
5 steps done: 39.464 68.783 98.109 s, 1 prompts, 0 runs
6 steps done: 36.681 66.000 95.319 s, 1 prompts, 2 runs
7 steps done: 35.596 62.250 88.904 s, 0 prompts, 2 runs
8 steps done: 34.512 58.500 82.488 s, 0 prompts, 2 runs
9 steps done: 32.677 54.000 75.323 s, 0 prompts, 2 runs
10 steps done: 30.343 49.000 67.657 s, 0 prompts, 2 runs
11 steps done: 27.508 43.500 59.492 s, 0 prompts, 2 runs
12 steps done: 24.173 37.500 50.827 s, 0 prompts, 2 runs
13 steps done: 20.339 31.000 41.661 s, 0 prompts, 2 runs
14 steps done: 16.004 24.000 31.996 s, 0 prompts, 2 runs
15 steps done: 11.169 16.500 21.831 s, 0 prompts, 2 runs
16 steps done: 5.835 8.500 11.165 s, 0 prompts, 2 runs
17 steps done: 0.000 0.000 0.000 s, 0 prompts, 2 runs
one: 27.808 43.783 77.033 s, 1 prompts, 0 runs
two: 36.681 66.000 95.319 s, 1 prompts, 2 runs
both: 76.395 109.783 154.113 s, 2 prompts, 0 runs
)");
  flat.learn(db::RunStore::open_read_only(store.path()), "b", {}, false);
  check_left(shown_left(flat, steps.size()), R"(
0 steps done: 76.395 109.783 154.113 s, 2 prompts, 0 runs
1 steps done: 50.448 79.783 109.282 s, 1 prompts, 0 runs
2 steps done: 47.671 77.000 106.434 s, 1 prompts, 0 runs
3 steps done: 44.892 74.217 103.600 s, 1 prompts, 0 runs
4 steps done: 42.245 71.567 100.914 s, 1 prompts, 0 runs
5 steps done: 39.464 68.783 98.109 s, 1 prompts, 0 runs
6 steps done: 36.681 66.000 95.319 s, 1 prompts, 2 runs
7 steps done: 17.387 31.283 45.180 s, 0 prompts, 2 runs
8 steps done: 15.682 28.217 40.751 s, 0 prompts, 2 runs
9 steps done: 13.935 25.073 36.211 s, 0 prompts, 2 runs
10 steps done: 12.188 21.929 31.671 s, 0 prompts, 2 runs
11 steps done: 10.441 18.786 27.131 s, 0 prompts, 2 runs
12 steps done: 8.693 15.642 22.590 s, 0 prompts, 2 runs
13 steps done: 6.989 12.575 18.161 s, 0 prompts, 2 runs
14 steps done: 5.242 9.431 13.621 s, 0 prompts, 2 runs
15 steps done: 3.494 6.288 9.081 s, 0 prompts, 2 runs
16 steps done: 1.747 3.144 4.540 s, 0 prompts, 2 runs
17 steps done: 0.000 0.000 0.000 s, 0 prompts, 2 runs
one: 27.808 43.783 77.033 s, 1 prompts, 0 runs
two: 36.681 66.000 95.319 s, 1 prompts, 2 runs
both: 76.395 109.783 154.113 s, 2 prompts, 0 runs
)");
}
