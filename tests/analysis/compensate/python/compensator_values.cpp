// Prints a set-up, frames of counts and what the C++ side makes of them, for compensator_test.py.
#include <cstdio>

#include "analysis/compensate/dynamic_frame_compensator.h"
#include "tests/analysis/compensate/frames.h"
#include "tests/analysis/support/dynamic_plant.h"

using namespace synthetic;

namespace {

void line(const char* name, std::span<const double> values) {
  std::printf("%s", name);
  for (const double value : values) std::printf(" %.17g", value);
  std::printf("\n");
}

// The dynamic compensator: five taxels, one of them dead, 200 frames 0.4 s apart.
void dynamic_lines() {
  constexpr std::size_t kTaxels = 5;
  DynamicArray array = dynamic_array(kTaxels, 0.002);
  array.setup.taxels[2].usable = false;
  const DynamicSetup& setup = array.setup;
  const Dynamics& d = setup.dynamics;
  line("creep_s", d.creep_s);
  line("creep_share", d.creep_share);
  line("half_and_lag", std::vector<double>{d.creep_half, d.lag_s});
  for (const DynamicTaxel& taxel : setup.taxels) {
    line("dynamic_usable", std::vector<double>{taxel.usable ? 1.0 : 0.0});
    line("everett", taxel.everett);
    line("dynamic", std::vector<double>{taxel.divider.zero, taxel.divider.per_amplitude, taxel.creep_scale,
                                        taxel.lag_share, taxel.noise_v});
  }
  std::vector<DynamicPlant> plants;
  for (std::size_t t = 0; t < kTaxels; ++t) plants.emplace_back(array.films[t], d, setup.taxels[t], 20);
  DynamicFrameCompensator<float> fast(setup);
  fast.set_interval(0.4);
  Results<float> single(kTaxels);
  for (const double psi : random_way(200, 2.0, 6)) {
    std::vector<std::uint16_t> counts;
    for (DynamicPlant& plant : plants)
      counts.push_back(static_cast<std::uint16_t>(std::lround(plant.step(psi, 0.4) * 65536.0 / 5.0)));
    fast.frame(counts, single.output());
    line("dynamic_counts", std::vector<double>(counts.begin(), counts.end()));
    line("dynamic_single", std::vector<double>(single.pressure.begin(), single.pressure.end()));
  }
}

}  // namespace

int main() {
  constexpr int kTaxels = 20;
  Frames frames = random_reversals(kTaxels, 300, 0.002, 0.7);
  frames.setup.taxels[3].usable = false;
  for (std::size_t t = 0; t < kTaxels; ++t)
    if (t != 4)
      for (std::size_t k = 0; k < 12; ++k)
        frames.setup.taxels[t].residual_psi.push_back(0.1 + 0.01 * static_cast<double>(k + t));
  line("pressure", frames.setup.pressure_psi);
  line("volts_per_count", std::span(&frames.setup.volts_per_count, 1));
  for (const TaxelSetup& taxel : frames.setup.taxels) {
    const ElamParameters& p = taxel.parameters;
    const double parameters[] = {p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a, taxel.noise_v};
    line("usable", std::vector<double>{taxel.usable ? 1.0 : 0.0});
    line("ascending", taxel.ascending_v);
    line("descending", taxel.descending_v);
    line("parameters", parameters);
    line("residual", taxel.residual_psi);
  }
  FrameCompensator<double> exact(frames.setup);
  FrameCompensator<float> fast(frames.setup);
  Results<double> whole(kTaxels);
  Results<float> single(kTaxels);
  for (std::size_t f = 0; f < frames.pressure.size(); ++f) {
    exact.frame(frames.at(f), whole.output());
    fast.frame(frames.at(f), single.output());
    line("counts", std::vector<double>(frames.at(f).begin(), frames.at(f).end()));
    line("whole", whole.pressure);
    line("uncertainty", whole.uncertainty);
    line("single", std::vector<double>(single.pressure.begin(), single.pressure.end()));
    line("status", std::vector<double>(single.status.begin(), single.status.end()));
  }
  dynamic_lines();
}
