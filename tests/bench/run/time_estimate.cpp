#include "bench/run/time_estimate.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>

#include "tests/bench/run/quick_store.h"
#include "tests/bench/run/stored_past.h"

using namespace tactbench;
using namespace tactbench::bench;
using namespace tactbench::tests;
using sequences::Recipe;

namespace {

struct Bed {
  QuickStore store;
  Bed() { store.add_sensor({"S-1", "type", "", "", "", "", ""}); }
  [[nodiscard]] TimeEstimate learned(const std::vector<Recipe>& recipes,
                                     const std::vector<sequences::Override>& overrides = {}, bool shape = true) const {
    TimeEstimate estimate(recipes, sequences::compile(recipes), sequences::TimeModel());
    estimate.learn(db::RunStore::open_read_only(store.path()), "b", overrides, shape);
    return estimate;
  }
};

Recipe long_recipe() {  // 65 frames, once, two steps of conditioning before them
  return sequences::parse_recipe(sequences::TomlDocument::from_text(
      "schema = 1\nname = \"long\"\nunit = \"psi\"\nturning_points = [0, 64, 0]\nstep = 2\nrepeats = 1\n"
      "[conditioning]\ncycles = 1\npeak = 8\n",
      "long.toml"));
}

}  // namespace

TEST_CASE("time estimate: without earlier runs it is the time band of the model, and marked as such") {
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
}

TEST_CASE("time estimate: for a resumed run the complete branches count as done") {
  const auto steps = sequences::compile(long_recipe(), 0);  // two of conditioning, 33 frames up, 32 down
  const auto first_undone = [&](std::int64_t frames) { return steps_done(steps, frames); };
  CHECK(first_undone(32) == 2);
  CHECK(first_undone(33) == 35);
  CHECK(first_undone(64) == 35);
  CHECK(first_undone(65) == steps.size());
  const TimeEstimate estimate({long_recipe()}, steps, sequences::TimeModel());
  CHECK(estimate.remaining(first_undone(33)).p50_s == Approx(32 * 2.65 + 64.0 / 60.0));
}

