// alpha_a1, alpha_a0, beta_a: with phi(L) = alpha_a1 L + alpha_a0 the split lies inside every branch exactly when u =
// phi(0) and v = phi(X) are in [0, 1], so the box is the unit cube in (u, v, beta_a). J is a narrow valley in it, with
// kinks and dents: damped Gauss-Newton in (u, v) on a grid of beta_a that is made finer where J is least, all three
// from the minima on it, and an evolution strategy in the valley's own metric for the kinks.
#include <algorithm>
#include <array>

#include "analysis/identify/elam/ascending_search.h"

namespace tactbench::analysis {
namespace {

constexpr std::size_t kGrid = 64;  // values of beta_a, both ends included,
constexpr std::size_t kEven = 48;  // so many of them evenly spaced, the others evenly on the pattern's abscissa
constexpr std::array kStartsU = {0.5, 0.0, 1.0};
constexpr int kGridSteps = 3;            // Gauss-Newton steps at each value of beta_a
constexpr int kInsideSteps = 2;          // at those that are put between them
constexpr std::size_t kIntervals = 16;   // at most so many between them, made finer
constexpr std::size_t kFirstMinima = 4;  // beside the best minima of that line,
constexpr double kPromising = 0.1;       // and where J is within this share of the least
constexpr std::size_t kInside = 8;       // values of beta_a inside each
constexpr std::size_t kMinima = 8;       // local minima of that line, made finer once more
constexpr std::size_t kInsideAgain = 8;
constexpr std::size_t kEnds = 16;  // minima of the finest line that are followed in all three
constexpr int kSpaceSteps = 14;
constexpr std::size_t kEvolved = 3;  // at most so many of them to the end,
constexpr double kNearly = 3e-4;     // if their J is within this share of the best one's,
constexpr double kDistinct = 1e-3;   // and they lie so far from those that were

bool by_beta(const Value& a, const Value& b) { return a.at[2] < b.at[2]; }

std::vector<Value> first_line(AscendingSearch& search, const LaneProblem& problem) {
  std::vector<Value> line(kGrid), tried(kGrid);
  const double span_x = problem.xu - problem.x0, span_y = problem.yu - problem.y0;
  // Where the pattern is flat, as that of a clipped taxel, all happens within a narrow range of beta_a.
  for (std::size_t i = 0; i < kGrid; ++i) {
    const double share = static_cast<double>(i - kEven + 1) / static_cast<double>(kGrid - kEven + 1);
    line[i].at[2] = i < kEven ? static_cast<double>(i) / (kEven - 1)
                              : (problem.table.value(problem.x0 + share * span_x) - problem.y0) / span_y;
  }
  std::ranges::stable_sort(line, by_beta);
  for (const double u : kStartsU) {
    for (std::size_t i = 0; i < kGrid; ++i) {
      const double beta = line[i].at[2];
      // v where the mapping of an external branch is the identity.
      tried[i].at = {u, (problem.table.inverse(problem.y0 + beta * span_y).u - problem.x0) / span_x, beta};
    }
    search.evaluate(tried);
    for (std::size_t i = 0; i < kGrid; ++i)
      if (tried[i].j < line[i].j) line[i] = tried[i];
  }
  search.descend(line, kGridSteps, Gradient::kPlane);
  return line;
}

// Puts `count` values of beta_a between i and i + 1 for each i of `intervals`, started between its ends.
void refine(AscendingSearch& search, std::vector<Value>& line, std::span<const std::size_t> intervals,
            std::size_t count) {
  std::vector<Value> inside;
  for (const std::size_t i : intervals) {
    for (std::size_t k = 1; k <= count; ++k) {
      const double share = static_cast<double>(k) / static_cast<double>(count + 1);
      Value value;
      for (std::size_t d = 0; d < 3; ++d) value.at[d] = line[i].at[d] + share * (line[i + 1].at[d] - line[i].at[d]);
      inside.push_back(value);
    }
  }
  search.descend(inside, kInsideSteps, Gradient::kPlane);
  line.insert(line.end(), inside.begin(), inside.end());
  std::ranges::stable_sort(line, by_beta);
}

// Places of the local minima of a line, least J first.
std::vector<std::size_t> minima_of(std::span<const Value> line) {
  std::vector<std::size_t> minima;
  for (std::size_t i = 0; i < line.size(); ++i)
    if ((i == 0 || line[i].j <= line[i - 1].j) && (i + 1 == line.size() || line[i].j < line[i + 1].j))
      minima.push_back(i);
  if (minima.empty()) minima.push_back(0);  // J the same everywhere
  std::ranges::stable_sort(minima, {}, [&](std::size_t i) { return line[i].j; });
  return minima;
}

// The intervals on both sides of the first `most` of these places.
std::vector<std::size_t> beside(std::span<const std::size_t> places, std::size_t most, std::size_t size) {
  std::vector<std::size_t> intervals;
  for (const std::size_t i : places.first(std::min(places.size(), most))) {
    if (i > 0 && std::ranges::find(intervals, i - 1) == intervals.end()) intervals.push_back(i - 1);
    if (i + 1 < size && std::ranges::find(intervals, i) == intervals.end()) intervals.push_back(i);
  }
  return intervals;
}

std::vector<Value> ends_of_lines(AscendingSearch& search, const LaneProblem& problem) {
  std::vector<Value> line = first_line(search, problem);
  const auto least = [&](std::size_t i) { return std::min(line[i].j, line[i + 1].j); };
  const double promising = (1.0 + kPromising) * std::ranges::min_element(line, {}, &Value::j)->j;
  std::vector<std::size_t> intervals = beside(minima_of(line), kFirstMinima, line.size());
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i + 1 < line.size(); ++i)
    if (least(i) <= promising && std::ranges::find(intervals, i) == intervals.end()) others.push_back(i);
  std::ranges::stable_sort(others, {}, least);
  intervals.insert(intervals.end(), others.begin(), others.end());
  intervals.resize(std::min(intervals.size(), kIntervals));
  refine(search, line, intervals, kInside);
  intervals = beside(minima_of(line), kMinima, line.size());
  refine(search, line, intervals, kInsideAgain);
  std::vector<Value> ends;
  for (const std::size_t i : minima_of(line)) ends.push_back(line[i]);
  ends.resize(std::min(ends.size(), kEnds));
  search.descend(ends, kSpaceSteps, Gradient::kSpace);
  std::ranges::stable_sort(ends, {}, &Value::j);
  return ends;
}

}  // namespace

double fit_ascending(ElamModel& model, std::span<const CurveSamples> curves) {
  const LaneProblem problem = lane_problem(model, curves, true);
  AscendingSearch search(problem, std::max(kIntervals * kInside, 2 * kMinima * kInsideAgain));
  const std::vector<Value> ends = ends_of_lines(search, problem);
  Value best;
  std::vector<Value> done;
  for (const Value& end : ends) {
    if (done.size() == kEvolved || end.j > best.j * (1.0 + kNearly)) break;
    const auto same = [&](const Value& other) {
      double off = 0.0;
      for (std::size_t k = 0; k < 3; ++k) off = std::max(off, std::abs(end.at[k] - other.at[k]));
      return off < kDistinct;
    };
    if (std::ranges::any_of(done, same)) continue;
    done.push_back(end);
    const Value found = search.evolve(end);
    if (found.j < best.j) best = found;
  }
  set_direction(model.parameters, true, model.xu() - model.x0(), best.at.data());
  return best.j;
}

}  // namespace tactbench::analysis
