#include "bench/run/time_estimate.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/bench/run/stored_past.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using sequences::Recipe;

namespace {

struct Bed {
  TemporaryFolder folder;
  db::RunStore store = db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  Bed() { store.add_sensor({"S-1", "type", "", "", "", "", ""}); }
  [[nodiscard]] TimeEstimate learned(const std::vector<Recipe>& recipes,
                                     const std::vector<sequences::Override>& overrides = {}, bool shape = true) const {
    TimeEstimate estimate(recipes, sequences::compile(recipes), sequences::TimeModel());
    estimate.learn(db::RunStore::open_read_only(store.path()), "b", overrides, shape);
    return estimate;
  }
};

}  // namespace

TEST_CASE("without history the model's time band is given and labelled as the model's") {
  // Of each recipe 2 steps of conditioning and 18 frames: 20 x (2 s dwell + 0.65 s settling), and three times 0-8-0 psi
  // at 60 psi/s: 53.8 s.
  const std::vector<Recipe> recipes = {recipe_named("a"), recipe_named("b")};
  const auto steps = sequences::compile(recipes);
  const TimeEstimate estimate(recipes, steps, sequences::TimeModel());
  const TimeBand total = estimate.total();
  CHECK(total.runs == 0);
  CHECK(total.p10_s < total.p50_s);
  CHECK(total.p50_s < total.p90_s);
  CHECK(total.p50_s == Approx(107.6));
  CHECK(estimate.total_of(0).p50_s == Approx(53.8));
  CHECK(estimate.total_of(1).p50_s == Approx(53.8));
  CHECK(estimate.remaining(20).p50_s == Approx(53.8));
  CHECK(estimate.remaining(39).p50_s == Approx(2.65 + 2.0 / 60.0));  // the last level
  double last = total.p50_s;
  for (std::size_t done = 1; done <= steps.size(); ++done) {
    const double left = estimate.remaining(done).p50_s;
    CHECK(left < last);
    last = left;
  }
  CHECK(last == 0.0);
}

TEST_CASE("a completed run of the same recipe is learned from, total and remaining") {
  Bed bed;
  const std::vector<Recipe> recipes = {recipe_named("a")};
  const auto steps = sequences::compile(recipes);
  store_run(bed.store, recipes, {});
  const TimeEstimate one = bed.learned(recipes);
  CHECK(one.total().runs == 1);
  CHECK(one.total().p50_s == Approx(3.0 * static_cast<double>(steps.size())));
  for (std::size_t done = 0; done <= steps.size(); ++done) {
    CHECK(one.remaining(done).p50_s == Approx(3.0 * static_cast<double>(steps.size() - done)).margin(1e-6));
  }
  const double half_of_one = one.total().p90_s - one.total().p50_s;
  CHECK(half_of_one > 0.05 * one.total().p50_s);
  for (int i = 0; i < 5; ++i) store_run(bed.store, recipes, {});
  const TimeBand six = bed.learned(recipes).total();
  CHECK(six.runs == 6);
  CHECK(six.p90_s - six.p50_s < 0.2 * half_of_one);
  CHECK(six.p90_s > six.p50_s);
}

TEST_CASE("time already lost in a run is not added to the remaining time") {
  Bed bed;
  const std::vector<Recipe> recipes = {recipe_named("a")};
  Past past;
  past.redo_after = 5;
  store_run(bed.store, recipes, past);
  const TimeEstimate estimate = bed.learned(recipes);
  CHECK(estimate.total().p50_s == Approx(160.0));
  CHECK(estimate.remaining(2).p50_s == Approx(154.0));
  CHECK(estimate.remaining(9).p50_s == Approx(33.0));
}

TEST_CASE("other work is not learned from") {
  Bed bed;
  const std::vector<Recipe> recipes = {recipe_named("a")};
  Past other;
  other.outcome = db::Outcome::kStopped;
  store_run(bed.store, recipes, other);
  other = {};
  other.bench = "another";
  store_run(bed.store, recipes, other);
  other = {};
  other.overrides = R"([{"key":"recipe.dwell_s","value":"9"}])";
  store_run(bed.store, recipes, other);
  store_run(bed.store, {recipe_named("b")}, {});
  CHECK(bed.learned(recipes).total().runs == 0);
  CHECK(bed.learned(recipes, {{"recipe.dwell_s", "9"}}).total().runs == 1);
  // What was changed on the bench's side does not make another recipe of it.
  CHECK(bed.learned(recipes, {{"simulation.seed", "4"}, {"recipe.dwell_s", "9"}}).total().runs == 1);
}

