// Conformance to the frame-source protocol (devices/tactile/frame_protocol.md), tested over the wire on the simulated
// source, on the reference server, and on a laboratory's own:
//   TACTBENCH_FRAME_SOURCE=tcp:HOST:PORT build/tests/test_devices_wire "[laboratory]"

#include <catch2/catch.hpp>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <thread>

#include "devices/tactile/frame_source.h"
#include "devices/tactile/simulated_frame_source.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/tactile/frame_client.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"
#include "tests/support/child_process.h"
#include "tests/support/paths.h"

using namespace std::chrono_literals;
using namespace tactbench::devices::frame_protocol;
using namespace tactbench::devices;

using Packed = std::vector<std::uint8_t>;

namespace {

// A request of any type and payload, correctly packed.
std::vector<std::uint8_t> packed(std::uint8_t type, std::uint16_t tag, std::size_t payload) {
  auto bytes = encode({tag, Scan{}});
  bytes.resize(kHeaderBytes);
  bytes[4] = type;
  bytes[8] = static_cast<std::uint8_t>(payload);
  bytes.resize(kHeaderBytes + payload, 0x5A);
  const std::uint32_t crc = crc32(bytes);
  for (unsigned i = 0; i < 4; ++i) bytes.push_back(static_cast<std::uint8_t>(crc >> (8 * i) & 0xFFU));
  return bytes;
}

void check_answers(const std::string& address) {
  FrameClient client(address);
  client.send(7, Identify{});
  const auto description = client.expect<Description>(7);
  CHECK(description.version == kVersion);

  client.send(8, Scan{});
  const auto first = client.expect<Frame>(8);
  CHECK(first.rows == description.rows);
  CHECK(first.columns == description.columns);
  client.send(65535, Scan{});
  const auto second = client.expect<Frame>(65535);
  CHECK(second.counter == first.counter + 1);
  CHECK(second.device_time_us >= first.device_time_us);

  // Several requests at once are answered in order, and one that comes in pieces is answered too.
  auto bytes = encode({9, Scan{}});
  for (const Message& message : {Message{10, Scan{}}, Message{11, Identify{}}}) {
    const auto more = encode(message);
    bytes.insert(bytes.end(), more.begin(), more.end());
  }
  client.send_bytes({bytes.begin(), bytes.begin() + 5});
  client.send_bytes({bytes.begin() + 5, bytes.end()});
  CHECK(client.expect<Frame>(9).counter == second.counter + 1);
  CHECK(client.expect<Frame>(10).counter == second.counter + 2);
  CHECK(client.expect<Description>(11) == description);
  for (const std::uint8_t byte : encode({12, Scan{}})) {
    client.send_bytes({byte});
    std::this_thread::sleep_for(2ms);
  }
  CHECK(client.expect<Frame>(12).counter == second.counter + 3);
}

void check_refusals(const std::string& address) {
  FrameClient client(address);
  client.send_bytes(packed(0x55, 3, 0));
  CHECK(client.expect<Error>(3).code == ErrorCode::kUnknownType);
  client.send_bytes(packed(0x55, 4, 40));
  CHECK(client.expect<Error>(4).code == ErrorCode::kUnknownType);
  client.send_bytes(packed(0x81, 5, 0));  // an answer is no request
  CHECK(client.expect<Error>(5).code == ErrorCode::kUnknownType);
  for (const std::uint8_t type : {std::uint8_t{2}, std::uint8_t{3}, std::uint8_t{4}}) {
    client.send_bytes(packed(type, 6, 1));
    CHECK(client.expect<Error>(6).code == ErrorCode::kBadPayload);
  }
  for (const std::size_t size : {0U, 1U, 3U}) {
    client.send_bytes(packed(0x01, 7, size));
    CHECK(client.expect<Error>(7).code == ErrorCode::kBadPayload);
  }
  client.send(8, Scan{});
  (void)client.expect<Frame>(8);
}

void check_damage(const std::string& address) {
  for (const std::size_t at : {0U, 5U, 6U, 10U, 11U, 15U}) {  // magic, reserved, tag, length twice, CRC
    INFO("byte " << at);
    FrameClient client(address);
    auto bytes = encode({3, Scan{}});
    bytes[at] ^= 0x40U;
    client.send_bytes(bytes);
    client.expect_close();
  }
  {
    FrameClient client(address);
    client.send_bytes({'T', 'B'});  // hangs up in the middle of a request
  }
  FrameClient client(address);  // and the next connection is served as new
  client.send(1, Scan{});
  (void)client.expect<Frame>(1);
}

void check_subscription(const std::string& address) {
  FrameClient client(address);
  client.send(20, Subscribe{});
  auto frame = client.expect<Frame>(20);
  for (int i = 0; i < 3; ++i) {
    const auto next = client.expect<Frame>(20);
    CHECK(next.counter != frame.counter);
    frame = next;
  }
  client.send(21, Scan{});  // requested in between
  client.send(22, Unsubscribe{});
  bool scanned = false;
  for (auto message = client.next();; message = client.next()) {
    REQUIRE(message);
    if (message->tag == 22) {
      CHECK(std::holds_alternative<Done>(message->body));
      break;
    }
    CHECK(std::holds_alternative<Frame>(message->body));
    CHECK((message->tag == 20 || message->tag == 21));
    scanned = scanned || message->tag == 21;
  }
  CHECK(scanned);
  for (std::uint16_t tag = 100; tag < 130; ++tag) {
    client.send(tag, Scan{});
    (void)client.expect<Frame>(tag);  // nothing of the subscription in between
  }
  client.send(24, Unsubscribe{});
  (void)client.expect<Done>(24);
}

void check_driver(const std::string& address) {
  FrameClient client(address);
  client.send(1, Identify{});
  const auto description = client.expect<Description>(1);
  ManualClock clock;
  FrameSourceOptions options;
  options.address = address;
  options.expected_serial = description.serial;
  options.rows = description.rows;
  options.columns = description.columns;
  options.frame_timeout = kPatient;
  for (int connection = 0; connection < 2; ++connection) {
    FrameSource source(options, clock);
    const auto set = source.read(3);
    CHECK(set.counts.size() == std::size_t{3} * description.rows * description.columns);
    REQUIRE(set.frame_counters.size() == 3);
    CHECK(set.frame_counters[2] - set.frame_counters[0] == 2);
    CHECK(source.identity().model == description.model);
    CHECK(source.volts_per_count().value() == description.volts_per_count);
  }
}

void check_source(const std::string& address) {
  check_answers(address);
  check_refusals(address);
  check_damage(address);
  check_subscription(address);
  check_driver(address);
}

}  // namespace

