// The isotonic regression of all samples on the input: pool-adjacent-violators. On a grid it is the least squares
// optimum of all monotone curves through its points.
#include <algorithm>
#include <numeric>
#include <stdexcept>

#include "analysis/identify/fit_models.h"
#include "analysis/identify/fit_samples.h"
#include "analysis/models/monotone.h"

namespace tactbench::analysis {
namespace {

constexpr double kOneKnot = 5e-4;  // of the span: inputs within as much are one knot, so that there are 2000 at most

struct Knots {
  std::vector<double> x, y;
};

class MonotoneIdentifier final : public Identifier {
 public:
  explicit MonotoneIdentifier(const FitData& like) : samples_(like, true), order_(samples_.scored) {
    std::ranges::stable_sort(order_, {}, [&](std::size_t i) { return samples_.x[i]; });
  }
  [[nodiscard]] ModelFit fit(const FitData& data) const override {
    const std::vector<double> y = samples_.outputs(data);
    const Knots knots = isotonic(y);
    if (knots.x.size() < 2 || knots.y.back() <= knots.y.front())
      throw std::invalid_argument("the output does not rise with the input");
    ModelFit fit;
    fit.model = std::make_unique<MonotoneModel>(PatternCurve(knots.x, knots.y, knots.y.front(), knots.y.back()));
    score_walk(fit, data, samples_, y, false);
    return fit;
  }

 private:
  // Means at each knot, then of neighbours that do not rise.
  [[nodiscard]] Knots isotonic(std::span<const double> y) const {
    Knots knots;
    std::vector<double> weight;
    const double width = kOneKnot * (samples_.x_high - samples_.x_low);
    double begin = 0.0;
    for (const std::size_t i : order_) {
      if (knots.x.empty() || samples_.x[i] - begin > width) {
        begin = samples_.x[i];
        knots.x.push_back(begin);
        knots.y.push_back(y[i]);
        weight.push_back(1.0);
      } else {
        weight.back() += 1.0;
        knots.x.back() += (samples_.x[i] - knots.x.back()) / weight.back();
        knots.y.back() += (y[i] - knots.y.back()) / weight.back();
      }
    }
    knots.x.front() = samples_.x_low;
    knots.x.back() = samples_.x_high;
    struct Block {
      double mean, weight;
      std::size_t knots;
    };
    std::vector<Block> blocks;
    for (std::size_t k = 0; k < knots.y.size(); ++k) {
      blocks.push_back({knots.y[k], weight[k], 1});
      while (blocks.size() > 1 && blocks[blocks.size() - 2].mean > blocks.back().mean) {
        const Block last = blocks.back();
        blocks.pop_back();
        Block& into = blocks.back();
        into.mean = (into.mean * into.weight + last.mean * last.weight) / (into.weight + last.weight);
        into.weight += last.weight;
        into.knots += last.knots;
      }
    }
    std::size_t k = 0;
    for (const Block& block : blocks)
      for (std::size_t n = 0; n < block.knots; ++n) knots.y[k++] = block.mean;
    return knots;
  }

  FitSamples samples_;
  std::vector<std::size_t> order_;  // scored samples by input
};

}  // namespace

std::unique_ptr<Identifier> MonotoneModel::prepare(const FitData& like, const IdentifyOptions& /*options*/) {
  return std::make_unique<MonotoneIdentifier>(like);
}

}  // namespace tactbench::analysis
