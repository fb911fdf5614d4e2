#include "analysis/identify/dynamic_setup_of.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/compensate/everett.h"
#include "analysis/error.h"
#include "analysis/models/linearised.h"
#include "analysis/models/preisach.h"

namespace tactbench::analysis {
namespace {

AnalysisError refusal(const SensorModel& model, int taxel, const std::string& why) {
  return {"TB-MODEL-COMPENSATOR",
          fmt::format("the model of {} makes no dynamic compensator: taxel {}: {}", model.source, taxel, why),
          "fit it again: tactbench fit RUN --model dynamic --rate RUN --creep RUN"};
}

// Sums of weights, rounded: of two that are equal one may come out less, and the compensator's table does not fall.
std::vector<double> everett_of(const PreisachModel& film, double gain) {
  const std::size_t n = film.intervals();
  const double step = (film.x_high() - film.x_low()) / static_cast<double>(n);
  const auto at = [&](std::size_t i) { return film.x_low() + step * static_cast<double>(i); };
  const auto place = [](std::size_t i, std::size_t j) { return i * (i + 1) / 2 + j; };
  std::vector<double> table(Everett<double>::size(n), 0.0);
  for (std::size_t i = 1; i <= n; ++i)
    for (std::size_t j = i; j-- > 0;)
      table[place(i, j)] =
          std::max({gain * film.everett(at(i), at(j)), table[place(i - 1, j)], table[place(i, j + 1)]});
  return table;
}

}  // namespace

DynamicSetup dynamic_setup_of(const SensorModel& model, std::span<const ModelTaxel> taxels, double volts_per_count,
                              double noisier) {
  if (!model.dynamics) throw refusal(model, taxels.empty() ? 0 : taxels.front().taxel, "it has no lag and creep");
  DynamicSetup setup;
  setup.dynamics = model.dynamics->shared;
  setup.residual_psi = model.dynamics->residual_shape;
  setup.volts_per_count = volts_per_count;
  for (const ModelTaxel& taxel : taxels) {
    DynamicTaxel& own = setup.taxels.emplace_back();
    if (!taxel.fitted()) continue;
    const LinearisedModel* const outer = linearised_of(taxel);
    const auto* const film = outer == nullptr ? nullptr : dynamic_cast<const PreisachModel*>(&outer->inner());
    if (film == nullptr) throw refusal(model, taxel.taxel, "it is not Preisach on the linearised output");
    if (setup.intervals == 0) {
      setup.x_low = film->x_low();
      setup.x_high = film->x_high();
      setup.intervals = film->intervals();
    }
    if (film->x_low() != setup.x_low || film->x_high() != setup.x_high || film->intervals() != setup.intervals)
      throw refusal(model, taxel.taxel, "its range or number of intervals is not that of the others");
    // The compensator counts u from the unloaded output, which without a divider may lie anywhere.
    const Divider& divider = outer->divider();
    const double offset = film->y_low();
    if (divider.per_amplitude > 0.0 && std::abs(offset) > 1e-9 * std::abs(film->everett(setup.x_high, setup.x_low)))
      throw refusal(model, taxel.taxel, "its divider does not count from the unloaded output");
    // y = zero + gain (z + u / (1 + c u)): with u' = gain u the divider's amplitude grows as the output does.
    own.divider.zero = taxel.from_model(divider.zero + (divider.per_amplitude > 0.0 ? 0.0 : offset));
    own.divider.per_amplitude = divider.per_amplitude / taxel.gain;
    own.everett = everett_of(*film, taxel.gain);
    own.creep_scale = taxel.creep_scale;
    own.lag_share = taxel.lag_share;
    own.noise_v = noisier * taxel.noise;
    own.residual_scale = taxel.residual_psi;
    own.falling = model.falling;
    own.usable = true;
  }
  if (setup.intervals == 0) throw refusal(model, 0, "none of its taxels is fitted");
  return setup;
}

}  // namespace tactbench::analysis
