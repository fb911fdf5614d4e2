// The Zaber codec against bytes worked out by hand from the manual's frame layout and figures.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>

#include "devices/stage/zaber_binary.h"
#include "devices/stage/zaber_line.h"
#include "tests/devices/check_codec.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/stage/scripted_chain.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

std::vector<ZaberFrame> frames_of(ZaberParser& parser, std::vector<std::uint8_t> bytes, Nanoseconds time) {
  std::vector<ZaberBytes> found;
  parser.add(bytes, time, found);
  std::vector<ZaberFrame> frames;
  for (const ZaberBytes& one : found) frames.push_back(decode(one));
  return frames;
}

}  // namespace

TEST_CASE("Zaber codec: frames without message ids are device, command and 32 bits, least significant byte first") {
  using enum ZaberCommand;
  for (const auto& [frame, bytes] :
       std::vector<std::pair<ZaberFrame, ZaberBytes>>{{{0, kRenumber, 0, 0}, {0, 2, 0, 0, 0, 0}},
                                                      {{1, kHome, 0, 0}, {1, 1, 0, 0, 0, 0}},
                                                      {{1, kMoveAbsolute, 257, 0}, {1, 20, 1, 1, 0, 0}},
                                                      {{2, kMoveAbsolute, 1066666, 0}, {2, 20, 0xAA, 0x46, 0x10, 0}},
                                                      {{3, kMoveRelative, -1, 0}, {3, 21, 0xFF, 0xFF, 0xFF, 0xFF}},
                                                      {{4, kMoveRelative, -1000, 0}, {4, 21, 0x18, 0xFC, 0xFF, 0xFF}},
                                                      {{1, kFirmware, 523, 0}, {1, 51, 0x0B, 0x02, 0, 0}},
                                                      {{1, kDeviceId, 5082, 0}, {1, 50, 0xDA, 0x13, 0, 0}}})
    check_codec(bytes, frame, encode_without_id,
                [](const ZaberBytes& one) { return std::optional(decode_without_id(one)); });
}

TEST_CASE("Zaber codec: frames with message ids have 24 bits of data and the id last") {
  using enum ZaberCommand;
  for (const auto& [frame, bytes] : std::vector<std::pair<ZaberFrame, ZaberBytes>>{
           {{1, kMoveAbsolute, 1066666, 7}, {1, 20, 0xAA, 0x46, 0x10, 7}},
           {{3, kMoveRelative, -1000, 200}, {3, 21, 0x18, 0xFC, 0xFF, 200}},
           {{1, kError, 20, 9}, {1, 255, 20, 0, 0, 9}},
           {{3, kMoveRelative, kZaberDataMax, 1}, {3, 21, 0xFF, 0xFF, 0x7F, 1}},
           {{3, kMoveRelative, kZaberDataMin, 1}, {3, 21, 0, 0, 0x80, 1}}})
    check_codec(
        bytes, frame, [](const ZaberFrame& one) { return encode(one); },
        [](const ZaberBytes& one) { return std::optional(decode(one)); });
  // The driver's start relies on it: a reply without message ids reads the same when its value fits.
  CHECK(decode(encode_without_id({1, kPosition, 604724, 0})) == ZaberFrame{1, kPosition, 604724, 0});
}

TEST_CASE("Zaber codec: refuses data beyond 24 bits") {
  for (const std::int32_t data : {kZaberDataMax + 1, kZaberDataMin - 1, std::numeric_limits<std::int32_t>::max()})
    check_fault(
        [&] {
          (void)encode({1, ZaberCommand::kMoveAbsolute, data, 1});
        },
        "TB-STAGE-DATA", "device 1", std::to_string(data));
}

TEST_CASE("Zaber codec: every frame survives encoding and decoding") {
  std::mt19937 random(20250101);
  std::uniform_int_distribution<int> byte(0, 255);
  std::uniform_int_distribution<std::int32_t> data(kZaberDataMin, kZaberDataMax);
  std::uniform_int_distribution<std::int32_t> wide(std::numeric_limits<std::int32_t>::min());
  for (int i = 0; i < 20'000; ++i) {
    ZaberFrame frame{static_cast<std::uint8_t>(byte(random)), static_cast<ZaberCommand>(byte(random)), data(random),
                     static_cast<std::uint8_t>(byte(random))};
    REQUIRE(decode(encode(frame)) == frame);
    frame.id = 0;
    frame.data = wide(random);
    REQUIRE(decode_without_id(encode_without_id(frame)) == frame);
  }
}

