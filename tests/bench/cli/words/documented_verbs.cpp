// Each verb's --help is what docs/reference-verbs.md has of it: words, defaults, ranges, footers.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cctype>
#include <sstream>
#include <string>
#include <vector>

#include "bench/cli/rig/page_beside.h"
#include "bench/cli/session.h"
#include "bench/cli/words/command_tree.h"
#include "tests/support/paths.h"
#include "tests/support/process.h"

using namespace tactbench;

namespace {

// The program with all verbs, as the command line makes it.
struct AllVerbs {
  AllVerbs() {
    session.profile.only_for_help();
    app.require_subcommand(1);
    for (const auto add :
         {bench::add_demo,      bench::add_init,    bench::add_plan,     bench::add_recipes,  bench::add_run,
          bench::add_calibrate, bench::add_control, bench::add_status,   bench::add_page,     bench::add_fit,
          bench::add_import,    bench::add_predict, bench::add_model,    bench::add_report,   bench::add_reports,
          bench::add_runs,      bench::add_verify,  bench::add_db,       bench::add_fleet,    bench::add_sensors,
          bench::add_devices,   bench::add_live,    bench::add_simulate, bench::add_nightly,  bench::add_baseline,
          bench::add_trend,     bench::add_rig,     bench::add_config,   bench::add_selfcheck})
      add(app, session);
    bench::add_completion(app);
    bench::add_dead_man(app, session);
  }
  bench::Session session;
  CLI::App app{"of a test", "tactbench"};
};

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  while (!lines.empty() && lines.back().empty()) lines.pop_back();
  return lines;
}

std::string help_of_verb(const std::string& path) {
  AllVerbs program;
  std::vector<std::string> words;
  std::istringstream stream(path + " --help");
  for (std::string word; stream >> word;) words.push_back(word);
  std::ranges::reverse(words);  // as CLI11 takes them
  try {
    program.app.parse(words);
  } catch (const CLI::CallForHelp&) {
    return program.app.help();
  }
  return "no help";
}

// As the page has it: without --help, and without a head that nothing follows.
std::string section_of_help(const std::string& path) {
  const std::vector<std::string> lines = lines_of(help_of_verb(path));
  std::string about, text;
  std::size_t at = 0;
  for (; at < lines.size() && !lines[at].starts_with("Usage: "); ++at) about += (at == 0 ? "" : " ") + lines[at];
  REQUIRE(at < lines.size());
  about.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(about.front())));
  std::vector<std::string> kept;
  for (std::size_t i = at + 1; i < lines.size(); ++i)
    if (lines[i].find("--help") == std::string::npos) kept.push_back(lines[i]);
  for (std::size_t i = 0; i < kept.size(); ++i)
    if (kept[i] != "Options:" || (i + 1 < kept.size() && !kept[i + 1].empty())) text += kept[i] + "\n";
  while (text.ends_with("\n\n")) text.pop_back();
  return about + ".\n\n```text\n" + lines[at].substr(7) + "\n" + text + "```\n";
}

}  // namespace

TEST_CASE("each verb's help is its section of the page of verbs, and no verb is without one") {
  std::string page = tests::read_file(tests::source_path("docs/reference-verbs.md"));
  AllVerbs program;
  const bench::CommandNode tree = bench::command_tree(program.app);
  std::size_t verbs = 0;
  for (const bench::CommandNode* node : bench::all_nodes(tree)) {
    if (node->path.empty()) continue;
    INFO(node->path);
    ++verbs;
    const std::string head = "\n## " + node->path + "\n";
    const std::size_t begin = page.find(head);
    REQUIRE(begin != std::string::npos);
    const std::size_t from = begin + head.size(), end = page.find("\n\n## ", from);
    std::string section = page.substr(from, end == std::string::npos ? end : end + 1 - from);
    CHECK(section_of_help(node->path) == section);
  }
  std::size_t heads = 0;
  for (std::size_t at = 0; (at = page.find("\n## ", at)) != std::string::npos; ++at) ++heads;
  CHECK(verbs == heads);
}
