// The Zaber driver against the simulated chain over a pseudo-terminal.

#include <fcntl.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <limits>
#include <thread>

#include "tests/devices/actuator_contract.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/stage/scripted_chain.h"
#include "tests/devices/timeouts.h"

using namespace std::chrono_literals;
using namespace tactbench::devices;
using enum ZaberCommand;

namespace {

constexpr double kStep = 0.0001;  // mm, no less than any microstep here

double seconds(Nanoseconds time) { return std::chrono::duration<double>(time).count(); }

}  // namespace

TEST_CASE("Zaber stage: homing moves an axis to its sensor in the expected time") {
  ZaberRig rig;
  rig.stage.arm();
  const Nanoseconds begin = rig.clock.now();
  rig.stage.home(Axis::kZ);
  CHECK(rig.chain.position(Axis::kZ).value() == Approx(0.0).margin(kStep));
  CHECK(rig.stage.state(Axis::kZ).homed);
  CHECK_FALSE(rig.stage.state(Axis::kX).homed);
  // 5 mm at 2922 x 9.375 microsteps/s = 1.3046 mm/s, and the ramps.
  CHECK(seconds(rig.clock.now() - begin) == Approx(5.0 / 1.3046).margin(0.3));
}

TEST_CASE("Zaber stage: absolute and relative moves end at their targets, in the time of a trapezoidal profile") {
  ZaberRig rig;
  rig.arm_and_home();
  const Nanoseconds begin = rig.clock.now();
  rig.stage.start_move_to(Axis::kZ, Millimetres(20.0), MillimetresPerSecond(4.0));
  CHECK(rig.stage.state(Axis::kZ).activity == Activity::kMoving);
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(20.0).margin(kStep));
  CHECK(rig.chain.position(Axis::kZ).value() == Approx(20.0).margin(kStep));
  // 20 mm at 4 mm/s, and one ramp of 4 mm/s at 111 x 0.53578 mm/s^2.
  CHECK(seconds(rig.clock.now() - begin) == Approx(5.0 + 4.0 / 59.47).margin(0.03));
  rig.stage.start_move_by(Axis::kZ, Millimetres(-0.5), MillimetresPerSecond(0.01));
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(19.5).margin(kStep));
  CHECK(rig.chain.position(Axis::kZ).value() == Approx(19.5).margin(kStep));
}

TEST_CASE("Zaber stage: two axes move at once, and their replies may come in any order") {
  ZaberRig rig;
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kX, Millimetres(20.0), std::nullopt);  // 5 s
  rig.stage.start_move_to(Axis::kZ, Millimetres(4.0), std::nullopt);   // half a second
  CHECK(rig.stage.wait(Axis::kX).value() == Approx(20.0).margin(kStep));
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(4.0).margin(kStep));
  rig.stage.start_move_to(Axis::kX, Millimetres(10.0), std::nullopt);
  rig.stage.start_move_to(Axis::kZ, Millimetres(8.0), std::nullopt);
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(8.0).margin(kStep));
  CHECK(rig.stage.state(Axis::kX).activity == Activity::kMoving);
  CHECK(rig.stage.wait(Axis::kX).value() == Approx(10.0).margin(kStep));
}

TEST_CASE("Zaber stage: stop brings a moving axis to rest short of its target") {
  ZaberRig rig;
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kZ, Millimetres(40.0), MillimetresPerSecond(8.0));
  rig.clock.wait_until(rig.clock.now() + 1s);
  const Millimetres stood = rig.stage.stop(Axis::kZ);
  CHECK(stood.value() == Approx(8.0).margin(1.0));
  CHECK(rig.stage.state(Axis::kZ).activity == Activity::kIdle);
  rig.clock.wait_until(rig.clock.now() + 60s);
  CHECK(rig.chain.position(Axis::kZ).value() == Approx(stood.value()).margin(kStep));
  CHECK(rig.stage.stop(Axis::kZ).value() == Approx(stood.value()).margin(kStep));
}

