#include "bench/cli/words/command_tree.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>

#include "bench/config/config.h"

namespace tactbench::bench {

namespace {

// CLI11 keeps a set of words only as part of an option's type: "TEXT:{csv,json}".
std::vector<std::string> words_of_type(const std::string& type) {
  const std::size_t open = type.find('{'), close = type.find('}');
  if (open == std::string::npos || close == std::string::npos || close < open) return {};
  return CLI::detail::split(type.substr(open + 1, close - open - 1), ',');
}

std::vector<std::string> names_of_shipped_recipes() {
  std::vector<std::string> names = shipped_files("sequences");
  for (std::string& name : names) name.erase(name.rfind('.'));
  return names;
}

CommandArgument argument_of(const CLI::Option& option) {
  CommandArgument argument;
  argument.positional = option.get_positional() && option.nonpositional() == false;
  if (argument.positional) {
    argument.names = {option.get_name(true)};
  } else {
    for (const std::string& name : option.get_snames()) argument.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) argument.names.push_back("--" + name);
  }
  argument.about = option.get_description();
  argument.default_value = option.get_default_str();
  argument.required = option.get_required();
  argument.repeated = option.get_items_expected_max() > 1;
  if (option.get_items_expected_max() == 0) return argument;
  const std::string type = option.get_type_name();
  argument.choices = words_of_type(type);
  const bool number = type.starts_with("INT") || type.starts_with("UINT") || type.starts_with("FLOAT");
  argument.kind = !argument.choices.empty() ? ArgumentKind::kChoice
                  : number                  ? ArgumentKind::kNumber
                                            : ArgumentKind::kText;
  if (argument.kind != ArgumentKind::kText) return argument;
  const std::string& name = argument.names.back();
  constexpr std::array kOfRecipes{"recipe", "suite", "--recipe", "--held-out-recipe", "--from"};
  if (std::ranges::find(kOfRecipes, name) != kOfRecipes.end()) argument.choices = names_of_shipped_recipes();
  if (name == "--bench" || name == "--limits") argument.choices = shipped_files("bench/config");
  return argument;
}

CommandNode node_of(const CLI::App& app, const std::string& path) {
  CommandNode node{
      path.empty() ? std::string() : app.get_name(), path, app.get_description(), app.get_footer(), {}, {}};
  for (const CLI::Option* option : app.get_options()) {
    if (!option->get_group().empty()) node.arguments.push_back(argument_of(*option));
  }
  for (const CLI::App* verb : app.get_subcommands([](const CLI::App* v) { return !v->get_group().empty(); })) {
    const std::string below = path.empty() ? verb->get_name() : path + " " + verb->get_name();
    node.verbs.push_back(node_of(*verb, below));
  }
  return node;
}

}  // namespace

CommandNode command_tree(const CLI::App& app) { return node_of(app, {}); }

std::vector<const CommandNode*> all_nodes(const CommandNode& root) {
  std::vector<const CommandNode*> nodes{&root};
  for (const CommandNode& verb : root.verbs) {
    for (const CommandNode* below : all_nodes(verb)) nodes.push_back(below);
  }
  return nodes;
}

}  // namespace tactbench::bench
