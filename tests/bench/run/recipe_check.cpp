// The preflight of recipes: margins to their limits, the devices they need, the levels that limits judge at.

#include "bench/run/recipe_check.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/error.h"
#include "tests/support/paths.h"

using namespace tactbench;
using namespace tactbench::bench;
using bench::BenchConfig;
using bench::Margin;
using sequences::Recipe;
using sequences::RecipeKind;
using sequences::Step;
using sequences::StepKind;

namespace {

Step measure(double level, double from, double to) {
  Step step;
  step.setpoint = devices::Psi(level);
  step.branch_from = devices::Psi(from);
  step.branch_to = devices::Psi(to);
  return step;
}

std::vector<bench::LackingLevel> lacking(const std::vector<Step>& steps, const std::vector<double>& judged) {
  analysis::Limits limits;
  for (const double level : judged) limits.mismatch.push_back({level, 0.1});
  return bench::lacking_levels(steps, limits);
}

// Regulator to 9 bar, reference to 100 psi, 0 to 10 V each.
BenchConfig with_spans() {
  BenchConfig config;
  const auto to = [](double psi) {
    return devices::LinearSpan{devices::Volts(0.0), devices::Volts(10.0), devices::Psi(0.0), devices::Psi(psi)};
  };
  config.regulator.command_span = config.regulator.feedback_span = to(130.534);
  config.reference.span = to(100.0);
  return config;
}

Recipe levels_recipe(double peak) {
  Recipe recipe;
  recipe.name = "levels";
  recipe.turning_points = {devices::Psi(0.0), devices::Psi(peak), devices::Psi(0.0)};
  recipe.step = devices::Psi(peak / 2.0);
  return recipe;
}

// "id: what", of which numbers and names count.
std::string refusal(const Recipe& recipe, const BenchConfig& config) {
  try {
    bench::check_recipes({recipe}, config);
  } catch (const bench::Error& error) {
    CHECK(error.code() == bench::ExitCode::kUsage);
    CHECK_FALSE(error.remedy().empty());
    return error.id() + ": " + error.what();
  }
  return "none";
}

}  // namespace

TEST_CASE("recipe margins: the nearer limit counts, and a rounding error beyond it is accepted") {
  const Margin margin{"x", "mm", 3.0, 8.0, 1.0, 10.0};
  CHECK(margin.margin() == 2.0);
  CHECK(Margin{"x", "mm", 3.0, 8.0, 1.5, 12.0}.margin() == 1.5);
  CHECK(Margin{"x", "mm", 1.0, 10.0, 1.0, 10.0}.within());
  CHECK(Margin{"x", "psi", 0.0, 60.0 + 5.9e-8, -1e9, 60.0}.within());
  CHECK_FALSE(Margin{"x", "psi", 0.0, 60.0 + 6.1e-8, -1e9, 60.0}.within());
  CHECK(Margin{"x", "psi", 0.0, 0.5 + 0.9e-9, -1e9, 0.5}.within());
  CHECK_FALSE(Margin{"x", "psi", 0.0, 0.5 + 1.1e-9, -1e9, 0.5}.within());
  CHECK_FALSE(Margin{"x", "mm", 0.9, 8.0, 1.0, 10.0}.within());
}

TEST_CASE("recipe margins: pressure, positions and force, if the steps have them") {
  BenchConfig config = with_spans();
  config.limits.command_psi = 55.0;
  config.limits.force_n = {4.0, 6.0, 30.0};
  std::vector<Step> steps = {measure(10.0, 0.0, 40.0), measure(40.0, 0.0, 40.0)};
  auto margins = bench::margins(steps, config);
  REQUIRE(margins.size() == 1);
  CHECK((margins[0].axis == "pressure" && margins[0].unit == "psi"));
  CHECK((margins[0].highest == 40.0 && margins[0].high_limit == 55.0 && margins[0].margin() == 15.0));
  Step move;
  move.kind = StepKind::kMoveXy;
  move.x_mm = 10.0;
  move.y_mm = 20.0;
  Step press;
  press.kind = StepKind::kPress;
  press.force_n = 12.0;
  steps = {move, press};
  CHECK(bench::margins(steps, config).size() == 1);  // no stage: of the force alone
  config.stage.emplace();
  config.stage->options.axes[0].low = devices::Millimetres(2.0);
  config.stage->options.axes[1].high = devices::Millimetres(50.0);
  margins = bench::margins(steps, config);
  REQUIRE(margins.size() == 3);
  CHECK((margins[0].axis == "x" && margins[0].lowest == 10.0 && margins[0].low_limit == 2.0));
  CHECK((margins[1].axis == "y" && margins[1].highest == 20.0 && margins[1].high_limit == 50.0));
  CHECK((margins[2].axis == "force" && margins[2].highest == 12.0 && margins[2].high_limit == 30.0));
  CHECK(margins[2].lowest == 0.0);
}

