// Arming, identification, queries and the halt of the Zaber driver without a wire.
#include <catch2/catch.hpp>

#include "tests/devices/fault_of.h"
#include "tests/devices/stage/scripted_chain.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

TEST_CASE("Zaber stage: arming queries identity and settings of each axis in a fixed order") {
  StageAlone alone;
  alone.stage.arm();
  CHECK(alone.chain.opened == 1);
  CHECK(alone.chain.discards == 1);
  const auto exchanges = alone.stage.exchanges();
  const ScriptedChain::Frames sent = alone.sent();
  REQUIRE(sent.size() == 36);
  CHECK(exchanges == 36);
  const ScriptedChain::Frames first(sent.begin(), sent.begin() + 12);
  CHECK(first == ScriptedChain::Frames{{1, kDeviceId, 0, 0},
                                       {1, kFirmware, 0, 0},
                                       {1, kSupplyVoltage, 0, 0},
                                       {1, kStatus, 0, 0},
                                       {1, kPosition, 0, 0},
                                       {1, kReturnSetting, 40, 0},
                                       {1, kMode, kZaberMessageIds | kZaberKnobOff, 0},
                                       {1, kReturnSetting, 40, 0},
                                       {1, kReturnSetting, 37, 0},
                                       {1, kReturnSetting, 44, 0},
                                       {1, kReturnSetting, 43, 0},
                                       {1, kReturnSetting, 42, 0}});
  // A second time nothing is left to set.
  alone.stage.arm();
  CHECK(alone.chain.opened == 2);
  CHECK(alone.chain.count(kMode) == 0);
}

TEST_CASE(
    "Zaber stage: arming sets message ids and replies in the mode, the knob bit if configured, and nothing else") {
  const auto [mode, knob_off, written] = GENERATE(table<std::int32_t, bool, std::int32_t>({{0, false, 64},
                                                                                           {0, true, 72},
                                                                                           {1, false, 64},
                                                                                           {8, false, 72},
                                                                                           {1 | 16 | 4, true, 92},
                                                                                           {64, false, -1},
                                                                                           {72, true, -1}}));
  ZaberStageOptions options = even_stage();
  options.knob_off = knob_off;
  std::vector<ChainDeviceOptions> devices = even_chain();
  devices[0].mode = mode;
  StageAlone alone(options, devices);
  alone.stage.arm();
  std::vector<std::int32_t> modes;
  for (const ZaberFrame& one : alone.sent()) {
    if (one.device == 1 && one.command == kMode) modes.push_back(one.data);
  }
  CHECK(modes == (written < 0 ? std::vector<std::int32_t>{} : std::vector<std::int32_t>{written}));
}

TEST_CASE("Zaber stage: arming reads from the mode whether an axis is homed") {
  StageAlone alone;
  alone.take(1, kSetPosition, 45000);
  alone.stage.arm();
  CHECK(alone.stage.state(Axis::kX).homed);
  CHECK_FALSE(alone.stage.state(Axis::kY).homed);
  alone.stage.start_move_to(Axis::kX, Millimetres(4.46484375), {});
  CHECK(alone.stage.wait(Axis::kX).value() == Approx(4.46484375));
}

TEST_CASE("Zaber stage: a fault during arming names the axis and the value that it answered") {
  struct Kept {
    std::uint8_t device;
    ZaberCommand command;
    StageAlone::Answer answer;
    std::string id, axis, number;
  };
  const Kept one =
      GENERATE(Kept{2, kReturnSetting, std::pair(kMode, 128), "TB-STAGE-REFUSED", "stage y (device 2)",
                    "128"},  // not as written
               Kept{2, kDeviceId, std::pair(kDeviceId, 5082), "TB-STAGE-WRONG-DEVICE", "stage y (device 2)", "5082"},
               Kept{3, kFirmware, std::pair(kFirmware, 607), "TB-STAGE-WRONG-DEVICE", "stage z (device 3)", "6.07"},
               Kept{3, kFirmware, std::pair(kFirmware, 600), "TB-STAGE-WRONG-DEVICE", "stage z (device 3)", "6.00"},
               Kept{3, kFirmware, std::pair(kFirmware, 499), "TB-STAGE-WRONG-DEVICE", "stage z (device 3)", "4.99"},
               Kept{1, kSupplyVoltage, std::pair(kError, 64), "TB-STAGE-REFUSED", "stage x (device 1)", "error 64"},
               Kept{3, kStatus, std::nullopt, "TB-STAGE-TIMEOUT", "stage z (device 3)", "5 s"});
  StageAlone alone;
  alone.instead[{one.device, one.command}] = {one.answer};
  if (one.command == kReturnSetting) alone.instead[{one.device, kMode}] = {{{kMode, 72}}};
  check_fault([&] { alone.stage.arm(); }, one.id, one.axis, one.number);
  if (!one.answer) CHECK(alone.clock.now() == 10s);
  CHECK_FALSE(alone.stage.armed());
  alone.instead.clear();
  CHECK(alone.stage.halt());  // the line was closed, and is opened again
  CHECK(alone.chain.opened == 2);
  alone.stage.arm();
  CHECK(alone.chain.opened == 3);
  CHECK(alone.stage.armed());
}

