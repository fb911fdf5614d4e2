// The line of a chain: which reply belongs to which instruction, and how long it is waited for.
#include "devices/stage/zaber_line.h"

#include <catch2/catch.hpp>

#include "tests/devices/stage/scripted_chain.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

namespace {

// A line whose devices say only what a test says.
struct LineAlone {
  explicit LineAlone(Nanoseconds reply_timeout = kPatient)
      : line(chain.open(), reply_timeout, kPatient, [this](const ZaberFrame& frame) { others.push_back(frame); }) {}

  ScriptedChain chain{nullptr, {}};
  std::vector<ZaberFrame> others;
  ZaberLine line;
};

}  // namespace

TEST_CASE("the reply to a query is the one with its device and its message id, and others go to the listener") {
  LineAlone alone;
  const ZaberFrame own{2, kPosition, 77, 1};
  const std::vector<ZaberFrame> foreign{{3, kPosition, 1, 1}, {2, kPosition, 2, 2}, {2, kPosition, 3, 0}};
  for (const ZaberFrame& one : foreign) alone.chain.say(one);
  alone.chain.say(own);
  alone.chain.say({2, kPosition, 99, 1});
  CHECK(alone.line.ask(2, kPosition, -5) == own);
  CHECK(alone.chain.sent == std::vector<ZaberFrame>{{2, kPosition, -5, 1}});
  CHECK(alone.others == foreign);
  CHECK(alone.chain.pieces.size() == 1);
}

TEST_CASE("a query takes an error for its reply, and what came with its reply goes to the listener") {
  LineAlone alone;
  std::vector<std::uint8_t> both;
  for (const ZaberFrame& one : {ZaberFrame{2, kError, 20, 1}, ZaberFrame{2, kError, 21, 1}}) {
    const ZaberBytes bytes = encode(one);
    both.insert(both.end(), bytes.begin(), bytes.end());
  }
  alone.chain.say_bytes(both);
  CHECK(alone.line.ask(2, kMoveAbsolute, 1) == ZaberFrame{2, kError, 20, 1});
  CHECK(alone.others == std::vector<ZaberFrame>{{2, kError, 21, 1}});
}

TEST_CASE("a reply in single bytes is put together") {
  LineAlone alone;
  for (const std::uint8_t byte : std::vector<std::uint8_t>{2, 60, 0x18, 0xFC, 0xFF, 1}) alone.chain.say_bytes({byte});
  CHECK(alone.line.ask(2, kPosition, 0) == ZaberFrame{2, kPosition, -1000, 1});
  CHECK(alone.chain.reads == 6);
}

TEST_CASE("without a reply a query ends after the first wait in vain, which is no longer than the reply timeout") {
  LineAlone alone(3s);
  CHECK_FALSE(alone.line.ask(2, kPosition, 0).has_value());
  CHECK_FALSE(alone.line.ask_plainly(2, kPosition, 0).has_value());
  CHECK(alone.chain.reads == 2);
  CHECK(alone.chain.longest_wait <= 3s);
  CHECK(alone.chain.longest_wait > 0s);
}

TEST_CASE("a reply that trickles past its time is not waited for any longer") {
  LineAlone alone(0s);
  alone.chain.say_bytes({2, 60, 1});
  alone.chain.say_bytes({0, 0, 1});
  CHECK_FALSE(alone.line.ask(2, kPosition, 0).has_value());
  CHECK(alone.chain.reads == 1);
  alone.chain.pieces.clear();
}

TEST_CASE("a reply that lies on the line is found by a program that was held up past its time, and once only") {
  LineAlone alone(1s);
  const ZaberFrame foreign{3, kPosition, 1, 0}, own{2, kPosition, 77, 1};
  for (const ZaberFrame& one : {foreign, own}) alone.chain.say(one);
  alone.chain.held_up = 1100ms;
  CHECK(alone.line.ask(2, kPosition, 0) == own);
  for (const ZaberFrame& one : {foreign, foreign, foreign}) alone.chain.say(one);
  alone.chain.held_up = 1100ms;
  CHECK_FALSE(alone.line.ask(2, kPosition, 0).has_value());
  CHECK(alone.chain.pieces.size() == 1);
}

