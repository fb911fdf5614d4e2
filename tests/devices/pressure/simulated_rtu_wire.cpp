// The simulated module's serial line: requests of every length, in pieces, damaged, for other units, and its faults.
#include <catch2/catch.hpp>

#include "devices/pressure/simulated_module.h"
#include "tests/devices/pressure/next_fault.h"
#include "tests/devices/pressure/raw_clients.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

using RawBytes = RawLine::Bytes;

const RawBytes kReadTime{1, 3, 0x11, 0x20, 0, 1}, kTime{1, 3, 2, 0x03, 0xE8};

struct SimulatedLine {
  explicit SimulatedLine(const SimulatedModuleFaults& faults = {})
      : server({{1, module_profile("beckhoff-ek9000"), {}}, {7, module_profile("generic"), {}}},
               SimulatedModule::Wire::kRtu, 0, chamber, clock, faults) {}
  void ask(const RawBytes& body) const { client.send(rtu_frame(body)); }
  // Whether this answer, with its check sum, comes.
  [[nodiscard]] bool answers(const RawBytes& body) const {
    const RawBytes frame = rtu_frame(body);
    return client.receive(frame.size()) == frame;
  }
  [[nodiscard]] bool answers(const RawBytes& request, const RawBytes& body) const {
    ask(request);
    return answers(body);
  }
  // After a silence what came is noise. A machine that holds the line up may not notice the first silence.
  [[nodiscard]] bool answers_after_a_silence() const {
    for (int i = 0; i < 40; ++i) {
      if (!client.receive(1, 300).empty()) return false;
      ask(kReadTime);
      if (client.receive(7, 1000) == rtu_frame(kTime)) return true;
    }
    return false;
  }
  ManualClock clock;
  TestChamber chamber{clock};
  SimulatedModule server;
  RawLine client{server.serial_port()};
};

}  // namespace

TEST_CASE("simulated RTU line: requests of each function code are read by their own length") {
  const SimulatedLine line;
  CHECK(line.server.port() == 0);
  REQUIRE(line.answers(kReadTime, kTime));
  REQUIRE(line.answers({1, 16, 0x08, 0x00, 0, 1, 2, 0x10, 0x00}, {1, 16, 0x08, 0x00, 0, 1}));
  REQUIRE(line.answers({1, 16, 0x11, 0x22, 0, 2, 4, 0, 2, 0, 1}, {1, 16, 0x11, 0x22, 0, 2}));
  REQUIRE(line.answers({1, 23, 0x11, 0x22, 0, 2, 0x08, 0x00, 0, 1, 2, 0x20, 0x00}, {1, 23, 4, 0, 2, 0, 1}));
  REQUIRE(line.answers({1, 6, 0x11, 0x24, 0, 0}, {1, 6, 0x11, 0x24, 0, 0}));
  REQUIRE(line.answers({1, 23, 0x08, 0x00, 0, 1, 0x11, 0x22, 0, 2, 4, 0, 1, 0, 0}, {1, 23, 2, 0x20, 0x00}));
  REQUIRE(line.answers({1, 4, 0, 0, 0, 1}, {1, 4, 2, 0x20, 0x00}));
  CHECK(line.chamber.output().value() == Approx(10.0 * 0x2000 / 0x7FFF));
}

TEST_CASE("simulated RTU line: each unit answers its own requests, and other unit numbers get no answer") {
  const SimulatedLine line;
  REQUIRE(line.answers({7, 6, 0, 0, 0x01, 0x23}, {7, 6, 0, 0, 0x01, 0x23}));
  REQUIRE(line.answers({7, 3, 0, 0, 0, 1}, {7, 3, 2, 0x01, 0x23}));
  REQUIRE(line.answers({7, 3, 0x11, 0x20, 0, 1}, {7, 0x83, 2}));
  for (const std::uint8_t unit : RawBytes{0, 2, 6, 8}) {
    line.ask({unit, 3, 0, 0, 0, 1});
    CHECK(line.client.is_silent());
  }
  REQUIRE(line.answers(kReadTime, kTime));
}

