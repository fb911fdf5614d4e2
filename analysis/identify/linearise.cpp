#include "analysis/identify/linearise.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "analysis/identify/fit_samples.h"
#include "analysis/models/linearised.h"

namespace tactbench::analysis {
namespace {

constexpr double kOuter = 0.01;              // of the input span: a turn this near to an end lies on it
constexpr double kHelps = 0.95;              // of the misfit
constexpr std::size_t kFewestCrossings = 3;  // crossings
constexpr double kMostShare = 0.98;          // of the amplitude, at the loop's upper end

struct FirstOrder {
  double turn = 0.0;
  std::vector<double> x, y;  // x from the turn on
  [[nodiscard]] double from() const { return y.front(); }
};

// Linear between samples; false outside.
bool output_at(const FirstOrder& branch, double x, double& y) {
  for (std::size_t i = 0; i + 1 < branch.x.size(); ++i) {
    const double a = branch.x[i], b = branch.x[i + 1];
    if ((x - a) * (x - b) > 0.0 || a == b) continue;
    y = branch.y[i] + (branch.y[i + 1] - branch.y[i]) * (x - a) / (b - a);
    return true;
  }
  return false;
}

struct Families {
  std::vector<FirstOrder> falls, rises;
};

Families families_of(const FitData& data) {
  Families families;
  const double low = data.ascending.x().front(), high = data.ascending.x().back(), near = kOuter * (high - low);
  for (const History& history : data.histories)
    for (std::size_t b = 1; b < history.branches.size(); ++b) {
      const Branch &before = history.branches[b - 1], &own = history.branches[b];
      const double from = history.x[static_cast<std::size_t>(before.first)];
      const double turn = history.x[static_cast<std::size_t>(own.first)];
      const bool inner = turn - low > near && high - turn > near;
      const bool first_order = own.ascending ? high - from <= near : from - low <= near;
      if (!inner || !first_order || before.ascending == own.ascending) continue;
      const auto first = own.first, end = own.last + 1;
      (own.ascending ? families.rises : families.falls)
          .push_back({turn,
                      {history.x.begin() + first, history.x.begin() + end},
                      {history.y.begin() + first, history.y.begin() + end}});
    }
  return families;
}

struct Crossing {
  double fall_from, fall_to, rise_from, rise_to;
};

double misfit(const std::vector<Crossing>& crossings, const Divider& divider) {
  double sum = 0.0;
  for (const Crossing& c : crossings) {
    const double down = divider.linear(c.fall_from) - divider.linear(c.fall_to);
    const double up = divider.linear(c.rise_to) - divider.linear(c.rise_from);
    const double fall_off = divider.output(divider.linear(c.fall_from) - up) - c.fall_to;
    const double rise_off = divider.output(divider.linear(c.rise_from) + down) - c.rise_to;
    sum += fall_off * fall_off + rise_off * rise_off;
  }
  return std::sqrt(sum / static_cast<double>(2 * crossings.size()));
}

}  // namespace

Congruency find_divider(const FitData& data) {
  Congruency result;
  result.divider.zero = data.ascending.y().front();
  const Families families = families_of(data);
  std::vector<Crossing> crossings;
  for (const FirstOrder& fall : families.falls)
    for (const FirstOrder& rise : families.rises) {
      Crossing crossing{fall.from(), 0.0, rise.from(), 0.0};
      if (rise.turn < fall.turn && output_at(fall, rise.turn, crossing.fall_to) &&
          output_at(rise, fall.turn, crossing.rise_to))
        crossings.push_back(crossing);
    }
  result.pairs = static_cast<int>(crossings.size());
  if (crossings.size() < kFewestCrossings) return result;
  result.plain_rms = result.rms = misfit(crossings, result.divider);
  const double span = data.ascending.y().back() - result.divider.zero;
  const auto at = [&](double share) { return Divider{result.divider.zero, share / span}; };
  constexpr int kAmplitudes = 49;
  int best = 0;
  for (int i = 1; i <= kAmplitudes; ++i)
    if (misfit(crossings, at(kMostShare * i / kAmplitudes)) < misfit(crossings, at(kMostShare * best / kAmplitudes)))
      best = i;
  double low = kMostShare * std::max(best - 1, 0) / kAmplitudes,
         high = kMostShare * std::min(best + 1, kAmplitudes) / kAmplitudes;
  constexpr double kGolden = 0.6180339887498949;
  for (int i = 0; i < 40; ++i) {
    const double a = high - kGolden * (high - low), b = low + kGolden * (high - low);
    (misfit(crossings, at(a)) < misfit(crossings, at(b)) ? high : low) =
        misfit(crossings, at(a)) < misfit(crossings, at(b)) ? b : a;
  }
  const Divider found = at(0.5 * (low + high));
  const double rms = misfit(crossings, found);
  if (rms > kHelps * result.plain_rms) return result;
  result.divider = found;
  result.rms = rms;
  return result;
}

FitData linearised(const FitData& data, const Divider& divider) {
  FitData own = data;
  for (History& history : own.histories)
    for (double& y : history.y) y = divider.linear(y);
  const auto moved = [&](const PatternCurve& curve) {
    std::vector<double> y(curve.y().begin(), curve.y().end());
    for (double& at : y) at = divider.linear(at);
    return PatternCurve(curve.x(), y, y.front(), y.back());
  };
  own.ascending = moved(data.ascending);
  own.descending = moved(data.descending);
  return own;
}

namespace {

// The plain model as a linearised one: the same outputs, bit for bit.
constexpr Divider kOff;

ModelFit wrapped(ModelFit fit, const Divider& divider) {
  fit.model = std::make_shared<LinearisedModel>(divider, std::move(fit.model));
  return fit;
}

class LinearisedIdentifier final : public Identifier {
 public:
  LinearisedIdentifier(const FitData& like, bool free_run, bool cross, const PrepareInner& inner)
      : samples_(like), inner_(inner(like)), free_run_(free_run) {
    if (!cross) return;
    try {
      for (Fold& fold : folds_of(like)) {
        std::unique_ptr<Identifier> own = inner(with_branches(like, fold.kept));
        folds_.push_back({std::move(fold), std::move(own)});
      }
    } catch (const std::invalid_argument&) {
      folds_.clear();
    }
  }

