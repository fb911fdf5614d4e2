#include "analysis/identify/elam/elam_samples.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace tactbench::analysis {
namespace {

// Puts the samples at the same place together and returns what J gains by them whatever the model's value there.
double merge(CurveSamples& curve) {
  std::vector<std::size_t> order(curve.x.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return curve.x[i]; });
  CurveSamples merged{curve.x_turn, curve.y_turn, {}, {}, {}};
  double constant = 0.0;
  for (const std::size_t i : order) {
    if (merged.x.empty() || curve.x[i] != merged.x.back()) {
      merged.x.push_back(curve.x[i]);
      merged.y.push_back(curve.y[i]);
      merged.weight.push_back(1.0);
      continue;
    }
    double &mean = merged.y.back(), &weight = merged.weight.back();
    const double off = curve.y[i] - mean;
    constant += off * off * weight / (weight + 1.0);
    weight += 1.0;
    mean += off / weight;
  }
  curve = std::move(merged);
  return constant;
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
  std::map<std::pair<double, double>, std::size_t> ascending, descending;  // places of curves by turning point
  for (const TaxelBranch& branch : branches) {
    const TurningPoint turn = turning_point(model, branch);
    std::vector<CurveSamples>& curves = branch.ascending ? samples.ascending : samples.descending;
    const auto [place, is_new] =
        (branch.ascending ? ascending : descending).try_emplace({turn.x, turn.y}, curves.size());
    if (is_new) curves.push_back({turn.x, turn.y, {}, {}, {}});
    CurveSamples& curve = curves[place->second];
    curve.x.insert(curve.x.end(), branch.pressure_psi.begin() + 1, branch.pressure_psi.end());
    curve.y.insert(curve.y.end(), branch.volts.begin() + 1, branch.volts.end());
  }
  for (CurveSamples& curve : samples.ascending) samples.ascending_constant += merge(curve);
  for (CurveSamples& curve : samples.descending) samples.descending_constant += merge(curve);
  return samples;
}

void thin(std::vector<CurveSamples>& curves, std::size_t most) {
  std::size_t count = 0;
  for (const CurveSamples& curve : curves) count += curve.x.size();
  if (count <= most) return;
  // Multiples of the golden section, modulo 1, are even over any stretch and in step with no period of the data.
  constexpr double kGolden = 0.6180339887498949;
  const double share = static_cast<double>(most) / static_cast<double>(count);
  std::size_t number = 0;
  for (CurveSamples& curve : curves) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      if (std::fmod(kGolden * static_cast<double>(++number), 1.0) >= share) continue;
      curve.x[kept] = curve.x[i];
      curve.y[kept] = curve.y[i];
      curve.weight[kept++] = curve.weight[i];
    }
    for (std::vector<double>* list : {&curve.x, &curve.y, &curve.weight}) list->resize(kept);
  }
  std::erase_if(curves, [](const CurveSamples& curve) { return curve.x.empty(); });
}

std::array<double, 3> direction_of(const ElamParameters& p, bool ascending, double length) {
  if (!ascending) return {p.alpha_d, p.beta_d, 0.0};
  return {p.alpha_a0, p.alpha_a0 + p.alpha_a1 * length, p.beta_a};
}

void set_direction(ElamParameters& p, bool ascending, double length, const double* at) {
  if (ascending) {
    p.alpha_a0 = at[0];
    p.alpha_a1 = (at[1] - at[0]) / length;
    p.beta_a = at[2];
  } else {
    p.alpha_d = at[0];
    p.beta_d = at[1];
  }
}

}  // namespace tactbench::analysis
