#include "analysis/statistics/sensor/drift.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/statistics/numbers/moments.h"
#include "analysis/statistics/scoring/score.h"

namespace tactbench::analysis {
namespace {

constexpr double kLeastTolerance = 0.005;  // of full scale
constexpr double kLeastCover = 0.1;        // of the model's input range, for a gain

struct Pairs {
  std::vector<double> model, measured;
  double x_low = 0.0, x_high = 0.0;
};

Pairs pairs_of(const HysteresisModel& model, const std::vector<History>& histories) {
  Pairs pairs;
  pairs.x_low = pairs.x_high = histories.front().x.front();
  for (const History& history : histories) {
    const std::vector<double> predicted = predict_history(model, history, true);
    pairs.model.insert(pairs.model.end(), predicted.begin(), predicted.end());
    pairs.measured.insert(pairs.measured.end(), history.y.begin(), history.y.end());
    const auto [low, high] = std::ranges::minmax(history.x);
    pairs.x_low = std::min(pairs.x_low, low);
    pairs.x_high = std::max(pairs.x_high, high);
  }
  return pairs;
}

double mean_residual(const Pairs& pairs, double zero, double gain) {
  double sum = 0.0;
  for (std::size_t i = 0; i < pairs.model.size(); ++i)
    sum += std::abs(pairs.measured[i] - zero - gain * pairs.model[i]);
  return sum / static_cast<double>(pairs.model.size());
}

TaxelDrift drift_of_taxel(const ModelTaxel& taxel, const Pairs& pairs) {
  const auto n = static_cast<double>(pairs.model.size());
  const LineFit line = line_fit(pairs.model, pairs.measured);
  const double m = line.mean_x, y = line.mean_y;
  const HysteresisModel& own = *taxel.fit.model;
  const bool covered = pairs.x_high - pairs.x_low >= kLeastCover * (own.x_high() - own.x_low()) && line.xx > 0.0;
  TaxelDrift drift;
  drift.taxel = taxel.taxel;
  drift.gain = covered ? line.slope() : taxel.gain;
  drift.zero = y - drift.gain * m;
  drift.zero_alone = y - taxel.gain * m;
  double residual = 0.0;
  for (std::size_t i = 0; i < pairs.model.size(); ++i) {
    const double off = pairs.measured[i] - drift.zero - drift.gain * pairs.model[i];
    residual += off * off;
  }
  const double variance = residual / std::max(n - 2.0, 1.0);
  drift.gain_u = covered ? std::sqrt(variance / line.xx) : 0.0;
  drift.zero_u = std::sqrt(variance / n + drift.gain_u * drift.gain_u * m * m);
  drift.as_is = mean_residual(pairs, taxel.zero, taxel.gain) / taxel.fit.full_scale;
  drift.zeroed = mean_residual(pairs, drift.zero_alone, taxel.gain) / taxel.fit.full_scale;
  drift.adjusted = mean_residual(pairs, drift.zero, drift.gain) / taxel.fit.full_scale;
  return drift;
}

// U (k = 2) of the mean of changes whose own uncertainties have one cause; the error that the model leaves may stand in
// for as much of a change (rectangular).
double expanded_of_mean(const std::vector<double>& changes, const std::vector<double>& uncertainties, double left) {
  const auto n = static_cast<double>(changes.size());
  const double scatter = changes.size() > 1 ? sample_deviation(changes) / std::sqrt(n) : 0.0;
  return 2.0 * std::hypot(mean_of(uncertainties), scatter, left / std::sqrt(3.0));
}

// Its external loop moves with it.
void move_taxel(ModelTaxel& taxel, double zero, double gain) {
  if (taxel.fit.model == nullptr) return;
  std::vector<double> up, down;
  for (const double y : taxel.ascending.y()) up.push_back(taxel.to_model(y));
  for (const double y : taxel.descending.y()) down.push_back(taxel.to_model(y));
  const std::vector<double> inputs(taxel.ascending.x().begin(), taxel.ascending.x().end());
  taxel.zero = zero;
  taxel.gain = gain;
  if (!inputs.empty()) set_loop(taxel, inputs, up, down);
}

}  // namespace

const char* to_string(DriftVerdict verdict) {
  switch (verdict) {
    case DriftVerdict::kGood:
      return "good";
    case DriftVerdict::kZero:
      return "re-zero enough";
    case DriftVerdict::kGain:
      return "gain adjustment enough";
    case DriftVerdict::kRecalibrate:
      return "recalibrate";
  }
  return "recalibrate";
}

bool Drift::zero_moved() const { return std::abs(zero) > zero_u; }
bool Drift::gain_moved() const { return gain_u > 0.0 && std::abs(gain) > gain_u; }

std::string display_text(const Drift& drift) {
  if (!drift.drifted()) return to_string(drift.verdict);
  const char* const moved = drift.zero_moved() && drift.gain_moved() ? "zero and gain moved"
                            : drift.zero_moved()                     ? "the zero moved"
                            : drift.gain_moved()                     ? "the gain moved"
                                                                     : "the taxels moved apart";
  return fmt::format("{}: {}", moved, to_string(drift.verdict));
}

Drift drift_of(const SensorModel& document, const Histories& measured_histories, double tolerance) {
  check_same_source(document, measured_histories);
  std::optional<Histories> undone;
  if (document.dynamics) undone = histories_without_dynamics(document, measured_histories);
  const Histories& histories = undone ? *undone : measured_histories;
  Drift drift;
  double own_error = 0.0;
  std::vector<double> zeros, zero_us, gains, gain_us;
  for (const ModelTaxel& taxel : document.taxels) {
    const auto measured = std::ranges::find(histories.taxels, taxel.taxel, &TaxelHistories::taxel);
    const bool array = document.taxels.size() > 1;
    if (!taxel.fitted() || measured == histories.taxels.end() || (array && taxel.taxel == kMeanTaxel)) continue;
    const TaxelDrift& own =
        drift.taxels.emplace_back(drift_of_taxel(taxel, pairs_of(*taxel.fit.model, measured->score)));
    const double full_scale = (document.falling ? -1.0 : 1.0) * taxel.fit.full_scale;  // falling: outputs are negated
    zeros.push_back((own.zero - taxel.zero) / full_scale);
    zero_us.push_back(own.zero_u / taxel.fit.full_scale);
    gains.push_back(own.gain / taxel.gain - 1.0);
    gain_us.push_back(own.gain_u / taxel.gain);
    own_error += taxel.fit.mean_error / taxel.fit.full_scale;
  }
  if (drift.taxels.empty())
    throw AnalysisError(
        "TB-ANALYSIS-NO-TAXEL",
        fmt::format("the model of {} and {} have no taxel in common", document.source, histories.source),
        "check the model on data of the array that was fitted");
  const auto n = static_cast<double>(drift.taxels.size());
  for (const TaxelDrift& taxel : drift.taxels) {
    drift.as_is += taxel.as_is / n;
    drift.zeroed += taxel.zeroed / n;
    drift.adjusted += taxel.adjusted / n;
  }
  drift.zero = mean_of(zeros);
  drift.zero_u = expanded_of_mean(zeros, zero_us, drift.adjusted);
  drift.gain = mean_of(gains);
  if (mean_of(gain_us) > 0.0) drift.gain_u = expanded_of_mean(gains, gain_us, drift.adjusted);
  drift.tolerance = tolerance > 0.0 ? tolerance : std::max(kLeastTolerance, 2.0 * own_error / n);
  if (drift.as_is > drift.tolerance) drift.verdict = DriftVerdict::kZero;
  // Over the inputs measured a zero can stand in for a gain that moved; unloaded nothing would be off.
  const bool gain_alone = drift.gain_moved() && std::abs(drift.gain) > std::abs(drift.zero);
  if (drift.drifted() && (gain_alone || drift.zeroed > drift.tolerance)) drift.verdict = DriftVerdict::kGain;
  if (std::min({drift.as_is, drift.zeroed, drift.adjusted}) > drift.tolerance)
    drift.verdict = DriftVerdict::kRecalibrate;
  return drift;
}

SensorModel adjusted(SensorModel document, const Drift& drift, const Histories& by, bool gain) {
  document.parent_sha256 = sha256_of(document);
  document.adjustment =
      fmt::format("{} by {} ({})", gain ? "zero and gain" : "zero", by.source, by.content_sha256.substr(0, 12));
  TaxelDrift mean;
  mean.gain = 0.0;
  const auto n = static_cast<double>(drift.taxels.size());
  for (const TaxelDrift& taxel : drift.taxels) {
    mean.zero += taxel.zero / n;
    mean.zero_alone += taxel.zero_alone / n;
    mean.gain += taxel.gain / n;
  }
  for (ModelTaxel& taxel : document.taxels) {
    const auto own = std::ranges::find(drift.taxels, taxel.taxel, &TaxelDrift::taxel);
    if (own == drift.taxels.end() && taxel.taxel != kMeanTaxel) continue;
    const TaxelDrift& moved = own == drift.taxels.end() ? mean : *own;
    const double zero = gain ? moved.zero : moved.zero_alone;
    move_taxel(taxel, zero, gain ? moved.gain : taxel.gain);
  }
  return document;
}

}  // namespace tactbench::analysis
