// U of the figures that are compared with limits.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/statistics/conformity/verdict.h"
#include "analysis/statistics/figures/levels.h"
#include "analysis/statistics/numbers/coverage.h"

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

// The figures of each repeat by itself.
struct RepeatFigures {
  std::vector<Evaluation> repeats;  // empty: fewer than two repeats, no scatter
  std::string run;                  // the run of these repeats
};

RepeatFigures figures_of_repeats(const Dataset& judged, const Dataset& models, const SensorModel& fit, int threads) {
  const bool own = repeats_of(judged) >= 2;
  const Dataset& dataset = own ? judged : models;
  RepeatFigures figures;
  if (repeats_of(dataset) < 2) return figures;
  for (std::size_t repeat = 0; repeat < repeats_of(dataset); ++repeat)
    figures.repeats.push_back(evaluate(repeat_of(dataset, repeat), fit, threads));
  figures.run = own ? "the run judged" : "the run of the models, for the run judged has one repeat";
  return figures;
}

struct FigureScatter {
  double s = 0.0;
  std::size_t count = 0;  // below 2: not known
};

template <class Figure>
FigureScatter scatter_of_repeats(const RepeatFigures& figures, Figure figure) {
  std::vector<double> values;
  for (const Evaluation& evaluation : figures.repeats)
    if (const double value = figure(evaluation); std::isfinite(value)) values.push_back(value);
  if (values.size() < 2) return {};
  return {sample_deviation(values), values.size()};
}

std::vector<VarianceShare> shares_of(const ReferenceUncertainty& reference, double drift_psi) {
  std::vector<VarianceShare> shares = {{reference.largest_certificate_u(), kInfiniteDof}};
  if (reference.drift_missing.empty()) shares.push_back({drift_psi / std::numbers::sqrt3, kInfiniteDof});
  if (reference.resolution_missing.empty())
    shares.push_back({0.5 * reference.resolution_psi / std::numbers::sqrt3, kInfiniteDof});
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

class JudgedMaker {
 public:
  JudgedMaker(const RepeatFigures& figures, std::size_t judged_repeats, const ReferenceUncertainty& reference)
      : figures_(figures), judged_repeats_(judged_repeats), reference_(reference) {}

  // A mean of absolute errors against the reference.
  template <class Figure>
  JudgedUncertainty error(const char* criterion, Figure figure) const {
    JudgedUncertainty out{criterion, "array", "psi", 0.0, 0.0, 0.0, 0.0, {}, {}};
    const FigureScatter scatter = scatter_of_repeats(figures_, figure);
    if (!reference_.certificate_missing.empty()) return unknown(std::move(out), reference_.certificate_missing);
    if (scatter.count < 2) return unknown(std::move(out), kOneRepeat);
    out.basis = fmt::format(
        "reference (certificate{}{}), which moves a mean of absolute errors by at most its own error (c = 1); and {}",
        !reference_.drift_missing.empty()                    ? ""
        : reference_.drift_psi > reference_.drift_stated_psi ? ", drift beyond its stated limit"
                                                             : ", drift",
        reference_.resolution_missing.empty() ? ", resolution" : "", scatter_in_words(scatter));
    // A drift beyond its stated limit raises u but does not lower k: it adds doubt, not degrees of freedom.
    std::vector<VarianceShare> shares = shares_of(reference_, reference_.drift_psi);
    std::vector<VarianceShare> firm =
        shares_of(reference_, std::min(reference_.drift_psi, reference_.drift_stated_psi));
    shares.push_back(share_of(scatter));
    firm.push_back(share_of(scatter));
    return expanded(std::move(out), shares, firm);
  }

  // A difference between readings at one level, in which the reference's error cancels.
  template <class Figure>
  JudgedUncertainty difference(const char* criterion, const std::string& scope, Figure figure) const {
    JudgedUncertainty out{criterion, scope, "FS", 0.0, 0.0, 0.0, 0.0, {}, {}};
    const FigureScatter scatter = scatter_of_repeats(figures_, figure);
    if (scatter.count < 2) return unknown(std::move(out), kOneRepeat);
    out.basis = fmt::format("the reference's error cancels; {}", scatter_in_words(scatter));
    return expanded(std::move(out), {share_of(scatter)}, {share_of(scatter)});
  }

 private:
  [[nodiscard]] VarianceShare share_of(const FigureScatter& scatter) const {
    return {scatter.s / std::sqrt(static_cast<double>(judged_repeats_)), static_cast<double>(scatter.count - 1)};
  }
  [[nodiscard]] std::string scatter_in_words(const FigureScatter& scatter) const {
    return fmt::format("scatter of the figure over {} repeats of {}{}", scatter.count, figures_.run,
                       judged_repeats_ > 1 ? fmt::format(", divided by √{}", judged_repeats_) : "");
  }

  const RepeatFigures& figures_;
  std::size_t judged_repeats_;
  const ReferenceUncertainty& reference_;
};

double level_figure(const Evaluation& evaluation, double pressure_psi, double LevelFigures::*figure) {
  const auto level = std::ranges::find_if(evaluation.levels, [&](const LevelFigures& figures) {
    return std::abs(figures.pressure_psi - pressure_psi) < 1e-6;
  });
  return level == evaluation.levels.end() ? kNan : (*level).*figure;
}

}  // namespace

std::vector<JudgedUncertainty> judged_uncertainties(const Dataset& judged, const Dataset& models,
                                                    const SensorModel& fit, const Evaluation& evaluation,
                                                    const ReferenceUncertainty& reference, int threads) {
  const RepeatFigures figures = figures_of_repeats(judged, models, fit, threads);
  const JudgedMaker maker(figures, std::max<std::size_t>(1, repeats_of(judged)), reference);
  std::vector<JudgedUncertainty> all;
  all.push_back(maker.error("mean_compensation_error", [](const Evaluation& e) { return e.mean_error_psi; }));
  const auto worst = static_cast<std::size_t>(std::max(0, evaluation.worst_taxel));
  all.push_back(
      maker.error("worst_taxel_error", [worst](const Evaluation& e) { return e.taxel_mean_error_psi[worst]; }));
  all.push_back(
      maker.difference("distance_of_mean", "array", [](const Evaluation& e) { return e.comp_distance_of_mean; }));
  all.push_back({"unfit_taxels",
                 "array",
                 "taxels",
                 0.0,
                 0.0,
                 kInfiniteDof,
                 2.0,
                 "a count by the rules of identification has no uncertainty of its own",
                 {}});
  for (const LevelFigures& level : evaluation.levels) {
    const auto mismatch = [&](const char* way, double LevelFigures::*figure) {
      all.push_back(maker.difference("mismatch", fmt::format("{:g} psi {}", level.pressure_psi, way),
                                     [&](const Evaluation& e) { return level_figure(e, level.pressure_psi, figure); }));
    };
    mismatch("up", &LevelFigures::comp_std_up);
    mismatch("down", &LevelFigures::comp_std_down);
  }
  for (JudgedUncertainty& uncertainty : all) uncertainty.run = evaluation.run;
  return all;
}

}  // namespace tactbench::analysis
