// What the plant asks a simulated stage: where its axes really are.
#pragma once

#include "devices/stage/stage.h"
#include "devices/units.h"

namespace tactbench::devices {

class StageView {
 public:
  virtual ~StageView() = default;
  // Distance from the home sensor at clock.now(), whatever the device believes. Callable from any thread.
  [[nodiscard]] virtual Millimetres position(Axis axis) const = 0;
};

}  // namespace tactbench::devices
