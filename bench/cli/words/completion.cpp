// Prints descriptions of the command line: completion scripts, and the manual page for the build.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>

#include "bench/cli/session.h"
#include "bench/cli/words/command_tree.h"
#include "bench/cli/words/key_reference.h"
#include "bench/common/build_info.h"

namespace tactbench::bench {

namespace {

using CompletionWriter = std::string (*)(const CommandNode&);
const std::map<std::string, CompletionWriter> completion_writers = {
    {"bash", bash_completion}, {"zsh", zsh_completion}, {"fish", fish_completion}};

}  // namespace

void add_completion(CLI::App& app) {
  auto shell = std::make_shared<std::string>();
  CLI::App* verb = app.add_subcommand("completion", "print a completion script for a shell");
  verb->add_option("shell", *shell, "whose words")->required()->check(CLI::IsMember(completion_writers));
  verb->footer(
      "bash: source <(tactbench completion bash). zsh: the same, after compinit. fish: tactbench completion "
      "fish | source.");
  verb->callback([shell, &app] { tty::print("{}", completion_writers.at(*shell)(command_tree(app))); });
  CLI::App* manual = app.add_subcommand("manual-page", "tactbench(1), for the build")->group("");
  manual->callback(
      [&app] { tty::print("{}", manual_page(command_tree(app), build_info().version, build_info().date)); });
  CLI::App* keys = app.add_subcommand("reference-keys", "docs/reference-keys.md, for the documents")->group("");
  keys->callback([] { tty::print("{}", key_reference()); });
}

}  // namespace tactbench::bench