TEST_CASE("Zaber stage: accepts firmware 5.00 to 5.99, or the range of the bench file, both ends included") {
  const auto [own, firmware, taken] = GENERATE(table<bool, std::int32_t, bool>({{true, 501, true},
                                                                                {true, 600, true},
                                                                                {true, 500, false},
                                                                                {true, 700, false},
                                                                                {false, 500, true},
                                                                                {false, 599, true}}));
  ZaberStageOptions options = even_stage();
  if (own) {
    options.axes[0].firmware_low = 501;
    options.axes[0].firmware_high = 600;
  }
  StageAlone alone(options);
  alone.instead[{1, kFirmware}] = {{{kFirmware, firmware}}};
  CHECK(alone.stage.identify()[0].complaint.empty() == taken);
}

TEST_CASE("Zaber stage: refuses a configured device of unknown microstep size") {
  ZaberStageOptions options = even_stage();
  options.axes[0].device_id = 7;
  std::vector<ChainDeviceOptions> devices = even_chain();
  devices[0].device_id = 7;
  StageAlone alone(options, devices);
  check_fault([&] { alone.stage.arm(); }, "TB-STAGE-WRONG-DEVICE", "stage x (device 1)", "7");
  CHECK(alone.stage.identities()[0].model.empty());
}

TEST_CASE("Zaber stage: an axis counts in its own resolution, 64 if it reports none, and travel may exceed 24 bits") {
  StageAlone alone;
  alone.take(2, kSetPosition, 6400);
  alone.take(2, kResolution, 128);
  alone.take(3, kSetPosition, 640);
  alone.take(3, kResolution, 1);
  alone.take(1, kMode, 200);
  alone.instead[{1, kReturnSetting}] = {
      {{kMode, 200}},       {{kMode, 200}},         {{kResolution, 0}}, {{kMaximumPosition, -1}},
      {{kAcceleration, 4}}, {{kTargetSpeed, 4800}}, {{kMode, 200}}};
  alone.instead[{1, kMoveAbsolute}] = {std::nullopt};
  alone.stage.arm();
  alone.instead[{1, kStatus}] = {{{kStatus, 20}}};
  CHECK(alone.stage.state(Axis::kY).position.value() == Approx(0.635));
  CHECK(alone.stage.state(Axis::kY).microsteps == 12800);
  CHECK(alone.stage.state(Axis::kZ).position.value() == Approx(0.03048));
  CHECK(alone.stage.state(Axis::kZ).microsteps == 10);
  alone.sent();
  alone.stage.start_move_to(Axis::kX, Millimetres(60.0), {});
  CHECK(alone.sent()[1] == ZaberFrame{1, kMoveAbsolute, 604724, 0});
}

TEST_CASE("Zaber stage: an axis without travel refuses any move away from 0") {
  StageAlone alone;
  alone.take(1, kMaximumPosition, 0);
  alone.stage.arm();
  alone.stage.home(Axis::kX);
  CHECK(fault_id_of([&] { alone.stage.start_move_to(Axis::kX, Millimetres(0.0001), {}); }) == "TB-STAGE-LIMIT");
  alone.stage.start_move_to(Axis::kX, Millimetres(0.0), {});
  CHECK(alone.stage.wait(Axis::kX).value() == 0.0);
}

TEST_CASE("Zaber stage: one lost reply is asked for again, two are a fault that disarms") {
  ReadyStage alone;
  const Nanoseconds begin = alone.clock.now();
  const auto before = alone.stage.exchanges();
  alone.instead[{1, kPosition}] = {std::nullopt, {{kPosition, 77}}};
  CHECK(alone.stage.state(Axis::kX).microsteps == 77);
  CHECK(alone.clock.now() == begin + 5s);
  CHECK(alone.stage.exchanges() == before + 3);
  alone.instead[{1, kPosition}] = {std::nullopt};
  check_fault([&] { (void)alone.stage.state(Axis::kX); }, "TB-STAGE-TIMEOUT", "stage x (device 1)", "5 s");
  CHECK(alone.clock.now() == begin + 15s);
  CHECK(alone.stage.exchanges() == before + 6);
  CHECK_FALSE(alone.stage.armed());
}

