// Prints descriptions of the command line: completion scripts, and the manual page for the build.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <map>
#include <memory>

#include "bench/cli/session.h"
#include "bench/cli/words/command_tree.h"
#include "bench/cli/words/key_manual.h"
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
  auto page = std::make_shared<std::string>("tactbench");
  CLI::App* manual =
      app.add_subcommand("manual-page", "tactbench(1), or a page of section 5, for the build")->group("");
  manual->add_option("page", *page, "which; all: the names of those of section 5");
  manual->callback([&app, page] {
    if (*page == "all") return tty::print("{}\n", fmt::join(key_manual_names(), "\n"));
    tty::print("{}", *page == "tactbench" ? manual_page(command_tree(app), build_info().version, build_info().date)
                                          : key_manual(*page, build_info().version, build_info().date));
  });
  CLI::App* keys = app.add_subcommand("reference-keys", "docs/reference-keys.md, for the documents")->group("");
  keys->callback([] { tty::print("{}", key_reference()); });
}

}  // namespace tactbench::bench