TEST_CASE("Zaber stage: after a refused homing the axis is not homed, and is after the next attempt") {
  ZaberRig rig;
  rig.arm_and_home();
  rig.chain.refuse_next(kHome, 1);
  CHECK(fault_id_of([&] { rig.stage.home(Axis::kY); }) == "TB-STAGE-REFUSED");
  CHECK(fault_id_of([&] { rig.stage.start_move_to(Axis::kY, Millimetres(3.0), {}); }) == "TB-STAGE-NOT-HOMED");
  rig.stage.home(Axis::kY);
  rig.stage.start_move_to(Axis::kY, Millimetres(3.0), std::nullopt);
  CHECK(rig.stage.wait(Axis::kY).value() == Approx(3.0).margin(kStep));
}

TEST_CASE("Zaber stage: a move that a power cycle interrupts is detected") {
  ZaberRig rig;
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kZ, Millimetres(20.0), std::nullopt);
  rig.chain.power_cycle();
  CHECK(fault_id_of([&] { (void)rig.stage.wait(Axis::kZ); }) == "TB-STAGE-ASTRAY");
  CHECK(fault_id_of([&] { rig.stage.start_move_to(Axis::kZ, Millimetres(20.0), {}); }) == "TB-STAGE-NOT-HOMED");
}

TEST_CASE("Zaber stage: after a damaged, cut or late reply the query is repeated and the move succeeds") {
  long SimulatedChainFaults::*const fault = GENERATE(
      &SimulatedChainFaults::corrupt_reply, &SimulatedChainFaults::cut_reply, &SimulatedChainFaults::late_reply);
  const long number = GENERATE(0L, 5L, 8L, 45L);
  SimulatedChainFaults faults;
  faults.*fault = number;
  ZaberRig rig({}, faults, impatient_stage());
  rig.stage.arm();
  rig.stage.home(Axis::kZ);
  rig.stage.start_move_to(Axis::kZ, Millimetres(2.0), std::nullopt);
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(2.0).margin(kStep));
  CHECK(rig.chain.position(Axis::kZ).value() == Approx(2.0).margin(kStep));
  CHECK(rig.count({kMoveAbsolute}) == 1);
}

TEST_CASE("Zaber stage: the chain is renumbered only on request") {
  SimulatedChainOptions chain;
  for (std::size_t i = 0; i < 3; ++i) chain.devices[i].number = static_cast<std::uint8_t>(7 - i);
  ZaberStageOptions options = impatient_stage();
  {
    ZaberRig rig(chain, {}, options);
    CHECK(fault_id_of([&] { rig.stage.arm(); }) == "TB-STAGE-TIMEOUT");
    CHECK(rig.count({kRenumber}) == 0);
  }
  options.renumber = true;
  ZaberRig rig(chain, {}, options);
  rig.arm_and_home();
  CHECK(rig.count({kRenumber}) == 1);
}

TEST_CASE("Zaber stage: an unexpected device is refused before its mode is written") {
  SimulatedChainOptions chain;
  SECTION("another model") { std::swap(chain.devices[0].device_id, chain.devices[2].device_id); }
  SECTION("firmware 6, whose units differ") { chain.devices[0].firmware = 606; }
  ZaberRig rig(chain);
  CHECK(fault_id_of([&] { rig.stage.arm(); }) == "TB-STAGE-WRONG-DEVICE");
  CHECK_FALSE(rig.stage.armed());
  CHECK(rig.count({kMode}) == 0);
}

// The Zaber driver's promises beyond the laws of every actuator.

namespace {

// Every command, each expected to end in `fault`.
void check_all_refused(Stage& stage, const std::string& fault) {
  CHECK(fault_id_of([&] { stage.home(Axis::kX); }) == fault);
  CHECK(fault_id_of([&] { stage.start_move_to(Axis::kX, Millimetres(1.0), std::nullopt); }) == fault);
  CHECK(fault_id_of([&] { stage.start_move_by(Axis::kX, Millimetres(1.0), std::nullopt); }) == fault);
  CHECK(fault_id_of([&] { stage.start_speed(Axis::kX, MillimetresPerSecond(1.0)); }) == fault);
  CHECK(fault_id_of([&] { (void)stage.wait(Axis::kX); }) == fault);
  CHECK(fault_id_of([&] { (void)stage.stop(Axis::kX); }) == fault);
  CHECK(fault_id_of([&] { (void)stage.state(Axis::kX); }) == fault);
}

}  // namespace

