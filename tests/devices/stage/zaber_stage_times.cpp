// Times of the Zaber driver under a manual clock: when a moving axis is asked, and when it is given up.

#include <catch2/catch.hpp>

#include <cmath>
#include <map>

#include "devices/stage/zaber_retreat.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/stage/scripted_chain.h"
#include "tests/devices/timeouts.h"

using namespace std::chrono_literals;
using namespace tactbench::devices;
using enum ZaberCommand;

namespace {

// Waits for x, which never answers that it is at rest; how long until it was given up.
Nanoseconds given_up_after(StageAlone& alone, Nanoseconds begin) {
  CHECK(fault_id_of([&] { (void)alone.stage.wait(Axis::kX); }) == "TB-STAGE-OVERDUE");
  return alone.clock.now() - begin;
}

// At that time or at the next look, which comes an eighth of 100 ms later.
void check_within_a_look(Nanoseconds time, Nanoseconds expected) {
  CHECK(time >= expected);
  CHECK(time <= expected + 12500us + 2ns);
}

}  // namespace

TEST_CASE(
    "Zaber stage: a moving axis is polled each 100 ms until its expected end, then each 12.5 ms until it is overdue") {
  ReadyStage alone;
  alone.instead[{1, kStatus}] = {{{kStatus, 20}}};
  const Nanoseconds begin = alone.clock.now();
  alone.polls.clear();
  alone.stage.start_move_to(Axis::kX, Millimetres(8.9296875), {});  // 3 s
  CHECK(alone.polls == std::vector<Nanoseconds>{begin});            // for a refusal
  alone.sent();
  // A quarter more than 3 s and two ramps of 1 s, and 2 s.
  check_within_a_look(given_up_after(alone, begin), 8250ms);
  CHECK(alone.stage.armed());
  const ScriptedChain::Frames last(alone.chain.sent.end() - 3, alone.chain.sent.end());
  CHECK(last[0].command == kStatus);
  CHECK(last[1] == ZaberFrame{1, kStop, 0, 0});
  CHECK(last[2].command == kStatus);
  REQUIRE(alone.polls.size() > 40);
  for (std::size_t i = 1; i < 30; ++i) CHECK(alone.polls[i] - begin == (i - 1) * 100ms);
  CHECK(alone.polls[31] - begin >= 3s);
  CHECK(alone.polls[31] - begin <= 3s + 2ns);
  CHECK(alone.polls[32] - alone.polls[31] == 12500us);
  // Now nothing is under way, and it is not asked any more.
  alone.sent();
  (void)alone.stage.wait(Axis::kX);
  CHECK(alone.sent().empty());
}

TEST_CASE("Zaber stage: the time limit of a move follows from its own speed and distance") {
  ReadyStage alone;
  alone.instead[{1, kStatus}] = {{{kStatus, 20}}};
  const Nanoseconds begin = alone.clock.now();
  SECTION("half the speed: 4 s and a ramp of 0.5 s") {
    alone.stage.start_move_to(Axis::kX, Millimetres(8.9296875), MillimetresPerSecond(2.232421875));
    check_within_a_look(given_up_after(alone, begin), 10125ms);
  }
  SECTION("constant speed to the end") {
    alone.stage.start_speed(Axis::kX, MillimetresPerSecond(2.232421875));
    check_within_a_look(given_up_after(alone, begin), 10125ms);
  }
  SECTION("a relative move over half the way: 1 s and a ramp of 1 s") {
    alone.stage.start_move_by(Axis::kX, Millimetres(4.46484375), {});
    check_within_a_look(given_up_after(alone, begin), 7s);
  }
  SECTION("another move from where the first one has come: 0.5 s and a ramp of 1 s") {
    alone.stage.start_move_to(Axis::kX, Millimetres(8.9296875), {});
    alone.clock.wait_until(begin + 1500ms);
    alone.stage.start_move_to(Axis::kX, Millimetres(6.697265625), {});
    check_within_a_look(given_up_after(alone, begin + 1500ms), 6375ms);
  }
  SECTION("a longer margin") {
    alone.stage.start_move_to(Axis::kX, Millimetres(0.0), {});
    check_within_a_look(given_up_after(alone, begin), 6250ms - 500ms);
  }
}

