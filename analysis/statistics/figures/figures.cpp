#include "analysis/statistics/figures/figures.h"

#include "analysis/json_fields.h"

#include <algorithm>
#include <cmath>

namespace tactbench::analysis {

std::map<std::string, double> figures_of(const SensorModel& fit, const Evaluation& evaluation) {
  std::map<std::string, double> figures = {{"hysteresis_max_percent_fs", 100.0 * evaluation.hysteresis_max_fs},
                                           {"hysteresis_mean_percent_fs", 100.0 * evaluation.hysteresis_mean_fs},
                                           JSON_FIELDS(evaluation, mean_error_psi, max_error_psi),
                                           {"worst_taxel_error_psi", evaluation.worst_taxel_mean_error_psi},
                                           {"distance_of_mean_percent_fs", 100.0 * evaluation.comp_distance_of_mean},
                                           {"flat_percent", 100.0 * evaluation.flat_share},
                                           {"full_scale_v", evaluation.full_scale_v}};
  double noise_v = 0.0, zero_v = 0.0, fitted = 0.0;
  ElamParameters sum{0.0, 0.0, 0.0, 0.0, 0.0};
  for (const ModelTaxel& taxel : fit.array()) {
    noise_v = std::max(noise_v, taxel.noise);
    if (!taxel.fitted()) continue;
    zero_v += taxel.y0();
    fitted += 1.0;
    const ElamModel* const elam = elam_of(taxel);
    if (elam == nullptr) continue;
    const ElamParameters& own = elam->parameters;
    sum.alpha_d += own.alpha_d;
    sum.beta_d += own.beta_d;
    sum.alpha_a1 += own.alpha_a1;
    sum.alpha_a0 += own.alpha_a0;
    sum.beta_a += own.beta_a;
  }
  figures["noisiest_taxel_mv"] = 1000.0 * noise_v;
  figures["zero_mv"] = 1000.0 * zero_v / fitted;
  if (elam_of(fit.mean_taxel()) != nullptr) {
    figures["elam_alpha_d"] = sum.alpha_d / fitted;
    figures["elam_beta_d"] = sum.beta_d / fitted;
    figures["elam_alpha_a1_per_psi"] = sum.alpha_a1 / fitted;
    figures["elam_alpha_a0"] = sum.alpha_a0 / fitted;
    figures["elam_beta_a"] = sum.beta_a / fitted;
  }
  figures["unfit_taxels"] = static_cast<double>(fit.array().size()) - fitted;
  std::erase_if(figures, [](const auto& figure) { return !std::isfinite(figure.second); });
  return figures;
}

}  // namespace tactbench::analysis
