// What completion, manual-page and reference-keys print: of a program with one verb beside them.
#include <CLI/CLI.hpp>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/cli/words/command_tree.h"
#include "bench/cli/words/key_manual.h"
#include "bench/cli/words/key_reference.h"
#include "bench/common/build_info.h"
#include "tests/bench/cli/verb_here.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

void add_written_words(CLI::App& app, bench::Session& session) {
  bench::add_completion(app);
  bench::add_sensors(app, session);
}

Finished written_words(const std::vector<std::string>& words) { return verb_here(add_written_words, words); }

// The same program as data.
bench::CommandNode tree_of_written_words() {
  bench::Session session;
  CLI::App app("of a test", "tactbench");
  app.require_subcommand(1);
  add_written_words(app, session);
  return bench::command_tree(app);
}

}  // namespace

TEST_CASE("completion prints the script of the shell that is named, and knows three") {
  const bench::CommandNode tree = tree_of_written_words();
  CHECK(written_words({"completion", "bash"}).out == bench::bash_completion(tree));
  CHECK(written_words({"completion", "zsh"}).out == bench::zsh_completion(tree));
  CHECK(written_words({"completion", "fish"}).out == bench::fish_completion(tree));
  CHECK_THAT(written_words({"completion", "bash"}).out, Catch::Contains("\" sensors\"") && Catch::Contains("zsh"));
  CHECK(written_words({"completion", "csh"}).code == 2);
  CHECK_THAT(written_words({"completion"}).err, Catch::Contains("shell is required"));
}

TEST_CASE("manual-page prints the program's page, a page of section 5, or their names") {
  const bench::BuildInfo& build = bench::build_info();
  const std::string page = bench::manual_page(tree_of_written_words(), build.version, build.date);
  CHECK(written_words({"manual-page"}).out == page);
  CHECK(written_words({"manual-page", "tactbench"}).out == page);
  const std::string lab = written_words({"manual-page", "tactbench-lab"}).out;
  CHECK(lab == bench::key_manual("tactbench-lab", build.version, build.date));
  CHECK_THAT(lab, Catch::Contains("\"" + build.date + "\" \"tactbench "));
  std::string names;
  for (const std::string& name : bench::key_manual_names()) names += name + "\n";
  CHECK(written_words({"manual-page", "all"}).out == names);
  const Finished none = written_words({"manual-page", "none"});
  CHECK(none.code == 2);
  CHECK(none.err ==
        "error: there is no page 'none' [TB-USAGE]\n  at: manual-page\n  try: one of: tactbench-bench, "
        "tactbench-recipe, tactbench-sensor, tactbench-limits, tactbench-lab, tactbench.toml, tactbench-nightly, "
        "tactbench-module\n");
  CHECK(written_words({"reference-keys"}).out == bench::key_reference());
}