TEST_CASE("recipe check: passes at the limit, and beyond it is rejected with the quantity") {
  const auto refused = [](const Recipe& recipe, const BenchConfig& config, const std::string& id,
                          const std::vector<std::string>& parts) {
    const std::string what = refusal(recipe, config);
    INFO(what);
    CHECK(what.starts_with(id + ": "));
    for (const std::string& part : parts) CHECK(what.find(part) != std::string::npos);
  };
  BenchConfig config = with_spans();
  CHECK(refusal(levels_recipe(60.0), config) == "none");
  config.limits.command_psi = 59.0;
  refused(levels_recipe(60.0), config, "TB-RECIPE-LIMIT", {"levels", "60.00 psi", "59.00 psi"});
  config = with_spans();
  config.regulator.command_span.high = devices::Psi(58.0);
  refused(levels_recipe(60.0), config, "TB-RECIPE-LIMIT", {"60.00 psi", "58.00 psi"});
  config = with_spans();
  config.module.profile.outputs.volts.high = 4.0;
  refused(levels_recipe(60.0), config, "TB-RECIPE-LIMIT", {"52.21 psi"});
  config = with_spans();
  config.reference.span.high = devices::Psi(50.0);  // and what a sound one may be off
  refused(levels_recipe(60.0), config, "TB-RECIPE-LIMIT", {"51.00 psi"});
  Recipe press;
  press.name = "press";
  press.kind = RecipeKind::kPress;
  press.press.positions_mm = {{30.0, 30.0}};
  press.press.forces_n = {2.0, 10.0};
  config = with_spans();
  refused(press, config, "TB-RECIPE-DEVICES", {"stage"});
  config.stage.emplace();
  refused(press, config, "TB-RECIPE-DEVICES", {"force sensor"});
  config.force.emplace();
  CHECK(refusal(press, config) == "none");
  config.limits.force_n[2] = 9.5;
  refused(press, config, "TB-RECIPE-LIMIT", {"10.00 N", "9.50 N"});
  config.limits.force_n[2] = 10.1;  // not with tolerance and overshoot
  refused(press, config, "TB-RECIPE-LIMIT", {"10 N", "10.1 N"});
  config.limits.force_n[2] = 35.0;
  config.stage->options.axes[0].high = devices::Millimetres(29.0);
  refused(press, config, "TB-RECIPE-LIMIT", {"30.00 mm", "29.00 mm", " x"});
  config.stage->options.axes[0].high = devices::Millimetres(60.0);
  config.stage->options.axes[1].low = devices::Millimetres(31.0);
  refused(press, config, "TB-RECIPE-LIMIT", {"30.00 mm", "31.00 mm", " y"});
  config = with_spans();
  Recipe timed = levels_recipe(20.0);
  timed.dwell_s = {1.0, 3.0};
  timed.step_timeout_s = 4.0;
  CHECK(refusal(timed, config) == "none");
  timed.step_timeout_s = 3.0;
  refused(timed, config, "TB-RECIPE-LIMIT", {"3 s"});
  Recipe waits = levels_recipe(20.0);
  waits.suspend.push_back({"supply_bar", true, 6.0, 6.5});
  config = with_spans();
  config.environment.emplace_back().quantity = "temperature_c";
  refused(waits, config, "TB-RECIPE-DEVICES", {"supply_bar"});
  config.environment.emplace_back().quantity = "supply_bar";
  CHECK(refusal(waits, config) == "none");
}

TEST_CASE("recipe check: a speed above the limit of the guard is rejected before anything moves") {
  BenchConfig config = with_spans();
  config.stage.emplace();
  config.force.emplace();
  Recipe press;
  press.name = "press";
  press.kind = RecipeKind::kPress;
  press.press.positions_mm = {{30.0, 30.0}};
  press.press.forces_n = {2.0, 10.0};
  const auto at = [&](double most, double approach, double servo) {
    config.stage->options.axes[2].maximum_speed = devices::MillimetresPerSecond(most);
    press.press.approach_mm_per_s = approach;
    press.press.servo_mm_per_s = servo;
    return refusal(press, config);
  };
  CHECK(at(0.5, 0.5, 0.5) == "none");
  for (const auto& [what, key] :
       {std::pair(at(0.05, 0.5, 0.05), "approach_mm_per_s"), std::pair(at(0.2, 0.2, 0.25), "servo_mm_per_s")}) {
    INFO(what);
    CHECK(what.starts_with("TB-RECIPE-LIMIT: "));
    CHECK(what.find(key) != std::string::npos);
  }
}

