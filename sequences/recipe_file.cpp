#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>

#include "sequences/recipe_parts.h"
#include "sequences/toml/pressure_text.h"

namespace tactbench::sequences {

namespace {

KeyTable tolerance_keys(Recipe& recipe) {
  if (recipe.kind == RecipeKind::kPress)
    return {key::number("tolerance_n", recipe.guard.tolerance_n, {"N"}, {0.0, 100.0},
                        "For kind = \"press\": a branch breaks when the force steps back by more than this")};
  return {key::number("tolerance_psi", recipe.guard.tolerance, {"psi"}, {0.0, 100.0},
                      "A branch breaks when the pressure steps back by more than this")};
}

KeyTable guard_keys(BranchRule& guard) {
  return {key::number("redo", guard.redo, kOne, {0, 20}, "How often a broken branch is done again"),
          key::word("on_broken", guard.fail_when_broken, {"fail", "flag"}, "fail",
                    "When it is still broken: fail the run, or flag the branch and go on")};
}

KeyTable quantity_keys(Suspension& item) {
  return {key::required(key::word("quantity", item.quantity, {"supply_bar", "temperature_c"},
                                  "What is watched; the bench needs a sensor of it"))};
}

// One pair of the two, by item.below.
KeyTable trip_keys(Suspension& item) {
  constexpr Unit kOfQuantity{"of the quantity"};
  if (item.below)
    return {key::required(key::number("trip_below", item.trip, kOfQuantity, {},
                                      "Below this the run vents and waits; it goes with resume_above")),
            key::required(key::number("resume_above", item.resume, kOfQuantity, {},
                                      "The run goes on once the quantity has stayed above this"))};
  return {key::required(key::number("trip_above", item.trip, kOfQuantity, {},
                                    "Above this the run vents and waits; it goes with resume_below")),
          key::required(key::number("resume_below", item.resume, kOfQuantity, {},
                                    "The run goes on once the quantity has stayed below this"))};
}

KeyTable hold_keys(Suspension& item) {
  return {key::number("hold_s", item.hold_s, {"s"}, {0.0, 86400.0}, "How long it must have stayed there"),
          key::number("timeout_s", item.timeout_s, {"s"}, {0.0, 7 * 86400.0}, "After a longer wait the run ends")};
}

void read_suspensions(const TomlTable& root, Recipe& recipe) {
  for (const TomlTable& table : root.tables("suspend")) {
    Suspension& item = recipe.suspend.emplace_back();
    read_keys(table, quantity_keys(item));
    item.below = table.has("trip_below");
    if (item.below == table.has("trip_above")) {
      table.fail("quantity", "a [[suspend]] needs either trip_below or trip_above",
                 "for instance trip_below = 6.0 with resume_above = 6.5");
    }
    read_keys(table, trip_keys(item));
    if (item.below ? item.resume < item.trip : item.resume > item.trip) {
      const char* resume = item.below ? "resume_above" : "resume_below";
      table.fail(resume,
                 fmt::format("'{}' is {:g}, on the wrong side of the trip at {:g}", resume, item.resume, item.trip),
                 "a quantity must come back past the trip before the run continues");
    }
    read_whole(table, hold_keys(item));
  }
}

KeyTable warm_up_keys(WarmUp& warm_up) {
  return {key::number("drift_percent_per_min", warm_up.drift_percent_per_min, {"%/min"}, {1e-6, 100.0},
                      "The first command waits until the unloaded output drifts less than this"),
          key::number("at_most_s", warm_up.at_most_s, {"s"}, {0.0, 86400.0},
                      "It waits at most this long; 0: it does not wait")};
}

KeyTable dwell_keys(Recipe& recipe) {
  return {key::number("tolerance_s", recipe.dwell_tolerance_s, {"s"}, {0.0, 3600.0},
                      "Frames whose dwell differs by more than this are flagged")};
}

KeyTable retry_keys(Retry& retry) {
  return {
      key::number("frame", retry.frame, kOne, {0, 20}, "How often a frame that a device failed is tried again"),
      key::number("branch", retry.branch, kOne, {0, 20}, "How often a branch in which a device failed is done again"),
      key::word("verdict", retry.any_passes, {"worst", "any"}, "any",
                "worst: a frame that needed another attempt is flagged; any: it counts like all others")};
}

KeyTable timeout_keys(Recipe& recipe) {
  return {key::number("step_s", recipe.step_timeout_s, {"s"}, {0.0, 86400.0},
                      "Longest time that one step may take; 0: the bench's own limits alone")};
}

KeyTable prompt_keys(Recipe& recipe) {
  return {key::text("before", recipe.prompt_before,
                    "Question to the operator before the sequence; \"\": none. --yes answers it")};
}

KeyTable rest_keys(Recipe& recipe) {
  return {key::number("rest_restart_s", recipe.rest_restart_s, {"s"}, {0.0, 1e9},
                      "A run that is resumed after a longer rest does the whole repeat again")};
}

void read_rules(const TomlTable& root, Recipe& recipe) {
  const auto read = [&](const char* name, std::initializer_list<KeyTable> tables) {
    const TomlTable table = root.table(name);
    for (const KeyTable& keys : tables) read_keys(table, keys);
    table.finish();
  };
  read("guard", {tolerance_keys(recipe), guard_keys(recipe.guard)});
  read_suspensions(root, recipe);
  read("warm_up", {warm_up_keys(recipe.warm_up)});
  read("dwell", {dwell_keys(recipe)});
  read("retry", {retry_keys(recipe.retry)});
  read("timeout", {timeout_keys(recipe)});
  read("prompt", {prompt_keys(recipe)});
  read_keys(root, rest_keys(recipe));
}

constexpr Unit kOfParameter{"of the parameter"};
constexpr const char* kTypedPrefix = "recipe.";  // prefix of a recipe's keys on the command line

KeyTable bound_keys(Parameter& parameter) {
  return {key::required(key::number("low", parameter.low, kOfParameter, {}, "Smallest value allowed")),
          key::required(key::number("high", parameter.high, kOfParameter, {}, "Largest value allowed")),
          key::required(key::number("default", parameter.standard, kOfParameter, {},
                                    "Its value where --set recipe.NAME=... names none"))};
}

KeyTable value_keys(double& value, const Range& range) {
  return {key::described(key::number("value", value, kOfParameter, range,
                                     "Its value, from low to high; --set recipe.NAME=... writes here"),
                         "that of default")};
}

KeyTable parameter_text_keys(Parameter& parameter) {
  return {key::text("unit", parameter.unit, "Its unit, for lists"),
          key::text("help", parameter.help, "What it does, for lists")};
}

// Errors in a typed value name the key as typed, not the place where the value is kept.
double value_of(const TomlTable& table, const Parameter& parameter, const std::vector<Override>& overrides,
                const std::string& file) {
  const auto typed = std::find_if(overrides.rbegin(), overrides.rend(),
                                  [&](const Override& item) { return item.key == parameter.name; });
  try {
    double value = parameter.standard;
    read_keys(table, value_keys(value, {parameter.low, parameter.high}));
    return value;
  } catch (const FileError& error) {
    if (typed == overrides.rend()) throw;
    std::string message = error.what();
    if (message.starts_with("'value'")) message.replace(1, 5, parameter.name);
    throw FileError(error.id(), message,
                    fmt::format("--set {}{}={} (over {})", kTypedPrefix, typed->key, typed->value, file),
                    error.remedy());
  }
}

}  // namespace

std::vector<Override> read_parameters(TomlDocument& document, Recipe& recipe, const std::vector<Override>& overrides) {
  std::vector<Override> others;
  const std::vector<std::string> declared = document.root().table("parameters").keys();
  for (const Override& item : overrides) {
    const bool known = std::find(declared.begin(), declared.end(), item.key) != declared.end();
    if (!known) {
      others.push_back(item);
      continue;
    }
    const std::string unit = document.root().table("parameters").table(item.key).text("unit", "");
    document.set({"parameters." + item.key + ".value", as_number_in(unit, item.value), item.value}, kTypedPrefix);
  }
  const TomlTable tables = document.root().table("parameters");
  for (const std::string& name : declared) {
    const TomlTable table = tables.table(name);
    Parameter parameter;
    parameter.name = name;
    read_keys(table, bound_keys(parameter));
    if (parameter.standard < parameter.low || parameter.standard > parameter.high) {
      table.fail(
          "default",
          fmt::format("'default' is {:g}, outside {:g} to {:g}", parameter.standard, parameter.low, parameter.high),
          "choose low <= default <= high");
    }
    parameter.value = value_of(table, parameter, overrides, document.name());
    read_whole(table, parameter_text_keys(parameter));
    document.define(name, parameter.value);
    recipe.parameters.push_back(parameter);
  }
  return others;
}

namespace {

// Pressures typed with a unit ("step=20kPa") as numbers in the unit of their key: the recipe's, or psi.
void apply_overrides(TomlDocument& document, const std::vector<Override>& overrides) {
  constexpr std::array kInRecipesUnit = {"step", "conditioning.peak", "random.low", "random.high"};
  for (const bool unit_first : {true, false}) {
    for (const Override& item : overrides) {
      if ((item.key == "unit") != unit_first) continue;
      std::string value = item.value;
      if (item.key.ends_with("_psi")) value = as_number_in("psi", value);
      if (std::ranges::find(kInRecipesUnit, item.key) != kInRecipesUnit.end())
        value = as_number_in(document.root().text("unit", "psi"), value);
      document.set({item.key, value, item.value}, kTypedPrefix);
    }
  }
}

KeyTable head_keys(Recipe& recipe) {
  return {key::schema(), key::name("name", recipe.name, "Short name, by which reports and lists call it")};
}

KeyTable kind_keys(Recipe& recipe) {
  recipe.title = recipe.name;
  return {key::described(key::text("title", recipe.title, "Title in reports and lists"), "the name"),
          key::word("kind", recipe.kind, {"levels", "press"},
                    "levels: pressure in the chamber; press: an object under the z stage")};
}

KeyTable set_keys(RecipeFile& file, std::vector<std::string>& names) {
  return {
      key::schema(), key::name("name", file.name, "Short name, by which reports and lists call it"),
      key::described(key::text("title", file.title, "Title in reports and lists"), "the name"),
      key::texts(
          "recipes", names,
          "In place of all other keys: recipes that are carried out one after the other; of each what else than its "
          "default its parameters have, as \"reversals seed=3\"")};
}

KeyTable repeat_keys(Recipe& recipe) {
  recipe.repeats = static_cast<int>(std::max(recipe.dwell_s.size(), recipe.ramp_psi_per_s.size()));
  return {key::described(
      key::number("repeats", recipe.repeats, kOne, {1, 1000}, "How often the whole sequence is carried out"),
      "as often as the longest list has entries")};
}

}  // namespace

std::vector<KeyFacts> recipe_keys() {
  Recipe recipe, press;
  press.kind = RecipeKind::kPress;
  Suspension below, above;
  above.below = false;
  Parameter parameter;
  std::vector<KeyFacts> all;
  const auto add = [&](const std::string& path, std::initializer_list<KeyTable> tables) {
    for (const KeyTable& keys : tables) add_facts(all, path, keys);
  };
  RecipeFile set;
  std::vector<std::string> names;
  add("", {head_keys(recipe), kind_keys(recipe), {set_keys(set, names).back()}});
  add_levels_keys(all);
  add("", {repeat_keys(recipe), rest_keys(recipe)});
  add("guard", {tolerance_keys(recipe), tolerance_keys(press), guard_keys(recipe.guard)});
  add("suspend[]", {quantity_keys(below), trip_keys(below), trip_keys(above), hold_keys(below)});
  add("warm_up", {warm_up_keys(recipe.warm_up)});
  add("dwell", {dwell_keys(recipe)});
  add("retry", {retry_keys(recipe.retry)});
  add("timeout", {timeout_keys(recipe)});
  add("prompt", {prompt_keys(recipe)});
  add("parameters.NAME", {bound_keys(parameter), value_keys(parameter.value, {}), parameter_text_keys(parameter)});
  add_press_keys(all);
  return all;
}

Recipe parse_recipe(TomlDocument document, const std::vector<Override>& overrides) {
  Recipe recipe;
  recipe.text = document.text();
  const std::vector<Override> others = read_parameters(document, recipe, overrides);
  apply_overrides(document, others);
  const TomlTable root = document.root();
  (void)root.table("parameters");
  read_keys(root, head_keys(recipe));
  read_keys(root, kind_keys(recipe));
  if (recipe.kind == RecipeKind::kPress) {
    read_press(root, recipe);
  } else {
    read_levels(root, recipe);
  }
  const KeyTable repeats = repeat_keys(recipe);
  const int shortest = recipe.repeats;
  read_keys(root, repeats);
  if (recipe.repeats < shortest) {
    root.fail("repeats", fmt::format("repeats = {} for a list of {}: not all would be used", recipe.repeats, shortest),
              fmt::format("use at least {}, or shorten the list", shortest));
  }
  read_rules(root, recipe);
  root.finish();
  check_size(root, recipe);
  for (const Parameter& parameter : recipe.parameters) {
    // An override may have replaced the "$name" in the file.
    if (document.uses(parameter.name) || !others.empty()) continue;
    root.table("parameters")
        .fail(parameter.name, fmt::format("nothing uses the parameter '{}'", parameter.name),
              fmt::format("write \"${}\" where its value belongs, or remove it", parameter.name));
  }
  return recipe;
}

Recipe read_recipe(const std::string& path, const std::vector<Override>& overrides) {
  return parse_recipe(TomlDocument::from_file(path), overrides);
}

RecipeFile read_recipe_file(const std::string& path, const std::vector<Override>& overrides,
                            const std::function<std::string(const std::string& name)>& find) {
  const TomlDocument document = TomlDocument::from_file(path);
  const TomlTable root = document.root();
  if (!root.has("recipes")) {
    const Recipe recipe = parse_recipe(document, overrides);
    return {recipe.name, recipe.title, recipe.text, {recipe}};
  }
  RecipeFile file{{}, {}, document.text(), {}};
  std::vector<std::string> names;
  read_whole(root, set_keys(file, names));
  if (file.title.empty()) file.title = file.name;
  if (names.empty()) root.fail("recipes", "no recipe is named", "name one or more, for instance [\"loops\", \"hold\"]");
  for (const std::string& entry : names) {
    std::istringstream words(entry);
    std::string name, setting;
    words >> name;
    TomlDocument named = TomlDocument::from_file(find(name));
    if (named.root().has("recipes"))
      root.fail("recipes", fmt::format("'{}' names recipes itself", name), "name those instead");
    bool any = false;
    while (words >> setting) {
      const std::size_t equals = setting.find('=');
      const std::string parameter = setting.substr(0, equals);
      if (equals == std::string::npos || !named.root().table("parameters").has(parameter))
        root.fail("recipes", fmt::format("'{}' sets no parameter of '{}'", setting, name), "write PARAMETER=VALUE");
      named.set({fmt::format("parameters.{}.default", parameter), setting.substr(equals + 1)});
      any = true;
    }
    // The text that is stored has them.
    if (any) named = TomlDocument::from_text(named.to_text(), named.name());
    file.recipes.push_back(parse_recipe(std::move(named), overrides));
  }
  return file;
}

namespace {

constexpr std::size_t kMostPositions = 10'000;
constexpr double kSlowest = 0.001;  // mm/s: the least speed of the slowest axis

// from, from + step, ... up to `to`.
std::vector<double> grid_axis(const TomlTable& grid, const std::string& key) {
  const std::vector<double> range = grid.numbers(key);
  if (range.size() != 3 || range[2] <= 0.0 || range[1] < range[0]) {
    grid.fail(key, fmt::format("'{}' must be [from, to, step] with a step above 0", key),
              fmt::format("e.g. {} = [10, 20, 2.54]", key));
  }
  const double count = std::floor((range[1] - range[0]) / range[2] + 1e-9) + 1.0;
  if (count > static_cast<double>(kMostPositions)) {
    grid.fail(key, fmt::format("'{}' has {:.12g} positions", key, count),
              fmt::format("a larger step: a recipe may have {}", kMostPositions));
  }
  std::vector<double> values;
  for (int i = 0; i < static_cast<int>(count); ++i) values.push_back(range[0] + i * range[2]);
  return values;
}

struct GridAxes {
  std::vector<double> x, y;  // positions
};

KeyTable grid_keys(GridAxes& axes) {
  const auto axis = [](const char* name, std::vector<double>& positions, const char* meaning) {
    return key::made({name, "list of numbers", "mm", "[from, to, step], step above 0", "required", meaning},
                     [name, &positions](const TomlTable& grid) { positions = grid_axis(grid, name); });
  };
  return {axis("x", axes.x, "Places along x"), axis("y", axes.y, "Places along y")};
}

// Row by row, every other row backward, so that the stage never travels a whole row without pressing.
void read_grid(const TomlTable& press, PressPlan& plan) {
  const TomlTable grid = press.table("grid");
  GridAxes axes;
  read_whole(grid, grid_keys(axes));
  const auto& [xs, ys] = axes;
  if (xs.size() * ys.size() > kMostPositions) {
    press.fail("grid", fmt::format("{} x {} positions", xs.size(), ys.size()),
               fmt::format("a recipe may have {}", kMostPositions));
  }
  for (std::size_t row = 0; row < ys.size(); ++row) {
    for (std::size_t i = 0; i < xs.size(); ++i) {
      plan.positions_mm.emplace_back(xs[row % 2 == 0 ? i : xs.size() - 1 - i], ys[row]);
    }
  }
}

void check_forces(const TomlTable& table, const PressPlan& plan) {
  for (std::size_t i = 0; i < plan.forces_n.size(); ++i) {
    const double last = i == 0 ? plan.contact_n : plan.forces_n[i - 1];
    if (plan.forces_n[i] > last) continue;
    table.fail("forces_n", fmt::format("force {} is {:g} N, not above {:g} N", i + 1, plan.forces_n[i], last),
               "forces rise, from above contact_n; the way down is added");
  }
  if (plan.forces_n.empty()) table.fail("forces_n", "'forces_n' is empty", "e.g. [2, 6, 10, 20, 30]");
}

KeyTable force_keys(PressPlan& plan) {
  return {key::required(key::text("object", plan.object,
                                  "Name of the object; stored, and on the simulated rig ring, point or flat")),
          key::number("contact_n", plan.contact_n, {"N"}, {0.01, 10.0},
                      "Force at which the object counts as touching while it approaches"),
          key::numbers("forces_n", plan.forces_n, {"N"},
                       "Forces at which frames are taken, rising, from above contact_n; the way down is added")};
}

KeyTable position_keys(PressPlan& plan) {
  return {key::optional(key::made({"positions_mm", "lists of 2 numbers", "mm", "", "",
                                   "Places [x, y] of the stage, one after another; or [press.grid]"},
                                  [&plan](const TomlTable& press) {
                                    for (const std::vector<double>& at : press.number_lists("positions_mm", 2))
                                      plan.positions_mm.emplace_back(at[0], at[1]);
                                  }))};
}

KeyTable motion_keys(PressPlan& plan) {
  return {key::word("hold", plan.hold_force, {"position", "force"}, "force",
                    "What stands still during the dwell: the position of z, or the force"),
          key::number("approach_mm_per_s", plan.approach_mm_per_s, {"mm/s"}, {kSlowest, 10.0},
                      "Speed of z until it touches"),
          key::number("servo_mm_per_s", plan.servo_mm_per_s, {"mm/s"}, {kSlowest, 10.0},
                      "Speed of z while a force is sought"),
          key::number("clear_mm", plan.clear_mm, {"mm"}, {0.01, 50.0}, "How far z goes back between two places"),
          key::flag("tare", plan.tare, "Whether the force sensor is set to zero before each repeat and after the last"),
          key::flag("registers", plan.registers, "Whether the touches are used to find the taxels under the stage")};
}

KeyTable peak_force_keys(Conditioning& conditioning, const Range& range) {
  return {key::described(key::number("peak_n", conditioning.peak_n, {"N"}, range,
                                     "For kind = \"press\": highest force of such a cycle, from contact_n on"),
                         "the highest of forces_n")};
}

}  // namespace

void add_press_keys(std::vector<KeyFacts>& all) {
  Recipe recipe;
  GridAxes axes;
  for (const KeyTable& keys : {force_keys(recipe.press), position_keys(recipe.press), motion_keys(recipe.press)})
    add_facts(all, "press", keys);
  add_facts(all, "press.grid", grid_keys(axes));
  add_facts(all, "conditioning", peak_force_keys(recipe.conditioning, {0.01, 1000.0}));
}

void read_press(const TomlTable& root, Recipe& recipe) {
  if (!root.has("press")) root.fail("press", "kind = \"press\" without a [press]", "add [press] with forces_n");
  PressPlan& plan = recipe.press;
  read_keys(root, {dwell_key(recipe.dwell_s)});
  for (const double value : recipe.dwell_s) {
    if (value < 0.0 || value > 86400.0) {
      root.fail("dwell_s", fmt::format("'dwell_s' is {:g}, outside 0 to 86400", value), "use 0 to 86400");
    }
  }
  const TomlTable press = root.table("press");
  read_keys(press, force_keys(plan));
  check_forces(press, plan);
  if (press.has("grid") == press.has("positions_mm")) {
    press.fail("positions_mm", "a press recipe needs either positions_mm or [press.grid]",
               "e.g. positions_mm = [[20, 20]]");
  }
  if (press.has("grid")) read_grid(press, plan);
  read_keys(press, position_keys(plan));
  read_whole(press, motion_keys(plan));
  const TomlTable conditioning = root.table("conditioning");
  read_keys(conditioning, {cycles_key(recipe.conditioning)});
  recipe.conditioning.least = recipe.conditioning.cycles;
  recipe.conditioning.peak_n = plan.forces_n.back();
  read_whole(conditioning, peak_force_keys(recipe.conditioning, {plan.contact_n, 1000.0}));
}

}  // namespace tactbench::sequences
