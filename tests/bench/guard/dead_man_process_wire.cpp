// The sequencer's side of its dead-man, which is a script here: what is sent to it, and what is made of each answer, of
// none and of its end.
#include "bench/guard/dead_man_process.h"

#include <fmt/format.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <sstream>

#include "devices/device.h"
#include "tests/devices/fault_of.h"
#include "tests/support/endless_run.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"

using namespace tactbench;
using namespace tactbench::tests;

namespace {

// Writes each message that comes to the file `heard`, the first one's members alone, and does what `rule` says.
class ScriptedDeadMan {
 public:
  // `rule`: lines of Python that see `word` and may call say(text) and hand(path).
  explicit ScriptedDeadMan(const std::string& rule, const std::string& first = "say('ready')") {
    config = small_request().bench;
    config.resolved = "text of the bench";
    config.file = "bench.toml";
    config.dead_man.program = folder.path("scripted-dead-man");
    config.dead_man.timeout_s = 5.0;
    config.dead_man.progress_s = 20.0;
    config.stage->address = {};
    config.stage->address.port = folder.path("no-such-line");
    std::string indented;
    std::istringstream lines(rule);
    for (std::string line; std::getline(lines, line);) indented += "    " + line + "\n";
    write_file(config.dead_man.program,
               "#!/usr/bin/python3\n"
               "import array, os, signal, socket, sys, time\n"
               "end = socket.socket(fileno=3)\n"
               "heard = open('" +
                   folder.path("heard") +
                   "', 'a', buffering=1)\n"
                   "heard.write(' '.join(sys.argv[1:]) + '\\n')\n"
                   "def say(text): end.send(text.encode())\n"
                   "def hand(path):\n"
                   "    line = os.open(path, os.O_RDWR)\n"
                   "    end.sendmsg([b'line'], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, array.array('i', [line]))])\n"
                   "    os.close(line)\n"
                   "heard.write(end.recv(65536).decode() + '\\n')\n" +
                   first +
                   "\nwhile True:\n"
                   "    word = end.recv(65536).decode()\n"
                   "    if not word: break\n"
                   "    heard.write(word + '\\n')\n" +
                   indented);
    std::filesystem::permissions(config.dead_man.program, std::filesystem::perms::owner_all);
  }
  [[nodiscard]] std::vector<std::string> heard() const {
    std::vector<std::string> words;
    std::istringstream lines(read_file(folder.path("heard")));
    for (std::string line; std::getline(lines, line);) {
      if (line == "feed" && !words.empty() && words.back() == "feed") continue;  // as often as time allows
      words.push_back(line);
    }
    return words;
  }
  const TemporaryFolder folder;
  bench::BenchConfig config;
};

std::string start_failure(const std::string& first) {
  const ScriptedDeadMan script("pass", first);
  const auto fault = devices::fault_of([&] { const bench::DeadManProcess process(script.config); });
  return fault ? fault->id() + " " + fault->what() : "(none)";
}

const std::string kAnswers = "if word == 'feed': say('fed')\nif word == 'goodbye': sys.exit()\n";

}  // namespace

TEST_CASE("dead-man process: gets the bench, feeding and the run number, and ends on goodbye") {
  const ScriptedDeadMan script(kAnswers);
  {
    bench::DeadManProcess process(script.config);
    CHECK(comes_true([&] { return script.heard().size() >= 3; }));
    process.name_run(17);
    CHECK_FALSE(process.fired());
    CHECK_FALSE(process.lost());
    CHECK_FALSE(process.wait_ended(std::chrono::milliseconds(1)));
    process.goodbye();
    CHECK(process.wait_ended(std::chrono::seconds(20)));
    CHECK_FALSE(process.lost());  // it was dismissed
    CHECK_FALSE(process.fired());
  }
  std::vector<std::string> heard = script.heard();
  std::erase(heard, "feed");
  CHECK(heard == std::vector<std::string>{"dead-man --socket 3", R"({"bench":"text of the bench","name":"bench.toml"})",
                                          "run 17", "goodbye"});
}

