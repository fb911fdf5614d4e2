// GPI has many minima: local searches from fixed starts, spread evenly over the shapes that loops have.
#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "analysis/identify/identifier.h"
#include "analysis/identify/rivals/gpi_search.h"
#include "analysis/models/invert.h"

namespace tactbench::analysis {
namespace {

// Of kTried times as many points as there are starts the best, kFirst times, are followed for a few steps, the best of
// these, kSecond times, for some more, and all of these evolved in a tournament from whose first round kThird times as
// many come. Chosen on simulated sensors with the seeds 1 to 3 and 11 to 13.
constexpr int kTried = 256, kFirst = 32, kSecond = 8, kThird = 2;
constexpr int kFirstSteps = 6, kSecondSteps = 30, kLastSteps = 60;
constexpr double kEqualJ = 1e-7;  // share of J by which points differ that are not one
constexpr double kApart = 1e-4;   // the same of ends that are not yet at their minimum
constexpr double kFirstSize = 0.1;
constexpr int kTournament = 300, kGpiGenerations = 250;
constexpr double kFurther[] = {2.0, 1.0, 0.5};  // sizes of the last evolutions, about the best: neighbouring minima

// Of more samples than this the search looks at so many, evenly chosen, between all turns; its ends go on on all.
constexpr std::size_t kSearched = 1000;
constexpr int kLastGenerations = 60;

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

// The n-th start: bends, density, and in units of the left envelope's end thresholds, its begin and the right one's end
// from the sequence; the right one's begin and the unit so that the external loop runs from 0 to 1 and back.
GpiPoint start_of(int n) {
  const auto between = [n](int base, double low, double high) { return low + (high - low) * halton(n, base); };
  const double alpha = std::exp(between(2, -4.0, 0.2)), s = between(3, -1.8, 1.8);
  const double l0 = between(7, -1.0, 0.7), r1 = between(11, -0.8, 1.4);
  const auto sum = [&](const auto& output) {
    double total = 0.0;
    for (int i = 0; i < kGpiOperators; ++i) total += std::exp(-s * i) * output(alpha * i);
    return total;
  };
  const auto at_top = [](double r) { return std::max(1.0 - r, 0.0); };
  const double unit = 1.0 / sum(at_top);
  const double r0 = root(
      [&](double right) { return sum([&](double r) { return std::max(l0 - r, std::min(right + r, at_top(r))); }); },
      -8.0, 1.0);
  GpiPoint start{};
  start[kLnA] = between(5, std::log(0.3), std::log(10.0));
  start[kLnB] = between(13, std::log(0.1), std::log(40.0));
  start[kL0] = unit * l0;
  start[kLnDl] = std::log(unit * (1.0 - l0));
  start[kR0] = unit * r0;
  start[kLnDr] = std::log(unit * std::max(r1 - r0, 0.1));
  start[kLnAlpha] = std::log(unit * alpha);
  start[kS] = s;
  return start;
}

class GpiIdentifier final : public Identifier {
 public:
  GpiIdentifier(const FitData& like, int starts)
      : samples_(like), tree_(samples_), searched_(few_of(samples_)), starts_(starts) {
    if (starts < 1) throw std::invalid_argument("GPI: the search needs at least one start");
    for (int n = 1; n <= kTried * starts_; ++n) tried_.push_back({start_of(n)});
  }
  [[nodiscard]] ModelFit fit(const FitData& data) const override {
    const std::vector<double> y = samples_.outputs(data);
    const double y_low = data.ascending.y().front(), y_span = data.ascending.y().back() - y_low;
    std::vector<double> share(y.size());
    std::ranges::transform(y, share.begin(), [&](double output) { return (output - y_low) / y_span; });
    const GpiTree::Target target = tree_.target(share);
    const GpiFound best = search(target, share);
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
  static FitSamples few_of(FitSamples samples) {
    samples.fitted = thinned(samples.fitted, kSearched);
    return samples;
  }
  [[nodiscard]] GpiFound search(const GpiTree::Target& target, std::span<const double> y) const {
    const GpiTree::Target few = searched_.target(y);
    GpiSearch search(searched_, few);
    std::vector<GpiFound> found = tried_;
    const auto keep = [&](int share, double apart) {
      std::ranges::stable_sort(found, {}, &GpiFound::j);
      keep_apart(found, static_cast<std::size_t>(share * starts_), apart, [](const GpiFound& one) { return one.j; });
    };
    search.rate(found);
    keep(kFirst, kEqualJ);
    search.descend(found, kFirstSteps);
    keep(kSecond, kEqualJ);
    search.descend(found, kSecondSteps);
    keep(kSecond, kApart);
    found = search.tournament(found, kFirstSize, static_cast<std::size_t>(kThird * starts_), kTournament, kApart);
    search.descend(found, kLastSteps);
    GpiFound best = *std::ranges::min_element(found, {}, &GpiFound::j);
    const auto go_on = [&best](GpiSearch& on, double size, int generations) {
      GpiFound further = on.evolve(best, size, generations);
      on.descend(std::span(&further, 1), kLastSteps);
      if (further.j < best.j) best = further;
    };
    for (const double size : kFurther) go_on(search, size, kGpiGenerations);
    if (samples_.fitted.size() <= kSearched) return best;
    found.push_back(best);
    GpiSearch whole(tree_, target);
    whole.descend(found, kLastSteps);
    best = *std::ranges::min_element(found, {}, &GpiFound::j);
    go_on(whole, kFirstSize, kLastGenerations);
    return best;
  }

  FitSamples samples_;
  GpiTree tree_, searched_;
  int starts_;
  std::vector<GpiFound> tried_;
};

}  // namespace

std::unique_ptr<Identifier> prepare_gpi(const FitData& like, const IdentifyOptions& options) {
  return std::make_unique<GpiIdentifier>(like, options.starts);
}

}  // namespace tactbench::analysis
