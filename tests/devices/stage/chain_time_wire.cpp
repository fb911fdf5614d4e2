// The simulated chain in process time: ends of moves, renumbering, places of its axes, stalls, loss of power and of the
// line.
#include <atomic>
#include <catch2/catch.hpp>
#include <mutex>
#include <thread>

#include "tests/devices/fault_of.h"
#include "tests/devices/stage/scripted_chain.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

namespace {

// x moves at 45000 steps/s with ramps of 1 s.
SimulatedChainOptions even_moves() {
  SimulatedChainOptions options;
  options.devices[0].acceleration = 4;
  options.devices[0].home_speed = options.devices[0].target_speed = 4800;
  options.devices[0].stands_at = Millimetres(0.0);
  return options;
}

double steps_of(const SimulatedChain& chain, Axis axis) { return chain.position(axis).value() / (0.00635 / 64); }

// Of which the chain asks on its own thread.
struct GuardedStall {
  std::mutex mutex;
  StageStall stall;
};

// x and y, which move alike, go to 600000; the chain stalls as it is told.
struct StalledChain : private GuardedStall, RawChain {
  StalledChain() : RawChain(twins(), {.stall = [this] { return get(); }}) {
    for (const std::uint8_t device : std::vector<std::uint8_t>{1, 2}) send({device, kMoveAbsolute, 600000, 0});
    send({1, kStatus, 0, 0});
    CHECK(next() == ZaberFrame{1, kStatus, 20, 0});
  }
  static SimulatedChainOptions twins() {
    SimulatedChainOptions options = even_moves();
    options.devices[1] = options.devices[0];
    options.devices[1].number = 2;
    return options;
  }
  void set(const StageStall& next) {
    const std::lock_guard lock(mutex);
    stall = next;
  }
  StageStall get() {  // on the chain's thread
    const std::lock_guard lock(mutex);
    return stall;
  }
  void at(Nanoseconds time, double x, double y) {
    clock.wait_until(time);
    CHECK(steps_of(chain, Axis::kX) == Approx(x));
    CHECK(steps_of(chain, Axis::kY) == Approx(y));
  }
};

}  // namespace

TEST_CASE("simulated Zaber chain: reports ended moves before it answers the next request, to whichever device") {
  RawChain raw(even_moves());
  raw.send({1, kMoveAbsolute, 90000, 0});
  raw.expect({2, kStatus, 0, 0}, {2, kStatus, 0, 0});
  raw.clock.wait_until(3s - 1ns);
  raw.expect({2, kStatus, 0, 0}, {2, kStatus, 0, 0});
  CHECK_FALSE(raw.chain.at_rest_since(raw.clock.now()));
  raw.clock.wait_until(3s);
  CHECK(raw.chain.at_rest_since(3s));
  CHECK_FALSE(raw.chain.at_rest_since(3s - 1ns));
  raw.expect({2, kStatus, 0, 0}, {1, kMoveAbsolute, 90000, 0});
  CHECK(raw.next() == ZaberFrame{2, kStatus, 0, 0});
}

TEST_CASE("simulated Zaber chain: axes map to the devices as set, for present and past positions") {
  SimulatedChainOptions options = even_moves();
  options.axes = {2, 0, 1};
  options.devices[1].stands_at = Millimetres(7.0);
  options.devices[2].stands_at = Millimetres(9.0);
  RawChain raw(options);
  CHECK(raw.chain.position(Axis::kX).value() == Approx(9.0).margin(1e-4));
  CHECK(raw.chain.position(Axis::kY).value() == 0.0);
  CHECK(raw.chain.position(Axis::kZ).value() == Approx(7.0).margin(1e-4));
  raw.send({1, kMoveAbsolute, 90000, 0});
  raw.expect({1, kStatus, 0, 0}, {1, kStatus, 20, 0});
  raw.clock.wait_until(2s);
  CHECK(steps_of(raw.chain, Axis::kY) == Approx(67500));
  const auto before = raw.chain.places(1s);
  CHECK(before[0].value() == Approx(9.0).margin(1e-4));
  CHECK(before[1].value() == Approx(22500 * 0.00635 / 64));
  CHECK(before[2].value() == Approx(7.0).margin(1e-4));
}