TEST_CASE("Zaber contract: no axis moves before it is homed or after a power loss") {
  ZaberRig rig;
  rig.stage.arm();
  const auto before = rig.chain.bytes_received();
  CHECK(fault_id_of([&] { rig.stage.start_move_to(Axis::kX, Millimetres(1.0), {}); }) == "TB-STAGE-NOT-HOMED");
  CHECK(fault_id_of([&] { rig.stage.start_move_by(Axis::kX, Millimetres(1.0), {}); }) == "TB-STAGE-NOT-HOMED");
  CHECK(fault_id_of([&] { rig.stage.start_speed(Axis::kX, MillimetresPerSecond(1.0)); }) == "TB-STAGE-NOT-HOMED");
  CHECK(rig.chain.bytes_received() == before);
  rig.stage.home(Axis::kX);
  rig.chain.power_cycle();
  CHECK(fault_id_of([&] { rig.stage.start_move_to(Axis::kX, Millimetres(1.0), {}); }) == "TB-STAGE-NOT-HOMED");
  CHECK(rig.count({kMoveAbsolute, kMoveRelative, kConstantSpeed}) == 0);
}

TEST_CASE("Zaber contract: on a silent connection the query is repeated once, then a timeout fault disarms the stage") {
  SimulatedChainFaults faults;
  faults.silent_after_requests = GENERATE(0L, 7L, 60L, 75L);
  ZaberRig rig({}, faults, impatient_stage());
  const auto all = [&] {
    rig.arm_and_home();
    rig.stage.start_move_to(Axis::kZ, Millimetres(20.0), std::nullopt);
    (void)rig.stage.wait(Axis::kZ);
  };
  CHECK(fault_id_of(all) == "TB-STAGE-TIMEOUT");
  CHECK_FALSE(rig.stage.armed());
  // The query whose reply was lost was sent twice: process time has advanced by both waits.
  CHECK(rig.clock.now() >= 2 * impatient_stage().reply_timeout);
  check_all_refused(rig.stage, "TB-STAGE-NOT-ARMED");
}

TEST_CASE("Zaber contract: unplugging during any exchange is a lost connection, never a timeout") {
  SimulatedChainFaults faults;
  faults.unplug_after_requests = GENERATE(0L, 9L, 33L, 60L, 80L);
  ZaberRig rig({}, faults);
  CHECK(fault_id_of([&] {
          rig.arm_and_home();
          rig.stage.start_move_to(Axis::kZ, Millimetres(20.0), std::nullopt);
          (void)rig.stage.wait(Axis::kZ);
        }) == "TB-SERIAL-LOST");
  CHECK_FALSE(rig.stage.armed());
}

TEST_CASE("Zaber contract: halt stops every axis from any state, twice, and commands are refused until arming") {
  ZaberRig rig;
  CHECK(rig.stage.halt());  // never armed: it opens the line by itself
  CHECK(rig.count(kMoving) == 0);
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kX, Millimetres(40.0), std::nullopt);
  rig.stage.start_speed(Axis::kZ, MillimetresPerSecond(8.0));
  rig.clock.wait_until(rig.clock.now() + 1s);
  CHECK(rig.stage.halt());
  CHECK_FALSE(rig.stage.armed());
  const Millimetres x = rig.chain.position(Axis::kX);
  const Millimetres z = rig.chain.position(Axis::kZ);
  CHECK(x.value() < 6.0);
  CHECK(z.value() < 12.0);
  rig.clock.wait_until(rig.clock.now() + 100s);
  CHECK(rig.chain.position(Axis::kX) == x);
  CHECK(rig.chain.position(Axis::kZ) == z);
  CHECK(rig.stage.halt());
  const auto before = rig.chain.bytes_received();
  check_all_refused(rig.stage, "TB-STAGE-HALTED");
  CHECK(rig.chain.bytes_received() == before);
  rig.stage.arm();
  rig.stage.start_move_to(Axis::kZ, Millimetres(0.0), std::nullopt);
  CHECK(rig.stage.wait(Axis::kZ).value() == Approx(0.0).margin(1e-4));
}

