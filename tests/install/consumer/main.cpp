// One taxel from counts to pressure, with nothing but the installed package.
#include <array>
#include <cstdio>

#include "analysis/compensate/frame_compensator.h"

int main() {
  using namespace tactbench::analysis;
  FrameSetup setup;
  setup.pressure_psi = {0, 20, 40, 60};
  setup.taxels = {{true, {0, 1, 2, 3}, {0, 1.5, 2.5, 3}, {0.8, 0.97, -0.007, 0.6, 0.34}, 0.0, false}};
  setup.volts_per_count = 5.0 / 65536;
  setup.start_unknown = false;
  setup.elam.exact_outer = true;
  FrameCompensator<double> compensator(setup);
  std::array<double, 1> psi{}, uncertainty{};
  std::array<std::uint16_t, 1> status{};
  compensator.frame(std::array<std::uint16_t, 1>{13107}, {psi, uncertainty, status});  // 1 V, rising: 20 psi
  std::printf("%.3f %u\n", psi[0], static_cast<unsigned>(status[0]));
}
