#include "analysis/judgement/measured_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "analysis/loop.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

std::size_t repeats_of(const Dataset& dataset) {
  std::size_t least = dataset.sequences.empty() ? 0 : dataset.sequences.front().repeats.size();
  for (const SequenceData& data : dataset.sequences) least = std::min(least, data.repeats.size());
  return least;
}

Dataset repeat_of(const Dataset& dataset, std::size_t repeat) {
  Dataset one = dataset;
  for (SequenceData& data : one.sequences) data.repeats = {data.repeats[repeat]};
  return one;
}

// The sequences with more than one repeat.
Dataset repeated_of(Dataset dataset) {
  std::erase_if(dataset.sequences, [](const SequenceData& data) { return data.repeats.size() < 2; });
  return dataset;
}

// The figures of each repeat separately: of the judged run, or of the models' run if the judged run has one repeat.
class RepeatScatter {
 public:
  RepeatScatter(const Dataset& judged, const Dataset& models, const SensorModel& fit, int threads,
                ModelRunResults& shared)
      : judged_(std::max<std::size_t>(1, repeats_of(judged))) {
    const bool own = repeats_of(judged) >= 2;
    const auto evaluated = [&](const Dataset& dataset) {
      std::vector<Evaluation> each;
      for (std::size_t repeat = 0; repeat < repeats_of(dataset); ++repeat)
        each.push_back(evaluate(repeat_of(dataset, repeat), fit, threads));
      return each;
    };
    if (!own && !shared.repeats) shared.repeats = evaluated(repeated_of(models));
    repeats_ = own ? evaluated(judged) : *shared.repeats;
    run_ = own ? "the judged run" : "the run of the models, because the judged run has one repeat";
  }

  // Scatter of a mean of absolute errors, also of one taxel, pooled over the taxels.
  [[nodiscard]] FigureScatter errors() const {
    std::vector<std::vector<double>> rows;
    for (const Evaluation& evaluation : repeats_) rows.push_back(evaluation.taxel_mean_error_psi);
    const PooledScatter pooled = pooled_scatter(rows);
    if (!pooled.known()) return {};
    return quotient(pooled.s, pooled.dof, judged_,
                    fmt::format("scatter of a taxel over {} repeats of {}, pooled over {} taxels ({:.1f} degrees of "
                                "freedom)",
                                pooled.rows, run_, pooled.parts, pooled.dof));
  }

 private:
  std::size_t judged_;
  std::vector<Evaluation> repeats_;  // empty: fewer than two repeats, no scatter
  std::string run_;
};

std::vector<VarianceShare> shares_of(const ReferenceUncertainty& reference, double drift_psi) {
  std::vector<VarianceShare> shares;
  for (const ReferenceRow& row : reference.rows(reference.largest_certificate_u(), drift_psi))
    shares.push_back({row.u_psi, kInfiniteDof});
  return shares;
}

// `firm`: the contributions that give the degrees of freedom.
FigureUncertainty expanded(std::string basis, const std::vector<VarianceShare>& shares,
                           const std::vector<VarianceShare>& firm) {
  FigureUncertainty u;
  u.combined = combined_uncertainty(shares);
  u.dof = effective_dof(firm);
  u.factor = coverage_factor(std::max(1.0, u.dof));
  u.expanded = u.factor * u.combined;
  u.basis = std::move(basis);
  return u;
}

FigureUncertainty unknown(std::string why) {
  FigureUncertainty u;
  u.missing = std::move(why);
  return u;
}

constexpr const char* kOneRepeat = "neither the judged run nor that of the models has two repeats";
constexpr const char* kOneSweep = "neither the judged run nor that of the models has two full sweeps at its levels";

std::string limits_sentence(const ReferenceUncertainty& reference) {
  constexpr std::array<const char*, kReferenceParts> kNames = {"voltage input", "hysteresis", "zero", "temperature"};
  std::string words;
  for (std::size_t part = 0; part < kReferenceParts; ++part)
    if (reference.limits[part].half_width_psi > 0.0) words += fmt::format(", {}", kNames[part]);
  return words;
}

