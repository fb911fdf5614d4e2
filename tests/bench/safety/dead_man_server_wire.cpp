// The dead-man's process as its sequencer sees it: it is served in a thread here, and each message, what it does about
// it and what it writes down is compared.
#include "bench/safety/dead_man_server.h"

#include <fmt/format.h>
#include <sched.h>
#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <thread>

#include "bench/guard/dead_man_process.h"
#include "bench/guard/trip.h"
#include "devices/wire/descriptor_channel.h"
#include "tests/bench/cli/verb_here.h"
#include "tests/support/hosted_rig.h"

using namespace tactbench;
using namespace tactbench::tests;

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
