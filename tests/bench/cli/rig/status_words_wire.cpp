// status and watch of runs that answer and of benches that do not. The runs are of this process, and do nothing but
// answer.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/run/control/locks.h"
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

std::string not_answering(const std::string& run) {
  return run + " on bench 'a-frozen' does not answer (" + bench::peer_text({::getpid(), ::geteuid(), false}) + ")\n";
}

}  // namespace

TEST_CASE("status: each live run with its lines, an empty line between two, and those of one bench or store alone") {
  const AskedForStatus of;
  const AnsweringRun live("live", 3, of.store("live.db")), other("other", 4, of.store("other.db"));
  const Finished both = of.say({"status"});
  CHECK(both.code == 0);
  CHECK(both.err.empty());
  const std::string one = of.say({"status", "3"}).out, two = of.say({"status", "--bench", "other"}).out;
  CHECK_THAT(one, Catch::StartsWith("run 3 on bench 'live'") && !Catch::Contains("run 4"));
  CHECK_THAT(two, Catch::StartsWith("run 4 on bench 'other'") && !Catch::Contains("run 3"));
  CHECK_THAT(both.out, Catch::StartsWith("run 3 on bench 'live'") && Catch::Contains("\n\nrun 4 on bench 'other'"));
  CHECK_THAT(of.say({"status", "--db", "live.db"}).out,
             Catch::StartsWith("run 3 on bench 'live'") && !Catch::Contains("run 4"));
  const nlohmann::json told = of.told({"status"});
  CHECK(told.at("live") == true);
  REQUIRE(told.at("runs").size() == 2);
  CHECK(told.at("runs").at(1).at("run") == 4);
  CHECK(told.at("silent").empty());
  CHECK(told.at("last_run").is_null());
}

TEST_CASE("status: a bench that does not answer is named, and then it is not said that no run is live") {
  const AskedForStatus of;
  const SilentRun silent("a-frozen", "/run/7");
  const std::string line = not_answering("run 7");
  CHECK(of.say({"status"}).out == line + "no run in runs.db\n");
  const nlohmann::json told = of.told({"status"});
  CHECK(told.at("live") == false);
  REQUIRE(told.at("silent").size() == 1);
  CHECK(told.at("silent").at(0) ==
        nlohmann::json{
            {"bench", "a-frozen"}, {"run", 7}, {"process", ::getpid()}, {"text", line.substr(0, line.size() - 1)}});
  const AnsweringRun live("live", 3, of.store("live.db"));
  const std::string beside = of.say({"status"}).out;
  CHECK_THAT(beside, Catch::StartsWith("run 3 on bench 'live'") && Catch::EndsWith("\n" + line));
  CHECK(of.told({"status"}).at("live") == true);
  {  // the last run of a store is told beside a bench that does not answer
    db::RunStore store = db::RunStore::open(of.folder.path("runs.db"), db::Durability::kNormal);
    (void)store_example(store);
  }
  CHECK_THAT(of.say({"status", "--db", "runs.db"}).out,
             Catch::StartsWith(line + "last run in runs.db:\nrun 1 on bench 'bench-a' (simulated): completed, 3 "
                                      "frames\n") &&
                 Catch::EndsWith("\nnext: tactbench fit 1\n"));
  CHECK(of.say({"status"}).out.find("\nlast run in runs.db:\n") == std::string::npos);  // the live one is told
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
    const Finished held = of.say({"watch", "1"});
    CHECK(held.code == 2);
    CHECK_THAT(held.err, Catch::StartsWith("error: " + not_answering("run 1").substr(0, 40)) &&
                             Catch::Contains("[TB-RUN-SILENT]"));
  }
  const Finished ended = of.say({"watch", "2"});
  CHECK(ended.code == 3);  // its process died
  CHECK_THAT(ended.out, Catch::Contains("\nnext: tactbench resume 2"));
  const bench::RunLock lock(path);
  lock.take_new(2);
  const Finished carried_out = of.say({"watch", "2"});
  CHECK(carried_out.code == 2);
  CHECK(carried_out.out.empty());
  CHECK_THAT(carried_out.err, Catch::StartsWith("error: no live run 2 answers [TB-RUN-NOT-LIVE]\n"));
  const Finished status = of.say({"status", "2"});
  CHECK_THAT(status.out, Catch::StartsWith("no run is live\nlast run in runs.db:\nrun 2 on bench 'bench-a' ") &&
                             !Catch::Contains("next: "));
}

TEST_CASE("status: without --db the store of this folder is asked, and one that is not there only for a number") {
  const AskedForStatus of;
  CHECK(of.say({"status"}).out == "no run is live\nno run in runs.db\n");
  const Finished numbered = of.say({"status", "9"});
  CHECK(numbered.code == 5);
  CHECK_THAT(numbered.err, Catch::Contains("[TB-STORE-OPEN]"));
  CHECK(of.say({"status", "--db", "none.db"}).code == 5);
  {
    db::RunStore store = db::RunStore::open(of.folder.path("runs.db"), db::Durability::kNormal);
    (void)store_example(store);
  }
  CHECK_THAT(of.say({"status"}).out, Catch::StartsWith("no run is live\nlast run in runs.db:\nrun 1 on bench "));
  CHECK_THAT(of.say({"status", "1"}).out, Catch::StartsWith("no run is live\nlast run in runs.db:\nrun 1 on bench "));
}
