// What `simulate` prints of the wires that it serves, and the bench file that it writes for its clients.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/support/process.h"

using namespace tactbench::tests;

namespace {

struct ServedOnce {
  explicit ServedOnce(const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {"simulate", "--for", "0.1", "--write-bench", "client.toml"};
    words.insert(words.end(), more.begin(), more.end());
    finished = call(folder, words);
    REQUIRE(finished.code == 0);
    bench = read_file(folder.path("client.toml"));
  }
  // What is printed of the wire behind this name, up to a comma.
  [[nodiscard]] std::string where(const std::string& what) const {
    const std::string line = "\n  " + what + std::string(51 - what.size(), ' ');
    const std::size_t at = finished.out.find(line);
    REQUIRE(at != std::string::npos);
    return finished.out.substr(at + line.size(), finished.out.find_first_of(",\n", at + 60) - at - line.size());
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
  Finished finished;
  std::string bench;
};

std::string text_behind(const std::string& text, const std::string& mark) {
  return text.substr(text.find(mark) + mark.size());
}

}  // namespace

TEST_CASE("simulate: each wire by its name and place, how to connect, and the client's bench file") {
  const ServedOnce served({"--rate", "2.5"});
  CHECK_THAT(served.finished.out,
             Catch::StartsWith("simulated rig, process time at 2.5 x real time; simulated data only\n  pressure and "
                               "environment                           Modbus TCP 127.0.0.1:") &&
                 Catch::EndsWith("\nconnect:  tactbench devices check --bench client.toml\n"
                                 "          tactbench run descending --bench client.toml --sensor S --operator NAME\n"
                                 "Ctrl-C ends\n"));
  CHECK_THAT(served.bench,
             Catch::StartsWith("# Written by `tactbench simulate`: a client of that process, while it lives.\n"));
  CHECK(served.value("simulation", "seed") == "none");
  CHECK(served.bench.find("[simulation") == std::string::npos);
  CHECK(served.value("bench", "simulator") == "'external'");
  CHECK(served.value("bench", "rate") == "2.5");
  CHECK(served.value("bench", "origin") == "'simulated'");
  CHECK(served.value("module", "host") == "'127.0.0.1'");
  CHECK(served.value("module", "port") == text_behind(served.where("pressure and environment"), "127.0.0.1:"));
  CHECK(served.value("scanner", "socket") ==
        "'" + served.where("tactile scanner, HID reports over SOCK_SEQPACKET") + "'");
  CHECK(served.value("scanner", "address") == "none");
  CHECK(served.value("stage", "port") == "'" + served.where("stage, Zaber binary chain (firmware 5)") + "'");
  CHECK(served.value("force", "host") == "'127.0.0.1'");
  CHECK(served.value("force", "port") == text_behind(served.where("Nano17, Net F/T (RDT over UDP)"), "127.0.0.1:"));
  CHECK("http://127.0.0.1:" + served.value("force", "http_port") + "/netftapi2.xml" ==
        served.where("Nano17, its calibration page"));
}

TEST_CASE("simulate: a frame source and a force sensor on a serial line are connected by their own addresses") {
  const ServedOnce served({"--set", "scanner.kind=\"frame-source\"", "--set", "force.kind=\"digital\""});
  CHECK(served.value("scanner", "kind") == "'frame-source'");
  CHECK(served.value("scanner", "address") ==
        "'" + served.where("tactile scanner, frame-source protocol over TCP") + "'");
  CHECK(served.value("scanner", "socket") == "none");
  CHECK(served.value("force", "kind") == "'digital'");
  CHECK(served.value("force", "port") == "'" + served.where("Nano17, Digital F/T (RS-485)") + "'");
  CHECK(served.value("force", "host") == "none");
  CHECK(served.value("force", "http_port") == "none");
}

TEST_CASE("simulate: modules on a serial line, on a bench without stage and force sensor") {
  const TemporaryFolder folder;
  write_file(folder.path("rtu.toml"),
             "schema = 1\n[bench]\nid = \"b\"\norigin = \"simulated\"\n[module]\nprofile = "
             "\"waveshare-analog-output-8ch-b\"\ntransport = \"rtu\"\n[input_module]\nprofile = "
             "\"waveshare-analog-input-8ch-b\"\nunit = 2\n"
             "[regulator]\nserial = \"R\"\n[reference]\nmodel = \"m\"\nserial = \"s\"\n");
  const ServedOnce served({"--bench", folder.path("rtu.toml")});
  const std::string lines = served.finished.out;
  const std::size_t at = lines.find("Modbus RTU ") + 11;
  CHECK(served.value("module", "serial_port") == "'" + lines.substr(at, lines.find(',', at) - at) + "'");
  CHECK(served.value("module", "host") == "none");
  CHECK(served.value("module", "port") == "none");
  CHECK(served.value("stage", "port") == "none");
  CHECK(served.value("force", "port") == "none");
}

TEST_CASE("simulate: a bench file that names no host gets the one that is served") {
  const TemporaryFolder folder;
  write_file(folder.path("least.toml"),
             "schema = 1\n[bench]\nid = \"b\"\norigin = \"simulated\"\n[module]\nprofile = \"beckhoff-ek9000\"\n"
             "[regulator]\nserial = \"R\"\n[reference]\nmodel = \"m\"\nserial = \"s\"\n");
  const ServedOnce served({"--bench", folder.path("least.toml"), "--set", "settling.band_psi=0.5"});
  CHECK(served.value("module", "host") == "'127.0.0.1'");
  CHECK(served.value("settling", "band_psi") == "0.5");
}

TEST_CASE("simulate: as JSON, without a bench file, and what cannot be simulated") {
  const TemporaryFolder folder;
  const auto told = nlohmann::ordered_json::parse(call(folder, {"simulate", "--for", "0.1", "--json"}).out);
  CHECK(told.at("schema") == "tactbench.simulate");
  CHECK(told.at("rate") == 1.0);
  CHECK(told.at("bench") == "");
  REQUIRE(told.at("served").size() == 8);
  CHECK(told.at("served").at(4).at("what") == "stage, Zaber binary chain (firmware 5)");
  CHECK_THAT(told.at("served").at(4).at("where").get<std::string>(), Catch::StartsWith("/dev/"));
  CHECK_THAT(call(folder, {"simulate", "--for", "0.1"}).out,
             Catch::StartsWith("simulated rig, process time at 1 x real time") &&
                 Catch::EndsWith("\n--write-bench FILE writes a bench file that connects to these\nCtrl-C ends\n"));
  const Finished hardware = call(folder, {"simulate", "--for", "0.1", "--bench", "paper-rig.example.toml"});
  CHECK(hardware.code == 2);
  CHECK(hardware.out.empty());
  CHECK(hardware.err ==
        "error: only a simulated bench can be simulated [TB-USAGE]\n  at: paper-rig.example.toml\n  try: give a bench "
        "file with origin = \"simulated\", such as simulated.toml\n  state: no device was touched\n");
  write_file(folder.path("other.txt"), "mine\n");
  const Finished kept = call(folder, {"simulate", "--for", "0.1", "--write-bench", "other.txt"});
  CHECK(kept.code == 2);
  CHECK(read_file(folder.path("other.txt")) == "mine\n");
  CHECK(call(folder, {"simulate", "--for", "0.1", "--write-bench", "other.txt", "--replace"}).code == 0);
  CHECK_THAT(read_file(folder.path("other.txt")), Catch::StartsWith("# Written by `tactbench simulate`"));
}
