// The simulated chain spoken to with raw frames: what it answers, and each of its faults as it looks on the line.
#include <atomic>
#include <catch2/catch.hpp>
#include <thread>

#include "tests/devices/fault_of.h"
#include "tests/devices/stage/zaber_rig.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

TEST_CASE("the simulated chain answers frames in one piece, in single bytes and several at once") {
  RawChain raw;
  raw.send({2, kEcho, 1234, 0});
  CHECK(raw.next() == ZaberFrame{2, kEcho, 1234, 0});
  const ZaberBytes first = encode({1, kEcho, 7, 0}), second = encode({3, kDeviceId, 0, 0});
  std::vector<std::uint8_t> both(first.begin(), first.end());
  both.insert(both.end(), second.begin(), second.end());
  raw.line->write(both);
  CHECK(raw.next() == ZaberFrame{1, kEcho, 7, 0});
  CHECK(raw.next() == ZaberFrame{3, kDeviceId, 5082, 0});
  CHECK(raw.chain.bytes_received() == 18);
  CHECK(raw.chain.requests() == std::vector<ZaberFrame>{{2, kEcho, 1234, 0}, {1, kEcho, 7, 0}, {3, kDeviceId, 0, 0}});
  raw.send({0, kStatus, 0, 0});
  for (const std::uint8_t device : std::vector<std::uint8_t>{1, 2, 3})
    CHECK(raw.next() == ZaberFrame{device, kStatus, 0, 0});
  raw.send({4, kStatus, 0, 0});  // no such device
  raw.send({1, kFirmware, 0, 0});
  CHECK(raw.next() == ZaberFrame{1, kFirmware, 523, 0});
}

TEST_CASE("a simulated device answers with message ids from the change of its mode on, and the others do not") {
  RawChain raw;
  raw.send({2, kMode, kZaberMessageIds, 0});
  CHECK(raw.next() == ZaberFrame{2, kMode, 64, 0});
  raw.send({2, kEcho, -1000, 77});
  CHECK(raw.next() == ZaberFrame{2, kEcho, -1000, 77});
  raw.line->write(encode_without_id({1, kEcho, 0x12345678, 0}));
  CHECK(raw.next_bytes() == ZaberBytes{1, 55, 0x78, 0x56, 0x34, 0x12});
  raw.send({2, kMode, 0, 78});
  CHECK(raw.next() == ZaberFrame{2, kMode, 0, 0});
}

TEST_CASE("half a frame is dropped by the simulated chain after 10 ms of silence") {
  RawChain raw;
  raw.line->write(std::vector<std::uint8_t>{1, 55, 9});
  while (raw.chain.bytes_received() < 3) std::this_thread::sleep_for(1ms);  // a busy machine reads them late
  std::this_thread::sleep_for(30ms);
  raw.send({2, kEcho, 5, 0});
  CHECK(raw.next() == ZaberFrame{2, kEcho, 5, 0});
  CHECK(raw.chain.bytes_received() == 9);
  CHECK(raw.chain.requests() == std::vector<ZaberFrame>{{2, kEcho, 5, 0}});
}

TEST_CASE("the simulated chain answers as many requests as it is told, then none") {
  const int answered = GENERATE(0, 1, 3);
  RawChain raw({}, {.silent_after_requests = answered});
  for (int i = 0; i < answered; ++i) {
    raw.send({1, kEcho, i, 0});
    CHECK(raw.next() == ZaberFrame{1, kEcho, i, 0});
  }
  for (int i = 0; i < 2; ++i) {
    raw.send({1, kEcho, 100, 0});
    CHECK(raw.says_nothing());
  }
  CHECK(raw.chain.requests().size() == static_cast<std::size_t>(answered) + 2);
}

TEST_CASE("the simulated chain hangs up at the request it is told to, and not again once it is plugged in") {
  const int answered = GENERATE(0, 2);
  RawChain raw({}, {.unplug_after_requests = answered});
  for (int i = 0; i < answered; ++i) {
    raw.send({1, kEcho, i, 0});
    CHECK(raw.next() == ZaberFrame{1, kEcho, i, 0});
  }
  raw.send({1, kEcho, 100, 0});
  CHECK(fault_id_of([&] { (void)raw.next(); }) == "TB-SERIAL-LOST");
  raw.chain.plug_in();
  raw.connect();
  for (int i = 0; i < 3; ++i) {
    raw.send({1, kEcho, i, 0});
    CHECK(raw.next() == ZaberFrame{1, kEcho, i, 0});
  }
}

