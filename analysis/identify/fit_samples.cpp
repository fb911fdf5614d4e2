#include "analysis/identify/fit_samples.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <stdexcept>

namespace tactbench::analysis {
namespace {

// A number is not finite when all bits of its exponent are set: the sum below then reaches the sign bit. Without a
// branch the compiler looks at several at once.
bool all_finite(std::span<const double> values) {
  constexpr std::uint64_t kExponent = 0x7ff0'0000'0000'0000, kOne = 0x0010'0000'0000'0000;
  std::uint64_t carried = 0;
  for (const double value : values) carried |= (std::bit_cast<std::uint64_t>(value) & kExponent) + kOne;
  return carried >> 63 == 0;
}

void check_patterns(const FitData& data) {
  const auto &up = data.ascending, &down = data.descending;
  if (up.x().size() < 2 || down.x().size() < 2)
    throw std::invalid_argument("no external loop: a full sweep up and one down are needed");
  if (up.x().front() != down.x().front() || up.x().back() != down.x().back() || up.y().front() != down.y().front() ||
      up.y().back() != down.y().back())
    throw std::invalid_argument("the two pattern curves do not meet at both ends");
}

void check_history(const History& history) {
  const auto refuse = [&](const char* what) {
    throw std::invalid_argument(fmt::format("history \"{}\": {}", history.name, what));
  };
  if (history.x.size() != history.y.size()) refuse("it has not as many outputs as inputs");
  if (!all_finite(history.x) || !all_finite(history.y)) refuse("a value is not finite");
  int end = 0;
  for (const Branch& branch : history.branches) {
    if (branch.first < end || branch.last <= branch.first || branch.last >= static_cast<int>(history.x.size()))
      refuse("a branch lies outside of it, overlaps the one before or has fewer than two samples");
    end = branch.last;
  }
}

bool same(const Branch& a, const Branch& b) {
  return a.first == b.first && a.last == b.last && a.ascending == b.ascending;
}

}  // namespace

FitSamples::FitSamples(const FitData& data, bool one_way) {
  check_patterns(data);
  x_low = data.ascending.x().front();
  x_high = data.ascending.x().back();
  bool up = false, down = false;
  for (const History& history : data.histories) {
    check_history(history);
    const std::size_t begin = x.size();
    for (const double input : history.x) x.push_back(std::clamp(input, x_low, x_high));
    bool opens = true;
    for (const Branch& branch : history.branches) {
      const Part part{branch.ascending, opens, opens && begins_falling(history),
                      begin + static_cast<std::size_t>(branch.first), begin + static_cast<std::size_t>(branch.last)};
      for (std::size_t i = part.first + 1; i <= part.last; ++i) scored.push_back(i);
      parts.push_back(part);
      opens = false;
      (branch.ascending ? up : down) = true;
    }
    inputs_.push_back(history.x);
    branches_.push_back(history.branches);
  }
  if (one_way ? !up && !down : !up || !down) throw std::invalid_argument("branches of both directions are needed");
  fitted = thinned(scored, kFittedSamples);
}

// As thin() in elam.h: in step with no period of the data.
std::vector<std::size_t> thinned(const std::vector<std::size_t>& samples, std::size_t most) {
  constexpr double kGolden = 0.6180339887498949;
  const double share = static_cast<double>(most) / static_cast<double>(samples.size());
  std::vector<std::size_t> left;
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (share >= 1.0 || std::fmod(kGolden * static_cast<double>(i), 1.0) < share) left.push_back(samples[i]);
  return left;
}

std::vector<double> FitSamples::outputs(const FitData& data) const {
  const auto others = [] { throw std::invalid_argument("the inputs are not those that the fit was prepared for"); };
  if (data.histories.size() != inputs_.size()) others();
  check_patterns(data);
  if (data.ascending.x().front() != x_low || data.ascending.x().back() != x_high) others();
  std::vector<double> y;
  y.reserve(x.size());
  for (std::size_t h = 0; h < inputs_.size(); ++h) {
    const History& history = data.histories[h];
    const std::vector<double>& x_then = inputs_[h];
    if (history.x.size() != x_then.size() ||
        std::memcmp(history.x.data(), x_then.data(), x_then.size() * sizeof(double)) != 0 ||
        !std::ranges::equal(history.branches, branches_[h], same))
      others();
    if (history.y.size() != history.x.size() || !all_finite(history.y))
      throw std::invalid_argument(fmt::format("history \"{}\": an output is missing or not finite", history.name));
    y.insert(y.end(), history.y.begin(), history.y.end());
  }
  return y;
}

void score(ModelFit& fit, const FitData& data, std::span<const double> errors) {
  // Four sums side by side: one waits for itself.
  using Four = Eigen::Array4d;
  Four squares = Four::Zero(), sums = Four::Zero(), largest = Four::Zero();
  const auto add = [&](const Four& off) {
    squares += off.square();
    sums += off.abs();
    largest = largest.max(off.abs());
  };
  std::size_t i = 0;
  for (; i + 4 <= errors.size(); i += 4) add(Eigen::Map<const Four>(&errors[i]));
  for (; i < errors.size(); ++i) add({errors[i], 0.0, 0.0, 0.0});
  fit.j = squares.sum();                                             // (1)
  fit.mean_error = sums.sum() / static_cast<double>(errors.size());  // (49)
  fit.max_error = largest.maxCoeff();
  fit.samples = static_cast<int>(errors.size());
  fit.full_scale = data.ascending.y().back() - data.ascending.y().front();
}

void score_walk(ModelFit& fit, const FitData& data, const FitSamples& samples, std::span<const double> measured,
                bool free_run) {
  std::vector<double> errors;
  errors.reserve(measured.size());
  for (const History& history : data.histories) {
    const std::vector<double> own = predict_history(*fit.model, history, free_run);
    errors.insert(errors.end(), own.begin(), own.end());
  }
  for (std::size_t i = 0; i < samples.scored.size(); ++i)
    errors[i] = errors[samples.scored[i]] - measured[samples.scored[i]];  // scored[i] >= i: never overwritten unread
  score(fit, data, std::span(errors).first(samples.scored.size()));
}

std::vector<Fold> folds_of(const FitData& data, int most) {
  const double low = data.ascending.x().front(), high = data.ascending.x().back(), near = 0.01 * (high - low);
  const auto inner = [&](const History& history, const Branch& branch) {
    const double from = history.x[static_cast<std::size_t>(branch.first)];
    return branch.ascending ? from - low > near : high - from > near;
  };
  int count = 0;
  for (const History& history : data.histories)
    count += static_cast<int>(
        std::ranges::count_if(history.branches, [&](const Branch& branch) { return inner(history, branch); }));
  if (count < 2) return {};
  const int number = std::min(most, count);
  std::vector<Fold> folds;
  for (int f = 0; f < number; ++f) {
    Fold& fold = folds.emplace_back();
    int seen = 0;
    for (const History& history : data.histories) {
      std::vector<Branch>&kept = fold.kept.emplace_back(), &held = fold.held.emplace_back();
      for (const Branch& branch : history.branches)
        (inner(history, branch) && seen++ % number == f ? held : kept).push_back(branch);
    }
  }
  return folds;
}

FitData with_branches(FitData data, const std::vector<std::vector<Branch>>& branches) {
  for (std::size_t h = 0; h < data.histories.size(); ++h) data.histories[h].branches = branches.at(h);
  return data;
}

}  // namespace tactbench::analysis
