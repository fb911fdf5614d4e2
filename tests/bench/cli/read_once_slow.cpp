// A command reads each run once, however many figures of it are asked for. SQLite itself is asked: it names every
// statement that it carries out for a verb, which runs in this process.
#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "bench/cli/session.h"
#include "db/schema.h"
#include "tests/support/process.h"
#include "tests/support/run_recipe.h"
#include "tests/support/small_array.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// How the store asks for a run's rows, up to the first bound value; `holds`: what such a statement has besides.
struct RunQuery {
  const char* rows;
  std::string_view from, holds;
};
constexpr std::array kRunQueries = {
    RunQuery{"frames", "FROM frames WHERE frame > ", ", counts,"},
    RunQuery{"branches", "FROM branches WHERE run = ", "void_reason"},
    RunQuery{"events", "FROM events WHERE run = ", "detail"},
    RunQuery{"checks", "FROM checks c WHERE c.run = ", "detail_json"},
    RunQuery{"row", "FROM runs WHERE run = ", "uuid"},
};

// "frames of run 1" for each statement that reads them, on all connections opened while this lives; they must be
// closed before it goes.
class ReadLog {
 public:
  ReadLog() {
    current_ = this;
    REQUIRE(sqlite3_auto_extension(entry()) == SQLITE_OK);
  }
  ~ReadLog() {
    (void)sqlite3_cancel_auto_extension(entry());
    current_ = nullptr;
  }
  ReadLog(const ReadLog&) = delete;
  ReadLog& operator=(const ReadLog&) = delete;
  [[nodiscard]] std::vector<std::string> sorted() const {
    std::vector<std::string> lines = lines_;
    std::ranges::sort(lines);
    return lines;
  }

 private:
  using Entry = void (*)();
  static Entry entry() { return reinterpret_cast<Entry>(&attach); }
  static int attach(sqlite3* connection, char** /*error*/, const sqlite3_api_routines* /*api*/) {
    return sqlite3_trace_v2(connection, SQLITE_TRACE_STMT, &see, current_);
  }
  static int see(unsigned /*event*/, void* log, void* statement, void* /*sql*/) {
    static_cast<ReadLog*>(log)->note(static_cast<sqlite3_stmt*>(statement));
    return 0;
  }
  void note(sqlite3_stmt* statement) {
    const std::string_view sql = sqlite3_sql(statement);
    for (const RunQuery& query : kRunQueries) {
      const std::size_t from = sql.find(query.from);
      if (from == std::string_view::npos || sql.find(query.holds) == std::string_view::npos) continue;
      char* const bound = sqlite3_expanded_sql(statement);
      const std::int64_t number = std::stoll(std::string(bound).substr(from + query.from.size()));
      sqlite3_free(bound);
      const bool key = std::string_view(query.rows) == "frames";  // of the frame, which the run's number begins
      lines_.push_back(std::string(query.rows) + " of run " +
                       std::to_string(key ? number / db::kFramesPerRun : number));
    }
  }
  static inline ReadLog* current_ = nullptr;
  std::vector<std::string> lines_;
};

// What the verb reads of runs, in alphabetical order.
std::vector<std::string> read_by(const TemporaryFolder& folder, std::vector<std::string> words) {
  words.insert(words.begin(), "tactbench");
  words.insert(words.end(), {"--db", folder.path("runs.db")});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  ReadLog log;
  const int code = bench::run_command_line(static_cast<int>(arguments.size()), arguments.data());
  CAPTURE(words, code);
  REQUIRE((code == 0 || code == 1 || code == 6));  // by the verdicts
  return log.sorted();
}

std::vector<std::string> frames_read_by(const TemporaryFolder& folder, const std::vector<std::string>& words) {
  std::vector<std::string> lines = read_by(folder, words);
  std::erase_if(lines, [](const std::string& line) { return !line.starts_with("frames "); });
  return lines;
}

std::vector<std::string> all_once(const std::vector<int>& runs) {
  std::vector<std::string> lines;
  for (const RunQuery& query : kRunQueries)
    for (const int run : runs) lines.push_back(std::string(query.rows) + " of run " + std::to_string(run));
  std::ranges::sort(lines);
  return lines;
}

std::vector<std::string> frames_of(const std::vector<int>& runs) {
  std::vector<std::string> lines;
  for (const int run : runs) lines.push_back("frames of run " + std::to_string(run));
  return lines;
}

}  // namespace

TEST_CASE("a verb reads the frames of each run once") {
  const TemporaryFolder folder;
  init_small_array(folder);
  REQUIRE(call(folder, {"sensors", "add", "S-1", "--type", "sensor.toml"}).code == 0);
  write_file(
      folder.path("loops.toml"),
      "schema = 1\nname = \"loops\"\nunit = \"psi\"\nturning_points = [0, 60, 20, 60, 0]\nstep = 4\nrepeats = 2\n"
      "dwell_s = 1.0\n[conditioning]\ncycles = 1\npeak = 60\n");
  run_recipe(folder, "loops.toml", {"--seed", "1"});
  run_recipe(folder, "loops.toml", {"--seed", "2"});
  run_recipe(folder, "loops.toml", {"--seed", "3", "--set", "simulation.mount_seed=1"});
  run_recipe(folder, "ring", {"--set", "recipe.repeats=1"});
  run_recipe(folder, "rate-ramp", {});
  REQUIRE(call(folder, {"fit", "2"}).code == 0);
  const std::string page = folder.path("r.html"), limits = folder.path("limits.toml");

  // Fitted, evaluated, judged with U, and the report of that.
  CHECK(frames_read_by(folder, {"fit", "1", "--held-out", "2", "--limits", limits}) == frames_of({1, 2}));
  CHECK(read_by(folder, {"report", "1", "--held-out", "2", "-o", page}) == all_once({1, 2}));
  CHECK(read_by(folder, {"report", "1", "--held-out", "2", "3", "-o", page}) == all_once({1, 2, 3}));
  // The held-out run is the one that the fit was judged on; then by other limits, for which nothing is stored.
  CHECK(read_by(folder, {"report", "1", "-o", page}) == all_once({1, 2}));
  write_file(limits, read_file(limits) + "# another file\n");
  CHECK(read_by(folder, {"report", "1", "--limits", limits, "-o", page}) == all_once({1, 2}));

  // All that further runs tell: creep and temperature, a mount, an object, paces; and earlier models.
  CHECK(frames_read_by(folder, {"report", "1", "2", "--held-out", "2", "--previous", "2", "--studies", "3:mount", "4",
                                "5", "-o", page}) == frames_of({1, 2, 3, 4, 5}));
  CHECK(frames_read_by(folder, {"report", "--compare", "1", "2", "-o", folder.path("c.html")}) == frames_of({1, 2}));
  CHECK(frames_read_by(folder, {"model", "show", "1"}).empty());
  CHECK(frames_read_by(folder, {"fit", "1", "--check", "2"}) == frames_of({1}));
  // Once for the hash of what is stored, once for what follows from it.
  CHECK(frames_read_by(folder, {"verify", "2"}) == frames_of({1, 1, 2, 2}));
}