TEST_CASE("dead-man process: a failed start is reported with the text from the process") {
  CHECK_THAT(start_failure("say('no module there')\n"),
             Catch::StartsWith("TB-DEADMAN-START ") && Catch::EndsWith("no module there"));
  CHECK_THAT(start_failure("sys.exit()\n"), Catch::StartsWith("TB-DEADMAN-START "));
  const ScriptedDeadMan advised(kAnswers, "say('it refuses\\nreset it')\n");
  const auto fault = devices::fault_of([&] { const bench::DeadManProcess process(advised.config); });
  REQUIRE(fault);
  CHECK_THAT(fault->what(), Catch::EndsWith("it refuses"));
  CHECK(fault->remedy() == "reset it");
}

TEST_CASE("dead-man process: fires on command or by itself, and is lost when it ends") {
  {
    const ScriptedDeadMan script(kAnswers);
    bench::DeadManProcess process(script.config);
    process.fire();
    CHECK(process.fired());
    CHECK_FALSE(process.lost());
    CHECK(comes_true([&] { return script.heard().back() == "fire"; }));
  }
  {
    const ScriptedDeadMan script("if word.startswith('run'): say('fired')\n" + kAnswers);
    bench::DeadManProcess process(script.config);
    CHECK_FALSE(process.fired());
    process.name_run(1);
    CHECK(comes_true([&] { return process.fired(); }));
  }
  {
    const ScriptedDeadMan script("if word.startswith('run'): sys.exit()\n" + kAnswers);
    bench::DeadManProcess process(script.config);
    process.name_run(1);
    CHECK(comes_true([&] { return process.lost().has_value(); }));
    CHECK(process.lost()->id == "TB-DEADMAN-ENDED");
    CHECK_FALSE(process.fired());
    // The line is then opened here.
    devices::check_fault([&] { (void)process.open_line(); }, "TB-SERIAL-OPEN", script.config.stage->address.port);
  }
}

TEST_CASE("dead-man process: blind and seeing again are reported, one without answers is silent and is killed") {
  const ScriptedDeadMan script(
      "if word == 'run 1': say('blind: no answer')\nif word == 'run 2': say('sees')\n"
      "if word == 'run 3': time.sleep(1000)\n" +
      kAnswers);
  bench::BenchConfig config = script.config;
  config.dead_man.timeout_s = 1.5;
  bench::DeadManProcess process(config);
  process.name_run(1);
  std::vector<bench::DeadManNotice> news;
  const auto news_come = [&] {
    process.feed();
    news = process.take_notices();
    return !news.empty();
  };
  CHECK(comes_true(news_come));
  REQUIRE(news.size() == 1);
  CHECK(news[0].id == "TB-DEADMAN-BLIND");
  CHECK_THAT(news[0].what, Catch::Contains("no answer"));
  process.name_run(2);
  REQUIRE(comes_true(news_come));
  CHECK(news[0].id.empty());
  process.name_run(3);
  CHECK(comes_true([&] { return process.lost().has_value(); }));
  CHECK(process.lost()->id == "TB-DEADMAN-SILENT");
  CHECK_FALSE(process.fired());
  process.goodbye();  // it would keep the bench's next run waiting
  CHECK(process.wait_ended(std::chrono::seconds(20)));
}

TEST_CASE("dead-man process: hands over the line of the stage, or the reason why there is none") {
  const ScriptedDeadMan script(
      "if word == 'line':\n    count = globals().get('count', 0) + 1\n"
      "    hand('/dev/ptmx') if count == 1 else say('no line: it is unplugged')\n" +
      kAnswers);
  bench::DeadManProcess process(script.config);
  const auto line = process.open_line();
  REQUIRE(line);
  CHECK(line->descriptor() >= 0);
  CHECK(line->description().find(script.config.stage->address.port) != std::string::npos);
  devices::check_fault([&] { (void)process.open_line(); }, "TB-SERIAL-OPEN", "", "it is unplugged");
  process.goodbye();
}
