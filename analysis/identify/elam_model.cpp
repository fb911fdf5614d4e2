// ELAM for any data behind the interface of all models.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/identify/elam/elam.h"
#include "analysis/identify/elam/genetic.h"
#include "analysis/identify/fit_models.h"
#include "analysis/models/elam_hysteresis.h"

namespace tactbench::analysis {
namespace {

constexpr int kFreeRunPasses = 4;  // at most; two to four suffice

// A recording that begins inside the range: the turn of its first branch was not measured.
bool turn_not_measured(const FitData& data, const History& history, const Branch& branch) {
  const auto inputs = data.ascending.x();
  const double first = history.x[static_cast<std::size_t>(branch.first)];
  const double inside = branch.ascending ? first - inputs.front() : inputs.back() - first;
  return branch.first == 0 && inside > kOuterShare * (inputs.back() - inputs.front());
}

// Of FitData's, those that tell of ELAM: all whose turn was measured, or all where one direction would be missing.
std::vector<const Branch*> telling(const FitData& data, const History& history) {
  std::vector<const Branch*> told;
  bool up = false, down = false;
  for (const Branch& branch : history.branches) {
    if (turn_not_measured(data, history, branch)) continue;
    told.push_back(&branch);
    (branch.ascending ? up : down) = true;
  }
  if (up && down) return told;
  told.clear();
  for (const Branch& branch : history.branches) told.push_back(&branch);
  return told;
}

std::vector<TaxelBranch> branches_in(const FitData& data) {
  std::vector<TaxelBranch> branches;
  for (const History& history : data.histories) {
    for (const Branch* const told : telling(data, history)) {
      const Branch& branch = *told;
      TaxelBranch own{branch.ascending, {}, {}};
      own.pressure_psi.assign(history.x.begin() + branch.first, history.x.begin() + branch.last + 1);
      own.volts.assign(history.y.begin() + branch.first, history.y.begin() + branch.last + 1);
      branches.push_back(std::move(own));
    }
  }
  return branches;
}

struct Walk {
  double j = 0.0, sum = 0.0, max = 0.0;
  int samples = 0;
  std::vector<double> starts;  // ordinate at which each branch starts
};

Walk walk(const ElamHysteresis& model, const FitData& data, bool free_run) {
  Walk result;
  for (const History& history : data.histories) {
    const auto state = model.state();
    if (begins_falling(history)) state->go(model.x_high());
    const std::vector<const Branch*> told = telling(data, history);
    for (const Branch& branch : history.branches) {
      const auto first = static_cast<std::size_t>(branch.first), last = static_cast<std::size_t>(branch.last);
      state->go(history.x[first]);
      if (!free_run) state->measured(history.y[first]);
      if (std::ranges::find(told, &branch) == told.end()) {
        state->go(history.x[last]);
        continue;
      }
      result.starts.push_back(state->output_at(history.x[first]));
      // Without a turn inside the branch: measured inputs may waver.
      for (std::size_t i = first + 1; i <= last; ++i) {
        const double off = std::abs(state->output_at(history.x[i]) - history.y[i]);
        result.j += off * off;
        result.sum += off;
        result.max = std::max(result.max, off);
        ++result.samples;
      }
      state->go(history.x[last]);
    }
  }
  return result;
}

// Scored as it was identified: the walk of a model takes the same way, and rounds otherwise.
ModelFit as_model_fit(ElamFit fit, const std::vector<TaxelBranch>& branches) {
  ModelFit out;
  out.j = fit.j_v2;
  out.mean_error = fit.mean_error_v;
  out.max_error = fit.max_error_v;
  out.full_scale = fit.model.yu() - fit.model.y0();
  out.at_bound = fit.at_bound;
  out.undetermined = undetermined_names(fit);
  for (const TaxelBranch& branch : branches) out.samples += static_cast<int>(branch.volts.size()) - 1;
  out.model = std::make_shared<ElamHysteresis>(std::move(fit.model));
  return out;
}

ModelFit identified(const FitData& data, const IdentifyOptions& options) {
  const bool paper = !options.free_run && !options.memory && options.splits == 1;
  if (options.splits < 1 || options.splits > kMaxSplits)
    throw std::invalid_argument(
        fmt::format("ELAM: {} split points a branch were asked for; 1 to {} can be had", options.splits, kMaxSplits));
  std::vector<TaxelBranch> branches = branches_in(data);
  const ElamOptions elam{options.exact_outer};
  const auto identified = [&] {
    return options.genetic ? identify_elam_ga(data.ascending, data.descending, branches, elam)
                           : identify_elam(data.ascending, data.descending, branches, elam);
  };
  if (paper) return as_model_fit(identified(), branches);
  std::vector<std::string> undetermined;
  const auto fitted = [&] {
    ElamFit found = identified();
    undetermined = undetermined_names(found);
    ElamModel model = std::move(found.model);
    ElamPieces pieces;
    if (options.splits > 1) pieces = fit_pieces(model, collect_samples(model, branches), options.splits);
    return std::make_unique<ElamHysteresis>(std::move(model), options.memory, std::move(pieces));
  };
  auto model = fitted();
  Walk best = walk(*model, data, options.free_run);
  // The halves of J meet in the starting ordinates: each pass takes them from the model of the one before.
  Walk last = best;
  for (int pass = 0; options.free_run && pass < kFreeRunPasses; ++pass) {
    for (std::size_t i = 0; i < branches.size(); ++i) branches[i].volts.front() = last.starts[i];
    auto next = fitted();
    last = walk(*next, data, true);
    if (last.j >= best.j) continue;
    best = last;
    model = std::move(next);
  }
  ModelFit fit;
  fit.undetermined = std::move(undetermined);
  fit.j = best.j;
  fit.mean_error = best.sum / best.samples;
  fit.max_error = best.max;
  fit.full_scale = data.ascending.y().back() - data.ascending.y().front();
  fit.samples = best.samples;
  fit.model = std::move(model);
  return fit;
}

// ELAM has nothing that inputs alone decide.
class ElamIdentifier final : public Identifier {
 public:
  explicit ElamIdentifier(const IdentifyOptions& options) : options_(options) {}
  [[nodiscard]] ModelFit fit(const FitData& data) const override { return identified(data, options_); }

