#include "analysis/identify/linearised_identifier.h"

#include <cmath>
#include <optional>
#include <stdexcept>

#include "analysis/identify/congruency.h"
#include "analysis/identify/fit_samples.h"
#include "analysis/models/linearised.h"

namespace tactbench::analysis {
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