TEST_CASE("Zaber stage: the time limit of an axis follows from its own acceleration") {
  std::vector<ChainDeviceOptions> devices = even_chain();
  devices[0].acceleration = 8;  // a ramp of 0.5 s
  ReadyStage alone(even_stage(), devices);
  alone.instead[{1, kStatus}] = {{{kStatus, 20}}};
  const Nanoseconds begin = alone.clock.now();
  SECTION("a move: 2.5 s and two ramps") {
    alone.polls.clear();
    alone.stage.start_move_to(Axis::kX, Millimetres(8.9296875), {});
    check_within_a_look(given_up_after(alone, begin), 6375ms);
    REQUIRE(alone.polls.size() > 30);
    CHECK(alone.polls[25] - begin == 2400ms);
    CHECK(alone.polls[27] - alone.polls[26] == 12500us);
  }
  SECTION("half the speed: 4 s and a ramp of 0.25 s, and two ramps of 0.5 s") {
    alone.stage.start_move_to(Axis::kX, Millimetres(8.9296875), MillimetresPerSecond(2.232421875));
    check_within_a_look(given_up_after(alone, begin), 8562500us);
  }
  SECTION("a stop") {
    CHECK(fault_id_of([&] { (void)alone.stage.stop(Axis::kX); }) == "TB-STAGE-OVERDUE");
    check_within_a_look(alone.clock.now() - begin, 2625ms);
  }
}

TEST_CASE("Zaber stage: the time limit of homing is the home timeout") {
  ZaberStageOptions options = even_stage();
  options.axes[0].home_timeout = 10s;
  ReadyStage alone(options);
  alone.instead[{1, kStatus}] = {{{kStatus, 1}}};
  alone.polls.clear();
  const Nanoseconds begin = alone.clock.now();
  CHECK(fault_id_of([&] { alone.stage.home(Axis::kX); }) == "TB-STAGE-OVERDUE");
  CHECK(alone.clock.now() - begin == 10s);
  CHECK(alone.polls.size() == 102);  // each 100 ms, both ends, and once after the stop
  // From then on it counts as not homed.
  CHECK(fault_id_of([&] { alone.stage.start_move_to(Axis::kX, Millimetres(1.0), {}); }) == "TB-STAGE-NOT-HOMED");
}

TEST_CASE("Zaber stage: the time limit of a stop is 1.25 times its ramp plus two seconds") {
  ReadyStage alone;
  alone.instead[{1, kStatus}] = {{{kStatus, 23}}};
  alone.polls.clear();
  const Nanoseconds begin = alone.clock.now();
  CHECK(fault_id_of([&] { (void)alone.stage.stop(Axis::kX); }) == "TB-STAGE-OVERDUE");
  check_within_a_look(alone.clock.now() - begin, 3250ms);
  REQUIRE(alone.polls.size() > 12);
  for (std::size_t i = 0; i < 10; ++i) CHECK(alone.polls[i] - begin == i * 100ms);
  CHECK(alone.polls[11] - alone.polls[10] <= 12501us);
}