TEST_CASE("Zaber parser: finds frames however the stream is cut") {
  std::mt19937 random(7);
  std::uniform_int_distribution<int> byte(0, 255);
  std::uniform_int_distribution<std::size_t> length(1, 17);
  std::vector<std::uint8_t> stream(6 * 500);
  for (auto& one : stream) one = static_cast<std::uint8_t>(byte(random));
  ZaberParser parser;
  std::vector<ZaberBytes> found;
  Nanoseconds time{0};
  for (std::size_t at = 0; at < stream.size(); time += 9ms) {
    const std::size_t count = std::min(length(random), stream.size() - at);
    parser.add(std::span(stream).subspan(at, count), time, found);
    at += count;
  }
  REQUIRE(found.size() == 500);
  for (std::size_t i = 0; i < stream.size(); ++i) REQUIRE(found[i / 6][i % 6] == stream[i]);
  CHECK(parser.dropped() == 0);
  CHECK(parser.waiting() == 0);
}

TEST_CASE("Zaber parser: drops an incomplete frame after 10 ms of silence and not before") {
  ZaberParser parser;
  CHECK(frames_of(parser, {1, 60, 0xFF}, 100ms).empty());
  CHECK(frames_of(parser, {0, 0}, 110ms).empty());
  CHECK(parser.waiting() == 5);
  const auto after = frames_of(parser, {1, 60, 5, 0, 0, 3}, 120ms + 1ns);
  REQUIRE(after.size() == 1);
  CHECK(after[0] == ZaberFrame{1, ZaberCommand::kPosition, 5, 3});
  CHECK(parser.dropped() == 5);
  // Silence between whole frames costs nothing.
  CHECK(frames_of(parser, {1, 60, 6, 0, 0, 4}, 10s).size() == 1);
  CHECK(parser.dropped() == 5);
}

TEST_CASE("Zaber parser: drops a single byte before a silence, and an empty read does not end a silence") {
  ZaberParser parser(20ms);
  CHECK(frames_of(parser, {1}, 0ms).empty());
  CHECK(parser.waiting() == 1);
  CHECK(frames_of(parser, {}, 19ms).empty());
  CHECK(frames_of(parser, {2, 60, 5, 0, 0, 3}, 20ms + 1ns) ==
        std::vector<ZaberFrame>{{2, ZaberCommand::kPosition, 5, 3}});
  CHECK(parser.dropped() == 1);
  CHECK(frames_of(parser, {1, 60}, 10s).empty());
  CHECK(frames_of(parser, {5, 0, 0, 3, 9}, 10s + 20ms).size() == 1);
  CHECK(parser.waiting() == 1);
  CHECK(frames_of(parser, {1, 60}, 20s).empty());
  CHECK(parser.dropped() == 2);
  CHECK(parser.waiting() == 2);
}

TEST_CASE("Zaber units: those of the T-NA08A50 and the T-LA60A are the manual's") {
  const ZaberModel* z = zaber_model(5082);
  const ZaberModel* x = zaber_model(60);
  REQUIRE(z != nullptr);
  REQUIRE(x != nullptr);
  CHECK(z->name == "T-NA08A50");
  CHECK(x->name == "T-LA60A");
  CHECK(zaber_model(61) == nullptr);
  const ZaberUnits na{z->full_step_mm / 64};
  const ZaberUnits la{x->full_step_mm / 64};
  CHECK(na.microstep_mm == Approx(0.000047625));
  CHECK(la.microstep_mm == Approx(0.00009921875));
  CHECK(na.microsteps(Millimetres(50.8)) == 1066667);
  CHECK(la.microsteps(Millimetres(60.0)) == 604724);
  CHECK(na.speed(1).value() == Approx(0.00044648).epsilon(1e-4));
  CHECK(la.speed(1).value() == Approx(0.00093018).epsilon(1e-4));
  CHECK(na.speed_data(MillimetresPerSecond(8.0)) == 17918);
  CHECK(la.speed_data(MillimetresPerSecond(4.0)) == 4300);
  CHECK(na.speed(32767).value() == Approx(14.63).epsilon(1e-3));
  CHECK(na.acceleration_mm_per_s2(1) == Approx(0.53578).epsilon(1e-4));
  CHECK(la.acceleration_mm_per_s2(1) == Approx(1.11621).epsilon(1e-4));
  CHECK(la.acceleration_mm_per_s2(0) == Approx(la.acceleration_mm_per_s2(32767)));
}