TEST_CASE("the simulated chain damages one reply: another number, only three bytes, or after the next one") {
  const long which = GENERATE(0L, 1L);
  const auto three = [](RawChain& raw) {
    for (std::int32_t i = 0; i < 4; ++i) raw.send({1, kEcho, i, 0});
  };
  const auto echo = [](std::int32_t data) { return ZaberFrame{1, kEcho, data, 0}; };
  SECTION("corrupt") {
    RawChain raw({}, {.corrupt_reply = which});
    three(raw);
    for (std::int32_t i = 0; i < 4; ++i)
      CHECK(raw.next() == ZaberFrame{static_cast<std::uint8_t>(i == which ? 0x41 : 1), kEcho, i, 0});
  }
  SECTION("cut") {
    RawChain raw({}, {.cut_reply = which});
    three(raw);
    for (std::int32_t i = 0; i < 4; ++i) {
      if (i != which) CHECK(raw.next() == echo(i));
      if (i == which) CHECK(raw.read(3) == std::vector<std::uint8_t>{1, 55, static_cast<std::uint8_t>(i)});
    }
  }
  SECTION("late") {
    RawChain raw({}, {.late_reply = which});
    three(raw);
    std::vector<std::int32_t> order{0, 1, 2, 3};
    std::swap(order[static_cast<std::size_t>(which)], order[static_cast<std::size_t>(which) + 1]);
    for (const std::int32_t i : order) CHECK(raw.next() == echo(i));
  }
}

TEST_CASE("an injected fault damages the reply to its request alone") {
  std::atomic<InjectedFault> fault{InjectedFault::kNone};
  RawChain raw({}, {.inject = [&] { return fault.exchange(InjectedFault::kNone); }});
  std::int32_t count = 0;
  const auto ask = [&](InjectedFault next) {
    fault = next;
    raw.send({1, kEcho, ++count, 0});
    // Its request has been read before the next one is sent, which is to have a fault of its own.
    while (raw.chain.requests().size() < static_cast<std::size_t>(count)) std::this_thread::yield();
  };
  const auto echo = [](std::int32_t data) { return ZaberFrame{1, kEcho, data, 0}; };
  ask(InjectedFault::kSilent);
  ask(InjectedFault::kNone);
  CHECK(raw.next() == echo(2));
  ask(InjectedFault::kCorrupt);
  CHECK(raw.next() == ZaberFrame{0x41, kEcho, 3, 0});
  ask(InjectedFault::kTorn);
  CHECK(raw.read(3) == std::vector<std::uint8_t>{1, 55, 4});
  ask(InjectedFault::kLate);
  ask(InjectedFault::kNone);
  CHECK(raw.next() == echo(6));
  CHECK(raw.next() == echo(5));
  ask(InjectedFault::kLate);
  ask(InjectedFault::kLate);  // one reply at a time is held back
  CHECK(raw.next() == echo(8));
  CHECK(raw.next() == echo(7));
  ask(InjectedFault::kStale);  // the line of a stage has no such fault
  CHECK(raw.next() == echo(9));
  ask(InjectedFault::kUnplugged);
  CHECK(fault_id_of([&] { (void)raw.next(); }) == "TB-SERIAL-LOST");
}

TEST_CASE("a reply held back is lost with the silence that follows it") {
  RawChain raw({}, {.silent_after_requests = 1, .late_reply = 0});
  raw.send({1, kEcho, 1, 0});
  raw.send({1, kEcho, 2, 0});
  CHECK(raw.says_nothing());
}

TEST_CASE("the simulated chain refuses the next instruction of a kind, on whichever device, once") {
  RawChain raw;
  raw.chain.refuse_next(kStop, kZaberBusy);
  raw.send({1, kStatus, 0, 0});
  CHECK(raw.next() == ZaberFrame{1, kStatus, 0, 0});
  raw.send({2, kStop, 0, 0});
  CHECK(raw.next() == ZaberFrame{2, kError, 255, 0});
  raw.send({2, kStop, 0, 0});
  raw.send({1, kStatus, 0, 0});
  CHECK(raw.next() == ZaberFrame{2, kStop, 0, 0});  // it stands, so that its stop has ended
  CHECK(raw.next() == ZaberFrame{1, kStatus, 0, 0});
}

TEST_CASE("frames given to the simulated chain come before its next reply, as they are and once") {
  RawChain raw;
  raw.chain.inject({9, kPosition, -3, 44});
  raw.chain.inject({1, kLimitActive, 70000, 0});
  raw.send({1, kStatus, 0, 0});
  CHECK(raw.next_bytes() == ZaberBytes{9, 60, 0xFD, 0xFF, 0xFF, 44});
  CHECK(raw.next() == ZaberFrame{1, kLimitActive, 70000, 0});
  CHECK(raw.next() == ZaberFrame{1, kStatus, 0, 0});
  raw.send({1, kStatus, 0, 0});
  CHECK(raw.next() == ZaberFrame{1, kStatus, 0, 0});
}