TEST_CASE("Zaber stage: renumbering waits for the answers, then for a second in which nothing is sent") {
  ZaberStageOptions options = even_stage();
  options.renumber = true;
  StageAlone alone(options);
  alone.stage.arm();
  CHECK(alone.clock.now() == 1s);
  CHECK(alone.chain.discards == 2);
  CHECK(alone.chain.longest_wait > 5s);
  CHECK(alone.chain.longest_wait <= 6s);
  CHECK(alone.sent()[0] == ZaberFrame{0, kRenumber, 0, 0});
  CHECK(alone.chain.pieces.empty());
}

TEST_CASE("Zaber stage: identities are those reported by the devices, or those expected before") {
  ZaberStageOptions options = even_stage();
  options.axes[0].serial = "S1";
  options.axes[2].serial = "S3";
  StageAlone alone(options);
  auto found = alone.stage.identities();
  REQUIRE(found.size() == 3);
  CHECK(found[0].role == "stage x");
  CHECK(found[1].role == "stage y");
  CHECK(found[2].role == "stage z");
  CHECK(found[0].model == "Zaber T-LA60A");
  CHECK(found[2].model == "Zaber T-NA08A50");
  CHECK(found[0].serial == "S1");
  CHECK(found[1].serial.empty());
  CHECK(found[2].serial == "S3");
  CHECK(found[0].firmware.empty());
  alone.instead[{1, kDeviceId}] = {{{kDeviceId, 28}}};
  alone.instead[{1, kFirmware}] = {{{kFirmware, 507}}};
  alone.instead[{3, kFirmware}] = {{{kFirmware, 600}}};
  alone.instead[{2, kPosition}] = {{{kPosition, 64000}}};
  const auto told = alone.stage.identify();
  REQUIRE(told.size() == 3);
  CHECK(told[0].axis == Axis::kX);
  CHECK(told[2].axis == Axis::kZ);
  CHECK_FALSE(told[0].complaint.empty());
  CHECK(told[1].complaint.empty());
  CHECK(told[0].id == "28");
  CHECK(told[1].microsteps == 64000);
  CHECK(told[1].position.value().value() == Approx(6.35));  // 1000 full steps of 6.35 um
  CHECK(told[2].firmware == "6.00");
  CHECK(told[1].supply == Volts(15.0));
  CHECK(told[1].activity == Activity::kIdle);
  found = alone.stage.identities();
  CHECK(found[0].model == "Zaber T-LA28A");
  CHECK(found[0].firmware == "5.07");
  CHECK(found[1].firmware == "5.23");
  CHECK(found[2].firmware == "6.00");
  CHECK(found[1].origin == Origin::kSimulated);
}

TEST_CASE("Zaber stage: halt stops all axes at once and asks each whether it is at rest") {
  ReadyStage alone;
  const auto before = alone.stage.exchanges();
  const int discards = alone.chain.discards;
  CHECK(alone.stage.halt());
  CHECK(alone.sent() ==
        std::vector<ZaberFrame>{{0, kStop, 0, 0}, {1, kStatus, 0, 0}, {2, kStatus, 0, 0}, {3, kStatus, 0, 0}});
  CHECK(alone.stage.exchanges() == before + 3);
  CHECK(alone.chain.discards == discards + 1);
  CHECK_FALSE(alone.stage.armed());
  alone.stage.arm();
  CHECK(alone.stage.armed());
}

TEST_CASE(
    "Zaber stage: halt polls each 20 ms, repeats the stop of an axis that keeps moving, and ends at its timeout") {
  ReadyStage alone;
  const auto [answer, stops] = GENERATE(table<StageAlone::Answer, std::size_t>({{std::pair(kStatus, 20), 101},
                                                                                {std::pair(kStatus, 1), 101},
                                                                                {std::pair(kError, 255), 101},
                                                                                {std::pair(kError, 0), 101},
                                                                                {std::pair(kStatus, 23), 0}}));
  alone.instead[{2, kStatus}] = {answer};
  const Nanoseconds begin = alone.clock.now();
  CHECK_FALSE(alone.stage.halt());
  CHECK(alone.clock.now() - begin == 2020ms);  // at 0, 20, ... 2000 ms
  CHECK(alone.chain.count(kStatus) == 103);
  const auto sent = alone.sent();
  CHECK(std::count(sent.begin(), sent.end(), ZaberFrame{2, kStop, 0, 0}) == static_cast<std::ptrdiff_t>(stops));
  CHECK(std::count(sent.begin(), sent.end(), ZaberFrame{2, kStatus, 0, 0}) == 101);
}

