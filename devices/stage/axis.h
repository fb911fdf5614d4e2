// The axes of a stage.
#pragma once

namespace tactbench::devices {

enum class Axis { kX, kY, kZ };
inline constexpr int kAxes = 3;

}  // namespace tactbench::devices