TEST_CASE("message ids count from 1 to 254 and leave out those whose reply is still to come") {
  LineAlone alone;
  CHECK(alone.line.send(1, kMoveAbsolute, 3) == 1);
  CHECK(alone.line.send(2, kMoveAbsolute, 4) == 2);
  for (int id = 3; id <= 254; ++id) (void)alone.line.ask(1, kStatus, 0);
  REQUIRE(alone.chain.sent.size() == 254);
  for (std::size_t i = 0; i < 254; ++i) CHECK(alone.chain.sent[i].id == i + 1);
  (void)alone.line.ask(1, kStatus, 0);
  CHECK(alone.chain.sent.back().id == 3);
  alone.line.release(2);
  for (int id = 4; id <= 254; ++id) (void)alone.line.ask(1, kStatus, 0);
  CHECK(alone.chain.sent.back().id == 254);
  CHECK(alone.line.send(1, kStop, 0) == 2);
  CHECK(alone.line.send(1, kStop, 0) == 3);
  alone.line.send_plainly(1, kStop, 0);
  CHECK(alone.chain.sent.back() == ZaberFrame{1, kStop, 0, 0});
}

TEST_CASE(
    "a reply without message id is known by its device and its command, a setting's by its number, or is an error") {
  struct Plain {
    ZaberCommand command;
    std::int32_t data;
    ZaberFrame reply;
    bool own;
  };
  for (const Plain& one : std::vector<Plain>{{kStatus, 0, {2, kStatus, 9, 0}, true},
                                             {kStatus, 0, {2, kError, 64, 0}, true},
                                             {kStatus, 0, {3, kStatus, 9, 0}, false},
                                             {kStatus, 0, {3, kError, 64, 0}, false},
                                             {kStatus, 0, {2, kStatus, 9, 1}, false},
                                             {kStatus, 0, {2, kError, 9, 1}, false},
                                             {kStatus, 0, {2, kPosition, 9, 0}, false},
                                             {kReturnSetting, 40, {2, kMode, 9, 0}, true},
                                             {kReturnSetting, 40, {2, kError, 53, 0}, true},
                                             {kReturnSetting, 40, {2, kHomeSpeed, 9, 0}, false},
                                             {kReturnSetting, 40, {3, kMode, 9, 0}, false},
                                             {kReturnSetting, 40, {2, kMode, 9, 7}, false},
                                             {kEcho, 40, {2, kMode, 9, 0}, false},
                                             {kEcho, 40, {2, kEcho, 40, 0}, true}}) {
    LineAlone alone;
    INFO(name(one.command) << ": " << name(one.reply.command) << " of " << int(one.reply.device));
    alone.chain.say(one.reply);
    const auto reply = alone.line.ask_plainly(2, one.command, one.data);
    CHECK(alone.chain.sent == std::vector<ZaberFrame>{{2, one.command, one.data, 0}});
    CHECK(reply.has_value() == one.own);
    if (reply) CHECK(*reply == one.reply);
    CHECK(alone.others == (one.own ? std::vector<ZaberFrame>{} : std::vector<ZaberFrame>{one.reply}));
  }
}

TEST_CASE("renumbering waits for as many answers as there are devices, no longer than it is told") {
  LineAlone alone;
  const std::vector<ZaberFrame> before{{1, kRenumber, 60, 0}, {9, kStatus, 0, 0}};
  for (const ZaberFrame& one : before) alone.chain.say(one);
  alone.chain.say({2, kRenumber, 60, 0});
  alone.chain.say({7, kStatus, 1, 0});
  alone.line.renumber(2, 7s);
  CHECK(alone.chain.sent == std::vector<ZaberFrame>{{0, kRenumber, 0, 0}});
  CHECK(alone.others == before);
  CHECK(alone.chain.pieces.size() == 1);
  CHECK(alone.chain.longest_wait <= 7s);
}

TEST_CASE("a line settles for longer than devices keep half a frame, and what was left on it is discarded") {
  LineAlone alone;
  alone.chain.say({1, kStatus, 0, 0});
  const auto begin = std::chrono::steady_clock::now();
  alone.line.settle();
  CHECK(std::chrono::steady_clock::now() - begin > 10ms);
  CHECK(alone.chain.discards == 1);
  CHECK(alone.chain.pieces.empty());
  CHECK(alone.chain.sent.empty());
}

TEST_CASE("half a reply is dropped after the silence that the line is given") {
  ScriptedChain chain(nullptr, {});
  ZaberLine line(chain.open(), kPatient, 0s, [](const ZaberFrame&) {});
  chain.say_bytes({9, 9, 9});
  chain.say({2, kStatus, 5, 1});
  CHECK(line.ask(2, kStatus, 0) == ZaberFrame{2, kStatus, 5, 1});
}