TEST_CASE("Zaber contract: halt during homing succeeds, whether or not the device refuses stops while homing") {
  SimulatedChainOptions options;
  options.devices[2].stands_at = Millimetres(1.5);
  options.devices[2].refuses_stop_while_homing = GENERATE(false, true);
  ZaberRig rig(options);
  rig.stage.arm();
  // Another program's homing: the driver's own would block the thread that turns the clock.
  {
    rig.stage.disarm();
    const auto stream = rig.connect();
    stream->write(encode({3, kHome, 0, 1}));
    stream->write(encode({3, kStatus, 0, 2}));
    std::array<std::uint8_t, 6> reply{};
    REQUIRE(stream->read(reply, 5s) == 6);
    REQUIRE(decode(reply).data == kZaberHoming);
  }
  CHECK(rig.stage.halt());
}

TEST_CASE("Zaber contract: half a frame left on the line does not corrupt the halt") {
  ZaberRig rig;
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kZ, Millimetres(40.0), std::nullopt);
  if (GENERATE(false, true)) rig.stage.disarm();
  const int intruder = ::open(rig.chain.address().c_str(), O_WRONLY | O_NOCTTY | O_CLOEXEC);
  const std::array<std::uint8_t, 4> half{3, 20, 0, 0};
  REQUIRE(::write(intruder, half.data(), half.size()) == 4);
  while (rig.chain.bytes_received() % 6 != 4) std::this_thread::sleep_for(1ms);  // a busy machine reads them late
  CHECK(rig.stage.halt());
  ::close(intruder);
  // Joined to it the first bytes of the stop would have made another move.
  CHECK(rig.count(kMoving) == 4);
  CHECK(rig.chain.position(Axis::kZ).value() < 39.0);
}

TEST_CASE("Zaber contract: halt from another thread ends a wait in progress") {
  ZaberStageOptions options = paper_stage();
  options.halt_timeout = 100ms;
  ZaberRig rig({}, {}, options);
  rig.arm_and_home();
  rig.stage.start_move_to(Axis::kX, Millimetres(60.0), MillimetresPerSecond(0.001));  // 60 000 s
  const std::size_t before = rig.chain.requests().size();
  std::thread other([&] {
    while (rig.chain.requests().size() < before + 20) std::this_thread::yield();
    (void)rig.stage.halt();  // the clock may not advance meanwhile, so the answer may be false
  });
  CHECK(fault_id_of([&] { (void)rig.stage.wait(Axis::kX); }) == "TB-STAGE-HALTED");
  other.join();
  CHECK(rig.stage.halt());
  CHECK(rig.chain.position(Axis::kX).value() < 59.0);
}