 private:
  IdentifyOptions options_;
};

}  // namespace

std::unique_ptr<Identifier> ElamHysteresis::prepare(const FitData& /*like*/, const IdentifyOptions& options) {
  if (options.genetic && !has_genetic()) throw std::invalid_argument(kNoGenetic);
  return std::make_unique<ElamIdentifier>(options);
}

// Patterns of the paper's shape at 31 pressures.
KnownModel ElamHysteresis::known() {
  constexpr double kSpanPsi = 60.0;
  constexpr double kFull = 2.812897313573669, kBend = 1.3829440636103729, kGap = 0.20164693731064747;
  constexpr double kFall = 0.019262829601589903, kSplitLow = 0.56051751541486483, kSplitHigh = 0.1535427633368237;
  std::vector<double> x, up, down;
  for (int i = 0; i <= 30; ++i) {
    const double share = i / 30.0, rise = std::pow(std::sin(1.5707963 * std::pow(share, 0.8)), kBend);
    x.push_back(kSpanPsi * share);
    up.push_back(kFull * rise);
    down.push_back(kFull *
                   std::min(rise + kGap * std::sin(3.1415927 * share) * (1.0 - share) + kGap * share * (1 - rise),
                            1.0 - kFall * std::pow((1.0 - share) * 6.0, 1.3)));
  }
  down.front() = up.front();
  down.back() = up.back();
  const ElamModel elam = {
      PatternCurve(x, up, up.front(), up.back()),
      PatternCurve(x, down, up.front(), up.back()),
      {0.81963407492294863, 0.98152362703107, (kSplitHigh - kSplitLow) / kSpanPsi, kSplitLow, 0.30542499913911907},
      {}};
  return {std::make_unique<ElamHysteresis>(elam),
          {0.0, 2.10077920147374, 2.81289731357367, 2.38296550145603, 1.01073107822528, 2.47883974152128}};
}

}  // namespace tactbench::analysis
