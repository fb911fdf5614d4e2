// The command line as data, and what is written from it: completion of three shells and the manual page, of a small
// tree.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/cli/words/command_tree.h"

using namespace tactbench::bench;

namespace {

CommandNode small_tree() {
  CommandNode write{"export", "runs export", "write it's rows", "Exit codes: 0. .toml ~^` stay.\n", {}, {}};
  write.arguments = {
      {{"run"}, "number of the run", "", ArgumentKind::kNumber, {}, true, true, false},
      {{"recipe"}, "which", "", ArgumentKind::kText, {"a", "b"}, true, false, true},
      {{"--format"}, "csv's kind", "csv", ArgumentKind::kChoice, {"csv", "json"}, false, false, false},
      {{"-o", "--output"}, "file [C:\\x]", "", ArgumentKind::kText, {}, false, true, false},
      {{"--count"}, "how many", "", ArgumentKind::kNumber, {}, false, false, true},
      {{"--all"}, "all of\nthem", "", ArgumentKind::kFlag, {}, false, false, false},
  };
  const CommandArgument help{{"-h", "--help"}, "print this", "", ArgumentKind::kFlag, {}, false, false, false};
  const CommandNode runs{"runs", "runs", "what is stored", "", {help}, {write}};
  const CommandNode plan{"dry-run", "dry-run", "look ahead", "", {}, {}};
  return {"", "", "about all", "", {help}, {runs, plan}};
}

void check_holds(const std::string& text, const std::vector<std::string>& parts) {
  INFO(text);
  for (const std::string& part : parts) {
    INFO(part);
    CHECK(text.find(part) != std::string::npos);
  }
}

const CommandArgument& argument_of(const CommandNode& node, const std::string& name) {
  const auto found =
      std::ranges::find_if(node.arguments, [&](const CommandArgument& one) { return one.names.back() == name; });
  REQUIRE(found != node.arguments.end());
  return *found;
}

}  // namespace

TEST_CASE("command words: the nodes of a tree, parents first") {
  const CommandNode tree = small_tree();
  std::vector<std::string> paths;
  for (const CommandNode* node : all_nodes(tree)) paths.push_back(node->path);
  CHECK(paths == std::vector<std::string>{"", "runs", "runs export", "dry-run"});
}

TEST_CASE("command words: completion for bash") {
  check_holds(bash_completion(small_tree()),
              {"      \" runs\" | \\\n      \" runs export\" | \\\n      \" dry-run\") verb+=",
               "        \"\") words=\"runs dry-run\" options=\"-h --help\" files=\"\" ;;\n",
               "        \" runs\") words=\"export\" options=\"-h --help\" files=\"\" ;;\n",
               "        \" runs export\") words=\"a b\" options=\"--format -o --output --count --all\" files=1 ;;\n",
               "        \" dry-run\") words=\"\" options=\"\" files=\"\" ;;\n",
               "  case \"$verb:$previous\" in\n    \" runs export:--format\") words=\"csv json\" ;;\n"
               "    \" runs export:-o\" | \" runs export:--output\") words=\"\" files=1 ;;\n"
               "    \" runs export:--count\") words=\"\" ;;\n    *)\n"});
}

TEST_CASE("command words: completion for zsh") {
  check_holds(zsh_completion(small_tree()),
              {"_tactbench_runs_export() {\n  _arguments \\\n    ':run:' \\\n"
               "    '*:recipe:_alternative \"words\\::(a b)\" \"files\\::_files\"' \\\n"
               "    '--format[csv'\\''s kind]:--format:(csv json)' \\\n"
               "    '-o[file \\[C\\:\\\\x\\]]:--output:_files' '--output[file \\[C\\:\\\\x\\]]:--output:_files' \\\n"
               "    '*--count[how many]:--count:' \\\n    '--all[all of them]'\n}\n",
               "_tactbench() {\n  local curcontext",
               "  verbs=( \\\n      'runs:what is stored' \\\n      'dry-run:look ahead')\n"
               "  _arguments -C \\\n    '-h[print this]' '--help[print this]' \\\n    '1:verb:->verb'",
               "        runs) _tactbench_runs ;;\n        dry-run) _tactbench_dry_run ;;\n      esac",
               "_tactbench_dry_run() {\n  _arguments\n}\n"});
}

TEST_CASE("command words: completion for fish") {
  const std::string at = "complete -c tactbench -n '__tactbench_at \" runs export\"' ";
  const std::string text = fish_completion(small_tree());
  check_holds(text, {"      case ' runs' ' runs export' ' dry-run'\n",
                     "complete -c tactbench -n '__tactbench_at \"\"' -a runs -d 'what is stored'\n",
                     "complete -c tactbench -n '__tactbench_at \"\"' -s h -l help  -d 'print this'\n",
                     "complete -c tactbench -n '__tactbench_at \" runs\"' -a export -d 'write it\\'s rows'\n",
                     at + "-F -a 'a b' -d 'which'\n", at + "-l format -x -a 'csv json' -d 'csv\\'s kind'\n",
                     at + "-s o -l output -r -F  -d 'file [C:\\\\x]'\n", at + "-l count -x  -d 'how many'\n",
                     at + "-l all  -d 'all of them'\n"});
  CHECK(text.find("number of the run") == std::string::npos);  // nothing to complete
}

