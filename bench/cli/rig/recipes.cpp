#include "bench/cli/rig/recipes.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "analysis/counted.h"
#include "analysis/json_io.h"
#include "bench/cli/session.h"
#include "bench/common/output_file.h"
#include "bench/config/config.h"
#include "bench/run/recipe_check.h"

namespace tactbench::bench {

using nlohmann::ordered_json;
using sequences::Recipe;
using sequences::RecipeFile;

std::vector<ShippedRecipe> shipped_recipes() {
  std::vector<ShippedRecipe> shipped;
  for (const std::string& file : shipped_files("sequences")) {
    const std::string path = fmt::format("{}/sequences/{}", share_folder(), file);
    try {
      shipped.push_back({read_recipe_file(path), path});
    } catch (const sequences::FileError&) {
      continue;  // the folder also holds a suite
    }
  }
  return shipped;
}

// The recipes that can be planned, for a call without names.
void list_plannable(const Session& session) {
  ordered_json list = ordered_json::array();
  for (const auto& [file, path] : shipped_recipes()) {
    list.push_back({{"name", file.name}, {"title", file.title}});
    if (!session.json) tty::print("{:<18}{}\n", one_line(file.name), one_line(file.title));
  }
  if (session.json) return print_json("plan.recipes", {{"recipes", list}});
  tty::print("tactbench plan NAME... shows more; own recipes are given as files\n");
}

namespace {

struct RecipesOptions {
  std::vector<std::string> recipes;
  std::string bench = "simulated.toml", from = "production", output;
};

struct RecipeExtent {
  std::size_t steps = 0, frames = 0;
  std::string highest;  // "60.0 psi", "30.0 N"
};

RecipeExtent extent_of(const std::vector<Recipe>& recipes, analysis::PressureUnit unit) {
  const std::vector<sequences::Step> steps = sequences::compile(recipes);
  RecipeExtent extent{steps.size(), 0, {}};
  for (const sequences::Step& step : steps) extent.frames += takes_frame(step) ? 1 : 0;
  const sequences::Extremes reached = sequences::extremes(steps);
  extent.highest =
      reached.pressurizes ? unit.text(reached.highest.value(), 1) : fmt::format("{:.1f} N", reached.largest_force_n);
  return extent;
}

// "31 turning points drawn, ..."; empty where none of them are drawn.
std::string drawn_of(const RecipeFile& file) {
  std::string drawn;
  for (const Recipe& recipe : file.recipes)
    if (!recipe.drawn.empty()) drawn += (drawn.empty() ? "" : "; ") + recipe.drawn;
  return drawn;
}

ordered_json recipe_json(const RecipeFile& file, const std::string& path) {
  const RecipeExtent extent = extent_of(file.recipes, analysis::PressureUnit::kPsi);
  auto names = ordered_json::array();
  for (const Recipe& recipe : file.recipes) names.push_back(recipe.name);
  return {{"name", file.name},
          {"title", file.title},
          {"file", path},
          {"steps", extent.steps},
          {"frames", extent.frames},
          {"highest", extent.highest},
          {"repeats", file.recipes.front().repeats},
          {"drawn", drawn_of(file)},
          {"recipes", names}};
}

void list(const Session& session) {
  auto json = ordered_json::array();
  if (!session.json) tty::print("{:<18}{:>8}{:>12}  {}\n", "recipe", "frames", "highest", "what it is");
  for (const ShippedRecipe& shipped : shipped_recipes()) {
    if (session.json) {
      json.push_back(recipe_json(shipped.file, shipped.path));
      continue;
    }
    const RecipeExtent extent = extent_of(shipped.file.recipes, session.unit());
    tty::print("{}{:>8}{:>12}  {}\n", cell(shipped.file.name, 18), extent.frames, extent.highest,
               one_line(shipped.file.title));
  }
  if (session.json) return print_json("recipes.list", {{"recipes", json}});
  tty::print("tactbench recipes show NAME prints the file; recipes new MINE --from NAME makes one of your own\n");
}

void show(const RecipesOptions& options, const Session& session) {
  const std::string path = find_recipe(options.recipes.front());
  const RecipeFile file = read_recipe_file(path);
  if (session.json) {
    ordered_json json = recipe_json(file, path);
    json["text"] = file.text;
    return print_json("recipes.show", json);
  }
  tty::print("# {}\n{}", path, file.text);
}

// Each file by itself: a wrong one does not hide the next.
void check(const RecipesOptions& options, Session& session) {
  const BenchConfig bench = read_bench(find_config(options.bench), {});
  auto json = ordered_json::array();
  for (const std::string& name : options.recipes) {
    try {
      const std::string path = find_recipe(name);
      const RecipeFile file = read_recipe_file(path);
      check_recipes(file.recipes, bench);
      for (const std::string& line : recipe_warnings(file.recipes, bench, session.unit()))
        tty::print(stderr, "warning: {}\n", line);
      if (session.json) {
        ordered_json good = recipe_json(file, path);
        good["good"] = true;
        json.push_back(good);
      } else {
        const RecipeExtent extent = extent_of(file.recipes, session.unit());
        const std::string drawn = drawn_of(file);
        tty::print("{}: recipe '{}' is good on bench '{}': {}, {}, up to {}{}\n", path, one_line(file.name),
                   one_line(bench.id), analysis::counted(extent.steps, "step"),
                   analysis::counted(extent.frames, "frame"), extent.highest, drawn.empty() ? "" : "; " + drawn);
      }
    } catch (...) {
      const Error error = as_error(std::current_exception(), name);
      session.code = error.code();
      if (session.json)
        json.push_back({{"file", name}, {"good", false}, {"error", analysis::parse_ordered_json(error_json(error))}});
      else
        tty::print(stderr, "{}", error_text(error, false));
    }
  }
  if (session.json) print_json("recipes.check", {{"bench", bench.id}, {"recipes", json}});
}

// The file of `from` under another name: all comments stay.
std::string renamed(const std::string& text, const std::string& from, const std::string& name) {
  const std::string line = fmt::format("\nname = \"{}\"", from);
  const std::size_t at = text.find(line);
  if (at == std::string::npos)
    throw Error("TB-USAGE", fmt::format("the name of '{}' is not found in its file", from), "--from",
                "start from a shipped recipe");
  return text.substr(0, at) + fmt::format("\nname = \"{}\"", name) + text.substr(at + line.size());
}

void make(const RecipesOptions& options, const Session& session) {
  const std::string& name = options.recipes.front();
  constexpr const char* kAllowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
  if (name.empty() || name.find_first_not_of(kAllowed) != std::string::npos)
    throw Error("TB-USAGE", fmt::format("'{}' is no name of a recipe", name), "recipes new",
                "use letters, digits, - and _");
  const RecipeFile from = read_recipe_file(options.from);
  const std::string text = renamed(from.text, from.name, name);
  const std::string path = options.output.empty() ? name + ".toml" : options.output;
  // A copy begins as its original does, so the kind of the file would not protect it.
  if (std::filesystem::exists(path) && !session.replace)
    throw Error("TB-FILE-EXISTS", fmt::format("'{}' exists already", path), path,
                "give another name or -o FILE, or --replace to overwrite it");
  write_output(path, text, session.replace);
  if (session.json) return print_json("recipes.new", {{"name", name}, {"from", from.name}, {"path", path}});
  tty::print("{}: '{}', begun as a copy of '{}'\n\nNext:  edit it, then\n       tactbench recipes check {}\n", path,
             name, one_line(from.name), path);
}

}  // namespace

void add_recipes(CLI::App& app, Session& session) {
  CLI::App* group = app.add_subcommand("recipes", "list, show or check recipes, or begin one of your own");
  group->require_subcommand(1);
  auto options = std::make_shared<RecipesOptions>();
  const auto add_json = [&session](CLI::App* verb) {
    verb->add_flag("--json", session.json, "one JSON document on standard output");
  };
  CLI::App* list_verb = group->add_subcommand("list", "the shipped recipes, one line each");
  add_units(*list_verb, session);
  add_json(list_verb);
  list_verb->callback([&session] { list(session); });
  CLI::App* show_verb = group->add_subcommand("show", "print a recipe's file, with its comments");
  show_verb->add_option("recipe", options->recipes, "file, or name of a shipped one")->required()->expected(1);
  add_json(show_verb);
  show_verb->callback([options, &session] { show(*options, session); });
  CLI::App* check_verb =
      group->add_subcommand("check", "read and compile recipes and compare them with a bench's limits and devices");
  check_verb->add_option("recipe", options->recipes, "files, or names of shipped ones")->required();
  session.profile
      .add(*check_verb, "--bench", ProfileKey::kBench, options->bench, "bench file, for its limits and devices")
      ->capture_default_str();
  add_units(*check_verb, session);
  add_json(check_verb);
  check_verb->callback([options, &session] { check(*options, session); });
  CLI::App* new_verb = group->add_subcommand("new", "write a recipe of your own, begun as a copy of a shipped one");
  new_verb->add_option("name", options->recipes, "its name: letters, digits, - and _")->required()->expected(1);
  new_verb->add_option("--from", options->from, "recipe to copy")->capture_default_str();
  new_verb->add_option("-o,--output", options->output, "file to write (default: NAME.toml)");
  add_replace(*new_verb, session);
  add_json(new_verb);
  new_verb->callback([options, &session] { make(*options, session); });
}

}  // namespace tactbench::bench
