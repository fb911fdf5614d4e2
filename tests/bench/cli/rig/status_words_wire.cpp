// status and watch of runs that answer and of benches that do not. The runs are of this process, and do nothing but
// answer.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/run/control/locks.h"
#include "tests/bench/cli/check_refusal.h"
#include "tests/db/store_example.h"
#include "tests/support/answering_run.h"
#include "tests/support/process.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

struct AskedForStatus {
  // A file that is none.
  [[nodiscard]] std::string store(const std::string& name) const {
    write_file(folder.path(name), "");
    return folder.path(name);
  }
  [[nodiscard]] Finished say(const std::vector<std::string>& words) const { return call(folder, words); }
  [[nodiscard]] nlohmann::json told(std::vector<std::string> words) const {
    words.emplace_back("--json");
    return nlohmann::json::parse(say(words).out);
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("status: each live run, and those of one bench or store alone") {
  const AskedForStatus of;
  const AnsweringRun live("live", 3, of.store("live.db")), other("other", 4, of.store("other.db"));
  const Finished both = of.say({"status"});
  CHECK(both.code == 0);
  CHECK(both.err.empty());
  const auto only = [&](const std::vector<std::string>& words) {
    const nlohmann::json runs = of.told(words).at("runs");
    REQUIRE(runs.size() == 1);
    return runs.at(0).at("run");
  };
  CHECK(only({"status", "3"}) == 3);
  CHECK(only({"status", "--bench", "other"}) == 4);
  CHECK(only({"status", "--db", "live.db"}) == 3);
  const nlohmann::json told = of.told({"status"});
  CHECK(told.at("live") == true);
  REQUIRE(told.at("runs").size() == 2);
  CHECK(told.at("runs").at(1).at("run") == 4);
  CHECK(told.at("silent").empty());
  CHECK(told.at("last_run").is_null());
}

TEST_CASE("status: a bench that does not answer is named") {
  const AskedForStatus of;
  const SilentRun silent("a-frozen", "/run/7");
  const nlohmann::json told = of.told({"status"});
  CHECK(told.at("live") == false);
  REQUIRE(told.at("silent").size() == 1);
  const nlohmann::json& one = told.at("silent").at(0);
  CHECK((one.at("bench") == "a-frozen" && one.at("run") == 7 && one.at("process") == ::getpid()));
  const AnsweringRun live("live", 3, of.store("live.db"));
  CHECK(of.told({"status"}).at("live") == true);
  {  // the last run of a store is told beside a bench that does not answer
    db::RunStore store = db::RunStore::open(of.folder.path("runs.db"), db::Durability::kNormal);
    (void)store_example(store);
  }
  CHECK(of.told({"status", "--db", "runs.db"}).at("last_run").at("run") == 1);
}

TEST_CASE("watch: an ended run is told only where nothing else is meant, and one that is carried out is not ended") {
  const AskedForStatus of;
  const std::string path = of.folder.path("runs.db");
  {
    db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
    (void)store_example(store);
    (void)begin_example(store);
  }
  CHECK(of.say({"watch", "1"}).code == 0);
  {
    const SilentRun silent("a-frozen", "/run/1");
    check_refusal(of.say({"watch", "1"}), 2, "TB-RUN-SILENT");
  }
  const Finished ended = of.say({"watch", "2"});
  CHECK(ended.code == 3);  // its process died
  const bench::RunLock lock(path);
  lock.take_new(2);
  const Finished carried_out = of.say({"watch", "2"});
  CHECK(carried_out.code == 2);
  CHECK(carried_out.out.empty());
  CHECK_THAT(carried_out.err, Catch::Contains("[TB-RUN-NOT-LIVE]"));
}

TEST_CASE("status: without --db the store of this folder is asked, and one that is not there only for a number") {
  const AskedForStatus of;
  check_refusal(of.say({"status", "9"}), 5, "TB-STORE-OPEN");
  CHECK(of.say({"status", "--db", "none.db"}).code == 5);
  {
    db::RunStore store = db::RunStore::open(of.folder.path("runs.db"), db::Durability::kNormal);
    (void)store_example(store);
  }
  CHECK(of.told({"status"}).at("last_run").at("run") == 1);
  CHECK(of.told({"status", "1"}).at("last_run").at("run") == 1);
}
