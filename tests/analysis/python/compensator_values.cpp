// Prints a set-up, frames of counts and what the C++ side makes of them, for compensator_test.py.
#include <cstdio>

#include "tests/analysis/support/frames.h"

using namespace synthetic;

namespace {

void line(const char* name, std::span<const double> values) {
  std::printf("%s", name);
  for (const double value : values) std::printf(" %.17g", value);
  std::printf("\n");
}

}  // namespace

int main() {
  constexpr int kTaxels = 20;
  Frames frames = random_reversals(kTaxels, 300, 0.002, 0.7);
  frames.setup.taxels[3].usable = false;
  line("pressure", frames.setup.pressure_psi);
  line("volts_per_count", std::span(&frames.setup.volts_per_count, 1));
  for (const TaxelSetup& taxel : frames.setup.taxels) {
    const ElamParameters& p = taxel.parameters;
    const double parameters[] = {p.alpha_d, p.beta_d, p.alpha_a1, p.alpha_a0, p.beta_a, taxel.noise_v};
    line("usable", std::vector<double>{taxel.usable ? 1.0 : 0.0});
    line("ascending", taxel.ascending_v);
    line("descending", taxel.descending_v);
    line("parameters", parameters);
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
}
