// GPI's tree of states against play operators walked along the data: what is compared at one step has one model value,
// and what a larger swing has wiped out is not told apart.
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <span>
#include <vector>

#include "analysis/identify/fit_samples.h"
#include "analysis/identify/rivals/gpi_tree.h"
#include "tests/analysis/support/fit_samples.h"

using namespace synthetic;

namespace {

// Play operators of a virgin sensor, and a sum of them in which none hides another.
class Plays {
 public:
  double to(double x) {
    double sum = x;
    for (std::size_t k = 0; k < at_.size(); ++k) {
      const double half = 0.03 + 0.06 * static_cast<double>(k);
      at_[k] = std::clamp(at_[k], x - half, x + half);
      sum += at_[k] / (2.0 + static_cast<double>(k));
    }
    return sum;
  }

 private:
  std::vector<double> at_ = std::vector<double>(9, 0.0);
};

// The inputs as shares of the range, each way from a virgin sensor.
FitData played(const std::vector<std::vector<double>>& ways) {
  const std::vector<double> ends{0.0, 1.0};
  const PatternCurve line(ends, ends, 0.0, 1.0);
  FitData data{{}, line, line};
  for (const std::vector<double>& way : ways) {
    Plays plays;
    data.histories.push_back({"way", way, {}, branches_along(way), {}, {}});
    for (const double x : way) data.histories.back().y.push_back(plays.to(x));
  }
  return data;
}

std::size_t check_tree(const FitData& data) {
  const FitSamples samples(data);
  const GpiTree tree(samples);
  const std::vector<double> y = samples.outputs(data);
  const GpiTree::Target target = tree.target(y);
  CHECK(target.constant < 1e-20);
  double weights = 0.0;
  for (const GpiTree::Step& step : tree.steps) weights += step.weight;
  CHECK(weights == static_cast<double>(samples.fitted.size()));
  // Walked node by node, with no more states kept than there are slots.
  std::vector<Plays> slots(tree.slots);
  for (const GpiTree::Node& node : tree.nodes) {
    Plays here = node.from == GpiTree::kVirgin ? Plays() : slots.at(node.from);
    (void)here.to(tree.knots.at(node.knot));
    slots.at(node.slot) = here;
    for (std::size_t s = node.first; s < node.end; ++s) {
      Plays there = here;
      CHECK(there.to(tree.knots.at(tree.steps[s].knot)) == Approx(target.mean[s]).epsilon(1e-12));
    }
  }
  return tree.steps.size();
}

}  // namespace

TEST_CASE("GPI's tree by hand: loops that close, and repeats, are compared once") {
  // Up, down, up again: three steps, and two more loops between the same turns add none.
  CHECK(check_tree(played({{0, 0.8, 0.4, 0.8}})) == 3);
  CHECK(check_tree(played({{0, 0.8, 0.4, 0.8, 0.4, 0.8, 0.4}})) == 3);
  // A second history from a virgin sensor shares what it has in common with the first.
  CHECK(check_tree(played({{0, 0.8, 0.4, 0.8}, {0, 0.8, 0.4, 0.8}})) == 3);
  CHECK(check_tree(played({{0, 0.8, 0.4, 0.8}, {0, 0.8, 0.2}})) == 4);
  // Beyond the first turn the inner loop is wiped out: 0.9 is then reached as from below.
  CHECK(check_tree(played({{0, 0.8, 0.4, 0.9, 0.4, 0.9}})) == 5);
  // An inner loop of an inner loop, closed at 0.4: the same fall goes on.
  CHECK(check_tree(played({{0, 0.8, 0.4, 0.6, 0.4, 0.2, 0.4}})) == 6);
  CHECK(check_tree(played({{0, 0.8, 0.4, 0.6, 0.5, 0.6, 0.4, 0.6, 0.5, 0.6}})) == 6);
  // A fall to 0 is no virgin state: the next rise differs from the first.
  CHECK(check_tree(played({{0, 0.8, 0, 0.8, 0, 0.8}})) == 3);
}

TEST_CASE("GPI's tree: inputs at random are compared where play operators have one value") {
  std::mt19937 random(4);
  for (int n = 0; n < 40; ++n) {
    std::uniform_int_distribution<int> twelfth(0, 12), length(3, 40);
    std::vector<std::vector<double>> ways(n % 3 == 0 ? 2 : 1);
    for (std::vector<double>& way : ways) {
      way = {0.0, 0.5, 0.25};
      for (int i = length(random); i-- > 0;) {
        const double next = twelfth(random) / 12.0;
        if (next != way.back()) way.push_back(next);
      }
    }
    CAPTURE(ways);
    CHECK(check_tree(played(ways)) > 0);
  }
}
