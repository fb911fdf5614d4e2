// Conformance to the frame-source protocol (devices/tactile/frame_protocol.md), tested over the wire on the simulated
// source, on the reference server, and on a laboratory's own:
//   TACTBENCH_FRAME_SOURCE=tcp:HOST:PORT build/tests/test_devices_wire "[laboratory]"
#include <catch2/catch.hpp>
#include <cstdlib>
#include <thread>

#include "devices/tactile/frame_source.h"
#include "devices/tactile/simulated_frame_source.h"
#include "tests/devices/tactile/frame_client.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"
#include "tests/support/child_process.h"
#include "tests/support/paths.h"

using namespace tactbench::devices;
using namespace tactbench::devices::frame_protocol;
using namespace std::chrono_literals;

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
