// A plant with an array of 2 x 3 taxels under a manual clock, and a stage whose positions the test sets.
#pragma once

#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "bench/simulation/plant.h"
#include "devices/clock.h"
#include "devices/stage/chain_device.h"
#include "devices/stage/stage.h"

namespace tactbench::tests {

// A stage with the positions that `where` returns.
struct ScriptedStage final : devices::StageView {
  using Place = std::array<double, 3>;
  explicit ScriptedStage(std::function<Place(double time_s)> given) : where(std::move(given)) {}
  [[nodiscard]] devices::Millimetres position(devices::Axis) const override { return devices::Millimetres(0.0); }
  [[nodiscard]] std::array<devices::Millimetres, devices::kAxes> places(devices::Nanoseconds time) const override {
    ++asked;
    const Place place = where(devices::in_seconds(time));
    return {devices::Millimetres(place[0]), devices::Millimetres(place[1]), devices::Millimetres(place[2])};
  }
  [[nodiscard]] bool at_rest_since(devices::Nanoseconds) const override { return rests; }
  std::function<Place(double)> where;
  mutable int asked = 0;
  bool rests = false;
};

struct SmallPlant {
  explicit SmallPlant(const std::function<void(bench::PlantOptions&)>& change = {}) : plant(made(change), clock) {}
  static bench::PlantOptions made(const std::function<void(bench::PlantOptions&)>& change) {
    bench::PlantOptions options;
    options.seed = 3;
    options.specimen.rows = 2;
    options.specimen.columns = 3;
    options.specimen.sensor_seed = 4;
    if (change) change(options);
    return options;
  }
  void drive(double volts) { plant.drive(devices::Volts(volts), devices::Nanoseconds::max(), devices::Volts(0.0)); }
  void at(devices::Nanoseconds time) { clock.wait_until(time); }
  std::vector<int> scan() {
    std::vector<std::uint16_t> counts(6);
    plant.scan(counts, status);
    return {counts.begin(), counts.end()};
  }
  devices::ManualClock clock;
  bench::Plant plant;
  std::vector<std::uint8_t> status = std::vector<std::uint8_t>(2);
};

}  // namespace tactbench::tests

namespace tactbench::bench {

// The simulated axes without their wire, for unit tests of the plant.

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
