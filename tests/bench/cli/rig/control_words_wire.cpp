// pause, resume, stop, abort and panic: which of several runs they command, and what is refused. The runs
// are of this process, and do nothing but answer.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/check_refusal.h"
#include "tests/support/answering_run.h"
#include "tests/support/process.h"

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
  void taken(const CommandWords& words) const {
    const Finished done = give(words);
    CAPTURE(words, done.err);
    CHECK(done.code == 0);
    CHECK_FALSE(done.out.empty());
  }
  void refused(const CommandWords& words, const std::string& id) const {
    const Finished done = give(words);
    CAPTURE(words);
    CHECK(done.code == 2);
    CHECK(done.out.empty());
    CHECK_THAT(done.err, Catch::Contains("[" + id + "]\n"));
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
  of.taken({"abort", "3"});
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
