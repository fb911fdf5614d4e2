// pause, resume, stop, abort, panic, status and watch: which of several runs they mean, and what is refused. The runs
// are of this process, and do nothing but answer.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/run/control/locks.h"
#include "tests/bench/cli/check_refusal.h"
#include "tests/db/store_example.h"
#include "tests/support/answering_run.h"

using namespace tactbench;
using namespace tactbench::tests;
using CommandWords = std::vector<std::string>;

namespace {

struct CommandsGiven {
  // A file that is none.
  [[nodiscard]] std::string store(const std::string& name) const {
    write_file(folder.path(name), "");
    return folder.path(name);
  }
  Finished give(const CommandWords& words) const { return call(folder, words); }
  [[nodiscard]] nlohmann::json told(CommandWords words) const {
    words.emplace_back("--json");
    return nlohmann::json::parse(give(words).out);
  }
  void taken(const CommandWords& words) const {
    const Finished done = give(words);
    CAPTURE(words, done.err);
    CHECK(done.code == 0);
    CHECK_FALSE(done.out.empty());
  }
  void refused(const CommandWords& words, const std::string& id) const {
    const Finished done = give(words);
    CAPTURE(words);
    check_refusal(done, 2, id);
    CHECK(done.out.empty());
  }
  TemporaryFolder folder;
};

}  // namespace

TEST_CASE("commands: the answer of the one live run, or why it is refused") {
  const CommandsGiven of;
  of.refused({"stop"}, "TB-RUN-NOT-LIVE");
  const AnsweringRun live("live", 3, of.store("live.db"));
  of.refused({"resume", "3", "--db", "live.db"}, "TB-RUN-WORD");
  of.taken({"pause"});
  of.taken({"resume"});
  const auto told = nlohmann::ordered_json::parse(of.give({"stop", "--json"}).out);
  CHECK(told.at("schema") == "tactbench.stop");
  CHECK((told.at("run") == 3 && told.at("bench") == "live" && told.at("store") == of.folder.path("live.db")));
  CHECK((told.at("state") == "running" && told.at("step") == 3 && told.at("steps") == 40));
  of.taken({"stop", "--abort", "3"});
  of.taken({"panic", "--bench", "live"});
  of.refused({"pause", "4"}, "TB-RUN-NOT-LIVE");
}

TEST_CASE("resume: a number alone resumes no run of another store where this folder has one") {
  const CommandsGiven of;
  const AnsweringRun live("live", 3, of.store("live.db"));
  of.taken({"pause"});
  of.taken({"resume", "3"});  // no runs.db lies here
  of.taken({"pause"});
  write_file(of.folder.path("runs.db"), "");
  of.refused({"resume", "3"}, "TB-RUN-AMBIGUOUS");
  of.taken({"resume", "3", "--db", "live.db"});
  of.taken({"pause"});
  of.taken({"resume"});
}

TEST_CASE("resume: the run of this folder's own store is resumed by its number") {
  const CommandsGiven of;
  const AnsweringRun live("live", 3, of.store("runs.db"));
  of.taken({"pause", "3"});
  of.taken({"resume", "3"});
}

TEST_CASE("commands: several live runs must be told apart, and a panic reaches all that are meant") {
  const CommandsGiven of;
  const AnsweringRun live("live", 3, of.store("live.db")), other("other", 3, of.store("other.db"));
  for (const CommandWords& words : {CommandWords{"stop"}, CommandWords{"stop", "3"}, CommandWords{"panic"}})
    of.refused(words, "TB-RUN-AMBIGUOUS");
  CHECK(live.control.who().empty());
  of.taken({"stop", "--bench", "other"});
  CHECK(live.control.who().empty());
  of.taken({"panic", "3"});
  CHECK_FALSE(live.control.who().empty());
  of.taken({"panic", "3", "--db", "other.db"});
}

TEST_CASE("panic: all runs must refuse for it to fail") {
  const CommandsGiven of;
  const AnsweringRun ended("a", 3, of.store("a.db"), bench::RunState::kEnded);
  {
    const AnsweringRun live("live", 3, of.store("live.db"));
    of.taken({"panic", "3"});  // the live one takes it
  }
  const AnsweringRun more("more", 3, of.store("more.db"), bench::RunState::kEnded);
  check_refusal(of.give({"panic", "3"}), 2, "TB-RUN-WORD");
}

TEST_CASE("commands: a bench that does not answer is named, and holds up a stop but no panic") {
  const CommandsGiven of;
  const AnsweringRun live("live", 3, of.store("live.db"));
  const SilentRun silent("a-frozen", "/run/7");
  of.refused({"stop"}, "TB-RUN-AMBIGUOUS");
  for (const CommandWords& words : {CommandWords{"stop", "7"}, CommandWords{"stop", "--bench", "a-frozen"}})
    of.refused(words, "TB-RUN-SILENT");
  of.taken({"stop", "3"});  // the silent one is of another number
  of.taken({"panic"});
  of.taken({"stop", "--db", "live.db"});
}

TEST_CASE("status: each live run, and those of one bench or store alone") {
  const CommandsGiven of;
  const AnsweringRun live("live", 3, of.store("live.db")), other("other", 4, of.store("other.db"));
  const Finished both = of.give({"status"});
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
  const CommandsGiven of;
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
  const CommandsGiven of;
  const std::string path = of.folder.path("runs.db");
  {
    db::RunStore store = db::RunStore::open(path, db::Durability::kNormal);
    (void)store_example(store);
    (void)begin_example(store);
  }
  CHECK(of.give({"status", "--watch", "1"}).code == 0);
  {
    const SilentRun silent("a-frozen", "/run/1");
    check_refusal(of.give({"status", "--watch", "1"}), 2, "TB-RUN-SILENT");
  }
  const Finished ended = of.give({"status", "--watch", "2"});
  CHECK(ended.code == 3);  // its process died
  const bench::RunLock lock(path);
  lock.take_new(2);
  const Finished carried_out = of.give({"status", "--watch", "2"});
  CHECK(carried_out.code == 2);
  CHECK(carried_out.out.empty());
  CHECK_THAT(carried_out.err, Catch::Contains("[TB-RUN-NOT-LIVE]"));
}

TEST_CASE("status: without --db the store of this folder is asked") {
  const CommandsGiven of;
  check_refusal(of.give({"status", "9"}), 5, "TB-STORE-OPEN");
  CHECK(of.give({"status", "--db", "none.db"}).code == 5);
  {
    db::RunStore store = db::RunStore::open(of.folder.path("runs.db"), db::Durability::kNormal);
    (void)store_example(store);
  }
  CHECK(of.told({"status"}).at("last_run").at("run") == 1);
  CHECK(of.told({"status", "1"}).at("last_run").at("run") == 1);
}