TEST_CASE("Zaber stage: a stop that a busy device refuses is repeated until its time limit, then is a refusal") {
  ReadyStage alone;
  alone.instead[{1, kStatus}] = {{{kStatus, 1}}};
  alone.instead[{1, kStop}] = {{{kError, kZaberBusy}}};
  const Nanoseconds begin = alone.clock.now();
  check_fault([&] { (void)alone.stage.stop(Axis::kX); }, "TB-STAGE-REFUSED", "stage x (device 1)", "error 255");
  check_within_a_look(alone.clock.now() - begin, 3250ms);
  ScriptedChain::Frames stops = alone.sent();
  std::erase_if(stops, [](const ZaberFrame& one) { return one.command != kStop; });
  CHECK(stops.size() > 250);
  CHECK(std::count(stops.begin(), stops.end(), ZaberFrame{1, kStop, 0, 0}) == std::ssize(stops));
  // Another refusal is one at once.
  alone.sent();
  alone.instead[{1, kStop}] = {{{kError, 64}}};
  CHECK(fault_id_of([&] { (void)alone.stage.stop(Axis::kX); }) == "TB-STAGE-REFUSED");
  CHECK(alone.sent().size() == 2);
  // A move that a busy device refuses is not sent again.
  alone.instead[{1, kMoveAbsolute}] = {{{kError, kZaberBusy}}};
  CHECK(fault_id_of([&] { alone.stage.start_move_to(Axis::kX, Millimetres(1.0), {}); }) == "TB-STAGE-REFUSED");
  CHECK(alone.chain.count(kMoveAbsolute) == 1);
}

TEST_CASE("Zaber stage: a stop refused exactly at its time limit is not repeated") {
  ZaberStageOptions options = even_stage();
  options.axes[0].maximum_speed = MillimetresPerSecond(ZaberUnits{0.00635 / 64}.acceleration_mm_per_s2(4));
  ReadyStage alone(options);
  const bool over = GENERATE(false, true);
  const Nanoseconds time = alone.clock.now() + 3250ms - (over ? 0ns : 1ns);
  alone.chain.script = [&](const ZaberFrame& frame) -> std::optional<ScriptedChain::Frames> {
    if (frame.command != kStop) return std::nullopt;
    alone.clock.wait_until(time);
    return ScriptedChain::Frames{{1, kError, kZaberBusy, frame.id}};
  };
  CHECK(fault_id_of([&] { (void)alone.stage.stop(Axis::kX); }) == "TB-STAGE-REFUSED");
  CHECK(alone.chain.count(kStop) == (over ? 1 : 2));
}

TEST_CASE("Zaber stage: after a lost reply to a move, the position is queried once the axis is idle") {
  ReadyStage alone;
  alone.instead[{1, kMoveAbsolute}] = {std::nullopt};
  alone.instead[{1, kStatus}] = {{{kStatus, 20}}, {{kStatus, 20}}, {{kStatus, 0}}};
  SECTION("it has arrived") {
    alone.instead[{1, kPosition}] = {{{kPosition, 45000}}};
    alone.stage.start_move_to(Axis::kX, Millimetres(4.46484375), {});
    CHECK(alone.stage.wait(Axis::kX).value() == Approx(4.46484375));
    CHECK(alone.chain.sent.back().command == kPosition);
  }
  SECTION("it stands elsewhere") {
    alone.instead[{1, kPosition}] = {{{kPosition, 44999}}};
    alone.stage.start_move_to(Axis::kX, Millimetres(4.46484375), {});
    check_fault([&] { (void)alone.stage.wait(Axis::kX); }, "TB-STAGE-ASTRAY", "stage x (device 1)", "4.46474 mm");
    CHECK(alone.stage.wait(Axis::kX).value() == Approx(4.46474).epsilon(1e-5));
  }
}

TEST_CASE("Zaber stage: a reply to a move with another position than its target is an astray fault") {
  ReadyStage alone;
  alone.instead[{1, kMoveAbsolute}] = {{{kMoveAbsolute, 45001}}};
  CHECK(fault_id_of([&] { alone.stage.start_move_to(Axis::kX, Millimetres(4.46484375), {}); }) == "TB-STAGE-ASTRAY");
  alone.instead[{1, kMoveAbsolute}] = {{{kMoveAbsolute, 45000}}};
  alone.stage.start_move_to(Axis::kX, Millimetres(4.46484375), {});
  alone.sent();
  CHECK(alone.stage.wait(Axis::kX).value() == Approx(4.46484375));
  CHECK(alone.sent().empty());  // its reply ended it before the wait
}

