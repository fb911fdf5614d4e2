// U of the figures that are compared with limits.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "analysis/loop.h"
#include "analysis/statistics/conformity/sweep_scatter.h"
#include "analysis/statistics/conformity/verdict.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/numbers/coverage.h"
#include "analysis/statistics/numbers/pooled_scatter.h"

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

// Its sequences of more than one repeat.
Dataset repeated_of(Dataset dataset) {
  std::erase_if(dataset.sequences, [](const SequenceData& data) { return data.repeats.size() < 2; });
  return dataset;
}

// The figures of each repeat by itself: of the run judged, or of what the models' run repeats where that has one
// repeat.
class RepeatScatter {
 public:
  RepeatScatter(const Dataset& judged, const Dataset& models, const SensorModel& fit, int threads)
      : judged_(std::max<std::size_t>(1, repeats_of(judged))) {
    const bool own = repeats_of(judged) >= 2;
    const Dataset dataset = own ? judged : repeated_of(models);
    for (std::size_t repeat = 0; repeat < repeats_of(dataset); ++repeat)
      repeats_.push_back(evaluate(repeat_of(dataset, repeat), fit, threads));
    run_ = own ? "the run judged" : "the run of the models, for the run judged has one repeat";
  }

  // Of a mean of absolute errors: pooled over the taxels. Also of one taxel's.
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
JudgedUncertainty expanded(JudgedUncertainty uncertainty, const std::vector<VarianceShare>& shares,
                           const std::vector<VarianceShare>& firm) {
  uncertainty.combined = combined_uncertainty(shares);
  uncertainty.dof = effective_dof(firm);
  uncertainty.factor = coverage_factor(std::max(1.0, uncertainty.dof));
  uncertainty.expanded = uncertainty.factor * uncertainty.combined;
  return uncertainty;
}

JudgedUncertainty unknown(JudgedUncertainty uncertainty, std::string why) {
  uncertainty.expanded = uncertainty.combined = kNan;
  uncertainty.missing = std::move(why);
  return uncertainty;
}

constexpr const char* kOneRepeat = "neither the run judged nor that of the models has two repeats";
constexpr const char* kOneSweep = "neither the run judged nor that of the models has two full sweeps at its levels";

JudgedUncertainty figure_of(const char* criterion, std::string scope, const char* unit) {
  return {criterion, std::move(scope), unit, 0.0, 0.0, 0.0, 0.0, {}, {}};
}

std::string words_of_limits(const ReferenceUncertainty& reference) {
  constexpr std::array<const char*, kReferenceParts> kNames = {"voltage input", "hysteresis", "zero", "temperature"};
  std::string words;
  for (std::size_t part = 0; part < kReferenceParts; ++part)
    if (reference.limits[part].half_width_psi > 0.0) words += fmt::format(", {}", kNames[part]);
  return words;
}

// A mean of absolute errors against the reference.
JudgedUncertainty error_uncertainty(const char* criterion, const FigureScatter& scatter,
                                    const ReferenceUncertainty& reference) {
  JudgedUncertainty out = figure_of(criterion, "array", "psi");
  if (!reference.certificate_missing.empty()) return unknown(std::move(out), reference.certificate_missing);
  if (!reference.beyond.empty()) return unknown(std::move(out), reference.beyond);
  if (!scatter.known()) return unknown(std::move(out), kOneRepeat);
  out.basis = fmt::format(
      "reference (certificate{}{}{}), which moves a mean of absolute errors by at most its own error (c = 1); and {}",
      !reference.drift_missing.empty()                   ? ""
      : reference.drift_psi > reference.drift_stated_psi ? ", drift beyond its stated limit"
                                                         : ", drift",
      reference.resolution_missing.empty() ? ", resolution" : "", words_of_limits(reference), scatter.words);
  // A drift beyond its stated limit raises u but does not lower k: it adds doubt, not degrees of freedom.
  std::vector<VarianceShare> shares = shares_of(reference, reference.drift_psi);
  std::vector<VarianceShare> firm = shares_of(reference, std::min(reference.drift_psi, reference.drift_stated_psi));
  shares.push_back({scatter.u, scatter.dof});
  firm.push_back({scatter.u, scatter.dof});
  return expanded(std::move(out), shares, firm);
}

// A difference between readings at one level, in which the reference's error cancels, but for its hysteresis where
// they were reached in two directions. `hysteresis`: its half-width to each side, as a share of full pressure.
JudgedUncertainty difference_uncertainty(const char* criterion, std::string scope, const FigureScatter& scatter,
                                         double hysteresis = 0.0) {
  JudgedUncertainty out = figure_of(criterion, std::move(scope), "FS");
  if (!scatter.known()) return unknown(std::move(out), kOneSweep);
  std::vector<VarianceShare> shares = {{scatter.u, scatter.dof}};
  if (hysteresis > 0.0) shares.push_back({2.0 * hysteresis / std::numbers::sqrt3, kInfiniteDof});
  out.basis = fmt::format("the reference's error cancels{}; {}", hysteresis > 0.0 ? " but for its hysteresis" : "",
                          scatter.words);
  return expanded(std::move(out), shares, shares);
}

// `mismatch(level, up)`: its scatter.
template <class Mismatch>
std::vector<JudgedUncertainty> all_uncertainties(const Evaluation& evaluation, const ReferenceUncertainty& reference,
                                                 const FigureScatter& errors, const FigureScatter& distance,
                                                 const Mismatch& mismatch) {
  const double full = evaluation.full_scale_psi;
  const double hysteresis = full > 0.0 ? reference.limit(ReferencePart::kHysteresis).half_width_psi / full : 0.0;
  std::vector<JudgedUncertainty> all = {error_uncertainty("mean_compensation_error", errors, reference),
                                        error_uncertainty("worst_taxel_error", errors, reference),
                                        difference_uncertainty("distance_of_mean", "array", distance, hysteresis),
                                        {"unfit_taxels",
                                         "array",
                                         "taxels",
                                         0.0,
                                         0.0,
                                         kInfiniteDof,
                                         2.0,
                                         "a count by the rules of identification has no uncertainty of its own",
                                         {}}};
  for (const LevelFigures& level : evaluation.levels)
    for (const bool up : {true, false})
      all.push_back(difference_uncertainty("mismatch",
                                           fmt::format("{:g} psi {}", level.pressure_psi, up ? "up" : "down"),
                                           mismatch(level.pressure_psi, up)));
  for (JudgedUncertainty& uncertainty : all) uncertainty.run = evaluation.run;
  return all;
}

}  // namespace

std::vector<JudgedUncertainty> judged_uncertainties(const Dataset& judged, const Dataset& models,
                                                    const SensorModel& fit, const Evaluation& evaluation,
                                                    const ReferenceUncertainty& reference, int threads) {
  const FigureScatter errors = RepeatScatter(judged, models, fit, threads).errors();
  const SweepScatter sweeps(judged, models, fit, threads);
  return all_uncertainties(evaluation, reference, errors, sweeps.distance(),
                           [&](double pressure_psi, bool up) { return sweeps.mismatch(pressure_psi, up); });
}

}  // namespace tactbench::analysis
