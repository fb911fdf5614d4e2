// A plant with an array of 2 x 3 taxels under a manual clock, and a stage whose positions the test sets.
#pragma once

#include <array>
#include <catch2/catch.hpp>
#include <functional>
#include <utility>
#include <vector>

#include "bench/simulation/plant.h"

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
