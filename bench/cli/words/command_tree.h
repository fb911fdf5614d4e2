// The command line as data: verbs, options, choices, from CLI11's own tables. Completion scripts and the manual page
// are generated from it, so that they always match the program.
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace tactbench::bench {

enum class ArgumentKind {
  kFlag,    // takes no value
  kNumber,  // nothing to complete
  kChoice,  // one of `choices`
  kText,    // free text: a file's name, beside `choices` (shipped recipes, say)
};

struct CommandArgument {
  std::vector<std::string> names;  // "-o", "--output"; of a positional argument its bare name
  std::string about, default_value;
  ArgumentKind kind = ArgumentKind::kFlag;
  std::vector<std::string> choices;
  bool positional = false, required = false, repeated = false;
};

struct CommandNode {
  std::string name;  // "export"
  std::string path;  // "runs export"; empty at the top
  std::string about, footer;
  std::vector<CommandArgument> arguments;  // in the order of --help
  std::vector<CommandNode> verbs;
};

// Without entries hidden from --help. Reads the names of the shipped recipes and configurations.
CommandNode command_tree(const CLI::App& app);

// The node and all below it, parents first.
std::vector<const CommandNode*> all_nodes(const CommandNode& root);

// Scripts for the shells, and tactbench(1) in man(7) format; `date` as 2026-01-31.
std::string bash_completion(const CommandNode& root);
std::string zsh_completion(const CommandNode& root);
std::string fish_completion(const CommandNode& root);
std::string manual_page(const CommandNode& root, const std::string& version, const std::string& date);

void add_completion(CLI::App& app);

}  // namespace tactbench::bench
