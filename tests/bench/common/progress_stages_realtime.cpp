// The progress line before a person: on a terminal, written over, silent with --json and -q. Work is held up by a table
// that comes through a pipe, a store that is written by somebody else, a night that does not end.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "db/run_store.h"
#include "db/sqlite.h"
#include "tests/support/in_terminal.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// A table whose rows come when the test gives them.
class TableThroughPipe {
 public:
  explicit TableThroughPipe(const std::string& path) {
    REQUIRE(::mkfifo(path.c_str(), 0600) == 0);
    pipe_ = ::open(path.c_str(), O_RDWR | O_CLOEXEC);
    REQUIRE(pipe_ >= 0);
  }
  ~TableThroughPipe() { end(); }
  TableThroughPipe(const TableThroughPipe&) = delete;
  TableThroughPipe& operator=(const TableThroughPipe&) = delete;
  void give(const std::string& text) {
    REQUIRE(::write(pipe_, text.data(), text.size()) == static_cast<ssize_t>(text.size()));
    end();
  }

 private:
  void end() {
    if (pipe_ >= 0) ::close(pipe_);
    pipe_ = -1;
  }
  int pipe_ = -1;
};

constexpr const char* kLoopOfPipe =
    "input,output\n0,0\n1,1.5\n2,2.5\n3,4\n2,3.5\n1,2\n0,0.1\n1,1.4\n2,2.6\n1,2.1\n0,0\n";

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

TEST_CASE("progress of an import: shows its stages and their share while it waits for table and store") {
  const TemporaryFolder folder;
  db::RunStore::open(folder.path("runs.db"), db::Durability::kNormal);
  TableThroughPipe table(folder.path("t.csv"));
  InTerminal importing(folder.path(), {"runs", "import", "t.csv"}, 100, 24);
  REQUIRE(importing.shows("(1 of 3)"));
  {
    db::sqlite::Connection other(folder.path("runs.db"), db::sqlite::Access::kReadWrite);
    other.execute("BEGIN IMMEDIATE");
    table.give(kLoopOfPipe);
    CHECK(importing.shows("(3 of 3)"));
    CHECK(importing.shows("99 %"));
    other.execute("ROLLBACK");
  }
  CHECK(importing.wait() == 0);
  CHECK(db::RunStore::open_read_only(folder.path("runs.db")).runs().size() == 1);
}

TEST_CASE("progress of a night: a terminal shows the percentage done, no progress with --json or -q") {
  const TemporaryFolder folder;
  write_file(folder.path("s.toml"),
             "schema = 1\nname = \"small\"\n[[scenario]]\nname = \"misspelt\"\nabout = \"a\"\nrecipes = [\"no-such\"]\n"
             "[[scenario]]\nname = \"endless\"\nabout = \"b\"\nrecipes = [\"./long.toml\"]\nfits = false\n");
  write_file(folder.path("long.toml"),
             "schema = 1\nname = \"long\"\nunit = \"psi\"\nturning_points = [0, 60, 0]\nstep = 2\nrepeats = 1000\n");
  const auto night = [](const std::string& more) {
    std::vector<std::string> words = {"nightly", "./s.toml", "--jobs", "1"};
    if (!more.empty()) words.push_back(more);
    return words;
  };
  InTerminal quiet(folder.path(), night("-q"), 100, 24), as_json(folder.path(), night("--json"), 100, 24),
      shown(folder.path(), night(""), 100, 24);
  REQUIRE(shown.shows("50 %"));
  CHECK(shown.shown().find("1 of 2") == std::string::npos);
  CHECK(quiet.shown().find("nightly: ") == std::string::npos);
  CHECK(as_json.shown().find("nightly: ") == std::string::npos);
  for (InTerminal* each : {&quiet, &as_json, &shown}) {
    each->type("\x03");
    CHECK(each->wait() == 130);
  }
}

TEST_CASE("progress: one line on a terminal, no line with --json or -q") {
  const TemporaryFolder folder;
  write_loops(folder);
  InTerminal silent(folder.path(), search("4096", {"-q"}), 100, 24),
      document(folder.path(), search("4096", {"--json"}), 100, 24), shown(folder.path(), search("4096"), 100, 24);
  REQUIRE(shown.shows("(2 of 3)"));
  CHECK(shown.shown().find('\n') == shown.shown().rfind('\n'));  // written over, not below
  CHECK(silent.shown().find("fit: ") == std::string::npos);
  CHECK(document.shown().find("fit: ") == std::string::npos);
}