TEST_CASE("frame conformance: the simulated source follows the protocol") {
  const ManualClock clock;
  TestArray array;
  const SimulatedFrameSource source(
      {.description = {1, 16, 16, 1e-4, "simulated", "SIM-1", "1.0"}, .free_running_hz = 20'000}, array, clock);
  check_source("tcp:127.0.0.1:" + std::to_string(source.port()));
}

TEST_CASE("frame conformance: the reference server follows the protocol") {
  tactbench::tests::ChildProcess server(
      {"/usr/bin/python3", tactbench::tests::source_path("devices/tactile/frame_server.py"), "--port", "0"});
  const std::string line = server.line();
  REQUIRE(line.starts_with("listening on 127.0.0.1:"));
  check_source("tcp:" + line.substr(line.rfind(' ') + 1));
}

TEST_CASE("frame conformance: a laboratory's own source follows the protocol", "[.][laboratory]") {
  const char* address = std::getenv("TACTBENCH_FRAME_SOURCE");
  REQUIRE(address != nullptr);
  check_source(address);
}

// The simulated frame source by its messages: each field, each of its faults, and what it says to a wrong request.

namespace {

const Description kSmall{1, 2, 3, 0.25, "M", "S", "F"};

struct FrameSim {
  explicit FrameSim(SimulatedFrameSourceFaults faults = {})
      : server({.description = kSmall, .faults = std::move(faults)}, array, clock),
        address("tcp:127.0.0.1:" + std::to_string(server.port())) {}
  ManualClock clock;
  CountedArray array;
  SimulatedFrameSource server;
  std::string address;
};

// Scan number `scan` as frame number `counter`.
Frame frame_of(int scan, std::uint32_t counter) {
  Frame frame{0, counter, static_cast<std::uint8_t>(16 * scan + 1), 2, 3, {}};  // status of rows 0 and 1 together
  for (int i = 0; i < 6; ++i) frame.counts.push_back(static_cast<std::uint16_t>(100 * scan + i));
  return frame;
}

void expect_frame(FrameClient& client, std::uint16_t tag, int scan, std::uint32_t counter) {
  client.send(tag, Scan{});
  CHECK(client.expect<Frame>(tag) == frame_of(scan, counter));
}

// The next message answers the identity: nothing else was on its way.
void expect_description(FrameClient& client) {
  client.send(4242, Identify{});
  CHECK(client.expect<Description>(4242) == kSmall);
}

}  // namespace

TEST_CASE("simulated frame source: every field of every frame has its expected value") {
  FrameSim sim;
  FrameClient client(sim.address);
  expect_description(client);
  sim.clock.wait_until(70'999ns);
  for (int scan = 0; scan < 3; ++scan) {
    client.send(9, Scan{});
    Frame frame = frame_of(scan, static_cast<std::uint32_t>(scan));
    frame.device_time_us = scan < 2 ? 70 : 5'000'000'000;  // whole microseconds
    CHECK(client.expect<Frame>(9) == frame);
    if (scan == 1) sim.clock.wait_until(5000s);
  }
}

TEST_CASE("simulated frame source: response messages, damaged requests and failed scans get an error each") {
  FrameSim sim;
  FrameClient client(sim.address);
  const auto said = [&](const Packed& request, std::uint16_t tag) {
    client.send_bytes(request);
    return client.expect<Error>(tag).code;
  };
  for (const Body& answer : {Body{kSmall}, Body{frame_of(0, 0)}, Body{Done{}}, Body{Error{ErrorCode::kDevice, "x"}}})
    CHECK(said(encode({5, answer}), 5) == ErrorCode::kUnknownType);
  CHECK(sim.array.scans == 0);
  sim.array.broken_scan = 1;
  expect_frame(client, 1, 0, 0);
  CHECK(said(encode({2, Scan{}}), 2) == ErrorCode::kDevice);
  expect_frame(client, 3, 2, 1);
  FrameClient damaged(sim.address);
  Packed request = encode({3, Scan{}});
  request[15] ^= 1U;
  damaged.send_bytes(request);
  CHECK(damaged.expect<Error>(0).code == ErrorCode::kDamaged);
  CHECK_FALSE(damaged.next());
}

TEST_CASE("simulated frame source: each fault affects a single scan, the first or a later one, by number or injected") {
  using Faults = SimulatedFrameSourceFaults;
  for (const int at : {0, 1}) {
    const auto tag = static_cast<std::uint16_t>(70 + at);
    const auto counter = static_cast<std::uint32_t>(at);
    const auto ask = [&](FrameClient& client) {
      for (int scan = 0; scan < at; ++scan) expect_frame(client, 1, scan, static_cast<std::uint32_t>(scan));
      client.send(tag, Scan{});
    };
    for (const Faults& faults : {Faults{.corrupt_scan = at}, Faults{.inject = fault_at(at, InjectedFault::kCorrupt)}}) {
      FrameSim sim(faults);
      FrameClient client(sim.address);
      ask(client);
      Packed wrong = encode({tag, frame_of(at, counter)});
      REQUIRE(wrong.size() == 46);
      wrong[23] ^= 0x10U;
      CHECK(client.raw(46) == wrong);
      expect_frame(client, 2, at + 1, counter + 1);
    }
    for (const Faults& faults : {Faults{.cut_scan = at}, Faults{.inject = fault_at(at, InjectedFault::kTorn)}}) {
      FrameSim sim(faults);
      FrameClient client(sim.address);
      ask(client);
      const Packed whole = encode({tag, frame_of(at, counter)});
      CHECK(client.raw(46) == Packed(whole.begin(), whole.begin() + 23));
      FrameClient again(sim.address);
      expect_frame(again, 2, at + 1, counter + 1);
    }
    for (const bool dropped : {true, false}) {  // computed and not sent, or not even computed
      FrameSim sim(dropped ? Faults{.drop_scan = at} : Faults{.inject = fault_at(at, InjectedFault::kSilent)});
      FrameClient client(sim.address);
      ask(client);
      expect_frame(client, 2, dropped ? at + 1 : at, dropped ? counter + 1 : counter);
    }
    {
      FrameSim sim({.double_scan = at});
      FrameClient client(sim.address);
      ask(client);
      for (int i = 0; i < 2; ++i) CHECK(client.expect<Frame>(tag) == frame_of(at, counter));
      expect_frame(client, 2, at + 1, counter + 1);
    }
    FrameSim sim({.silent_after_scans = at});
    FrameClient client(sim.address);
    ask(client);
    client.send(2, Scan{});
    expect_description(client);
    CHECK(sim.array.scans == at);
  }
  for (const Faults& faults : {Faults{.repeat_scan = 1}, Faults{.inject = fault_at(1, InjectedFault::kStale)}}) {
    FrameSim sim(faults);
    FrameClient client(sim.address);
    expect_frame(client, 1, 0, 0);
    expect_frame(client, 2, 0, 0);
    expect_frame(client, 3, 1, 1);
  }
  FrameSim sim({.inject = fault_at(1, InjectedFault::kUnplugged)});
  FrameClient client(sim.address), other(sim.address);
  expect_frame(client, 1, 0, 0);
  client.send(2, Scan{});
  CHECK_FALSE(client.next());
  expect_frame(other, 3, 1, 1);
}

TEST_CASE("simulated frame source: a fault of the second of two pipelined scans leaves the first intact") {
  Packed requests = encode({1, Scan{}});
  const Packed second = encode({2, Scan{}});
  requests.insert(requests.end(), second.begin(), second.end());
  Packed both = encode({1, frame_of(0, 0)});
  const Packed later = encode({2, frame_of(1, 1)});
  both.insert(both.end(), later.begin(), later.end());
  {
    FrameSim sim({.corrupt_scan = 1});
    FrameClient client(sim.address);
    client.send_bytes(requests);
    Packed wrong = both;
    wrong[46 + 23] ^= 0x10U;
    CHECK(client.raw(92) == wrong);
  }
  FrameSim sim({.cut_scan = 1});
  FrameClient client(sim.address);
  client.send_bytes(requests);
  CHECK(client.raw(92) == Packed(both.begin(), both.begin() + 46 + 23));
}

TEST_CASE("simulated frame source: accepts only rates above 0 up to 100 kHz and valid descriptions") {
  ManualClock clock;
  CountedArray array;
  const auto opened = [&](double rate) {
    return fault_id_of([&] { SimulatedFrameSource({.description = kSmall, .free_running_hz = rate}, array, clock); });
  };
  for (const double rate : {0.001, 0.5, 1e5}) CHECK(opened(rate) == "none");
  for (const double rate :
       {0.0, -1.0, std::nextafter(1e5, 1e6), std::nan(""), std::numeric_limits<double>::infinity()}) {
    CHECK(opened(rate) == "TB-SIM-LISTEN");
  }
  CHECK_THROWS_AS(SimulatedFrameSource({.description = {1, 0, 3, 0.25, "", "", ""}}, array, clock),
                  std::invalid_argument);
}