TEST_CASE("a recipe is learned from wherever it stood in a run") {
  Bed bed;
  const std::vector<Recipe> both = {recipe_named("a"), recipe_named("b")};
  store_run(bed.store, both, {});
  const TimeBand second = bed.learned({both[1]}).total();
  CHECK(second.runs == 1);
  CHECK(second.p50_s == Approx(60.0));
  const TimeEstimate again = bed.learned(both, {}, false);
  CHECK(again.total().p50_s == Approx(120.0));
  CHECK(again.total().runs == 1);
  CHECK(again.remaining(20).p50_s == Approx(60.0));
  // Without the shape the remaining time follows the model's.
  CHECK(again.remaining(30).p50_s == Approx(30.0).epsilon(0.2));
  const TimeBand mixed = bed.learned({both[0], recipe_named("c")}).total();
  CHECK(mixed.runs == 0);
}

TEST_CASE("waits in a stored run are not learned, neither for the total nor for the remaining time") {
  const auto [prompt_s, paused_after, tolerance] =
      GENERATE(table<double, int, double>({{600.0, -1, 1e-6}, {0.0, 5, 1e-6}, {600.0, 13, 1e-6}, {0.0, 18, 1e-6}}));
  Bed bed;
  const std::vector<Recipe> recipes = {recipe_named("a")};
  const auto steps = sequences::compile(recipes);
  Past past;
  past.prompt_s = prompt_s;
  past.paused_after = paused_after;
  store_run(bed.store, recipes, past);
  const TimeEstimate estimate = bed.learned(recipes);
  REQUIRE(estimate.total().runs == 1);
  for (std::size_t done = 0; done <= steps.size(); ++done) {
    CHECK(estimate.remaining(done).p50_s == Approx(3.0 * static_cast<double>(steps.size() - done)).margin(tolerance));
  }
}

TEST_CASE("waiting between two sequences of a run counts in the time of neither") {
  Bed bed;
  const std::vector<Recipe> both = {recipe_named("a"), recipe_named("b")};
  Past past;
  past.paused_after = 18;  // the last of the first
  store_run(bed.store, both, past);
  const TimeEstimate estimate = bed.learned(both);
  CHECK(estimate.total_of(0).p50_s == Approx(60.0));
  CHECK(estimate.total_of(1).p50_s == Approx(60.0 + 50.0));  // that it had to travel again is its own
}

TEST_CASE("prompts are counted separately from the time") {
  const std::vector<Recipe> recipes = {sequences::read_recipe(find_recipe("ring")), recipe_named("a")};
  BenchConfig bench;
  const TimeEstimate estimate(recipes, sequences::compile(recipes), time_model(bench));
  CHECK(estimate.total().prompts == 1);
  CHECK(estimate.total_of(0).prompts == 1);
  CHECK(estimate.total_of(1).prompts == 0);
  CHECK(estimate.remaining(1).prompts == 0);
}

TEST_CASE("time left: rises and falls at their own speeds, and bands of two recipes widen independently") {
  const auto recipe = [](const std::string& text) {
    return sequences::parse_recipe(sequences::TomlDocument::from_text("schema = 1\nunit = \"psi\"\n" + text, "r.toml"));
  };
  const std::vector<Recipe> recipes = {
      recipe("name = \"one\"\nturning_points = [0, 8, 0]\nstep = 8\n[prompt]\nbefore = \"ready?\"\n"
             "[conditioning]\ncycles = 1\npeak = 8\n"),
      recipe("name = \"two\"\nturning_points = [0, 8, 0]\nstep = 4\nrepeats = 2\n[prompt]\nbefore = \"now?\"\n")};
  const auto steps = sequences::compile(recipes);
  sequences::TimeModel model;
  model.rise_psi_per_s = 20.0;
  model.fall_psi_per_s = 10.0;
  model.settle_s = 1.0;
  model.prompt_s = 0.0;
  const TimeEstimate estimate(recipes, steps, model);
  // Steps of 2 s dwell and 1 s to settle; 8 psi up take 0.4 s, down 0.8 s. One: five steps, up and down twice.
  CHECK(estimate.total_of(0).p50_s == Approx(5 * 3.0 + 2 * (0.4 + 0.8)));
  CHECK(estimate.total_of(1).p50_s == Approx(10 * 3.0 + 2 * (0.4 + 0.8)));
  const TimeBand one = estimate.total_of(0), two = estimate.total_of(1), both = estimate.total();
  CHECK(both.p50_s == Approx(one.p50_s + two.p50_s));
  CHECK(both.p90_s - both.p50_s == Approx(std::hypot(one.p90_s - one.p50_s, two.p90_s - two.p50_s)));
  CHECK(both.p50_s - both.p10_s == Approx(std::hypot(one.p50_s - one.p10_s, two.p50_s - two.p10_s)));
  double last_s = both.p50_s;
  for (std::size_t done = 0; done <= steps.size(); ++done) {
    const TimeBand left = estimate.remaining(done);
    CHECK(left.p50_s <= last_s);
    CHECK((left.p10_s <= left.p50_s && left.p50_s <= left.p90_s));
    CHECK(left.prompts == (done == 0 ? 2 : done <= 6 ? 1 : 0));  // the prompts are steps 1 and 7
    last_s = left.p50_s;
  }
  CHECK(last_s == 0.0);
}
