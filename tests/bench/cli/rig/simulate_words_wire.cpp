// What `simulate` tells of the wires that it serves, and the bench file that it writes for its clients.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/cli/check_refusal.h"
#include "tests/support/process.h"

using namespace tactbench::tests;

namespace {

struct ServedOnce {
  explicit ServedOnce(const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {"simulate", "--for", "0.1", "--write-bench", "client.toml"};
    words.insert(words.end(), more.begin(), more.end());
    words.emplace_back("--json");
    const Finished finished = call(folder, words);
    REQUIRE(finished.code == 0);
    told = nlohmann::json::parse(finished.out);
    bench = read_file(folder.path("client.toml"));
  }
  // The place of the first wire whose name begins so.
  [[nodiscard]] std::string where(const std::string& what) const {
    for (const auto& one : told.at("served"))
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
  nlohmann::json told;
  std::string bench;
};

}  // namespace

TEST_CASE("simulate: each wire by its place, and the client's bench file") {
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

TEST_CASE("simulate: a frame source and a force sensor on a serial line are connected by their own addresses") {
  const ServedOnce served({"--set", "scanner.kind=\"frame-source\"", "--set", "force.kind=\"digital\""});
  CHECK(served.value("scanner", "kind") == "'frame-source'");
  CHECK(served.value("scanner", "address") == "'" + served.where("tactile scanner, frame-source") + "'");
  CHECK(served.value("scanner", "socket") == "none");
  CHECK(served.value("force", "kind") == "'digital'");
  CHECK(served.value("force", "port") == "'" + served.where("Nano17, Digital") + "'");
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
  check_members(told, R"({"schema": "tactbench.simulate", "rate": 1.0, "bench": ""})");
  REQUIRE(told.at("served").size() == 9);
  CHECK_THAT(told.at("served").at(5).at("where").get<std::string>(), Catch::StartsWith("/dev/"));
  const Finished hardware = call(folder, {"simulate", "--for", "0.1", "--bench", "paper-rig.example.toml"});
  CHECK(hardware.code == 2);
  CHECK(hardware.out.empty());
  CHECK_THAT(hardware.err, Catch::Contains("[TB-USAGE]") && Catch::Contains("\n  at: paper-rig.example.toml\n"));
  write_file(folder.path("other.txt"), "mine\n");
  CHECK(call(folder, {"simulate", "--for", "0.1", "--write-bench", "other.txt"}).code == 2);
  CHECK(read_file(folder.path("other.txt")) == "mine\n");
  CHECK(call(folder, {"simulate", "--for", "0.1", "--write-bench", "other.txt", "--replace"}).code == 0);
}