TEST_CASE(
    "simulated Zaber chain: ignores requests for 0.5 s after renumbering, but not after that of a single device") {
  SimulatedChainOptions options;
  for (std::size_t i = 0; i < 3; ++i) options.devices[i].number = static_cast<std::uint8_t>(20 + i);
  RawChain raw(options);
  raw.clock.wait_until(10s);
  raw.expect({21, kRenumber, 5, 0}, {5, kRenumber, 60, 0});
  raw.expect({5, kEcho, 1, 0}, {5, kEcho, 1, 0});
  raw.send({0, kEcho, 2, 0});
  for (const std::uint8_t device : std::vector<std::uint8_t>{20, 5, 22})
    CHECK(raw.next() == ZaberFrame{device, kEcho, 2, 0});
  raw.expect({0, kRenumber, 0, 0}, {1, kRenumber, 60, 0});
  CHECK(raw.next() == ZaberFrame{2, kRenumber, 60, 0});
  CHECK(raw.next() == ZaberFrame{3, kRenumber, 5082, 0});
  raw.clock.wait_until(10s + 500ms - 1ns);
  raw.send({1, kEcho, 3, 0});
  CHECK(raw.says_nothing());
  raw.clock.wait_until(10s + 500ms);
  raw.expect({1, kEcho, 4, 0}, {1, kEcho, 4, 0});
}

TEST_CASE("simulated Zaber chain: a power cycle stops each device in place and clears its home") {
  RawChain raw(even_moves());
  for (const std::uint8_t device : std::vector<std::uint8_t>{1, 2}) {
    raw.expect({device, kSetPosition, 500, 0}, {device, kSetPosition, 500, 0});
  }
  raw.send({1, kMoveAbsolute, 90500, 0});
  raw.expect({1, kStatus, 0, 0}, {1, kStatus, 20, 0});
  raw.clock.wait_until(1s);
  raw.chain.power_cycle();
  raw.clock.wait_until(100s);
  CHECK(steps_of(raw.chain, Axis::kX) == Approx(22500));
  for (const std::uint8_t device : std::vector<std::uint8_t>{1, 2}) {
    raw.expect({device, kReturnSetting, 40, 0}, {device, kMode, 0, 0});
    raw.expect({device, kPosition, 0, 0}, {device, kPosition, 0, 0});
  }
}

TEST_CASE("simulated Zaber chain: a stall without an axis stops all axes from its begin to its end, repeatedly") {
  StalledChain raw;
  raw.at(1s, 22500, 22500);
  raw.set({2s, {}, {}});
  raw.at(2s, 67500, 67500);
  raw.at(3s, 67500, 67500);
  CHECK(raw.chain.at_rest_since(2s));
  CHECK_FALSE(raw.chain.at_rest_since(2s - 1ns));
  raw.set({2s, 4s, {}});
  raw.at(3500ms, 67500, 67500);
  raw.at(5s, 112500, 112500);  // noticed late, free since its end
  CHECK(raw.chain.places(3900ms)[0].value() == Approx(67500 * 0.00635 / 64));
  raw.set({6s, 7s, {}});
  raw.at(6500ms, 157500, 157500);
  raw.at(8s, 202500, 202500);
}

TEST_CASE("simulated Zaber chain: a stall lasts exactly from its begin to its end, whoever asks first") {
  StalledChain raw;
  raw.set({2s, 3s, {}});
  raw.clock.wait_until(2s);
  CHECK(raw.chain.at_rest_since(2s));
  raw.clock.wait_until(3s);
  CHECK_FALSE(raw.chain.at_rest_since(3s));
  raw.at(4s, 112500, 112500);
}