TEST_CASE(
    "recipe check: a step smaller than the output resolution or the settling band gives a warning with the value") {
  BenchConfig config;  // 12 bits of 10 V, 130 psi: 0.0317 psi a count
  config.module.profile.outputs.volts = {0.0, 4095.0, 0.0, 10.0};
  config.regulator.command_span = {devices::Volts(0.0), devices::Volts(10.0), devices::Psi(0.0), devices::Psi(130.0)};
  config.settling.band_psi = 0.25;
  const auto warned = [&](double step, bool settle = true) {
    Recipe recipe = levels_recipe(60.0);
    recipe.step = devices::Psi(step);
    recipe.settle = settle;
    const std::vector<std::string> lines = bench::recipe_warnings({recipe, levels_recipe(60.0)}, config);
    REQUIRE(lines.size() <= 1);
    return lines.empty() ? std::string() : lines.front();
  };
  CHECK(warned(0.25).empty());
  CHECK(warned(0.04, false).empty());  // taken as the ramp passes: no band
  CHECK(warned(0.01).find("0.0317") != std::string::npos);
  CHECK(warned(0.01, false).find("0.0317") != std::string::npos);
  CHECK(warned(0.01).find("band_psi") != std::string::npos);
  CHECK(warned(0.1).find("0.0317") == std::string::npos);
  for (const double step : {0.1, 0.2}) CHECK(warned(step).find("band_psi") != std::string::npos);
  CHECK(warned(0.029, false).find("0.0317") != std::string::npos);  // 0.002 bar
  for (const double step : {0.5, 2.0, 2.9008, 4.0}) CHECK(warned(step).empty());
  Recipe fast = levels_recipe(60.0);
  fast.ramp_psi_per_s = {0.5, 30.0};
  CHECK(bench::recipe_warnings({fast}, config).size() == 1);
  fast.ramp_psi_per_s = {config.limits.rate_psi_per_s};
  CHECK(bench::recipe_warnings({fast}, config).empty());
  Recipe press = levels_recipe(60.0);
  press.kind = RecipeKind::kPress;
  press.step = devices::Psi(0.01);
  CHECK(bench::recipe_warnings({press}, config).empty());
}

TEST_CASE("recipe check: the devices needed by recipes are listed once, in the order of use") {
  Recipe levels, press;
  press.kind = RecipeKind::kPress;
  levels.suspend.push_back({"supply_bar", true, 6.0, 6.5});
  using Names = std::vector<std::string>;
  CHECK(bench::devices_needed({levels, levels}) ==
        Names{"pressure source", "pressure reference", "tactile array", "supply_bar"});
  CHECK(bench::devices_needed({press}) == Names{"stage", "force sensor", "tactile array"});
  CHECK(bench::devices_needed({press, levels}) ==
        Names{"stage", "force sensor", "tactile array", "pressure source", "pressure reference", "supply_bar"});
  CHECK(bench::needs_press({levels, press}));
  CHECK_FALSE(bench::needs_press({levels, levels}));
}

TEST_CASE("missing levels: levels that are not measured in both directions, with the nearest that are") {
  // Up over 2, 4, 6 to 8, down over 5 to 0: both pass 0 and 8, which turn.
  std::vector<Step> steps = {measure(0.0, 0.0, 8.0), measure(2.0, 0.0, 8.0), measure(4.0, 0.0, 8.0),
                             measure(8.0, 0.0, 8.0), measure(5.0, 8.0, 0.0), measure(0.0, 8.0, 0.0)};
  CHECK(lacking(steps, {0.0, 8.0}).empty());
  const auto found = lacking(steps, {4.0, 9.0, -1.0, 5.0});
  REQUIRE(found.size() == 4);
  CHECK(found[0].pressure_psi == 4.0);
  CHECK(found[0].nearest_psi == std::vector<double>{0.0, 8.0});
  CHECK(found[1].nearest_psi == std::vector<double>{8.0});
  CHECK(found[2].nearest_psi == std::vector<double>{0.0});
  CHECK(found[3].pressure_psi == 5.0);
  steps.push_back(measure(4.0 + 4e-7, 8.0, 0.0));  // the same except for rounding
  CHECK(lacking(steps, {4.0}).empty());
  CHECK(lacking(steps, {4.0 + 4e-7}).empty());
  CHECK(lacking(steps, {4.009}).empty());  // as people type it, or another unit's
  CHECK(lacking(steps, {4.011}).size() == 1);
  steps.back().setpoint = devices::Psi(4.000002);
  CHECK(lacking(steps, {4.0}).size() == 1);
  steps.back().kind = StepKind::kConditioning;
  steps.back().setpoint = devices::Psi(4.0);
  CHECK(lacking(steps, {4.0}).size() == 1);  // travelled, not measured
  CHECK(lacking({measure(4.0, 4.0, 4.0)}, {4.0}).empty());
  CHECK(lacking({}, {4.0}).front().nearest_psi.empty());
}