TEST_CASE("Zaber models: every actuator in the table has its product's travel, step and top speed") {
  for (const auto& [id, product] : std::map<int, std::string>{{5081, "T-NA08A25"},
                                                              {5082, "T-NA08A50"},
                                                              {5085, "T-NA08A25-S"},
                                                              {5086, "T-NA08A50-S"},
                                                              {5091, "T-NA08A25-SV2"},
                                                              {5092, "T-NA08A50-SV2"},
                                                              {5095, "T-NA08A25-SV1"},
                                                              {5096, "T-NA08A50-SV1"},
                                                              {28, "T-LA28A"},
                                                              {60, "T-LA60A"}}) {
    INFO(product);
    const ZaberModel* model = zaber_model(id);
    REQUIRE(model != nullptr);
    CHECK(model->name == product);
    const bool micrometer = product.starts_with("T-NA");  // lead screw of 0.6096 mm and of 1.27 mm a turn, 200 steps
    CHECK(model->full_step_mm == Approx((micrometer ? 0.6096 : 1.27) / 200).epsilon(1e-12));
    CHECK(model->maximum_speed == MillimetresPerSecond(micrometer ? 8.0 : 4.0));
    const double longest = micrometer ? (product.starts_with("T-NA08A50") ? 50.8 : 25.4) : (id == 60 ? 60.0 : 28.0);
    CHECK(model->travel == Millimetres(longest));
  }
}

TEST_CASE("Zaber units: a position converts to microsteps and back within half a microstep, and NaN is refused") {
  const ZaberUnits na{0.003048 / 64};
  std::mt19937 random(11);
  std::uniform_real_distribution<double> millimetres(-50.0, 50.0);
  for (int i = 0; i < 1000; ++i) {
    const Millimetres asked(millimetres(random));
    const auto steps = na.microsteps(asked);
    REQUIRE(steps.has_value());
    REQUIRE(std::abs((na.position(*steps) - asked).value()) <= 0.5001 * na.microstep_mm);
  }
  CHECK_FALSE(na.microsteps(Millimetres(std::nan(""))).has_value());
  CHECK_FALSE(na.microsteps(Millimetres(std::numeric_limits<double>::infinity())).has_value());
  CHECK_FALSE(na.microsteps(Millimetres(1e6)).has_value());
  CHECK_FALSE(na.speed_data(MillimetresPerSecond(-1e9)).has_value());
  const ZaberUnits whole{1.0};
  CHECK(whole.microsteps(Millimetres(8388607.4)) == kZaberDataMax);
  CHECK_FALSE(whole.microsteps(Millimetres(8388607.5)).has_value());
  CHECK(whole.microsteps(Millimetres(-8388608.4)) == kZaberDataMin);
  CHECK_FALSE(whole.microsteps(Millimetres(-8388608.5)).has_value());
  CHECK(whole.microsteps(Millimetres(8388607.0)) == 8388607);
  CHECK(whole.microsteps(Millimetres(-8388608.0)) == -8388608);
}

TEST_CASE("Zaber codec: the named commands and errors are those of the manual of firmware 5") {
  const std::set<int> commands{0,  1,  2,  8,  9,  10, 16, 17, 18, 20, 21, 22, 23, 35, 36, 37, 38, 39,
                               40, 41, 42, 43, 44, 45, 46, 47, 48, 49, 50, 51, 52, 53, 54, 55, 60, 255};
  for (int number = 0; number < 256; ++number) {
    CAPTURE(number);
    CHECK((name(static_cast<ZaberCommand>(number)) != "command " + std::to_string(number)) ==
          commands.contains(number));
  }
  const std::set<int> errors{1,    2,    14,   15,   18,   20,   21,   22,   36,   37,   38,   39,   40,   41,
                             42,   43,   44,   45,   46,   47,   48,   49,   50,   53,   64,   255,  1600, 1601,
                             1700, 1800, 1801, 2146, 3600, 4001, 4002, 4008, 4010, 4011, 4012, 4013, 4014, 4015};
  for (int code = 0; code < 5000; ++code) {
    CAPTURE(code);
    CHECK(zaber_error_text(code).starts_with("error " + std::to_string(code) + ": ") == errors.contains(code));
  }
}