TEST_CASE("simulated Zaber chain: a stall of another axis ends the previous one") {
  StalledChain raw;
  raw.set({2s, {}, Axis::kX});
  raw.at(3s, 67500, 112500);
  raw.set({4s, {}, Axis::kY});
  raw.at(5s, 112500, 157500);
  raw.set({6s, {}, Axis::kZ});
  raw.at(7s, 202500, 202500);
}

TEST_CASE("simulated Zaber chain: homing of a stalled axis continues when the stall ends") {
  StalledChain raw;
  raw.clock.wait_until(3s);
  raw.send({1, kHome, 0, 0});  // back from 112500, to rest at 135000 a second later
  raw.expect({1, kStatus, 0, 0}, {1, kStatus, 1, 0});
  raw.set({4s, {}, {}});
  raw.clock.wait_until(100s);
  raw.expect({1, kStatus, 0, 0}, {2, kMoveAbsolute, 600000, 0});
  CHECK(raw.next() == ZaberFrame{1, kStatus, 1, 0});
  raw.set({4s, 100s, {}});
  raw.clock.wait_until(104s - 1ns);
  raw.expect({1, kStatus, 0, 0}, {1, kStatus, 1, 0});
  raw.clock.wait_until(104s);  // 3 s and a ramp for 135000 steps
  raw.expect({1, kStatus, 0, 0}, {1, kHome, 0, 0});
  CHECK(raw.next() == ZaberFrame{1, kStatus, 0, 0});
  CHECK(steps_of(raw.chain, Axis::kX) == Approx(0.0).margin(1e-6));
}

TEST_CASE("simulated Zaber chain: stays unplugged while its port is in use, and is plugged in once it is free") {
  RawChain raw({.listen = "tcp:0"});
  const std::string address = raw.chain.address();
  raw.chain.unplug();
  CHECK(fault_id_of([&] { (void)raw.next(); }) == "TB-SERIAL-LOST");
  {
    SimulatedChainOptions options;
    options.listen = "tcp:" + address.substr(address.rfind(':') + 1);
    options.devices[0].device_id = 28;
    SimulatedChain other(options, raw.clock);
    CHECK(fault_id_of([&] { SimulatedChain third(options, raw.clock); }) == "TB-SIM-LISTEN");
    raw.chain.plug_in();
    raw.connect();
    raw.expect({1, kDeviceId, 0, 0}, {1, kDeviceId, 28, 0});
    raw.line.reset();
  }
  raw.chain.plug_in();
  CHECK(raw.chain.address() == address);
  raw.connect();
  raw.expect({1, kDeviceId, 0, 0}, {1, kDeviceId, 60, 0});
}

TEST_CASE("simulated Zaber chain: forgets half a frame when plugged in again, and its devices keep their settings") {
  RawChain raw;
  raw.expect({1, kMode, kZaberKnobOff, 0}, {1, kMode, 8, 0});
  raw.line->write(std::vector<std::uint8_t>{1, 55, 9});
  while (raw.chain.bytes_received() < 9) std::this_thread::yield();
  raw.chain.unplug();
  raw.chain.plug_in();
  raw.connect();
  raw.expect({1, kReturnSetting, 40, 0}, {1, kMode, 8, 0});  // and its devices kept their power
}

TEST_CASE("simulated Zaber chain: answers frames in one piece and several at once") {
  RawChain raw;
  raw.expect({2, kEcho, 1234, 0}, {2, kEcho, 1234, 0});
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
  raw.expect({1, kFirmware, 0, 0}, {1, kFirmware, 523, 0});
}

TEST_CASE("simulated Zaber device: answers with message ids after its mode is changed, and the others do not") {
  RawChain raw;
  raw.expect({2, kMode, kZaberMessageIds, 0}, {2, kMode, 64, 0});
  raw.expect({2, kEcho, -1000, 77}, {2, kEcho, -1000, 77});
  raw.line->write(encode_without_id({1, kEcho, 0x12345678, 0}));
  CHECK(raw.next_bytes() == ZaberBytes{1, 55, 0x78, 0x56, 0x34, 0x12});
  raw.expect({2, kMode, 0, 78}, {2, kMode, 0, 0});
}

