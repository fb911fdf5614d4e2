// Pages that the program writes of itself: the reference of keys as it stands in docs, roff of single letters and
// sentences, and the frames of the scripts that complete words.
#include <CLI/CLI.hpp>
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/cli/words/command_tree.h"
#include "bench/cli/words/key_manual.h"
#include "bench/cli/words/key_reference.h"
#include "bench/cli/words/roff.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::bench;

TEST_CASE("the reference of keys is the page in docs") {
  CHECK(key_reference() == tests::read_file(tests::source_path("docs/reference-keys.md")));
}

TEST_CASE("roff: letters that it would take for commands, and those beyond ASCII by their numbers") {
  CHECK(roff("a.b'c\\d-e`f^g~h") == "a.b\\(aqc\\ed\\-e\\(gaf\\(hag\\(tih");
  CHECK(roff(".a\n.b\n'c\n d.") == "\\&.a\n\\&.b\n\\&\\(aqc\n d.");
  CHECK(roff("\n\n.") == "\n\n\\&.");
  CHECK(roff("\xC3\xA4.") == "\\[u00E4].");
  CHECK(roff("\n\xC2\xB0.") == "\n\\[u00B0].");
  CHECK(roff("\xF0\x9F\x98\x80") == "\\[u1F600]");
  CHECK(roff("").empty());
}

TEST_CASE("roff: each sentence on a line of its own, and no blanks at its ends") {
  CHECK(roff_paragraph("One. Two.  Three") == "One.\nTwo.\nThree");
  CHECK(roff_paragraph("a\nb.\nc") == "a b.\nc");
  CHECK(roff_paragraph("and so on ... more") == "and so on ... more");
  CHECK(roff_paragraph("a 1.5 b.c") == "a 1.5 b.c");
  CHECK(roff_paragraph("end. \n ") == "end.");
  CHECK(roff_paragraph("end  \n") == "end");
  CHECK(roff_paragraph("a. \n\n .b") == "a.\n\\&.b");
  CHECK(roff_paragraph("").empty());
  CHECK(roff_paragraph(". a") == "\\&.\na");
}

TEST_CASE("manual pages of section 5 name each other, and none names itself") {
  const std::vector<std::string> names = key_manual_names();
  REQUIRE(names.size() == 8);
  for (const std::string& name : names) {
    INFO(name);
    const std::string page = key_manual(name, "0.1", "2026-01-31"), also = page.substr(page.find(".SH SEE ALSO"));
    for (const std::string& other : names)
      CHECK((also.find("\\fB" + roff(other) + "\\fR(5)") != std::string::npos) == (other != name));
    CHECK_THAT(also, Catch::StartsWith(".SH SEE ALSO\n\\fBtactbench\\fR(1), \\fB") && Catch::EndsWith("\\fR(5)\n"));
    CHECK(page.find("](") == std::string::npos);  // a link of Markdown
    CHECK(page.find('`') == std::string::npos);
    CHECK(page.find("Not described") == std::string::npos);
  }
  const std::string suite = key_manual("tactbench-nightly", "0.1", "2026-01-31");
  CHECK_THAT(suite, Catch::Contains("What \\fBtactbench nightly FILE\\fR carries out. How\\-to: a night in CI."));
  CHECK_THAT(suite, Catch::StartsWith(".TH TACTBENCH\\-NIGHTLY 5 \"2026-01-31\" \"tactbench 0.1\" \"File Formats\"\n"));
  const std::string recipe = key_manual("tactbench-recipe", "0.1", "2026-01-31");
  CHECK_THAT(recipe, Catch::Contains(".TP\n\\fBstep\\fR (number, in the file\\(aqs unit") &&
                         Catch::Contains("one of ") && Catch::Contains("default "));
}

