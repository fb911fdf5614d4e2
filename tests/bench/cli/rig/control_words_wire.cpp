// pause, resume, stop, abort and panic: what they print of the answer, and which of several runs they command. The runs
// are of this process, and do nothing but answer.
#include <fmt/format.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

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
  void taken(const CommandWords& words, const std::string& said, const std::string& warned = "") const {
    const Finished done = give(words);
    CAPTURE(words);
    CHECK(done.code == 0);
    CHECK(done.out == said + "\n");
    CHECK(done.err == warned);
  }
  void refused(const CommandWords& words, const std::string& said, const std::string& remedy) const {
    const Finished done = give(words);
    CAPTURE(words);
    CHECK(done.code == 2);
    CHECK(done.out.empty());
    CHECK_THAT(done.err, Catch::StartsWith("error: " + said + "\n  at: ") &&
                             Catch::EndsWith("\n  try: " + remedy + "\n  state: no device was touched\n"));
  }
  [[nodiscard]] std::string run(std::int64_t number, const std::string& name) const {
    return fmt::format("run {} of {} on bench '{}' (running, step 3/40)", number, folder.path(name + ".db"), name);
  }
  TemporaryFolder folder;
};

const std::string kSaidOfEnd = "run 3 ends: vents, retracts and proves it",
                  kSaidOfPanic = "run 3 ends: vented and halted past the sequencer";

}  // namespace

TEST_CASE("commands: the answer of the one live run, in words and as JSON, or why it is refused") {
  const CommandsGiven of;
  of.refused({"stop"}, "no live run answers [TB-RUN-NOT-LIVE]",
             "see `tactbench runs list`; continue an ended run with `tactbench resume RUN`");
  const AnsweringRun live("live", 3, of.store("live.db"));
  of.refused({"resume", "3", "--db", "live.db"}, "run 3 is running, not paused [TB-RUN-WORD]",
             "see `tactbench runs list`");
  of.taken({"pause"}, "run 3 pauses at the end of this branch; 'stop' ends it at once");
  of.taken({"resume"}, "run 3 continues: the pause is taken back");
  const auto told = nlohmann::ordered_json::parse(of.give({"stop", "--json"}).out);
  CHECK(told == nlohmann::ordered_json{{"schema", "tactbench.stop"},
                                       {"version", 1},
                                       {"run", 3},
                                       {"bench", "live"},
                                       {"store", of.folder.path("live.db")},
                                       {"state", "running"},
                                       {"step", 3},
                                       {"steps", 40},
                                       {"answer", kSaidOfEnd}});
  of.taken({"abort", "3"}, kSaidOfEnd);
  of.taken({"panic", "--bench", "live"}, kSaidOfPanic);
  of.refused({"pause", "4"}, "no live run 4 answers [TB-RUN-NOT-LIVE]", "live: " + of.run(3, "live"));
}

TEST_CASE("resume: a number alone resumes no run of another store where this folder has one") {
  const CommandsGiven of;
  const AnsweringRun live("live", 3, of.store("live.db"));
  of.taken({"pause"}, "run 3 pauses at the end of this branch; 'stop' ends it at once");
  const std::string resumed = "run 3 continues: the pause is taken back";
  of.taken({"resume", "3"}, resumed);  // no runs.db lies here
  of.taken({"pause"}, "run 3 pauses at the end of this branch; 'stop' ends it at once");
  write_file(of.folder.path("runs.db"), "");
  of.refused({"resume", "3"}, "a live run 3 belongs to another store than 'runs.db' [TB-RUN-AMBIGUOUS]",
             "name its store: tactbench resume 3 --db STORE; live: " + of.run(3, "live"));
  of.taken({"resume", "3", "--db", "live.db"}, resumed);
  of.taken({"pause"}, "run 3 pauses at the end of this branch; 'stop' ends it at once");
  of.taken({"resume"}, resumed);
}

TEST_CASE("resume: the run of this folder's own store is resumed by its number") {
  const CommandsGiven of;
  const AnsweringRun live("live", 3, of.store("runs.db"));
  of.taken({"pause", "3"}, "run 3 pauses at the end of this branch; 'stop' ends it at once");
  of.taken({"resume", "3"}, "run 3 continues: the pause is taken back");
}

TEST_CASE("commands: several live runs must be told apart, and a panic reaches all that are meant") {
  const CommandsGiven of;
  const AnsweringRun live("live", 3, of.store("live.db")), other("other", 3, of.store("other.db"));
  const std::string both = of.run(3, "live") + "; " + of.run(3, "other");
  for (const CommandWords& words : {CommandWords{"stop"}, CommandWords{"stop", "3"}, CommandWords{"panic"}})
    of.refused(words, "2 runs are live [TB-RUN-AMBIGUOUS]",
               fmt::format("name one: tactbench {} --bench ID, or RUN --db STORE; live: {}", words[0], both));
  CHECK(live.control.who().empty());
  of.taken({"stop", "--bench", "other"}, kSaidOfEnd);
  CHECK(live.control.who().empty());
  of.taken({"panic", "3"}, kSaidOfPanic);
  CHECK_FALSE(live.control.who().empty());
  of.taken({"panic", "3", "--db", "other.db"}, kSaidOfPanic);
}

TEST_CASE("panic: runs that refuse it are told, and all must refuse for it to fail") {
  const CommandsGiven of;
  const AnsweringRun ended("a", 3, of.store("a.db"), bench::RunState::kEnded);
  {
    const AnsweringRun live("live", 3, of.store("live.db"));
    of.taken({"panic", "3"}, kSaidOfPanic, "warning: run 3 is ended already\n");
  }
  const AnsweringRun more("more", 3, of.store("more.db"), bench::RunState::kEnded);
  const Finished none = of.give({"panic", "3"});
  CHECK(none.code == 2);
  CHECK_THAT(none.err, Catch::StartsWith("warning: run 3 is ended already\nwarning: run 3 is ended already\nerror: run "
                                         "3 is ended already [TB-RUN-WORD]\n"));
}

TEST_CASE("commands: a bench that does not answer is named, and holds up a stop but no panic") {
  const CommandsGiven of;
  const AnsweringRun live("live", 3, of.store("live.db"));
  const SilentRun silent("a-frozen", "/run/7");
  const std::string text =
      fmt::format("run 7 on bench 'a-frozen' does not answer ({})", bench::peer_text({::getpid(), ::geteuid(), false}));
  of.refused({"stop"}, "2 runs are live [TB-RUN-AMBIGUOUS]",
             "name one: tactbench stop --bench ID, or RUN --db STORE; live: " + of.run(3, "live") + "; " + text);
  const std::string process = std::to_string(::getpid());
  for (const CommandWords& words : {CommandWords{"stop", "7"}, CommandWords{"stop", "--bench", "a-frozen"}})
    of.refused(words, text + " [TB-RUN-SILENT]",
               "check the rig: the process is stopped, or opens its devices. `kill -CONT " + process +
                   "` continues a stopped process, `kill -KILL " + process + "` ends it, and its dead-man vents");
  of.taken({"stop", "3"}, kSaidOfEnd);  // the silent one is of another number
  of.taken({"panic"}, kSaidOfPanic, "warning: " + text + "\n");
  of.taken({"stop", "--db", "live.db"}, kSaidOfEnd, "warning: " + text + "\n");
}
