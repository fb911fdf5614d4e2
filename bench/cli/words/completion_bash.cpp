#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bench/cli/words/command_tree.h"

namespace tactbench::bench {

namespace {

constexpr const char* kBashHead = R"(# Completion of tactbench for bash, generated: tactbench completion bash
_tactbench() {
  local current="${COMP_WORDS[COMP_CWORD]}" previous="${COMP_WORDS[COMP_CWORD-1]}" verb="" words="" options="" files="" i
  for ((i = 1; i < COMP_CWORD; i++)); do
    case "$verb ${COMP_WORDS[i]}" in
)";
constexpr const char* kBashMiddle = R"( verb+=" ${COMP_WORDS[i]}" ;;
    esac
  done
  if [[ $current == = ]]; then
    current=""  # --option=, of which bash makes two words
  elif [[ $previous == = ]]; then
    previous="${COMP_WORDS[COMP_CWORD-2]}"
  fi
  case "$verb:$previous" in
)";
constexpr const char* kBashEnd = R"(      esac
      if [[ $current == -* ]]; then words=$options files=""; fi ;;
  esac
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current"; [[ -z $files ]] || compgen -f -- "$current")
  if [[ -n $files ]]; then compopt -o filenames 2>/dev/null; fi
  return 0
}
complete -F _tactbench tactbench
)";

std::string bash_key(const CommandNode& node) { return node.path.empty() ? "" : fmt::format(" {}", node.path); }

// What stands after a verb: its own verbs or positional arguments, and its options.
std::string bash_verb(const CommandNode& node) {
  std::vector<std::string> words, options;
  bool files = false;
  for (const CommandNode& verb : node.verbs) words.push_back(verb.name);
  for (const CommandArgument& argument : node.arguments) {
    auto& place = argument.positional ? words : options;
    const auto& more = argument.positional ? argument.choices : argument.names;
    place.insert(place.end(), more.begin(), more.end());
    files = files || (argument.positional && argument.kind == ArgumentKind::kText);
  }
  return fmt::format("        \"{}\") words=\"{}\" options=\"{}\" files={} ;;\n", bash_key(node), fmt::join(words, " "),
                     fmt::join(options, " "), files ? "1" : "\"\"");
}

// What stands after an option that takes a value.
std::string bash_values(const CommandNode& node) {
  std::string text;
  for (const CommandArgument& argument : node.arguments) {
    if (argument.positional || argument.kind == ArgumentKind::kFlag) continue;
    std::vector<std::string> keys;
    for (const std::string& name : argument.names) keys.push_back(fmt::format("\"{}:{}\"", bash_key(node), name));
    text += fmt::format("    {}) words=\"{}\"{} ;;\n", fmt::join(keys, " | "), fmt::join(argument.choices, " "),
                        argument.kind == ArgumentKind::kText ? " files=1" : "");
  }
  return text;
}

}  // namespace

std::string bash_completion(const CommandNode& root) {
  std::vector<std::string> keys;
  std::string values, verbs;
  for (const CommandNode* node : all_nodes(root)) {
    if (!node->path.empty()) keys.push_back(fmt::format("\"{}\"", bash_key(*node)));
    values += bash_values(*node);
    verbs += bash_verb(*node);
  }
  return fmt::format("{}      {}){}{}    *)\n      case \"$verb\" in\n{}{}", kBashHead,
                     fmt::join(keys, " | \\\n      "), kBashMiddle, values, verbs, kBashEnd);
}

}  // namespace tactbench::bench