// The line of a chain: which reply belongs to which instruction, and how long it is waited for.

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

TEST_CASE("Zaber line: the reply to a query has its device and message id, other frames go to the listener") {
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

TEST_CASE("Zaber line: an error counts as the reply, and what came with the reply goes to the listener") {
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

TEST_CASE("Zaber line: a reply in single bytes is assembled") {
  LineAlone alone;
  for (const std::uint8_t byte : std::vector<std::uint8_t>{2, 60, 0x18, 0xFC, 0xFF, 1}) alone.chain.say_bytes({byte});
  CHECK(alone.line.ask(2, kPosition, 0) == ZaberFrame{2, kPosition, -1000, 1});
  CHECK(alone.chain.reads == 6);
}

TEST_CASE("Zaber line: a query without a reply ends after one wait, which is at most the reply timeout") {
  LineAlone alone(3s);
  CHECK_FALSE(alone.line.ask(2, kPosition, 0).has_value());
  CHECK_FALSE(alone.line.ask_without_id(2, kPosition, 0).has_value());
  CHECK(alone.chain.reads == 2);
  CHECK(alone.chain.longest_wait <= 3s);
  CHECK(alone.chain.longest_wait > 0s);
}

TEST_CASE("Zaber line: a reply still incomplete at its timeout is not waited for") {
  LineAlone alone(0s);
  alone.chain.say_bytes({2, 60, 1});
  alone.chain.say_bytes({0, 0, 1});
  CHECK_FALSE(alone.line.ask(2, kPosition, 0).has_value());
  CHECK(alone.chain.reads == 1);
  alone.chain.pieces.clear();
}

TEST_CASE("Zaber line: after a delay beyond the timeout, one more read accepts a reply that already arrived") {
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

TEST_CASE("Zaber line: message ids count from 1 to 254 and skip those still waiting for a reply") {
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
  alone.line.send_without_id(1, kStop, 0);
  CHECK(alone.chain.sent.back() == ZaberFrame{1, kStop, 0, 0});
}

TEST_CASE(
    "Zaber line: a reply without message id is matched by device and by command or setting number, or is an error") {
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
    const auto reply = alone.line.ask_without_id(2, one.command, one.data);
    CHECK(alone.chain.sent == std::vector<ZaberFrame>{{2, one.command, one.data, 0}});
    CHECK(reply.has_value() == one.own);
    if (reply) CHECK(*reply == one.reply);
    CHECK(alone.others == (one.own ? std::vector<ZaberFrame>{} : std::vector<ZaberFrame>{one.reply}));
  }
}

TEST_CASE("Zaber line: renumbering waits for as many answers as there are devices, no longer than its time limit") {
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

TEST_CASE("Zaber line: settling outlasts half a frame in the devices, and discards what was left on the line") {
  LineAlone alone;
  alone.chain.say({1, kStatus, 0, 0});
  const auto begin = std::chrono::steady_clock::now();
  alone.line.settle();
  CHECK(std::chrono::steady_clock::now() - begin > 10ms);
  CHECK(alone.chain.discards == 1);
  CHECK(alone.chain.pieces.empty());
  CHECK(alone.chain.sent.empty());
}

TEST_CASE("Zaber line: half a reply is dropped after the set silence") {
  ScriptedChain chain(nullptr, {});
  ZaberLine line(chain.open(), kPatient, 0s, [](const ZaberFrame&) {});
  chain.say_bytes({9, 9, 9});
  chain.say({2, kStatus, 5, 1});
  CHECK(line.ask(2, kStatus, 0) == ZaberFrame{2, kStatus, 5, 1});
}
