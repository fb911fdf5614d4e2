// A command reads each run once, however many figures of it are asked for. SQLite itself is asked: it names every
// statement that it carries out for a verb, which runs in this process.
#include <sqlite3.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdint>
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

// How the store asks for the frames of a run, up to the first bound value; and what such a statement has besides.
constexpr std::string_view kFramesFrom = "FROM frames WHERE frame > ", kWithCounts = ", counts,";

// The run of each statement that reads frames, on all connections opened while this lives; they must be closed before
// it goes.
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
  [[nodiscard]] std::vector<std::int64_t> sorted() const {
    std::vector<std::int64_t> runs = runs_;
    std::ranges::sort(runs);
    return runs;
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
    const std::size_t from = sql.find(kFramesFrom);
    if (from == std::string_view::npos || sql.find(kWithCounts) == std::string_view::npos) return;
    char* const bound = sqlite3_expanded_sql(statement);
    runs_.push_back(std::stoll(std::string(bound).substr(from + kFramesFrom.size())) / db::kFramesPerRun);
    sqlite3_free(bound);
  }
  static inline ReadLog* current_ = nullptr;
  std::vector<std::int64_t> runs_;
};

using RunsRead = std::vector<std::int64_t>;

// The runs whose frames the verb reads, in their order, each as often as it does.
RunsRead frames_read_by(const TemporaryFolder& folder, std::vector<std::string> words) {
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
  CHECK(frames_read_by(folder, {"fit", "1"}) == RunsRead{1});
  CHECK(frames_read_by(folder, {"judge", "1", "2", "--limits", limits}) == RunsRead{1, 2});
  CHECK(frames_read_by(folder, {"report", "1", "--held-out", "2", "-o", page}) == RunsRead{1, 2});
  CHECK(frames_read_by(folder, {"report", "1", "--held-out", "2", "3", "-o", page}) == RunsRead{1, 2, 3});
  // The held-out run is the one that the fit was judged on; then by other limits, for which nothing is stored.
  CHECK(frames_read_by(folder, {"report", "1", "-o", page}) == RunsRead{1, 2});
  write_file(limits, read_file(limits) + "# another file\n");
  CHECK(frames_read_by(folder, {"report", "1", "--limits", limits, "-o", page}) == RunsRead{1, 2});

  // All that further runs tell: creep and temperature, a mount, an object, paces; and earlier models.
  CHECK(frames_read_by(folder, {"report", "1", "2", "--held-out", "2", "--previous", "2", "--studies", "3:mount", "4",
                                "5", "-o", page}) == RunsRead{1, 2, 3, 4, 5});
  CHECK(frames_read_by(folder, {"report", "--compare", "1", "2", "-o", folder.path("c.html")}) == RunsRead{1, 2});
  CHECK(frames_read_by(folder, {"model", "show", "1"}).empty());
  CHECK(frames_read_by(folder, {"model", "check", "2", "1"}) == RunsRead{1});
  // Once for the hash of what is stored, once for what follows from it.
  CHECK(frames_read_by(folder, {"verify", "2"}) == RunsRead{1, 1, 2, 2});
}