TEST_CASE("Zaber stage: a move of another program is waited for after arming, at most for the home timeout") {
  ZaberStageOptions options = even_stage();
  options.axes[0].home_timeout = 3s;
  StageAlone alone(options);
  const bool ends = GENERATE(true, false);
  alone.instead[{1, kStatus}] = {{{kStatus, 22}}};
  alone.stage.arm();
  alone.polls.clear();
  if (ends) alone.instead[{1, kStatus}] = {{{kStatus, 22}}, {{kStatus, 22}}, {{kStatus, 0}}};
  const auto fault = fault_of([&] { (void)alone.stage.wait(Axis::kX); });
  CHECK(fault.has_value() == !ends);
  CHECK(alone.clock.now() == (ends ? Nanoseconds(200ms) : Nanoseconds(3s)));
  alone.sent();
  (void)alone.stage.wait(Axis::kY);
  CHECK(alone.sent().empty());
}

// The retreat against devices that answer by a table: what is sent, in which order, and what is told of it.

namespace {

// Three devices at rest; z, the third, stands homed at 2000 steps. A step of z is 0.003048 mm / 64.
struct RetreatBed {
  // Answers in turn to the status query of a device; the last one stays. Error: {kError, code}.
  using Answers = std::deque<std::optional<std::pair<ZaberCommand, std::int32_t>>>;

  RetreatBed() {
    options.axes[1].device = 2;
    options.axes[2].device = 3;
    options.axes[2].device_id = 5082;
    options.axes[2].maximum_speed = MillimetresPerSecond(8.0);
    options.reply_timeout = kPatient;
    options.frame_silence = kPatient;
    options.halt_timeout = kPatient;
    for (std::uint8_t device = 1; device <= 3; ++device) status[device] = {{{kStatus, 0}}};
    mode = {{{kMode, kZaberHomed}}};
    position = {{{kPosition, 20000}}};
    resolution = {{{kResolution, 64}}};
    target_speed = {{{kTargetSpeed, 17918}}};
    chain.script = [this](const ZaberFrame& frame) { return answer(frame); };
  }

  static std::optional<ScriptedChain::Frames> next(const ZaberFrame& frame, Answers& answers) {
    const auto one = answers.front();
    if (answers.size() > 1) answers.pop_front();
    if (!one) return ScriptedChain::Frames{};
    return ScriptedChain::Frames{{frame.device, one->first, one->second, 0}};
  }
  std::optional<ScriptedChain::Frames> answer(const ZaberFrame& frame) {
    if (frame.command == kStatus) return next(frame, status[frame.device]);
    if (frame.device != 3) return ScriptedChain::Frames{};
    if (frame.command == kReturnSetting) return next(frame, frame.data == 40 ? mode : resolution);
    if (frame.command == kPosition) return next(frame, position);
    if (frame.command == kTargetSpeed) return next(frame, target_speed);
    if (frame.command == kMoveAbsolute && obeys) position = {{{kPosition, frame.data}}};
    return ScriptedChain::Frames{};
  }
  StageRetreat retreat_by(double millimetres, Nanoseconds move_timeout = kPatient) {
    return retreat(chain.open(), options, Millimetres(millimetres), move_timeout);
  }
  [[nodiscard]] std::vector<std::int32_t> targets() const {
    std::vector<std::int32_t> all;
    for (const ZaberFrame& one : chain.sent) {
      if (one.command == kMoveAbsolute) all.push_back(one.data);
    }
    return all;
  }
  [[nodiscard]] std::size_t stops_of(std::uint8_t device) const {
    return static_cast<std::size_t>(std::count(chain.sent.begin(), chain.sent.end(), ZaberFrame{device, kStop, 0, 0}));
  }