TEST_CASE("completion scripts begin and end as their shells need it") {
  const CommandNode leaf{"export", "runs export", "write", "", {}, {}}, runs{"runs", "runs", "stored", "", {}, {leaf}};
  const CommandNode root{"", "", "all", "", {}, {runs}};
  CHECK(zsh_completion(root) ==
        "#compdef tactbench\n# Completion of tactbench for zsh, generated: tactbench completion zsh\n"
        "_tactbench() {\n  local curcontext=\"$curcontext\" state line\n  local -a verbs\n  verbs=( \\\n"
        "      'runs:stored')\n  _arguments -C \\\n    '1:verb:->verb' '*::argument:->rest'\n  case $state in\n"
        "    verb) _describe verb verbs ;;\n    rest)\n      case $line[1] in\n        runs) _tactbench_runs ;;\n"
        "      esac ;;\n  esac\n}\n"
        "_tactbench_runs() {\n  local curcontext=\"$curcontext\" state line\n  local -a verbs\n  verbs=( \\\n"
        "      'export:write')\n  _arguments -C \\\n    '1:verb:->verb' '*::argument:->rest'\n  case $state in\n"
        "    verb) _describe verb verbs ;;\n    rest)\n      case $line[1] in\n        export) _tactbench_runs_export "
        ";;\n"
        "      esac ;;\n  esac\n}\n"
        "_tactbench_runs_export() {\n  _arguments\n}\n"
        "if [ \"$funcstack[1]\" = _tactbench ]; then  # autoloaded from $fpath\n  _tactbench \"$@\"\nelse\n"
        "  compdef _tactbench tactbench\nfi\n");
  CHECK(
      fish_completion(root) ==
      "# Completion of tactbench for fish, generated: tactbench completion fish\n"
      "function __tactbench_at\n  set -l verb \"\"\n  for word in (commandline -opc)[2..]\n    switch \"$verb $word\"\n"
      "      case ' runs' ' runs export'\n        set verb \"$verb $word\"\n    end\n  end\n"
      "  test \"$verb\" = \"$argv[1]\"\nend\ncomplete -c tactbench -f\n"
      "complete -c tactbench -n '__tactbench_at \"\"' -a runs -d 'stored'\n"
      "complete -c tactbench -n '__tactbench_at \" runs\"' -a export -d 'write'\n");
}

TEST_CASE("the manual page: names of values in capitals, and the pages of section 5 at its end") {
  CommandNode verb{"run", "run", "carry out", "", {}, {}};
  verb.arguments = {{{"--x2-yz"}, "a size", "", ArgumentKind::kNumber, {}, false, true, false}};
  const std::string page = manual_page({"", "", "all", "", {}, {verb}}, "0.1", "2026-01-31");
  CHECK_THAT(page, Catch::Contains(".TP\n\\fB\\-\\-x2\\-yz\\fR \\fIX2\\-YZ\\fR\na size\n"));
  std::string also = "\n.SH SEE ALSO\n";
  for (const std::string& name : key_manual_names())
    also += (also.ends_with("\n") ? "" : ", ") + ("\\fB" + roff(name) + "\\fR(5)");
  CHECK_THAT(page, Catch::EndsWith(also + "\n"));
  CHECK(page.find("Common options") == std::string::npos);
}

TEST_CASE("the manual page: options of five verbs stand once, those of four with each") {
  const CommandArgument option{{"--json"}, "as JSON", "", ArgumentKind::kFlag, {}, false, false, false};
  for (const int count : {4, 5}) {
    CommandNode root{"", "", "all", "same end", {}, {}};
    for (int i = 0; i < count; ++i) {
      const std::string name = "verb" + std::to_string(i);
      root.verbs.push_back({name, name, "do", i == 0 ? "same end" : "its end", {option}, {}});
    }
    const std::string page = manual_page(root, "0.1", "2026-01-31"), entry = ".TP\n\\fB\\-\\-json\\fR\nas JSON\n";
    std::size_t entries = 0, named = 0, ends = 0;
    for (std::size_t at = 0; (at = page.find(entry, at)) != std::string::npos; ++at) ++entries;
    for (std::size_t at = 0; (at = page.find(".PP\nCommon options: \\fB\\-\\-json\\fR.\n", at)) != std::string::npos;
         ++at)
      ++named;
    for (std::size_t at = 0; (at = page.find("its end", at)) != std::string::npos; ++at) ++ends;
    CHECK(entries == (count == 5 ? 1U : 4U));
    CHECK(named == (count == 5 ? 5U : 0U));
    CHECK(ends == static_cast<std::size_t>(count) - 1);
    CHECK(page.find("same end") == std::string::npos);  // the footer of all
  }
}

TEST_CASE("an option's words are those between braces in its type, and none without both") {
  const auto choices = [](const char* type) {
    CLI::App app("all", "tactbench");
    std::string value;
    app.add_option("--kind", value, "kind")->type_name(type);
    return command_tree(app).arguments.back().choices;
  };
  using Words = std::vector<std::string>;
  CHECK(choices("TEXT:{a,b}") == Words{"a", "b"});
  for (const char* type : {"TEXT", "TEXT:{a", "TEXT:a}", "TEXT:}a{"}) CHECK(choices(type) == Words{});
}