// Of a mean of absolute errors against the reference.
FigureUncertainty error_uncertainty(const FigureScatter& scatter, const ReferenceUncertainty& reference) {
  if (!reference.certificate_missing.empty()) return unknown(reference.certificate_missing);
  if (reference.untraced() && !reference.overdue)
    return unknown("the run goes beyond the pressures that the reference's certificate covers");
  if (!scatter.known()) return unknown(kOneRepeat);
  // A drift beyond its stated limit raises u but does not lower k: it adds doubt, not degrees of freedom.
  std::vector<VarianceShare> shares = shares_of(reference, reference.drift_psi);
  std::vector<VarianceShare> firm = shares_of(reference, std::min(reference.drift_psi, reference.drift_stated_psi));
  shares.push_back({scatter.u, scatter.dof});
  firm.push_back({scatter.u, scatter.dof});
  return expanded(fmt::format("reference (certificate{}{}{}), which moves a mean of absolute errors by at most its own "
                              "error (c = 1); and {}",
                              !reference.drift_missing.empty()                   ? ""
                              : reference.drift_psi > reference.drift_stated_psi ? ", drift beyond its stated limit"
                                                                                 : ", drift",
                              reference.resolution_missing.empty() ? ", resolution" : "", limits_sentence(reference),
                              scatter.words),
                  shares, firm);
}

// Of a difference between readings at one level, in which the reference's error cancels, except for its hysteresis
// where they were reached in two directions. `hysteresis`: its half-width to each side, as a share of full pressure.
FigureUncertainty difference_uncertainty(const FigureScatter& scatter, double hysteresis = 0.0) {
  if (!scatter.known()) return unknown(kOneSweep);
  std::vector<VarianceShare> shares = {{scatter.u, scatter.dof}};
  if (hysteresis > 0.0) shares.push_back({2.0 * hysteresis / std::numbers::sqrt3, kInfiniteDof});
  return expanded(fmt::format("the reference's error cancels{}; {}",
                              hysteresis > 0.0 ? " except for its hysteresis" : "", scatter.words),
                  shares, shares);
}

}  // namespace

std::vector<Figure> measured_figures(const Dataset& judged, const Dataset& models, const SensorModel& fit,
                                     const Evaluation& evaluation, const ReferenceUncertainty& reference, int threads,
                                     ModelRunResults* shared) {
  ModelRunResults alone;
  ModelRunResults& of_models = shared != nullptr ? *shared : alone;
  const FigureUncertainty of_errors =
      error_uncertainty(RepeatScatter(judged, models, fit, threads, of_models).errors(), reference);
  const SweepScatter sweeps(judged, models, fit, threads, of_models.sweeps);
  const double full = evaluation.full_scale_psi;
  const double hysteresis = full > 0.0 ? reference.limit(ReferencePart::kHysteresis).half_width_psi / full : 0.0;
  const bool any = evaluation.frames > 0 && evaluation.worst_taxel >= 0;
  const std::size_t unfit = fit.array().size() - fit.fitted().size();
  std::vector<Figure> figures = {
      {Criterion::kMeanError, {}, any ? evaluation.mean_error_psi : kNan, of_errors},
      {Criterion::kWorstTaxelError, {}, any ? evaluation.worst_taxel_mean_error_psi : kNan, of_errors},
      {Criterion::kDistanceOfMean,
       {},
       evaluation.levels.empty() ? kNan : evaluation.comp_distance_of_mean,
       difference_uncertainty(sweeps.distance(), hysteresis)},
      {Criterion::kUnfitTaxels,
       {},
       static_cast<double>(unfit),
       {0.0, 0.0, kInfiniteDof, 2.0, "a count by the rules of identification has no uncertainty of its own", {}, {}}}};
  for (const LevelFigures& level : evaluation.levels)
    for (const bool up : {true, false})
      figures.push_back({Criterion::kMismatch, Scope::level(level.pressure_psi, up ? Direction::kUp : Direction::kDown),
                         up ? level.comp_std_up : level.comp_std_down,
                         difference_uncertainty(sweeps.mismatch(level.pressure_psi, up))});
  return figures;
}

}  // namespace tactbench::analysis
