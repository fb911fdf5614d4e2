// Clients of the simulated frame source that subscribe, that are many, and that read late.
#include <catch2/catch.hpp>
#include <list>
#include <thread>

#include "devices/tactile/simulated_frame_source.h"
#include "tests/devices/tactile/counted_array.h"
#include "tests/devices/tactile/frame_client.h"

using namespace tactbench::devices;
using namespace tactbench::devices::frame_protocol;
using namespace std::chrono_literals;
using Steady = std::chrono::steady_clock;

namespace {

struct Running {
  explicit Running(double rate, std::uint16_t side = 2)
      : server({.description = {1, side, side, 0.25, "", "", ""}, .free_running_hz = rate}, array, clock),
        address("tcp:127.0.0.1:" + std::to_string(server.port())) {}
  ManualClock clock;
  CountedArray array;
  SimulatedFrameSource server;
  std::string address;
};

void check_whole(const Frame& frame, int scan) {
  for (std::size_t i = 0; i < frame.counts.size(); ++i) {
    if (frame.counts[i] != static_cast<std::uint16_t>(100 * scan + static_cast<int>(i))) FAIL("taxel " << i);
  }
}

}  // namespace

TEST_CASE("frame subscribers: each receives every frame under its own tag, until it unsubscribes") {
  const Running source(500.0);
  FrameClient first(source.address), second(source.address);
  first.send(11, Subscribe{});
  CHECK(first.expect<Frame>(11).counter == 0);
  second.send(22, Subscribe{});
  const auto begin = second.expect<Frame>(22).counter;
  for (std::uint32_t i = 1; i <= begin + 5; ++i) CHECK(first.expect<Frame>(11).counter == i);
  for (std::uint32_t i = 1; i <= 5; ++i) {
    const Frame frame = second.expect<Frame>(22);
    CHECK(frame.counter == begin + i);
    check_whole(frame, static_cast<int>(begin + i));
  }
  first.send(12, Unsubscribe{});
  for (auto message = first.next(); message->tag != 12; message = first.next()) REQUIRE(message->tag == 11);
  auto last = second.expect<Frame>(22).counter;
  for (int i = 0; i < 20; ++i) {
    const auto counter = second.expect<Frame>(22).counter;
    CHECK(counter == last + 1);
    last = counter;
  }
  first.send(13, Identify{});
  (void)first.expect<Description>(13);  // nothing of the subscription in between
  first.send(14, Subscribe{});
  first.send(15, Subscribe{});  // the newer tag counts
  bool newer = false;
  while (!newer) newer = first.next().value().tag == 15;
  (void)first.expect<Frame>(15);
}

TEST_CASE("frame subscribers: the first frame is sent at once, the others a period apart, for any number of clients") {
  const Running source(40.0);
  FrameClient first(source.address), second(source.address);
  const auto begin = Steady::now();
  first.send(1, Subscribe{});
  CHECK(first.expect<Frame>(1).counter == 0);
  second.send(2, Subscribe{});
  CHECK(second.expect<Frame>(2).counter >= 1);
  CHECK(Steady::now() - begin >= 25ms);
  while (first.expect<Frame>(1).counter < 4) {
  }
  CHECK(Steady::now() - begin >= 100ms);
  // On a busy machine one of many times three frames come within little more than three periods.
  const auto end = Steady::now() + kPatient;
  bool in_time = false;
  while (!in_time && Steady::now() < end) {
    FrameClient client(source.address);
    const auto asked = Steady::now();
    client.send(3, Subscribe{});
    for (int frame = 0; frame < 3; ++frame) (void)client.expect<Frame>(3);
    in_time = Steady::now() - asked < 85ms;
  }
  CHECK(in_time);
}

TEST_CASE("frame subscribers: the first subscriber is served at once") {
  const Running source(2.0);
  const auto end = Steady::now() + kPatient;
  bool at_once = false;
  while (!at_once && Steady::now() < end) {
    FrameClient client(source.address);
    const auto asked = Steady::now();
    client.send(3, Subscribe{});
    (void)client.expect<Frame>(3);
    at_once = Steady::now() - asked < 400ms;
    client.send(4, Unsubscribe{});
    (void)client.expect<Done>(4);
  }
  CHECK(at_once);
}

TEST_CASE("frame subscribers: a frame that the array fails to measure is skipped") {
  Running source(500.0);
  source.array.broken_scan = 1;
  FrameClient client(source.address);
  client.send(1, Subscribe{});
  for (const int scan : {0, 2, 3}) {
    const Frame frame = client.expect<Frame>(1);
    CHECK(frame.counter == static_cast<std::uint32_t>(scan == 0 ? 0 : scan - 1));
    check_whole(frame, scan);
  }
}

TEST_CASE("frame subscribers: sixteen clients are served, and the next one after one disconnects") {
  const Running source(100.0);
  std::list<FrameClient> clients;
  for (std::uint16_t i = 0; i < 16; ++i) {
    clients.emplace_back(source.address).send(i, Identify{});
    (void)clients.back().expect<Description>(i);
  }
  FrameClient waiting(source.address);
  waiting.send(99, Identify{});
  for (std::uint16_t i = 0; i < 3; ++i) {
    clients.front().send(i, Identify{});
    (void)clients.front().expect<Description>(i);
  }
  CHECK_FALSE(waiting.waits());
  clients.pop_back();
  (void)waiting.expect<Description>(99);
}

TEST_CASE("frame subscribers: a client that reads late receives all answers, whole and in order") {
  const Running source(100.0, 256);
  FrameClient client(source.address);
  for (std::uint16_t tag = 0; tag < 80; ++tag) client.send(tag, Scan{});  // 10 megabytes
  FrameClient other(source.address);
  other.send(5, Identify{});
  (void)other.expect<Description>(5);
  for (std::uint16_t tag = 0; tag < 80; ++tag) {
    const Frame frame = client.expect<Frame>(tag);
    CHECK(frame.counter == tag);
    check_whole(frame, tag);
  }
  client.send(200, Identify{});
  (void)client.expect<Description>(200);
}

TEST_CASE(
    "frame subscribers: a client that reads late misses frames, gets the others whole, and delays no other client") {
  const Running source(20'000.0, 256);
  FrameClient late(source.address), other(source.address);
  late.send(1, Subscribe{});
  const auto end = Steady::now() + kPatient;
  while (source.array.scans < 200 && Steady::now() < end) std::this_thread::yield();
  REQUIRE(source.array.scans >= 200);
  other.send(5, Identify{});
  (void)other.expect<Description>(5);
  bool missed = false;
  std::uint32_t expected = 0;
  for (int i = 0; i < 400 && !missed; ++i) {
    const Frame frame = late.expect<Frame>(1);
    check_whole(frame, static_cast<int>(frame.counter));
    missed = frame.counter != expected;
    expected = frame.counter + 1;
  }
  CHECK(missed);
}

TEST_CASE("frame subscribers: a client that disconnects during its stream frees its place") {
  const Running source(5000.0);
  FrameClient staying(source.address);
  staying.send(1, Subscribe{});
  for (int i = 0; i < 40; ++i) {
    FrameClient leaving(source.address);
    leaving.send(2, Subscribe{});
    (void)leaving.expect<Frame>(2);
  }
  auto last = staying.expect<Frame>(1).counter;
  for (int i = 0; i < 20; ++i) {
    const auto counter = staying.expect<Frame>(1).counter;
    CHECK(counter > last);
    last = counter;
  }
}
