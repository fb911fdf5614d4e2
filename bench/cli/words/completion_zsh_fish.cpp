#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "bench/cli/words/command_tree.h"

namespace tactbench::bench {

namespace {

// Each character of `special` with a backslash before it; a single quote as `quote`.
std::string shell_escaped(const std::string& text, const std::string& special, const std::string& quote) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\'') {
      escaped += quote;
      continue;
    }
    if (special.find(c) != std::string::npos) escaped += '\\';
    escaped += c == '\n' ? ' ' : c;
  }
  return escaped;
}

std::string zsh_about(const std::string& text) { return shell_escaped(text, "[]:\\", "'\\''"); }
std::string fish_about(const std::string& text) { return shell_escaped(text, "\\", "\\'"); }

std::string zsh_function(const CommandNode& node) {
  std::string name = fmt::format("_tactbench{}{}", node.path.empty() ? "" : "_", node.path);
  std::ranges::replace(name, ' ', '_');
  std::ranges::replace(name, '-', '_');
  return name;
}

std::string zsh_values(const CommandArgument& argument) {
  const std::string message = zsh_about(argument.names.back());
  const std::string words = fmt::format("{}", fmt::join(argument.choices, " "));
  switch (argument.kind) {
    case ArgumentKind::kFlag:
      return {};
    case ArgumentKind::kNumber:
      return fmt::format(":{}:", message);
    case ArgumentKind::kChoice:
      return fmt::format(":{}:({})", message, words);
    case ArgumentKind::kText:
      break;
  }
  return words.empty() ? fmt::format(":{}:_files", message)
                       : fmt::format(":{}:_alternative \"words\\::({})\" \"files\\::_files\"", message, words);
}

std::string zsh_argument(const CommandArgument& argument) {
  if (argument.positional) return fmt::format(" '{}{}'", argument.repeated ? "*" : "", zsh_values(argument));
  const std::string star = argument.repeated ? "*" : "";
  std::string text;
  for (const std::string& name : argument.names)
    text += fmt::format(" '{}{}[{}]{}'", star, name, zsh_about(argument.about), zsh_values(argument));
  return text;
}

std::string zsh_node(const CommandNode& node) {
  std::string text = fmt::format("{}() {{\n", zsh_function(node)), arguments;
  for (const CommandArgument& argument : node.arguments)
    arguments += fmt::format(" \\\n    {}", zsh_argument(argument).substr(1));
  if (node.verbs.empty()) return fmt::format("{}  _arguments{}\n}}\n", text, arguments);
  std::string verbs, cases;
  for (const CommandNode& verb : node.verbs) {
    verbs += fmt::format(" \\\n      '{}:{}'", verb.name, zsh_about(verb.about));
    cases += fmt::format("        {}) {} ;;\n", verb.name, zsh_function(verb));
  }
  return fmt::format(
      "{}  local curcontext=\"$curcontext\" state line\n  local -a verbs\n  verbs=({})\n  _arguments -C{} \\\n"
      "    '1:verb:->verb' '*::argument:->rest'\n  case $state in\n    verb) _describe verb verbs ;;\n    rest)\n"
      "      case $line[1] in\n{}      esac ;;\n  esac\n}}\n",
      text, verbs, arguments, cases);
}

std::string fish_line(const CommandNode& node, const std::string& what, const std::string& about) {
  return fmt::format("complete -c tactbench -n '__tactbench_at \"{}\"' {} -d '{}'\n",
                     node.path.empty() ? "" : fmt::format(" {}", node.path), what, fish_about(about));
}

std::string fish_argument(const CommandNode& node, const CommandArgument& argument) {
  std::string what;
  if (!argument.positional) {
    for (const std::string& name : argument.names) {
      const bool is_long = name.starts_with("--");
      what += fmt::format("{} {} ", is_long ? "-l" : "-s", name.substr(is_long ? 2 : 1));
    }
  }
  const std::string words = fmt::format("{}", fmt::join(argument.choices, " "));
  if (argument.kind == ArgumentKind::kText) what += argument.positional ? "-F " : "-r -F ";
  if (!argument.positional && (argument.kind == ArgumentKind::kChoice || argument.kind == ArgumentKind::kNumber))
    what += "-x ";
  if (!words.empty()) what += fmt::format("-a '{}'", words);
  return what.empty() ? std::string() : fish_line(node, what, argument.about);
}

}  // namespace

std::string zsh_completion(const CommandNode& root) {
  std::string text = "#compdef tactbench\n# Completion of tactbench for zsh, generated: tactbench completion zsh\n";
  for (const CommandNode* node : all_nodes(root)) text += zsh_node(*node);
  return text +
         "if [ \"$funcstack[1]\" = _tactbench ]; then  # autoloaded from $fpath\n  _tactbench \"$@\"\nelse\n"
         "  compdef _tactbench tactbench\nfi\n";
}

std::string fish_completion(const CommandNode& root) {
  std::vector<std::string> keys;
  std::string lines;
  for (const CommandNode* node : all_nodes(root)) {
    if (!node->path.empty()) keys.push_back(fmt::format("' {}'", node->path));
    for (const CommandNode& verb : node->verbs) lines += fish_line(*node, fmt::format("-a {}", verb.name), verb.about);
    for (const CommandArgument& argument : node->arguments) lines += fish_argument(*node, argument);
  }
  return fmt::format(
      "# Completion of tactbench for fish, generated: tactbench completion fish\n"
      "function __tactbench_at\n  set -l verb \"\"\n  for word in (commandline -opc)[2..]\n    switch \"$verb $word\"\n"
      "      case {}\n        set verb \"$verb $word\"\n    end\n  end\n  test \"$verb\" = \"$argv[1]\"\nend\n"
      "complete -c tactbench -f\n{}",
      fmt::join(keys, " "), lines);
}

}  // namespace tactbench::bench