TEST_CASE("command words: the manual page") {
  const std::string page = manual_page(small_tree(), "0.1-x", "2026-01-31");
  check_holds(
      page, {".TH TACTBENCH 1 \"2026-01-31\" \"tactbench 0.1\\-x\" \"User Commands\"\n",
             ".SS runs\n\\fBtactbench runs\\fR \\fIVERB\\fR [\\fIoptions\\fR]\n.PP\nwhat is stored.\n.SS runs export\n",
             "\\fBtactbench runs export\\fR \\fIRUN\\fR [\\fIRECIPE\\fR...] \\fB\\-\\-output\\fR \\fIOUTPUT\\fR "
             "[\\fIoptions\\fR]\n.PP\nwrite it\\(aqs rows.\n",
             ".TP\n\\fIRUN\\fR\nnumber of the run\n.TP\n\\fIRECIPE\\fR\nwhich\n",
             ".TP\n\\fB\\-\\-format\\fR \\fIFORMAT\\fR\ncsv\\(aqs kind; one of csv, json (default: csv)\n",
             ".TP\n\\fB\\-o\\fR, \\fB\\-\\-output\\fR \\fIOUTPUT\\fR\nfile [C:\\ex]\n",
             ".TP\n\\fB\\-\\-count\\fR \\fICOUNT\\fR\nhow many\n.TP\n\\fB\\-\\-all\\fR\nall of them\n"
             ".PP\nExit codes: 0.\n\\&.toml \\(ti\\(ha\\(ga stay.\n.SS dry\\-run\n",
             ".SH EXIT STATUS\n.TP\n\\fB0\\fR\nDone; all requirements are met.\nA conditional pass counts as 0, with a "
             "warning.\n",
             ".SH FILES\n.TP\n\\fBbench.toml, sensor.toml, limits.toml\\fR\n"});
  CHECK(page.find("help\\fR\nprint this") == std::string::npos);
}

TEST_CASE("command words: CLI11's tables as data, what is hidden left out") {
  CLI::App app("about all");
  CLI::App* runs = app.add_subcommand("runs", "what is stored");
  CLI::App* write = runs->add_subcommand("export", "write rows");
  write->footer("ends");
  int number = 1;
  double rate = 0.5;
  bool all = false;
  std::string format = "csv", output, bench, both, secret;
  std::vector<std::string> recipes;
  write->add_option("run", number, "which")->required();
  write->add_option("recipe", recipes, "recipes");
  write->add_option("--format", format, "kind")->check(CLI::IsMember({"csv", "json"}))->capture_default_str();
  write->add_option("-o,--output", output, "file");
  write->add_option("--rate", rate, "Hz")->capture_default_str();
  write->add_option("--bench", bench, "file");
  write->add_option("both,--both", both, "by its place or by its name");
  write->add_option("--secret", secret, "hidden")->group("");
  write->add_flag("--all", all, "all of them");
  app.add_subcommand("hidden", "not shown")->group("");
  const CommandNode tree = command_tree(app);
  CHECK(tree.path.empty());
  REQUIRE(tree.verbs.size() == 1);
  CHECK(tree.verbs[0].path == "runs");
  REQUIRE(tree.verbs[0].verbs.size() == 1);
  const CommandNode& node = tree.verbs[0].verbs[0];
  CHECK(node.name == "export");
  CHECK(node.path == "runs export");
  CHECK(node.about == "write rows");
  CHECK(node.footer == "ends");
  CHECK(node.arguments.size() == 9);  // with --help
  CHECK_FALSE(argument_of(node, "--both").positional);
  const CommandArgument &run = argument_of(node, "run"), &recipe = argument_of(node, "recipe");
  CHECK((run.positional && run.required && !run.repeated));
  CHECK(run.kind == ArgumentKind::kNumber);
  CHECK((recipe.positional && !recipe.required && recipe.repeated));
  CHECK(recipe.kind == ArgumentKind::kText);
  CHECK(std::ranges::find(recipe.choices, "descending") != recipe.choices.end());
  const CommandArgument &kind = argument_of(node, "--format"), &file = argument_of(node, "--output");
  CHECK(kind.kind == ArgumentKind::kChoice);
  CHECK(kind.choices == std::vector<std::string>{"csv", "json"});
  CHECK(kind.default_value == "csv");
  CHECK(file.names == std::vector<std::string>{"-o", "--output"});
  CHECK((!file.positional && !file.required && !file.repeated));
  CHECK(file.kind == ArgumentKind::kText);
  CHECK(file.choices.empty());
  CHECK(argument_of(node, "--rate").kind == ArgumentKind::kNumber);
  CHECK(argument_of(node, "--rate").default_value == "0.5");
  CHECK(argument_of(node, "--all").kind == ArgumentKind::kFlag);
  const std::vector<std::string>& benches = argument_of(node, "--bench").choices;
  CHECK(std::ranges::find(benches, "simulated.toml") != benches.end());
}