TEST_CASE("time estimate: time lost in a run is not added to the remaining time") {
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

TEST_CASE("time estimate: runs of other work are not used") {
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
  // Changes of bench settings do not make it another recipe.
  CHECK(bed.learned(recipes, {{"simulation.seed", "4"}, {"recipe.dwell_s", "9"}}).total().runs == 1);
}

TEST_CASE("time estimate: a recipe is learned at any position in a run") {
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

TEST_CASE("time estimate: waits in a stored run are not learned, neither for the total nor the remaining time") {
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

TEST_CASE("time estimate: a wait between two sequences is added to neither") {
  Bed bed;
  const std::vector<Recipe> both = {recipe_named("a"), recipe_named("b")};
  Past past;
  past.paused_after = 18;  // the last of the first
  store_run(bed.store, both, past);
  const TimeEstimate estimate = bed.learned(both);
  CHECK(estimate.total_of(0).p50_s == Approx(60.0));
  CHECK(estimate.total_of(1).p50_s == Approx(60.0 + 50.0));  // that it had to travel again is its own
}

TEST_CASE("time left: uses rise and fall rates, and bands of two recipes widen independently") {
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
  CHECK((one.prompts == 1 && two.prompts == 1 && both.prompts == 2));
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

TEST_CASE("time band: of less than ten runs by Student's t about their median, for one further run") {
  const Recipe recipe = recipe_named("a");
  Bed bed;
  // 0.9 quantiles of Student's distribution, one degree of freedom and more.
  const std::vector<double> student = {3.077684, 1.885618, 1.637744, 1.533206, 1.475884, 1.439756, 1.414924, 1.396815};
  std::vector<double> totals;
  for (std::size_t n = 1; n <= 9; ++n) {
    INFO(n << " runs");
    Past past;
    past.step_s = 3.0 + 0.01 * static_cast<double>(n * n);
    store_run(bed.store, {recipe}, past);
    totals.push_back(20.0 * past.step_s);
    const TimeBand band = bed.learned({recipe}).total();
    CHECK(band.runs == static_cast<int>(n));
    const double middle = n % 2 == 1 ? totals[n / 2] : (totals[n / 2 - 1] + totals[n / 2]) / 2.0;
    CHECK(band.p50_s == Approx(middle).epsilon(1e-9));
    double half = 1.281552 * std::sqrt(2.0) * 0.05 * middle;
    if (n > 1) {
      const double count = static_cast<double>(n);
      const double mean = std::accumulate(totals.begin(), totals.end(), 0.0) / count;
      double squares = 0.0;
      for (const double total : totals) squares += (total - mean) * (total - mean);
      half = student[n - 2] * std::sqrt(squares / (count - 1.0) * (1.0 + 1.0 / count));
    }
    CHECK(band.p90_s - band.p50_s == Approx(half).epsilon(1e-6));
    CHECK(band.p50_s - band.p10_s == Approx(half).epsilon(1e-6));
  }
}

TEST_CASE("time band: of ten runs by quantiles, of more by the newest ten, never narrower than 0.5 %") {
  const Recipe recipe = recipe_named("a");
  Bed bed;
  for (int i = 1; i <= 11; ++i) {
    Past past;
    past.step_s = 3.0 + 0.01 * i * i;
    store_run(bed.store, {recipe}, past);
  }
  // The oldest, 3.01 s a step, is no part of it.
  const auto total = [](double i) { return 20.0 * (3.0 + 0.01 * i * i); };
  const TimeBand band = bed.learned({recipe}).total();
  CHECK(band.runs == 10);
  CHECK(band.p10_s == Approx(total(2) + 0.9 * (total(3) - total(2))));
  CHECK(band.p50_s == Approx((total(6) + total(7)) / 2.0));
  CHECK(band.p90_s == Approx(total(10) + 0.1 * (total(11) - total(10))));
  Bed alike;
  for (int i = 0; i < 10; ++i) store_run(alike.store, {recipe}, {});
  const TimeBand narrow = alike.learned({recipe}).total();
  CHECK(narrow.p90_s - narrow.p50_s == Approx(0.005 * 60.0));
  CHECK(narrow.p50_s - narrow.p10_s == Approx(0.005 * 60.0));
  Bed apart;
  store_run(apart.store, {recipe}, {});
  Past slow;
  slow.step_s = 300.0;
  store_run(apart.store, {recipe}, slow);
  CHECK(apart.learned({recipe}).total().p10_s == 0.0);  // no less than nothing
}

TEST_CASE("time band: two recipes vary independently, and the smaller number of runs counts") {
  const std::vector<Recipe> both = {recipe_named("a"), recipe_named("b")};
  Bed bed;
  store_run(bed.store, both, {});
  Past slow;
  slow.step_s = 3.5;
  store_run(bed.store, {both[1]}, slow);
  const TimeEstimate estimate = bed.learned(both);
  const TimeBand a = estimate.total_of(0), b = estimate.total_of(1), all = estimate.total();
  CHECK(a.runs == 1);
  CHECK(b.runs == 2);
  CHECK(all.runs == 1);
  CHECK(a.p50_s == Approx(60.0));
  CHECK(b.p50_s == Approx(65.0));
  CHECK(all.p50_s == Approx(125.0));
  CHECK(all.p90_s == Approx(125.0 + std::hypot(a.p90_s - 60.0, b.p90_s - 65.0)));
  CHECK(all.p10_s == Approx(125.0 - std::hypot(60.0 - a.p10_s, 65.0 - b.p10_s)));
  CHECK(estimate.remaining(20).runs == 2);
  CHECK(estimate.remaining(40).p50_s == 0.0);
  CHECK(estimate.remaining(40).runs == 2);
}

TEST_CASE("time left: 32 samples of each run, interpolated linearly") {
  const std::vector<Recipe> recipes = {long_recipe()};
  REQUIRE(sequences::compile(recipes).size() == 67);
  Past past;
  past.growth_s = 0.5;
  Bed bed;
  store_run(bed.store, recipes, past);
  const auto elapsed = [](int frames) {  // after so many frames; the two steps before them are part of the first
    const int steps = frames == 0 ? 0 : frames + 2;
    return 3.0 * steps + 0.5 * steps * (steps - 1) / 2.0;
  };
  const TimeEstimate estimate = bed.learned(recipes);
  CHECK(estimate.total().p50_s == Approx(elapsed(65)));
  for (int done = 0; done < 65; ++done) {
    INFO(done << " frames");
    int i = 0;
    while (65 * (i + 1) / 32 < done) ++i;
    const int low = 65 * i / 32, high = 65 * (i + 1) / 32;
    const double share = static_cast<double>(done - low) / (high - low);
    const double at = elapsed(low) + share * (elapsed(high) - elapsed(low));
    const std::size_t steps = done == 0 ? 0 : static_cast<std::size_t>(done) + 2;
    CHECK(estimate.remaining(steps).p50_s == Approx(elapsed(65) - at).epsilon(1e-7));
  }
  // Conditioning counts as parts of the first frame, which lies between the first two samples (at 0 and 2 frames).
  CHECK(estimate.remaining(1).p50_s == Approx(elapsed(65) - elapsed(2) / 6.0));
  CHECK(estimate.remaining(2).p50_s == Approx(elapsed(65) - elapsed(2) / 3.0));
  // Without samples the model's own shape: 67 steps of 2.65 s, and their ramps at 60 psi/s.
  const TimeEstimate flat = bed.learned(recipes, {}, false);
  const double whole = 67 * 2.65 + (16.0 + 128.0) / 60.0;
  CHECK(flat.remaining(0).p50_s == Approx(elapsed(65)));
  CHECK(flat.remaining(66).p50_s == Approx(elapsed(65) * (2.65 + 2.0 / 60.0) / whole));
}

TEST_CASE("time estimate: uses the newest two hundred runs of the bench") {
  const Recipe recipe = recipe_named("a"), other = recipe_named("b");
  Bed bed;
  store_run(bed.store, {recipe}, {});
  Past idle;
  idle.idle = true;
  for (int i = 0; i < 199; ++i) store_run(bed.store, {other}, idle);
  CHECK(bed.learned({recipe}, {}, false).total().runs == 1);
  store_run(bed.store, {other}, idle);
  CHECK(bed.learned({recipe}, {}, false).total().runs == 0);
}

TEST_CASE("time estimate: only runs with the same recipe text and number of repeats, and a stored time, are used") {
  const Recipe recipe = recipe_named("a");
  Recipe thrice = recipe;
  thrice.repeats = 3;  // the text is the same
  Bed bed;
  store_run(bed.store, {thrice}, {});
  CHECK(bed.learned({recipe}).total().runs == 0);
  CHECK(bed.learned({thrice}).total().runs == 1);
  Past idle;
  idle.idle = true;
  store_run(bed.store, {recipe}, idle);  // nothing is stored of its time
  CHECK(bed.learned({recipe}).total().runs == 0);
  CHECK(bed.learned({recipe}).total_of(0).p50_s == Approx(53.8));
}

TEST_CASE("time model: rates in both directions, one feeding and one poll to settle, no time for operators") {
  BenchConfig bench;
  bench.limits.rate_psi_per_s = 13.0;
  bench.regulator.feed_interval = std::chrono::milliseconds(350);
  bench.settling.poll_s = 0.15;
  const sequences::TimeModel model = time_model(bench);
  CHECK(model.rise_psi_per_s == 13.0);
  CHECK(model.fall_psi_per_s == 13.0);
  CHECK(model.settle_s == Approx(0.5));
  CHECK(model.prompt_s == 0.0);
}
