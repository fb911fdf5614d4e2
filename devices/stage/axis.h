// Names of a stage's axes.
#pragma once

namespace tactbench::devices {

enum class Axis { kX, kY, kZ };
inline constexpr int kAxes = 3;

}  // namespace tactbench::devices