TEST_CASE("simulated RTU line: accepts a request byte by byte, several at once, and drops one that breaks off") {
  const SimulatedLine line;
  for (const std::uint8_t byte : rtu_frame(kReadTime)) line.client.send({byte});
  REQUIRE(line.answers(kTime));
  for (const std::uint8_t byte : rtu_frame(RawBytes{1, 16, 0x08, 0x00, 0, 1, 2, 0x10, 0x00})) line.client.send({byte});
  REQUIRE(line.answers({1, 16, 0x08, 0x00, 0, 1}));
  for (const std::uint8_t byte : rtu_frame(RawBytes{1, 23, 0x11, 0x20, 0, 1, 0x08, 0x00, 0, 1, 2, 0x20, 0x00})) {
    line.client.send({byte});
  }
  REQUIRE(line.answers({1, 23, 2, 0x03, 0xE8}));
  RawBytes three;
  for (int i = 0; i < 3; ++i) {
    const RawBytes one = rtu_frame(kReadTime);
    three.insert(three.end(), one.begin(), one.end());
  }
  line.client.send(three);
  for (int i = 0; i < 3; ++i) REQUIRE(line.answers(kTime));
  line.client.send({1, 3, 0x11, 0x20});
  CHECK(line.answers_after_a_silence());
}

TEST_CASE("simulated RTU line: does not answer a request with a damaged byte, nor one that follows it at once") {
  const SimulatedLine line;
  for (const std::size_t damaged : {0, 2, 5, 6, 7}) {
    INFO("byte " << damaged);
    RawBytes bytes = rtu_frame(kReadTime);
    bytes[damaged] = static_cast<std::uint8_t>(bytes[damaged] ^ 4U);
    const RawBytes next = rtu_frame(kReadTime);
    bytes.insert(bytes.end(), next.begin(), next.end());
    line.client.send(bytes);
    REQUIRE(line.answers_after_a_silence());
  }
}

TEST_CASE("simulated RTU line: each injected fault has its specified effect on the answer") {
  SimulatedModuleFaults faults;
  NextFault next(faults);
  SimulatedLine line(faults);
  const auto asks = [&](InjectedFault fault) {
    next = fault;
    next.meets([&] { line.ask(kReadTime); });
  };
  asks(InjectedFault::kNone);
  REQUIRE(line.answers(kTime));
  for (const InjectedFault silent : {InjectedFault::kSilent, InjectedFault::kUnplugged}) {
    asks(silent);
    CHECK(line.client.is_silent());
  }
  asks(InjectedFault::kRefused);
  REQUIRE(line.answers({1, 0x83, 4}));
  asks(InjectedFault::kCorrupt);
  RawBytes corrupt = rtu_frame(kTime);
  corrupt[1] ^= 0x10U;
  CHECK(line.client.receive(corrupt.size()) == corrupt);
  asks(InjectedFault::kLate);
  CHECK(line.client.is_silent());
  asks(InjectedFault::kNone);
  REQUIRE(line.answers(kTime));
  REQUIRE(line.answers(kTime));
  CHECK(line.client.is_silent());
  const RawBytes reference{1, 4, 0, 1, 0, 1};
  REQUIRE(line.answers(reference, {1, 4, 2, 0, 0}));
  line.chamber.reference_volts = Volts(10.0);
  next = InjectedFault::kStale;
  REQUIRE(line.answers(reference, {1, 4, 2, 0, 0}));
  next = InjectedFault::kNone;
  REQUIRE(line.answers(reference, {1, 4, 2, 0x7F, 0xFF}));
}

TEST_CASE("simulated RTU line: stays silent or hangs up after the set number of requests to its units") {
  for (const long after : {0L, 1L, 2L}) {
    INFO(after << " requests");
    const SimulatedLine silent({.silent_after_requests = after});
    const SimulatedLine dead({.dead_after_requests = after});
    for (const SimulatedLine* line : {&silent, &dead}) {
      line->ask({9, 3, 0, 0, 0, 1});  // of no unit here: it does not count
      CHECK(line->client.is_silent());
      for (long i = 0; i < after; ++i) {
        line->ask(kReadTime);
        CHECK(line->answers(kTime));
      }
      line->ask(kReadTime);
    }
    CHECK(silent.client.is_silent());
    REQUIRE(dead.client.is_closed());
  }
}