TEST_CASE("simulated Zaber chain: drops half a frame after 10 ms of silence") {
  RawChain raw;
  raw.line->write(std::vector<std::uint8_t>{1, 55, 9});
  while (raw.chain.bytes_received() < 3) std::this_thread::sleep_for(1ms);  // a busy machine reads them late
  std::this_thread::sleep_for(30ms);
  raw.expect({2, kEcho, 5, 0}, {2, kEcho, 5, 0});
  CHECK(raw.chain.bytes_received() == 9);
  CHECK(raw.chain.requests() == std::vector<ZaberFrame>{{2, kEcho, 5, 0}});
}

TEST_CASE("simulated Zaber chain: answers the set number of requests, then none") {
  const int answered = GENERATE(0, 1, 3);
  RawChain raw({}, {.silent_after_requests = answered});
  for (int i = 0; i < answered; ++i) {
    raw.expect({1, kEcho, i, 0}, {1, kEcho, i, 0});
  }
  for (int i = 0; i < 2; ++i) {
    raw.send({1, kEcho, 100, 0});
    CHECK(raw.says_nothing());
  }
  CHECK(raw.chain.requests().size() == static_cast<std::size_t>(answered) + 2);
}

TEST_CASE("simulated Zaber chain: hangs up at the set request, and not again once it is plugged in") {
  const int answered = GENERATE(0, 2);
  RawChain raw({}, {.unplug_after_requests = answered});
  for (int i = 0; i < answered; ++i) {
    raw.expect({1, kEcho, i, 0}, {1, kEcho, i, 0});
  }
  raw.send({1, kEcho, 100, 0});
  CHECK(fault_id_of([&] { (void)raw.next(); }) == "TB-SERIAL-LOST");
  raw.chain.plug_in();
  raw.connect();
  for (int i = 0; i < 3; ++i) {
    raw.expect({1, kEcho, i, 0}, {1, kEcho, i, 0});
  }
}

TEST_CASE("simulated Zaber chain: one reply gets another number, is cut to three bytes, or comes after the next one") {
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

TEST_CASE("simulated Zaber chain: an injected fault affects only the reply to its request") {
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

TEST_CASE("simulated Zaber chain: a delayed reply is lost if silence follows") {
  RawChain raw({}, {.silent_after_requests = 1, .late_reply = 0});
  raw.send({1, kEcho, 1, 0});
  raw.send({1, kEcho, 2, 0});
  CHECK(raw.says_nothing());
}

TEST_CASE("simulated Zaber chain: refuses the next instruction of a kind, to any device, once") {
  RawChain raw;
  raw.chain.refuse_next(kStop, kZaberBusy);
  raw.expect({1, kStatus, 0, 0}, {1, kStatus, 0, 0});
  raw.expect({2, kStop, 0, 0}, {2, kError, 255, 0});
  raw.send({2, kStop, 0, 0});
  raw.expect({1, kStatus, 0, 0}, {2, kStop, 0, 0});  // it stands, so that its stop has ended
  CHECK(raw.next() == ZaberFrame{1, kStatus, 0, 0});
}

TEST_CASE("simulated Zaber chain: injected frames are sent before its next reply, unchanged and once") {
  RawChain raw;
  raw.chain.inject({9, kPosition, -3, 44});
  raw.chain.inject({1, kLimitActive, 70000, 0});
  raw.send({1, kStatus, 0, 0});
  CHECK(raw.next_bytes() == ZaberBytes{9, 60, 0xFD, 0xFF, 0xFF, 44});
  CHECK(raw.next() == ZaberFrame{1, kLimitActive, 70000, 0});
  CHECK(raw.next() == ZaberFrame{1, kStatus, 0, 0});
  raw.expect({1, kStatus, 0, 0}, {1, kStatus, 0, 0});
}
