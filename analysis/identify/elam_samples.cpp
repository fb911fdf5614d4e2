#include "analysis/identify/elam_samples.h"

#include <algorithm>

namespace tactbench::analysis {
namespace {

// Adds a sample to its curve and returns what J gains whatever the model's value there.
double add_sample(CurveSamples& curve, double x, double y) {
  const auto found = std::ranges::find(curve.x, x);
  if (found == curve.x.end()) {
    curve.x.push_back(x);
    curve.y.push_back(y);
    curve.weight.push_back(1.0);
    return 0.0;
  }
  const auto i = static_cast<std::size_t>(found - curve.x.begin());
  const double off = y - curve.y[i], weight = curve.weight[i];
  curve.weight[i] += 1.0;
  curve.y[i] += off / curve.weight[i];
  return off * off * weight / (weight + 1.0);
}

}  // namespace

TurningPoint turning_point(const ElamModel& model, const TaxelBranch& branch) {
  const double x = branch.pressure_psi.front(), near = kOuterShare * (model.xu() - model.x0());
  if (branch.ascending && x - model.x0() <= near) return {model.x0(), model.y0()};
  if (!branch.ascending && model.xu() - x <= near) return {model.xu(), model.yu()};
  return {x, branch.volts.front()};
}

ElamSamples collect_samples(const ElamModel& model, std::span<const TaxelBranch> branches) {
  ElamSamples samples;
  for (const TaxelBranch& branch : branches) {
    const TurningPoint turn = turning_point(model, branch);
    std::vector<CurveSamples>& curves = branch.ascending ? samples.ascending : samples.descending;
    double& constant = branch.ascending ? samples.ascending_constant : samples.descending_constant;
    auto curve =
        std::ranges::find_if(curves, [&](const CurveSamples& c) { return c.x_turn == turn.x && c.y_turn == turn.y; });
    if (curve == curves.end()) curve = curves.insert(curves.end(), CurveSamples{turn.x, turn.y, {}, {}, {}});
    for (std::size_t i = 1; i < branch.volts.size(); ++i)
      constant += add_sample(*curve, branch.pressure_psi[i], branch.volts[i]);
  }
  return samples;
}

}  // namespace tactbench::analysis