TEST_CASE("Zaber contract: a command is refused at once while a halt still waits for the axes") {
  ReadyStage alone;
  std::atomic<bool> halting{false}, refused{false}, refused_meanwhile{false};
  alone.chain.script = [&](const ZaberFrame& frame) -> std::optional<ScriptedChain::Frames> {
    if (frame.command == kStatus && frame.device == 1) {
      halting = true;
      const auto end = std::chrono::steady_clock::now() + kPatient;
      while (!refused && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(1ms);
      refused_meanwhile = refused.load();
    }
    return std::nullopt;
  };
  bool stands = false;
  std::thread other([&] { stands = alone.stage.halt(); });
  while (!halting) std::this_thread::yield();
  CHECK(fault_id_of([&] { (void)alone.stage.state(Axis::kX); }) == "TB-STAGE-HALTED");
  refused = true;
  other.join();
  CHECK(stands);
  CHECK(refused_meanwhile);
  alone.stage.arm();
  CHECK(alone.stage.armed());
}

TEST_CASE("Zaber contract: a halt that waits for the line interrupts a sequence of queries") {
  bool refused = false;
  // The halt's thread may start late, and then has nothing to break off.
  const auto end = std::chrono::steady_clock::now() + kPatient;
  while (!refused && std::chrono::steady_clock::now() < end) {
    StageAlone alone;
    alone.stage.arm();
    std::thread other;
    alone.chain.script = [&](const ZaberFrame& frame) -> std::optional<ScriptedChain::Frames> {
      if (frame.command == kDeviceId && !other.joinable()) other = std::thread([&] { (void)alone.stage.halt(); });
      if (frame.device != 0) std::this_thread::sleep_for(2ms);
      return std::nullopt;
    };
    const auto fault = fault_of([&] { (void)alone.stage.identify(); });
    other.join();
    refused = fault && fault->id() == "TB-STAGE-HALTED";
    CHECK_FALSE(alone.stage.armed());
  }
  CHECK(refused);
}

// The Zaber stage joins the table of actuator laws, on a pseudo-terminal and over TCP.

namespace {

class ZaberBed final : public ActuatorBed {
 public:
  ZaberBed(const BedOptions& options, const std::string& listen)
      : rig_(chain_options(listen), faults(), stage_options(options)) {}

  ZaberStage& actuator() override { return rig_.stage; }
  ManualClock& clock() override { return rig_.clock; }
  [[nodiscard]] std::string faults_begin_with() const override { return "TB-STAGE"; }
  void make_ready() override { rig_.arm_and_home(); }
  std::vector<Act> commands() override {
    Stage& stage = rig_.stage;
    return {[&] { stage.home(Axis::kX); },
            [&] { stage.start_move_to(Axis::kX, Millimetres(1.0), std::nullopt); },
            [&] { stage.start_move_by(Axis::kX, Millimetres(1.0), std::nullopt); },
            [&] { stage.start_speed(Axis::kX, MillimetresPerSecond(1.0)); },
            [&] { (void)stage.wait(Axis::kX); },
            [&] { (void)stage.stop(Axis::kX); },
            [&] { (void)stage.state(Axis::kX); }};
  }
  // z goes from 0 to 50 mm at 8 mm/s at most.
  std::vector<Act> forbidden() override {
    std::vector<Act> all;
    for (const double target : {-0.001, 50.001, 1e9, std::nan(""), HUGE_VAL, -HUGE_VAL}) {
      all.emplace_back([this, target] { rig_.stage.start_move_to(Axis::kZ, Millimetres(target), {}); });
      all.emplace_back([this, target] { rig_.stage.start_move_by(Axis::kZ, Millimetres(target), {}); });
    }
    for (const double speed : {0.0, -1.0, 8.001, 1e-9, std::nan(""), HUGE_VAL})
      all.emplace_back(
          [this, speed] { rig_.stage.start_move_to(Axis::kZ, Millimetres(1.0), MillimetresPerSecond(speed)); });
    for (const double speed : {0.0, 8.001, -8.001, std::nan(""), -HUGE_VAL})
      all.emplace_back([this, speed] { rig_.stage.start_speed(Axis::kZ, MillimetresPerSecond(speed)); });
    return all;
  }
  // To the end of z that is further away.
  void load() override {
    const bool near = rig_.chain.position(Axis::kZ) < Millimetres(25.0);
    rig_.stage.start_move_to(Axis::kZ, Millimetres(near ? 50.0 : 0.0), MillimetresPerSecond(1.0));
  }
  [[nodiscard]] bool make_safe() noexcept override { return rig_.stage.halt(); }
  bool is_in_safe_state() override {
    const auto places = [&] { return rig_.chain.places(rig_.clock.now()); };
    const auto before = places();
    rig_.clock.wait_until(rig_.clock.now() + 100ms);
    return places() == before;
  }
  [[nodiscard]] std::uint64_t received() const override { return rig_.chain.bytes_received(); }
  [[nodiscard]] std::uint64_t driven() const override { return rig_.count(kMoving); }
  void fall_silent() override { silent_ = true; }
  void break_wire() override { rig_.chain.unplug(); }
  void mend_wire() override { rig_.chain.plug_in(); }
  [[nodiscard]] int questions() const override { return 2; }
  [[nodiscard]] int questions_to_make_safe() const override { return 2 * kAxes; }

 private:
  static SimulatedChainOptions chain_options(const std::string& listen) {
    SimulatedChainOptions options;
    options.listen = listen;
    return options;
  }
  SimulatedChainFaults faults() {
    SimulatedChainFaults faults;
    faults.inject = [this] { return silent_ ? InjectedFault::kSilent : InjectedFault::kNone; };
    return faults;
  }
  static ZaberStageOptions stage_options(const BedOptions& bed) {
    ZaberStageOptions options = paper_stage();
    options.reply_timeout = bed.reply_timeout;
    options.halt_timeout = bed.safe_timeout;
    return options;
  }

  std::atomic<bool> silent_{false};
  ZaberRig<> rig_;
};

const JoinsActuatorLaws<ZaberStage, ZaberBed> kTerminal("Zaber stage on a pseudo-terminal", std::string()),
    kTcp("Zaber stage over TCP", std::string("tcp:0"));

}  // namespace
