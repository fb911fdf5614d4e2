// The halt of the Zaber driver, and which line it and identification use, without a wire.
#include <catch2/catch.hpp>

#include "tests/devices/fault_of.h"
#include "tests/devices/stage/scripted_chain.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

TEST_CASE("a halt stops all Zaber axes at once and asks each whether it stands") {
  StageAlone alone;
  alone.ready();
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

TEST_CASE("a halt looks each 20 ms, repeats the stop of what does not slow down, and gives up after its timeout") {
  StageAlone alone;
  alone.ready();
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

TEST_CASE("a halt ends as soon as each Zaber axis stands") {
  StageAlone alone;
  alone.ready();
  alone.instead[{1, kStatus}] = {{{kStatus, 23}}, {{kStatus, 0}}};
  alone.instead[{3, kStatus}] = {{{kStatus, 23}}, {{kStatus, 23}}, {{kStatus, 23}}, {{kStatus, 0}}};
  const Nanoseconds begin = alone.clock.now();
  CHECK(alone.stage.halt());
  CHECK(alone.clock.now() - begin == 60ms);
  CHECK(alone.chain.count(kStatus) == 2 + 1 + 4);
  CHECK(alone.chain.count(kStop) == 1);
}

TEST_CASE("a halt asks a silent Zaber axis twice and no longer, while the others are waited for") {
  StageAlone alone;
  alone.ready();
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

TEST_CASE("a halt opens a lost line once more") {
  StageAlone alone;
  alone.ready();
  SECTION("it can be opened at the second attempt") {
    alone.stage.disarm();
    alone.chain.refused_openings = 1;
    CHECK(alone.stage.halt());
    CHECK(alone.chain.opened == 3);
  }
  SECTION("it cannot be opened") {
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

TEST_CASE("a halted Zaber axis forgets its move") {
  StageAlone alone;
  alone.ready();
  alone.stage.start_move_to(Axis::kX, Millimetres(8.9296875), {});
  alone.clock.wait_until(alone.clock.now() + 1s);
  CHECK(alone.stage.halt());
  alone.stage.arm();
  alone.sent();
  CHECK(alone.stage.wait(Axis::kX).value() == Approx(4.46484375));  // 22500 steps and a ramp of 22500
  CHECK(alone.sent().empty());
}

TEST_CASE("identifying a Zaber stage uses the line of an armed one, and closes the one it opened") {
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

TEST_CASE("identifying a Zaber stage tells an axis that does not answer, and lets the supervision go on before each") {
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
  CHECK(clock.now() == 10s);
  CHECK(found[1].present);
  CHECK_FALSE(found[2].present);
  CHECK_FALSE(found[2].complaint.empty());
  CHECK(found[2].device_id == 0);
  CHECK(stage.identities()[1].firmware == "5.23");
  CHECK(stage.identities()[2].firmware.empty());
}
