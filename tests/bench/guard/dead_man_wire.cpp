// The sequencer's side of its dead-man, which is a script here: what is sent to it, and what is made of each answer, of
// none and of its end.

#include "bench/guard/dead_man_process.h"

#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include <atomic>
#include <filesystem>
#include <sstream>
#include <thread>

#include "bench/guard/trip.h"
#include "bench/safety/dead_man_server.h"
#include "devices/device.h"
#include "devices/wire/descriptor_channel.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/devices/fault_of.h"
#include "tests/support/endless_run.h"
#include "tests/support/hosted_rig.h"
#include "tests/support/process.h"
#include "tests/support/small_run.h"
#include "tests/support/text.h"

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
    for (const std::string& line : lines_of(rule)) indented += "    " + line + "\n";
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
    for (const std::string& line : lines_of(read_file(folder.path("heard")))) {
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

// The dead-man's process as its sequencer sees it: it is served in a thread here, and each message, what it does about
// it and what it writes down is compared.

namespace {

constexpr std::chrono::seconds kPatientWithIt{20};

// Served over one end of a channel; the test speaks at the other.
class ServedDeadMan {
 public:
  ServedDeadMan() {
    const auto [ours, theirs] = devices::DescriptorChannel::make_pair();
    channel = std::make_unique<devices::DescriptorChannel>(ours);
    thread_ = std::thread([this, socket = theirs] {
      code_ = bench::serve_dead_man(socket);
      scheduled_ = ::sched_getscheduler(0);
    });
  }
  ~ServedDeadMan() {
    channel.reset();
    if (thread_.joinable()) thread_.join();
  }
  ServedDeadMan(const ServedDeadMan&) = delete;
  ServedDeadMan& operator=(const ServedDeadMan&) = delete;
  void describe(const bench::BenchConfig& config) const {
    channel->send(nlohmann::json{{"name", config.file}, {"bench", config.resolved}}.dump());
  }
  // Its next message; descriptors that come with it are closed.
  std::string heard(bool* with_descriptor = nullptr) const {
    const auto packet = channel->receive(kPatientWithIt);
    if (!packet) return channel->closed() ? "(closed)" : "(nothing)";
    if (with_descriptor != nullptr) *with_descriptor = packet->descriptor >= 0;
    if (packet->descriptor >= 0) ::close(packet->descriptor);
    return packet->text;
  }
  int exit_code() {
    thread_.join();
    return code_;
  }
  // SCHED_RR or another policy of sched(7), once it has ended.
  [[nodiscard]] int scheduled() const { return scheduled_; }
  std::unique_ptr<devices::DescriptorChannel> channel;

 private:
  std::thread thread_;
  std::atomic<int> code_{-1}, scheduled_{-1};
};

nlohmann::ordered_json record_by(const bench::BenchConfig& config) {
  auto json = nlohmann::ordered_json::parse(read_file(bench::TripFile(config.id).dead_man_path()));
  for (const char* key : {"pressure_s", "stage_s"}) {
    CHECK(json.at(key).get<double>() >= 0.0);
    CHECK(json.at(key).get<double>() < 20.0);
    json.erase(key);
  }
  CHECK(json.at("utc").get<std::string>().size() == 20);
  json.erase("utc");
  return json;
}

// Nothing that this test does takes as long as the dead-man waits.
const std::vector<sequences::Override> kSlow = {{"dead_man.timeout_ms", "5000"}};

}  // namespace

TEST_CASE("dead-man server: reports ready, is fed, hands over a line, fires on command, and records all of it") {
  HostedRig hosted(kSlow);
  const bench::BenchConfig config = hosted.client();
  std::string printed;
  {
    Captured errors(stderr);
    ServedDeadMan dead_man;
    dead_man.describe(config);
    CHECK(dead_man.heard() == "ready");
    for (int i = 0; i < 3; ++i) {
      dead_man.channel->send("feed");
      CHECK(dead_man.heard() == "fed");
    }
    dead_man.channel->send("run 17");
    dead_man.channel->send("something else");
    bool with_descriptor = false;
    dead_man.channel->send("line");
    CHECK(dead_man.heard(&with_descriptor) == "line");
    CHECK(with_descriptor);
    dead_man.channel->send("fire");
    CHECK(dead_man.heard() == "fired");
    CHECK(dead_man.heard().starts_with(bench::kDidPrefix));
    CHECK(dead_man.exit_code() == 7);
    CHECK(dead_man.heard() == "(closed)");
    printed = errors.text();
  }
  const nlohmann::ordered_json record = record_by(config);
  CHECK(record.at("why") == "commanded");
  CHECK(record.at("run") == 17);
  CHECK(record.at("ended") == "NOT verified");
  CHECK(record.at("tripped") == true);
  CHECK(record.size() == 6);
  const std::string pressure = record.at("pressure"), stage = record.at("stage");
  CHECK_THAT(pressure, Catch::Contains("verified") && Catch::Contains(" psi"));
  CHECK_FALSE(stage.empty());
  const auto trip = bench::TripFile(config.id).read();
  REQUIRE(trip);
  CHECK(trip->id == "TB-DEADMAN-FIRED");
  CHECK(trip->run == 17);
  // A person and the trip are told the same.
  for (const std::string& part : {std::string("commanded"), pressure, stage}) {
    CHECK(trip->what.find(part) != std::string::npos);
    CHECK(printed.find(part) != std::string::npos);
  }
  CHECK(printed.find(config.id) != std::string::npos);
}

TEST_CASE("dead-man server: a sequencer that ends or is silent leaves a record, a silent one also a trip") {
  const bool silent = GENERATE(false, true);
  HostedRig hosted(silent ? std::vector<sequences::Override>{{"dead_man.timeout_ms", "250"}} : kSlow);
  const bench::BenchConfig config = hosted.client();
  const Captured errors(stderr);
  ServedDeadMan dead_man;
  dead_man.describe(config);
  CHECK(dead_man.heard() == "ready");
  if (silent) {
    const auto begun = std::chrono::steady_clock::now();
    CHECK(dead_man.heard() == "fired");
    CHECK(std::chrono::steady_clock::now() - begun > std::chrono::milliseconds(200));
  } else {
    dead_man.channel.reset();
  }
  CHECK(dead_man.exit_code() == 0);
  const nlohmann::ordered_json record = record_by(config);
  const std::string why = record.at("why");
  CHECK(why != "commanded");
  CHECK((why.find("250 ms") != std::string::npos) == silent);
  CHECK(record.at("run") == 0);
  CHECK(record.at("ended") == "safe, verified");
  CHECK(record.at("tripped") == silent);
  CHECK(bench::TripFile(config.id).read().has_value() == silent);
}

TEST_CASE("dead-man server: has real-time priority if permitted, and ends on goodbye without any action") {
  int allowed = SCHED_OTHER;
  std::thread([&] {
    const sched_param lowest{.sched_priority = 1};
    if (::sched_setscheduler(0, SCHED_RR, &lowest) == 0) allowed = SCHED_RR;
  }).join();
  HostedRig hosted(kSlow);
  const bench::BenchConfig config = hosted.client();
  ServedDeadMan dead_man;
  dead_man.describe(config);
  CHECK(dead_man.heard() == "ready");
  dead_man.channel->send("goodbye");
  CHECK(dead_man.exit_code() == 0);
  CHECK(dead_man.scheduled() == allowed);
  CHECK_FALSE(std::filesystem::exists(bench::TripFile(config.id).dead_man_path()));
  CHECK_FALSE(bench::TripFile(config.id).read());
}

TEST_CASE("dead-man server: without a bench or a module that responds it reports why and ends") {
  HostedRig hosted(kSlow);
  bench::BenchConfig config = hosted.client();
  {
    ServedDeadMan dead_man;
    dead_man.channel->send("{}");
    const std::string said = dead_man.heard();
    CHECK((said != "ready" && said.front() != '('));
    CHECK(dead_man.exit_code() == 3);
  }
  {
    ServedDeadMan dead_man;
    const std::string at = fmt::format("port = {}", config.module.endpoint.port);
    config.resolved.replace(config.resolved.find(at), at.size(), "port = 1");
    dead_man.describe(config);
    CHECK_THAT(dead_man.heard(), Catch::Contains("127.0.0.1:1"));
    CHECK(dead_man.exit_code() == 3);
  }
}
