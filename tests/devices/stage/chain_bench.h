// One simulated device of the chain without a wire, addressed as a client would.
#pragma once

#include <catch2/catch.hpp>
#include <vector>

#include "devices/stage/chain_device.h"

namespace tactbench::devices {

// Sends each instruction with message id 5.
struct ChainBench {
  explicit ChainBench(const ChainDeviceOptions& options = {}) : device(options) {}

  std::vector<ZaberFrame> send(ZaberCommand command, std::int32_t data, std::uint8_t to = 1) {
    std::vector<ZaberFrame> replies;
    device.run(now, replies);
    replies.clear();
    if (device.hears(to)) device.receive({to, command, data, 5}, now, 1, replies);
    return replies;
  }
  // 0: it refused nothing.
  std::int32_t error_of(ZaberCommand command, std::int32_t data) {
    const auto replies = send(command, data);
    return replies.size() == 1 && replies[0].command == ZaberCommand::kError ? replies[0].data : 0;
  }
  std::vector<ZaberFrame> pass(Nanoseconds time) {
    now += time;
    std::vector<ZaberFrame> replies;
    device.run(now, replies);
    return replies;
  }
  // The data of the single answer.
  std::int32_t read(ZaberCommand command, std::int32_t data = 0) {
    const auto replies = send(command, data);
    REQUIRE(replies.size() == 1);
    return replies[0].data;
  }
  std::int32_t setting(ZaberCommand which) {
    return read(ZaberCommand::kReturnSetting, static_cast<std::int32_t>(which));
  }
  [[nodiscard]] double millimetres() const { return device.position(now).value(); }
  void home() {
    REQUIRE(send(ZaberCommand::kHome, 0).empty());
    REQUIRE(pass(std::chrono::seconds(60)) == std::vector<ZaberFrame>{{1, ZaberCommand::kHome, 0, 5}});
  }
  // An instruction that is answered once its motion has ended, at this place.
  void moves(ZaberCommand command, std::int32_t data, std::int32_t place) {
    INFO(name(command) << " " << data);
    CHECK(send(command, data).empty());
    CHECK(pass(std::chrono::seconds(300)) == std::vector<ZaberFrame>{{1, command, place, 5}});
  }
  void ends_after(Nanoseconds time, const ZaberFrame& reply) {
    CHECK(pass(time - Nanoseconds(1)).empty());
    CHECK(pass(Nanoseconds(1)) == std::vector<ZaberFrame>{reply});
  }
  void go_to(std::int32_t target) {
    REQUIRE(send(ZaberCommand::kMoveAbsolute, target).empty());
    REQUIRE(pass(std::chrono::hours(1)).size() == 1);
  }

  ChainDevice device;
  Nanoseconds now{0};
};

}  // namespace tactbench::devices
