// pause, resume, stop, abort, panic, status and watch: which of several runs they mean, and what is refused. The runs
// are of this process, and do nothing but answer.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/common/utc.h"
#include "bench/run/control/locks.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/db/store_example.h"
#include "tests/support/answering_run.h"
#include "tests/support/paths.h"
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
  [[nodiscard]] nlohmann::json printed(CommandWords words) const {
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

TEST_CASE("commands: one live run need not be named, a run or command that does not apply is refused by id") {
  const CommandsGiven of;
  of.refused({"stop"}, "TB-RUN-NOT-LIVE");
  const AnsweringRun live("live", 3, of.store("live.db"));
  of.refused({"resume", "3", "--db", "live.db"}, "TB-RUN-WORD");
  of.taken({"pause"});
  of.taken({"resume"});
  const auto printed = nlohmann::ordered_json::parse(of.give({"stop", "--json"}).out);
  CHECK(printed.at("schema") == "tactbench.stop");
  CHECK((printed.at("run") == 3 && printed.at("bench") == "live" && printed.at("store") == of.folder.path("live.db")));
  CHECK((printed.at("state") == "running" && printed.at("step") == 3 && printed.at("steps") == 40));
  of.taken({"stop", "--abort", "3"});
  of.taken({"panic", "--bench", "live"});
  of.refused({"pause", "4"}, "TB-RUN-NOT-LIVE");
}

TEST_CASE("resume: a run number alone does not resume a run of another store if this folder has a store") {
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

TEST_CASE("resume: a run of the store in this folder is resumed by its number") {
  const CommandsGiven of;
  const AnsweringRun live("live", 3, of.store("runs.db"));
  of.taken({"pause", "3"});
  of.taken({"resume", "3"});
}

TEST_CASE("commands: several live runs are ambiguous, and panic reaches every run that matches") {
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

TEST_CASE("panic: fails only if every run refuses it") {
  const CommandsGiven of;
  const AnsweringRun ended("a", 3, of.store("a.db"), bench::RunState::kEnded);
  {
    const AnsweringRun live("live", 3, of.store("live.db"));
    of.taken({"panic", "3"});  // the live one takes it
  }
  const AnsweringRun more("more", 3, of.store("more.db"), bench::RunState::kEnded);
  check_refusal(of.give({"panic", "3"}), 2, "TB-RUN-WORD");
}

TEST_CASE("commands: a bench that does not respond is named, and blocks a stop but not a panic") {
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

TEST_CASE("status: lists every live run, or only those of one run number, bench or store") {
  const CommandsGiven of;
  const AnsweringRun live("live", 3, of.store("live.db")), other("other", 4, of.store("other.db"));
  const Finished both = of.give({"status"});
  CHECK(both.code == 0);
  CHECK(both.err.empty());
  const auto only = [&](const std::vector<std::string>& words) {
    const nlohmann::json runs = of.printed(words).at("runs");
    REQUIRE(runs.size() == 1);
    return runs.at(0).at("run");
  };
  CHECK(only({"status", "3"}) == 3);
  CHECK(only({"status", "--bench", "other"}) == 4);
  CHECK(only({"status", "--db", "live.db"}) == 3);
  const nlohmann::json printed = of.printed({"status"});
  CHECK(printed.at("live") == true);
  REQUIRE(printed.at("runs").size() == 2);
  CHECK(printed.at("runs").at(1).at("run") == 4);
  CHECK(printed.at("silent").empty());
  CHECK(printed.at("last_run").is_null());
}

TEST_CASE("status: names a bench that does not respond") {
  const CommandsGiven of;
  const SilentRun silent("a-frozen", "/run/7");
  const nlohmann::json printed = of.printed({"status"});
  CHECK(printed.at("live") == false);
  REQUIRE(printed.at("silent").size() == 1);
  const nlohmann::json& one = printed.at("silent").at(0);
  CHECK((one.at("bench") == "a-frozen" && one.at("run") == 7 && one.at("process") == ::getpid()));
  const AnsweringRun live("live", 3, of.store("live.db"));
  CHECK(of.printed({"status"}).at("live") == true);
  {  // the last run of a store is shown next to a bench that does not answer
    db::RunStore store = db::RunStore::open(of.folder.path("runs.db"), db::Durability::kNormal);
    (void)store_example(store);
  }
  CHECK(of.printed({"status", "--db", "runs.db"}).at("last_run").at("run") == 1);
}

TEST_CASE("watch: shows how an ended run ended only if no silent run matches, a live run does not count as ended") {
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
  lock.lock_new_run(2);
  const Finished carried_out = of.give({"status", "--watch", "2"});
  CHECK(carried_out.code == 2);
  CHECK(carried_out.out.empty());
  CHECK_THAT(carried_out.err, Catch::Contains("[TB-RUN-NOT-LIVE]"));
}

TEST_CASE("status: without --db it reads the store of this folder") {
  const CommandsGiven of;
  check_refusal(of.give({"status", "9"}), 5, "TB-STORE-OPEN");
  CHECK(of.give({"status", "--db", "none.db"}).code == 5);
  {
    db::RunStore store = db::RunStore::open(of.folder.path("runs.db"), db::Durability::kNormal);
    (void)store_example(store);
  }
  CHECK(of.printed({"status"}).at("last_run").at("run") == 1);
  CHECK(of.printed({"status", "1"}).at("last_run").at("run") == 1);
}

// devices check, watch, reset and scan: dates of calibration on their very day, values that nobody filled in, what an
// instrument reads, and who resets.

TEST_CASE("devices check: a calibration is valid on its due date and overdue the next day") {
  const TemporaryFolder folder;
  const auto page_of = [&](const std::string& due) {
    return call(folder, {"devices", "check", "--bench", "simulated.toml", "--set", "reference.due=" + due}).out;
  };
  const auto today = [] { return bench::utc_now().substr(0, 10); };
  const auto overdue = [&](const std::string& due) { return page_of(due).find("OVERDUE") != std::string::npos; };
  std::string day;
  bool late = false;
  do {  // a day of UTC may turn meanwhile
    day = today();
    late = overdue(day);
  } while (day != today());
  CHECK_FALSE(late);
  CHECK(overdue(bench::utc_days_ago(1).substr(0, 10)));
}

TEST_CASE("devices check: warns about placeholders in the bench file, and reports a reference that is not at zero") {
  const TemporaryFolder folder;
  const Finished checked =
      call(folder, {"devices", "check", "--bench", "simulated.toml", "--set", "reference.certificate=\"FILL-IN\""});
  CHECK_THAT(checked.err, Catch::Contains("reference.certificate"));
  const auto document =
      nlohmann::ordered_json::parse(well(call(folder, {"devices", "check", "--bench", "simulated.toml", "--json",
                                                       "--set", "reference.span_psi=[5, 105]"}),
                                         3)
                                        .out);
  CHECK(document.at("schema") == "tactbench.devices.check");
  const auto& reference = document.at("devices").at(2);
  CHECK(reference.at("role") == "pressure reference");
  CHECK(reference.at("state") == "wrong");
  CHECK_FALSE(reference.at("reading").get<std::string>().empty());
  CHECK_FALSE(reference.at("notes").empty());
}

TEST_CASE("devices reset: needs the name of an operator") {
  const TemporaryFolder folder;
  check_refusal(call(folder, {"devices", "reset", "--bench", "simulated.toml", "--operator", " "}), 2, "TB-USAGE",
                "--operator");
}

TEST_CASE("live: prints pressures, forces and the array once per frame") {
  const TemporaryFolder folder;
  const Finished seen = call(folder, {"live", "--bench", "simulated.toml", "--frames", "2", "--interval", "0.05"});
  CHECK(seen.code == 0);
  for (const char* name : {"\nfeedback  ", "\nreference ", "\nforce     "}) {
    INFO(name << " in " << seen.out);
    const std::size_t first = seen.out.find(name);
    REQUIRE(first != std::string::npos);
    CHECK(seen.out.find(name, first + 1) != std::string::npos);
    // Pressures within 0.2 psi of 0, forces within 0.05 N.
    CHECK(std::abs(std::stod(seen.out.substr(first + 11))) < 0.2);
  }
  const auto printed =
      nlohmann::json::parse(call(folder, {"devices", "check", "--bench", "simulated.toml", "--json"}).out);
  CHECK(printed["bench"] == "simulated-rig");
  REQUIRE(printed["devices"].size() == 6);
  CHECK(printed["devices"][1]["role"] == "regulator");
  CHECK(printed["devices"][1]["state"] == "ok");
  CHECK(printed["devices"][4]["notes"].size() == 1);
}

TEST_CASE("devices scan: lists devices as JSON, including a host that does not respond") {
  const TemporaryFolder folder;
  CHECK(call(folder, {"devices", "scan"}).code == 0);
  const auto printed = nlohmann::json::parse(call(folder, {"devices", "scan", "--json"}).out);
  CHECK(printed.at("schema") == "tactbench.devices.scan");
  CHECK(printed.at("devices").is_array());
  // Nothing listens on this port, and the answer says so.
  const auto one = nlohmann::json::parse(call(folder, {"devices", "scan", "--modbus", "127.0.0.1:1", "--json"}).out);
  CHECK(std::ranges::any_of(one.at("devices"), [](const nlohmann::json& device) {
    return device.at("kind") == "Modbus TCP" && device.at("where") == "127.0.0.1:1";
  }));
}

// page: the address that it prints, as words and as JSON, and the port that it takes.

namespace {

// `page` with these words until it has announced itself.
Finished announced_page(const std::string& words, const char* announced_in = "out") {
  const TemporaryFolder folder;
  const std::string announcement = folder.path(announced_in);
  write_file(announcement, "");
  const auto printed = [&] {
    const std::string text = read_file(announcement);
    return text.ends_with("\n") && (!text.starts_with("{") || text.ends_with("\n}\n"));
  };
  Finished done =
      run_program("/bin/sh", {"-c", "exec '" + std::string(program_path()) + "' page " + words + " >out 2>err"},
                  folder.path(), {SIGTERM, printed});
  done.out = read_file(folder.path("out"));
  done.err = read_file(folder.path("err"));
  return done;
}

int port_in_page_link(const std::string& link) {
  const std::size_t at = link.find("127.0.0.1:");
  REQUIRE(at != std::string::npos);
  return std::stoi(link.substr(at + 10));
}

// Holds a port of this machine, unless somebody else does.
class HeldPort {
 public:
  explicit HeldPort(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    held_ =
        ::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 && ::listen(socket_, 1) == 0;
  }
  ~HeldPort() { ::close(socket_); }
  HeldPort(const HeldPort&) = delete;
  HeldPort& operator=(const HeldPort&) = delete;
  [[nodiscard]] bool held() const { return held_; }

 private:
  int socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  bool held_ = false;
};

}  // namespace

TEST_CASE("page: prints its address on a free port, with separate links for readers and operators, and as JSON") {
  const Finished reads = announced_page("--port 0");
  CHECK(reads.err.empty());
  const std::string secrets = reads.out.substr(reads.out.find('#') + 1);
  CHECK(secrets.find('.') == std::string::npos);
  const Finished commands = announced_page("--port 0 --operator bob");
  CHECK_THAT(commands.out.substr(commands.out.find('#')), Catch::Contains("."));
  const nlohmann::json printed = nlohmann::json::parse(announced_page("--port 0 --operator bob --json").out);
  CHECK(printed.at("schema") == "tactbench.page");
  CHECK(printed.at("operator") == "bob");
  const std::string link = printed.at("link"), readers = printed.at("readers_link");
  CHECK(printed.at("port") == port_in_page_link(link));
  CHECK(printed.at("port") != 0);
  CHECK(link.starts_with(readers + "."));
  CHECK(nlohmann::json::parse(announced_page("--port 0 --json").out).at("operator") == "");
}

TEST_CASE("page: next to a run it prints its address to standard error only") {
  const Finished next_to_run = announced_page("--port 0 --run-process " + std::to_string(::getpid()), "err");
  CHECK(next_to_run.out.empty());
}

TEST_CASE("page: if the default port is in use it takes another one, an explicit port in use is rejected") {
  const HeldPort usual(8765);
  if (!usual.held()) return;  // somebody else has it
  const Finished other = announced_page("");
  CHECK(port_in_page_link(other.out) != 8765);
  const TemporaryFolder folder;
  const Finished refused = call(folder, {"page", "--port", "8765"});
  CHECK(refused.code == 2);
  CHECK(refused.out.empty());
  CHECK_THAT(refused.err, Catch::Contains("[TB-PAGE-ADDRESS]") && Catch::Contains("8765"));
  CHECK(call(folder, {"page", "--listen", "192.0.2.1", "--tls", "none.pem", "none.key"}).code == 2);
}

// Output of `simulate` about the connections that it serves, and the bench file that it writes for its clients.

namespace {

struct ServedOnce {
  explicit ServedOnce(const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {"simulate", "--for", "0.1", "--write-bench", "client.toml"};
    words.insert(words.end(), more.begin(), more.end());
    words.emplace_back("--json");
    const Finished finished = call(folder, words);
    REQUIRE(finished.code == 0);
    printed = nlohmann::json::parse(finished.out);
    bench = read_file(folder.path("client.toml"));
  }
  // The place of the first wire whose name begins so.
  [[nodiscard]] std::string where(const std::string& what) const {
    for (const auto& one : printed.at("served"))
      if (one.at("what").get<std::string>().starts_with(what)) return one.at("where");
    return "none";
  }
  // The text behind the key in its table; "none" where there is no such key.
  [[nodiscard]] std::string value(const std::string& table, const std::string& key) const {
    const std::size_t head = bench.find("\n[" + table + "]\n");
    if (head == std::string::npos) return "none";
    const std::size_t end = bench.find("\n[", head + 1), at = bench.find("\n" + key + " = ", head);
    if (at == std::string::npos || at > end) return "none";
    const std::size_t from = at + key.size() + 4;
    return bench.substr(from, bench.find('\n', from) - from);
  }
  TemporaryFolder folder;
  nlohmann::json printed;
  std::string bench;
};

}  // namespace

TEST_CASE("simulate: prints the address of each wire, and writes the bench file of the client") {
  const ServedOnce served({"--rate", "2.5"});
  CHECK(served.value("simulation", "seed") == "none");
  CHECK(served.bench.find("[simulation") == std::string::npos);
  CHECK(served.value("bench", "simulator") == "'external'");
  CHECK(served.value("bench", "rate") == "2.5");
  CHECK(served.value("bench", "origin") == "'simulated'");
  CHECK(served.value("module", "host") == "'127.0.0.1'");
  CHECK(served.where("pressure").find("127.0.0.1:" + served.value("module", "port") + ",") != std::string::npos);
  CHECK(served.value("scanner", "socket") == "'" + served.where("tactile scanner") + "'");
  CHECK(served.value("stage", "port") == "'" + served.where("stage") + "'");
  CHECK(served.where("Nano17, Net F/T").ends_with("127.0.0.1:" + served.value("force", "port")));
  CHECK(served.where("Nano17, its calibration") ==
        "http://127.0.0.1:" + served.value("force", "http_port") + "/netftapi2.xml");
  CHECK(served.value("scanner", "address") == "none");
  CHECK(served.value("force", "host") == "'127.0.0.1'");
}

TEST_CASE("simulate: a frame source and a serial force sensor get their own addresses") {
  const ServedOnce served({"--set", "scanner.kind=\"frame-source\"", "--set", "force.kind=\"digital\""});
  CHECK(served.value("scanner", "kind") == "'frame-source'");
  CHECK(served.value("scanner", "address") == "'" + served.where("tactile scanner, frame-source") + "'");
  CHECK(served.value("scanner", "socket") == "none");
  CHECK(served.value("force", "kind") == "'digital'");
  CHECK(served.value("force", "port") == "'" + served.where("Nano17, Digital") + "'");
  CHECK(served.value("force", "host") == "none");
  CHECK(served.value("force", "http_port") == "none");
}

TEST_CASE("simulate: serves modules on a serial line, for a bench without stage and force sensor") {
  const TemporaryFolder folder;
  write_file(folder.path("rtu.toml"),
             "schema = 1\n[bench]\nid = \"b\"\norigin = \"simulated\"\n[module]\nprofile = "
             "\"waveshare-analog-output-8ch-b\"\ntransport = \"rtu\"\n[input_module]\nprofile = "
             "\"waveshare-analog-input-8ch-b\"\nunit = 2\n"
             "[regulator]\nserial = \"R\"\n[reference]\nmodel = \"m\"\nserial = \"s\"\n");
  const ServedOnce served({"--bench", folder.path("rtu.toml")});
  const std::string port = served.value("module", "serial_port");
  CHECK_THAT(served.where("pressure"), Catch::Contains(port.substr(1, port.size() - 2)));
  CHECK(served.value("module", "host") == "none");
  CHECK(served.value("module", "port") == "none");
  CHECK(served.value("stage", "port") == "none");
  CHECK(served.value("force", "port") == "none");
}

TEST_CASE("simulate: a serial pressure controller is connected by its terminal, and offered on every bench") {
  const ServedOnce served({"--bench", "simulated-serial.toml"});
  CHECK(served.value("regulator", "kind") == "'serial'");
  CHECK(served.value("regulator", "port") == "'" + served.where("pressure controller") + "'");
  CHECK(served.value("module", "port") == "none");
  const std::string gauge = served.where("pressure and environment");  // "Modbus TCP 127.0.0.1:40001, unit 5: ..."
  const std::size_t port = gauge.find(':') + 1;
  CHECK_THAT(served.bench, Catch::Contains("port = " + gauge.substr(port, gauge.find(',') - port) + "\n"));
  const ServedOnce usual;
  CHECK(usual.where("pressure controller").starts_with("/dev/pts/"));
  CHECK(usual.value("regulator", "port") == "none");
}

TEST_CASE("simulate: a bench file without a host gets the host that is served") {
  const TemporaryFolder folder;
  write_file(folder.path("least.toml"),
             "schema = 1\n[bench]\nid = \"b\"\norigin = \"simulated\"\n[module]\nprofile = \"beckhoff-ek9000\"\n"
             "[regulator]\nserial = \"R\"\n[reference]\nmodel = \"m\"\nserial = \"s\"\n");
  const ServedOnce served({"--bench", folder.path("least.toml"), "--set", "settling.band_psi=0.5"});
  CHECK(served.value("module", "host") == "'127.0.0.1'");
  CHECK(served.value("settling", "band_psi") == "0.5");
}

TEST_CASE("simulate: works with --json and without a bench file, and rejects a hardware bench") {
  const TemporaryFolder folder;
  const auto printed = nlohmann::ordered_json::parse(call(folder, {"simulate", "--for", "0.1", "--json"}).out);
  check_members(printed, R"({"schema": "tactbench.simulate", "rate": 1.0, "bench": ""})");
  REQUIRE(printed.at("served").size() == 9);
  CHECK_THAT(printed.at("served").at(5).at("where").get<std::string>(), Catch::StartsWith("/dev/"));
  const Finished hardware = call(folder, {"simulate", "--for", "0.1", "--bench", "paper-rig.example.toml"});
  CHECK(hardware.code == 2);
  CHECK(hardware.out.empty());
  CHECK_THAT(hardware.err, Catch::Contains("[TB-USAGE]") && Catch::Contains("\n  at: paper-rig.example.toml\n"));
  write_file(folder.path("other.txt"), "mine\n");
  CHECK(call(folder, {"simulate", "--for", "0.1", "--write-bench", "other.txt"}).code == 2);
  CHECK(read_file(folder.path("other.txt")) == "mine\n");
  CHECK(call(folder, {"simulate", "--for", "0.1", "--write-bench", "other.txt", "--replace"}).code == 0);
}
