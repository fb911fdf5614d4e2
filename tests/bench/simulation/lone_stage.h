// The simulated axes without their wire, for unit tests of the plant.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "devices/clock.h"
#include "devices/stage/chain_device.h"
#include "devices/stage/stage.h"

namespace tactbench::bench {

class LoneStage final : public devices::StageView {
 public:
  // Starts at 0, 0, 0.
  explicit LoneStage(const devices::Clock& clock) : clock_(clock), axes_{axis(60), axis(60), axis(5082)} {}
  [[nodiscard]] devices::Millimetres position(devices::Axis axis) const override {
    return axes_[static_cast<std::size_t>(axis)].position(clock_.now());
  }
  [[nodiscard]] std::array<devices::Millimetres, devices::kAxes> places(devices::Nanoseconds time) const override {
    return {axes_[0].position(time), axes_[1].position(time), axes_[2].position(time)};
  }
  [[nodiscard]] bool at_rest_since(devices::Nanoseconds time) const override {
    return axes_[0].at_rest_since(time) && axes_[1].at_rest_since(time) && axes_[2].at_rest_since(time);
  }
  // Starts a move and returns the time of its end.
  devices::Nanoseconds go(devices::Axis axis, double mm) {
    devices::ChainDevice& device = axes_[static_cast<std::size_t>(axis)];
    const double step = devices::zaber_model(axis == devices::Axis::kZ ? 5082 : 60)->full_step_mm / 64;
    std::vector<devices::ZaberFrame> replies;
    device.run(clock_.now(), replies);
    const auto target = static_cast<std::int32_t>(std::lround(mm / step));
    device.receive({device.number(), devices::ZaberCommand::kMoveAbsolute, target, 0}, clock_.now(), 0, replies);
    return device.due().value_or(clock_.now());
  }

 private:
  static devices::ChainDevice axis(std::int32_t id) {
    devices::ChainDeviceOptions options;
    options.device_id = id;
    options.stands_at = devices::Millimetres(0.0);
    return devices::ChainDevice(options);
  }
  const devices::Clock& clock_;
  std::array<devices::ChainDevice, devices::kAxes> axes_;
};

}  // namespace tactbench::bench
