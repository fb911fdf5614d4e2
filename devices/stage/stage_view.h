// Interface from the simulated stage to the simulated plant: the true positions of the axes.
#pragma once

#include <array>

#include "devices/stage/stage.h"
#include "devices/units.h"

namespace tactbench::devices {

class StageView {
 public:
  virtual ~StageView() = default;
  // Distance from the home sensor at clock.now(), whatever the device counts. Callable from any thread.
  [[nodiscard]] virtual Millimetres position(Axis axis) const = 0;
  // The same for x, y, z at `time`, not later than clock.now() and not before the last 256 changes of motion.
  [[nodiscard]] virtual std::array<Millimetres, kAxes> places(Nanoseconds time) const = 0;
  // True only if no axis has moved since `time`.
  [[nodiscard]] virtual bool at_rest_since(Nanoseconds time) const = 0;
};

}  // namespace tactbench::devices