TEST_CASE("Zaber stage: halt ends as soon as each axis is at rest") {
  ReadyStage alone;
  alone.instead[{1, kStatus}] = {{{kStatus, 23}}, {{kStatus, 0}}};
  alone.instead[{3, kStatus}] = {{{kStatus, 23}}, {{kStatus, 23}}, {{kStatus, 23}}, {{kStatus, 0}}};
  const Nanoseconds begin = alone.clock.now();
  CHECK(alone.stage.halt());
  CHECK(alone.clock.now() - begin == 60ms);
  CHECK(alone.chain.count(kStatus) == 2 + 1 + 4);
  CHECK(alone.chain.count(kStop) == 1);
}

TEST_CASE("Zaber stage: halt asks a silent axis only twice, while it waits for the others") {
  ReadyStage alone;
  alone.instead[{1, kStatus}] = {std::nullopt};
  SECTION("the others stand") {
    CHECK_FALSE(alone.stage.halt());
    CHECK(alone.chain.count(kStatus) == 4);
  }
  SECTION("another still slows down") {
    alone.instead[{3, kStatus}] = {{{kStatus, 23}}, {{kStatus, 23}}, {{kStatus, 23}}, {{kStatus, 0}}};
    CHECK_FALSE(alone.stage.halt());
    CHECK(alone.chain.count(kStatus) == 2 + 1 + 4);
  }
  SECTION("one answer was lost") {
    alone.instead[{1, kStatus}] = {std::nullopt, {{kStatus, 0}}};
    CHECK(alone.stage.halt());
    CHECK(alone.chain.count(kStatus) == 4);
  }
  CHECK(alone.chain.count(kStop) == 1);
}

TEST_CASE("Zaber stage: halt opens a lost line a second time") {
  ReadyStage alone;
  SECTION("at the second attempt") {
    alone.stage.disarm();
    alone.chain.refused_openings = 1;
    CHECK(alone.stage.halt());
    CHECK(alone.chain.opened == 3);
  }
  SECTION("at neither attempt") {
    alone.stage.disarm();
    alone.chain.refused_openings = 2;
    CHECK_FALSE(alone.stage.halt());
    CHECK(alone.chain.opened == 3);
    CHECK(alone.stage.halt());
  }
  SECTION("it is lost") {
    alone.chain.lost = true;
    CHECK_FALSE(alone.stage.halt());
    CHECK(alone.chain.opened == 2);
  }
}

TEST_CASE("Zaber stage: a halted axis forgets its move") {
  ReadyStage alone;
  alone.stage.start_move_to(Axis::kX, Millimetres(8.9296875), {});
  alone.clock.wait_until(alone.clock.now() + 1s);
  CHECK(alone.stage.halt());
  alone.stage.arm();
  alone.sent();
  CHECK(alone.stage.wait(Axis::kX).value() == Approx(4.46484375));  // 22500 steps and a ramp of 22500
  CHECK(alone.sent().empty());
}

TEST_CASE("Zaber stage: identify uses the line of an armed stage, and closes a line that it opened") {
  StageAlone alone;
  (void)alone.stage.identify();
  CHECK(alone.chain.opened == 1);
  (void)alone.stage.identify();
  CHECK(alone.chain.opened == 2);
  CHECK_FALSE(alone.stage.armed());
  alone.ready();
  CHECK(alone.chain.opened == 3);
  CHECK(alone.stage.identify().size() == 3);
  CHECK(alone.stage.armed());
  CHECK(fault_id_of([&] { (void)alone.stage.state(Axis::kX); }) == "none");
  CHECK(alone.chain.opened == 3);
  alone.chain.lost = true;
  CHECK(fault_id_of([&] { (void)alone.stage.identify(); }) == "TB-SERIAL-LOST");
  CHECK_FALSE(alone.stage.armed());
}

TEST_CASE("Zaber stage: identify reports an axis that does not answer, and lets the supervision run before each axis") {
  class CountedClock final : public Clock {
   public:
    [[nodiscard]] Nanoseconds now() const override { return now_; }
    void wait_until(Nanoseconds time) override {
      ++waits;
      now_ = std::max(now_, time);
    }
    void reply_lost(Nanoseconds nominal) override { now_ += nominal; }
    int waits = 0;

   private:
    Nanoseconds now_{0};
  };
  CountedClock clock;
  ScriptedChain chain(&clock);
  chain.devices.pop_back();
  ZaberStage stage([&] { return chain.open(); }, paper_stage(), clock);
  const auto found = stage.identify();
  REQUIRE(found.size() == 3);
  CHECK(clock.waits == 3);
  CHECK(chain.count(kMode) == 0);  // nothing is written
  CHECK(clock.now() == 10s);
  CHECK(found[1].present);
  CHECK_FALSE(found[2].present);
  CHECK_FALSE(found[2].complaint.empty());
  CHECK(found[2].id.empty());
  CHECK_FALSE(found[2].position);
  CHECK(stage.identities()[1].firmware == "5.23");
  CHECK(stage.identities()[2].firmware.empty());
}
