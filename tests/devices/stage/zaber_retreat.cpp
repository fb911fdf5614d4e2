// The retreat against devices that answer by a table: what is sent, in which order, and what is told of it.
#include "devices/stage/zaber_retreat.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <map>

#include "tests/devices/stage/scripted_chain.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

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

TEST_CASE("Zaber retreat: does not move z if the step of its model is unknown") {
  RetreatBed bed;
  bed.options.axes[2].device_id = 61;
  CHECK_FALSE(bed.retreat_by(0.47625).backed_off);
  CHECK(bed.targets().empty());
}

TEST_CASE("Zaber retreat: does not move z if it is not homed, whatever its other mode bits") {
  RetreatBed bed;
  bed.mode = {{{kMode, 0xFFFF & ~kZaberHomed}}};
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