  ScriptedChain chain{nullptr, {}};
  ZaberStageOptions options;
  std::map<std::uint8_t, Answers> status;
  Answers mode, position, resolution, target_speed;
  bool obeys = true;
};

}  // namespace

TEST_CASE("Zaber retreat: stops all axes, asks each whether it is at rest, then moves z away at its top speed") {
  RetreatBed bed;
  const StageRetreat result = bed.retreat_by(0.47625);  // 10000 steps
  CHECK(result.stands);
  CHECK(result.backed_off);
  CHECK(bed.chain.discards == 1);
  CHECK(bed.chain.sent == std::vector<ZaberFrame>{{0, kStop, 0, 0},
                                                  {1, kStatus, 0, 0},
                                                  {2, kStatus, 0, 0},
                                                  {3, kStatus, 0, 0},
                                                  {3, kReturnSetting, 40, 0},
                                                  {3, kPosition, 0, 0},
                                                  {3, kReturnSetting, 37, 0},
                                                  {3, kTargetSpeed, 17918, 0},
                                                  {3, kMoveAbsolute, 10000, 0},
                                                  {3, kPosition, 0, 0}});
}

TEST_CASE("Zaber retreat: repeats the stop until an axis slows down, and queries it until it is at rest") {
  RetreatBed bed;
  bed.status[1] = {{{kStatus, 20}}, {{kStatus, 1}}, {{kStatus, 23}}, {{kStatus, 23}}, {{kStatus, 0}}};
  bed.status[2] = {std::nullopt, {{kError, 255}}, {{kError, 0}}, {{kStatus, 0}}};
  const StageRetreat result = bed.retreat_by(0.47625);
  CHECK(result.stands);
  CHECK(result.backed_off);
  CHECK(bed.stops_of(0) == 1);
  CHECK(bed.stops_of(1) == 2);
  CHECK(bed.stops_of(2) == 2);
  CHECK(bed.stops_of(3) == 0);
  const auto asked = [&](std::uint8_t device) {
    return std::count(bed.chain.sent.begin(), bed.chain.sent.end(), ZaberFrame{device, kStatus, 0, 0});
  };
  CHECK(asked(1) == 5);
  CHECK(asked(2) == 4);
  CHECK(asked(3) == 1);
}

TEST_CASE("Zaber retreat: reports an axis that does not come to rest, and moves z away all the same") {
  RetreatBed bed;
  const std::uint8_t device = GENERATE(std::uint8_t{1}, std::uint8_t{2}, std::uint8_t{3});
  bed.status[device] = GENERATE(RetreatBed::Answers{std::nullopt}, RetreatBed::Answers{{{kStatus, 20}}},
                                RetreatBed::Answers{{{kError, 0}}});
  bed.options.halt_timeout = 30ms;
  const StageRetreat result = bed.retreat_by(0.47625);
  CHECK_FALSE(result.stands);
  CHECK(result.backed_off);
}

TEST_CASE("Zaber retreat: asks at most twice for z's mode and position, and does not move z without them") {
  RetreatBed bed;
  RetreatBed::Answers RetreatBed::*const lost = GENERATE(&RetreatBed::mode, &RetreatBed::position);
  bed.*lost = GENERATE(RetreatBed::Answers{std::nullopt}, RetreatBed::Answers{{{kError, 64}}});
  const StageRetreat result = bed.retreat_by(0.47625);
  CHECK(result.stands);
  CHECK_FALSE(result.backed_off);
  CHECK(bed.chain.count(kReturnSetting) + bed.chain.count(kPosition) == 3);
  CHECK(bed.targets().empty());
}