TEST_CASE("limits: those that cannot be judged on a recipe are found from its steps, shipped recipes have none") {
  struct Row {
    std::vector<std::string> judged, fitted;
    std::vector<double> levels;  // of the limits, in addition to the span of [[mpe]]
    std::pair<double, double> span;
    std::size_t open;
    bool nothing;
  };
  const std::pair<double, double> usual{4.0, 40.0}, beyond{61.0, 65.0};
  const std::vector<Row> rows = {
      {{"verification"}, {"production"}, {8.0, 40.0}, usual, 0, false},
      {{"verification-short"}, {"production-short"}, {8.0, 40.0}, usual, 0, false},
      {{"random-reversal"}, {"production"}, {8.0, 40.0}, usual, 1, false},  // one history of a kind alone
      {{"random-reversal"}, {"production"}, {9.0, 40.0}, usual, 2, false},
      {{"random-reversal"}, {"production"}, {9.0}, usual, 2, true},
      {{"verification"}, {"production"}, {9.0, 41.0}, usual, 2, false},
      {{"verification"}, {"production"}, {9.0, 41.0}, beyond, 3, true},
      {{"random-reversal", "reversals"}, {}, {}, usual, 0, false}};
  for (const Row& row : rows) {
    analysis::Limits limits;
    for (const double level : row.levels) limits.mismatch.push_back({level, 0.1});
    limits.mpe.push_back({row.span.first, row.span.second, 4.0});
    const auto steps_of = [](const std::vector<std::string>& names) {
      return sequences::compile(bench::read_recipes(names));
    };
    const bench::NotJudged found =
        bench::not_judged(steps_of(row.judged), steps_of(row.fitted), limits, analysis::PressureUnit::kPsi);
    INFO(row.judged.front() << " " << row.levels.size() << " " << row.span.first);
    CHECK(found.why.size() == row.open);
    CHECK(found.nothing == row.nothing);
  }
}

namespace {

std::vector<std::string> shipped() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(tactbench::tests::source_path("sequences"))) {
    const std::string stem = entry.path().stem();
    if (entry.path().extension() == ".toml" && stem != "nightly")  // the suite, read in a test of its own
      names.push_back(stem);
  }
  return names;
}

BenchConfig simulated(const std::vector<sequences::Override>& overrides = {}) {
  return read_bench(find_config("simulated.toml"), overrides);
}

}  // namespace

TEST_CASE("shipped recipes: all compile and are within the limits of both shipped benches") {
  const std::vector<std::string> names = shipped();
  const BenchConfig rig = read_bench(find_config("paper-rig.example.toml"), {});
  for (const std::string& name : names) {
    INFO(name);
    const sequences::RecipeFile file = read_recipe_file(name);
    REQUIRE(!file.recipes.empty());
    if (file.recipes.size() > 1) {  // of shipped parts, which are checked here as it sets them
      check_recipes(file.recipes, simulated());
      check_recipes(file.recipes, rig);
      continue;
    }
    const Recipe& recipe = file.recipes.front();
    CHECK(recipe.name == name);
    CHECK(recipe.text.starts_with("# "));
    check_recipes({recipe}, simulated());
    check_recipes({recipe}, rig);
    const std::vector<Step> steps = sequences::compile(recipe, 0);
    CHECK(!steps.empty());
    CHECK(!devices_needed({recipe}).empty());
    for (const Margin& margin : margins(steps, rig)) CHECK(margin.within());
    std::set<std::pair<int, int>> places;  // of frames: one each
    for (const Step& step : steps) CHECK((!has_frame(step) || places.emplace(step.repeat, step.ordinal).second));
  }
}

TEST_CASE("shipped recipes: every parameter can be set to both ends of its range") {
  for (const std::string& name : shipped()) {
    const sequences::RecipeFile file = read_recipe_file(name);
    if (file.recipes.size() > 1) continue;
    for (const sequences::Parameter& p : file.recipes.front().parameters) {
      INFO(name << " " << p.name);
      CHECK((p.low <= p.standard && p.standard <= p.high));
      CHECK(!p.help.empty());
      for (const double end : {p.low, p.high}) {
        const Recipe set = sequences::read_recipe(find_recipe(name), {{p.name, std::to_string(end)}});
        check_recipes({set}, simulated());
      }
    }
  }
}
