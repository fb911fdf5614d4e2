// The simulated frame source by its messages: each field, each of its faults, and what it says to a wrong request.
#include "devices/tactile/simulated_frame_source.h"

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "tests/devices/fault_at.h"
#include "tests/devices/tactile/counted_array.h"
#include "tests/devices/tactile/frame_client.h"

using namespace tactbench::devices;
using namespace tactbench::devices::frame_protocol;
using namespace std::chrono_literals;
using Packed = std::vector<std::uint8_t>;

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
