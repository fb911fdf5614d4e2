// GPI has many minima: Levenberg-Marquardt from fixed starts, spread evenly over the shapes that loops have.
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "analysis/identify/identifier.h"
#include "analysis/identify/rivals/gpi_search.h"
#include "analysis/models/invert.h"

namespace tactbench::analysis {
namespace {

// Of kTried times as many points as there are starts the best after a few steps are followed to where they stall,
// kFollowed times as many as there are starts, and the best of these evolved.
constexpr int kTried = 64, kFirstSteps = 6, kFollowed = 4, kGpiSteps = 60;
constexpr std::size_t kEvolutions = 6;  // at most,
constexpr double kHopeful = 0.3;        // of those whose J is within this share of the least
constexpr double kApart = 1e-4;         // share of J by which two ends differ that are not one
constexpr double kFirstSize = 0.1;
constexpr int kGpiGenerations = 250;

// What the data leave open: standard errors above 1, a factor e or the whole output. By the parameter that the unknown
// alone, or first, moves.
constexpr std::array<const char*, kGpiUnknowns> kUnknownNames = {"a1", "a3", "a0", "b1", "b3", "b0", "alpha", "tau"};
constexpr double kSmallestJ = 1e-12;  // a sample, of outputs in 0..1

// Halton's sequence: the digits of n mirrored at the point.
double halton(int n, int base) {
  double value = 0.0, digit = 1.0;
  for (; n > 0; n /= base) value += (digit /= base) * (n % base);
  return value;
}

double root(const auto& rising, double low, double high) {
  const double way[] = {low, high};
  return first_crossing(rising, way, 0.0);
}

// The n-th start: bends, threshold and density from the sequence, the envelopes' ends so that the external loop runs
// from 0 to 1 and back.
GpiPoint start_of(int n) {
  const auto between = [n](int base, double low, double high) { return low + (high - low) * halton(n, base); };
  const double alpha = std::exp(between(2, std::log(0.005), std::log(1.2))), s = between(3, -1.5, 3.0);
  const auto sum = [&](const auto& output) {
    double total = 0.0;
    for (int i = 0; i < kGpiOperators; ++i) total += std::exp(-s * i) * output(alpha * i);
    return total;
  };
  const double top =
      root([&](double left) { return sum([&](double r) { return std::max(left - r, 0.0); }) - 1.0; }, 0.0, 2.0);
  const auto at_top = [&](double r) { return std::max(top - r, 0.0); };
  const double bottom =
      root([&](double right) { return sum([&](double r) { return std::min(right + r, at_top(r)); }); }, -8.0, top);
  const double l0 = top * between(7, -0.3, 0.2), r1 = top * between(11, 0.5, 1.1);
  GpiPoint start{};
  start[kLnA] = between(5, std::log(0.05), std::log(8.0));
  start[kLnB] = between(13, std::log(0.05), std::log(12.0));
  start[kL0] = l0;
  start[kLnDl] = std::log(top - l0);
  start[kR0] = bottom;
  start[kLnDr] = std::log(std::max(r1 - bottom, 0.1));
  start[kLnAlpha] = std::log(alpha);
  start[kS] = s;
  return start;
}

class GpiIdentifier final : public Identifier {
 public:
  GpiIdentifier(const FitData& like, int starts) : samples_(like), tree_(samples_), starts_(starts) {
    if (starts < 1) throw std::invalid_argument("GPI: the search needs at least one start");
    for (int n = 1; n <= kTried * starts_; ++n) tried_.push_back({start_of(n)});
  }
  [[nodiscard]] ModelFit fit(const FitData& data) const override {
    const std::vector<double> y = samples_.outputs(data);
    const double y_low = data.ascending.y().front(), y_span = data.ascending.y().back() - y_low;
    std::vector<double> share(y.size());
    std::ranges::transform(y, share.begin(), [&](double output) { return (output - y_low) / y_span; });
    const GpiTree::Target target = tree_.target(share);
    const GpiFound best = search(target);
    const double x_span = samples_.x_high - samples_.x_low;
    ModelFit fit;
    fit.model =
        std::make_unique<GpiModel>(gpi_parameters(best.at, x_span, y_span), samples_.x_low, samples_.x_high, y_low);
    fit.starts = starts_;
    const double samples = static_cast<double>(samples_.fitted.size());
    const GpiPoint errors =
        GpiSearch(tree_, target).errors(best, std::max(best.j, kSmallestJ * samples) / std::max(samples - 8.0, 1.0));
    for (std::size_t k = 0; k < errors.size(); ++k)
      if (errors[k] > 1.0) fit.undetermined.emplace_back(kUnknownNames[k]);
    score_walk(fit, data, samples_, y, true);
    return fit;
  }

 private:
  [[nodiscard]] GpiFound search(const GpiTree::Target& target) const {
    GpiSearch search(tree_, target);
    std::vector<GpiFound> found = tried_;
    const auto best_of = [&](std::size_t count, int steps) {
      search.descend(found, steps);
      std::ranges::stable_sort(found, {}, &GpiFound::j);
      found.resize(std::min(count, found.size()));
    };
    best_of(static_cast<std::size_t>(kFollowed * starts_), kFirstSteps);
    best_of(found.size(), kGpiSteps);
    std::vector<GpiFound> ends;
    for (const GpiFound& one : found) {
      if (ends.size() == kEvolutions || one.j > found.front().j * (1.0 + kHopeful)) break;
      if (ends.empty() || one.j > ends.back().j * (1.0 + kApart)) ends.push_back(one);
    }
    for (GpiFound& end : ends) end = search.evolve(end, kFirstSize, kGpiGenerations);
    search.descend(ends, kGpiSteps);
    return *std::ranges::min_element(ends, {}, &GpiFound::j);
  }

  FitSamples samples_;
  GpiTree tree_;
  int starts_;
  std::vector<GpiFound> tried_;
};

}  // namespace

std::unique_ptr<Identifier> prepare_gpi(const FitData& like, const IdentifyOptions& options) {
  return std::make_unique<GpiIdentifier>(like, options.starts);
}

}  // namespace tactbench::analysis
