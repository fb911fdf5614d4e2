// The progress line before a person: on a terminal after two seconds, written over, gone at the end; silent with --json
// and -q; and not across what else is printed.
#include <catch2/catch.hpp>
#include <csignal>

#include "tests/support/in_terminal.h"
#include "tests/support/process.h"

using namespace tactbench::tests;

namespace {

// Long work of one taxel: a search from so many starts.
std::vector<std::string> search(const char* starts, const std::vector<std::string>& more = {}) {
  std::vector<std::string> words = {"fit", "loops.csv", "--model", "gpi", "--starts", starts};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

void write_loops(const TemporaryFolder& folder) {
  std::string table = "sequence,step,input,output\n";
  int step = 0;
  double lagging = 0.0;
  const auto go = [&](int from, int to) {
    for (int p = from; p != to; p += from < to ? 1 : -1) {
      lagging += 0.15 * (p - lagging);
      table +=
          "loops," + std::to_string(step++) + "," + std::to_string(p) + "," + std::to_string(0.05 * lagging) + "\n";
    }
  };
  go(0, 60), go(60, 20), go(20, 60), go(60, 0), go(0, 40), go(40, 0);
  write_file(folder.path("loops.csv"), table);
}

}  // namespace

TEST_CASE("progress: one line on a terminal, none with --json or -q") {
  const TemporaryFolder folder;
  write_loops(folder);
  InTerminal silent(folder.path(), search("4096", {"-q"}), 100, 24),
      document(folder.path(), search("4096", {"--json"}), 100, 24), shown(folder.path(), search("4096"), 100, 24);
  REQUIRE(shown.shows("(2 of 3)"));
  CHECK(shown.shown().find('\n') == shown.shown().rfind('\n'));  // written over, not below
  CHECK(silent.shown().find("fit: ") == std::string::npos);
  CHECK(document.shown().find("fit: ") == std::string::npos);
}