TEST_CASE("Zaber retreat: repeats a query once if its answer was lost") {
  RetreatBed bed;
  RetreatBed::Answers RetreatBed::*const lost =
      GENERATE(&RetreatBed::mode, &RetreatBed::position, &RetreatBed::resolution, &RetreatBed::target_speed);
  (bed.*lost).push_front(GENERATE(std::optional<std::pair<ZaberCommand, std::int32_t>>(),
                                  std::optional<std::pair<ZaberCommand, std::int32_t>>({kError, 255})));
  const StageRetreat result = bed.retreat_by(0.47625);
  CHECK(result.backed_off);
  CHECK(bed.targets() == std::vector<std::int32_t>{10000});
}

TEST_CASE("Zaber retreat: does not move z if its step is unknown or it is not homed, whatever its other mode bits") {
  RetreatBed bed;
  SECTION("step of the model") { bed.options.axes[2].device_id = 61; }
  SECTION("homed bit") { bed.mode = {{{kMode, 0xFFFF & ~kZaberHomed}}}; }
  const StageRetreat result = bed.retreat_by(0.47625);
  CHECK(result.stands);
  CHECK_FALSE(result.backed_off);
  CHECK(bed.targets().empty());
}

TEST_CASE("Zaber retreat: converts the distance with z's resolution, or with 64 if z does not report one") {
  const auto [told, target] = GENERATE(
      table<std::optional<std::pair<ZaberCommand, std::int32_t>>, std::int32_t>({{std::pair(kResolution, 128), 10000},
                                                                                 {std::pair(kResolution, 1), 19922},
                                                                                 {std::pair(kResolution, 0), 15000},
                                                                                 {std::pair(kResolution, -1), 15000},
                                                                                 {std::pair(kError, 53), 15000},
                                                                                 {std::nullopt, 15000}}));
  RetreatBed bed;
  bed.resolution = {told};
  CHECK(bed.retreat_by(0.238125).backed_off);  // 5000 steps of 1/64
  CHECK(bed.targets() == std::vector<std::int32_t>{target});
}

TEST_CASE("Zaber retreat: moves z to its home if the distance ends there, beyond it, or is NaN") {
  RetreatBed bed;
  CHECK(bed.retreat_by(GENERATE(0.95, 0.9525, 0.96, 50.0, std::nan(""), HUGE_VAL)).backed_off);
  REQUIRE(bed.targets().size() == 1);
  CHECK(bed.targets()[0] >= 0);
  CHECK(bed.targets()[0] <= 53);  // 20000 - 19948 for the first
}

TEST_CASE("Zaber retreat: leaves z's speed as it is if the top speed is NaN") {
  RetreatBed bed;
  bed.options.axes[2].maximum_speed = MillimetresPerSecond(std::nan(""));
  CHECK(bed.retreat_by(0.47625).backed_off);
  CHECK(bed.chain.count(kTargetSpeed) == 0);
}

TEST_CASE("Zaber retreat: fails if z stays or stops answering, and tolerates two lost answers on the way") {
  RetreatBed bed;
  bed.obeys = false;
  SECTION("it stays") {
    const StageRetreat result = bed.retreat_by(0.47625, 50ms);
    CHECK(result.stands);
    CHECK_FALSE(result.backed_off);
    CHECK(bed.chain.count(kPosition) >= 2);
  }
  SECTION("it answers no more") {
    bed.position = {{{kPosition, 20000}}, std::nullopt};
    const StageRetreat result = bed.retreat_by(0.47625, 50ms);
    CHECK_FALSE(result.backed_off);
  }
  SECTION("it arrives later, between two answers that are lost") {
    bed.position = {{{kPosition, 20000}}, {{kPosition, 15000}}, std::nullopt, std::nullopt, {{kPosition, 10000}}};
    const StageRetreat result = bed.retreat_by(0.47625);
    CHECK(result.backed_off);
  }
}

TEST_CASE("Zaber retreat: does not wait if z is already at its home") {
  RetreatBed bed;
  bed.position = {{{kPosition, 0}}};
  CHECK(bed.retreat_by(1.0, 0s).backed_off);
  CHECK(bed.chain.count(kPosition) == 1);
}