  [[nodiscard]] ModelFit fit(const FitData& data) const override {
    const Divider found = find_divider(data).divider;
    if (found.per_amplitude == 0.0 || !helps(data, found)) return wrapped(inner_->fit(data), kOff);
    ModelFit fit = wrapped(inner_->fit(linearised(data, found)), found);
    score_walk(fit, data, samples_, samples_.outputs(data), free_run_);
    return fit;
  }

 private:
  struct CrossedFold {
    Fold fold;
    std::unique_ptr<Identifier> inner;
  };

  [[nodiscard]] bool helps(const FitData& data, const Divider& divider) const {
    try {
      return folds_.empty() || held_error(data, divider) < held_error(data, kOff);
    } catch (const std::invalid_argument&) {
      return true;
    }
  }

  // Sum of the absolute errors on held branches.
  [[nodiscard]] double held_error(const FitData& data, const Divider& divider) const {
    double sum = 0.0;
    for (const auto& [fold, inner] : folds_) {
      const FitData kept = with_branches(data, fold.kept);
      const ModelFit fit =
          wrapped(divider.per_amplitude > 0.0 ? inner->fit(linearised(kept, divider)) : inner->fit(kept), divider);
      const FitData held = with_branches(data, fold.held);
      for (const History& history : held.histories) {
        if (history.branches.empty()) continue;
        const std::vector<double> predicted = predict_history(*fit.model, history, free_run_);
        for (const Branch& branch : history.branches)
          for (auto i = static_cast<std::size_t>(branch.first) + 1; i <= static_cast<std::size_t>(branch.last); ++i)
            sum += std::abs(predicted[i] - history.y[i]);
      }
    }
    return sum;
  }

  FitSamples samples_;
  std::unique_ptr<Identifier> inner_;
  std::vector<CrossedFold> folds_;  // none: the congruency test alone decides
  bool free_run_;
};

}  // namespace

std::unique_ptr<Identifier> prepare_linearised(const FitData& like, bool free_run, bool cross,
                                               const PrepareInner& inner) {
  return std::make_unique<LinearisedIdentifier>(like, free_run, cross, inner);
}

}  // namespace tactbench::analysis
