// GPI has many minima: Levenberg-Marquardt from fixed starts, spread evenly over the shapes that loops have.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/identify/identifier.h"
#include "analysis/identify/rivals/gpi_search.h"
#include "analysis/models/invert.h"

namespace tactbench::analysis {
namespace {

// Of kTried times as many points as there are starts the best after a few steps are followed to their minimum.
constexpr int kTried = 8, kFirstSteps = 12, kGpiSteps = 80;

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
GpiVector start_of(int n) {
  const auto between = [n](int base, double low, double high) { return low + (high - low) * halton(n, base); };
  const double alpha = std::exp(between(2, std::log(0.03), std::log(1.2))), s = between(3, -1.0, 3.0);
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
  GpiVector start;
  start[kLnA] = between(5, std::log(0.5), std::log(6.0));
  start[kLnB] = between(13, std::log(0.5), std::log(10.0));
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
  GpiIdentifier(const FitData& like, int starts) : samples_(like), search_(samples_), starts_(starts) {
    if (starts < 1) throw std::invalid_argument("GPI: the search needs at least one start");
  }
  [[nodiscard]] ModelFit fit(const FitData& data) const override {
    const std::vector<double> y = samples_.outputs(data);
    const double y_low = data.ascending.y().front(), y_span = data.ascending.y().back() - y_low;
    std::vector<double> share(y.size());
    std::ranges::transform(y, share.begin(), [&](double output) { return (output - y_low) / y_span; });
    std::vector<GpiSearch::Found> found;
    for (int n = 1; n <= kTried * starts_; ++n) found.push_back(search_.search(start_of(n), share, kFirstSteps));
    std::ranges::stable_sort(found, {}, &GpiSearch::Found::j);
    found.resize(static_cast<std::size_t>(starts_));
    for (GpiSearch::Found& one : found) one = search_.search(one.unknowns, share, kGpiSteps);
    const GpiSearch::Found& best = *std::ranges::min_element(found, {}, &GpiSearch::Found::j);
    const double x_span = samples_.x_high - samples_.x_low;
    ModelFit fit;
    fit.model = std::make_unique<GpiModel>(gpi_parameters(best.unknowns, x_span, y_span), samples_.x_low,
                                           samples_.x_high, y_low);
    fit.starts = starts_;
    score_walk(fit, data, samples_, y, true);
    return fit;
  }

 private:
  FitSamples samples_;
  GpiSearch search_;
  int starts_;
};

}  // namespace

std::unique_ptr<Identifier> prepare_gpi(const FitData& like, const IdentifyOptions& options) {
  return std::make_unique<GpiIdentifier>(like, options.starts);
}

}  // namespace tactbench::analysis
