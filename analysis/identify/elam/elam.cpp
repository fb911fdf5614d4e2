#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/identify/elam/elam_determined.h"

namespace tactbench::analysis {
namespace {

void check(const PatternCurve& ascending, const PatternCurve& descending, std::span<const TaxelBranch> branches) {
  if (ascending.x().size() < 2 || descending.x().size() < 2 || ascending.x().front() != descending.x().front() ||
      ascending.x().back() != descending.x().back() || ascending.y().front() != descending.y().front() ||
      ascending.y().back() != descending.y().back())
    throw std::invalid_argument("the two pattern curves do not meet at both ends");
  bool up = false, down = false;
  for (const TaxelBranch& branch : branches) {
    if (branch.volts.size() < 2 || branch.volts.size() != branch.pressure_psi.size())
      throw std::invalid_argument("a branch needs at least two samples, with a pressure each");
    const auto finite = [](double value) { return std::isfinite(value); };
    if (!std::ranges::all_of(branch.volts, finite) || !std::ranges::all_of(branch.pressure_psi, finite))
      throw std::invalid_argument("a branch holds a value that is not finite");
    (branch.ascending ? up : down) = true;
  }
  if (!up || !down) throw std::invalid_argument("branches of both directions are needed");
}

}  // namespace

unsigned bounds_met(const ElamModel& model) {
  constexpr double kNear = 1e-9;
  const ElamParameters& p = model.parameters;
  const double v = p.alpha_a1 * (model.xu() - model.x0()) + p.alpha_a0;  // phi(X); phi(0) is alpha_a0
  const double values[] = {p.alpha_d, p.beta_d, v, p.alpha_a0, p.beta_a};
  unsigned bits = 0;
  for (unsigned i = 0; i < 5; ++i)
    if (values[i] <= kNear || values[i] >= 1.0 - kNear) bits |= 1U << i;
  return bits;
}

ElamSamples searched_samples(const ElamModel& model, std::span<const TaxelBranch> branches) {
  check(model.ascending, model.descending, branches);
  ElamSamples samples = collect_samples(model, branches);
  // With exact_outer no parameter moves the external branches: they are scored, not searched.
  if (model.options.exact_outer) {
    std::erase_if(samples.descending, [&](const CurveSamples& c) { return c.x_turn == model.xu(); });
    std::erase_if(samples.ascending, [&](const CurveSamples& c) { return c.x_turn == model.x0(); });
  }
  thin(samples.descending, kSearchedSamples);
  thin(samples.ascending, kSearchedSamples);
  return samples;
}

ElamFit scored(const ElamModel& model, std::span<const TaxelBranch> branches) {
  ElamFit fit;
  fit.model = model;
  fit.full_scale_v = std::max(std::abs(model.y0()), std::abs(model.yu()));
  fit.at_bound = bounds_met(model);
  std::size_t count = 0;
  for (const TaxelBranch& branch : branches) {
    const TurningPoint turn = turning_point(model, branch);
    const ElamCurve curve(model, branch.ascending, turn.x, turn.y);
    for (std::size_t i = 1; i < branch.volts.size(); ++i, ++count) {
      const double error = curve.output(branch.pressure_psi[i]) - branch.volts[i];
      fit.j_v2 += error * error;            // (1)
      fit.mean_error_v += std::abs(error);  // (49)
      fit.max_error_v = std::max(fit.max_error_v, std::abs(error));
    }
  }
  fit.mean_error_v /= static_cast<double>(count);
  return fit;
}

std::vector<std::string> undetermined_names(const ElamFit& fit) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kElamParameterNames.size(); ++i)
    if (((fit.undetermined >> i) & 1U) != 0) names.emplace_back(kElamParameterNames[i]);
  return names;
}

ElamFit identify_elam(const PatternCurve& ascending, const PatternCurve& descending,
                      std::span<const TaxelBranch> branches, const ElamOptions& options, bool settle) {
  ElamModel model{ascending, descending, {}, options};
  const ElamSamples samples = searched_samples(model, branches);
  fit_descending(model, samples.descending);
  fit_ascending(model, samples.ascending);
  unsigned undetermined = 0;
  if (settle) {
    undetermined = settle_undetermined(model, samples.descending, samples.descending_constant, false);
    undetermined |= settle_undetermined(model, samples.ascending, samples.ascending_constant, true);
  }
  ElamFit fit = scored(model, branches);
  fit.undetermined = undetermined;
  return fit;
}

}  // namespace tactbench::analysis
