// alpha_d, beta_d: the target curve is affine in beta_d, so for each alpha_d the best beta_d is known in closed form
// and one variable with several minima is left: a grid, then the best brackets divided until nothing moves.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "analysis/identify/elam/lanes.h"

namespace tactbench::analysis {
namespace {

constexpr std::size_t kAlphas = 128;         // values of alpha_d, both ends included
constexpr std::size_t kAlphaIntervals = 32;  // at most so many between them, made finer
constexpr double kPromisingAlpha = 0.25;     // where J is within this share of the least
constexpr std::size_t kInsideAlpha = 4;      // values inside each
constexpr std::size_t kAlphaMinima = 6;      // local minima of that line, looked into
constexpr std::size_t kDivisions = 8;        // of a bracket, each round: it narrows 4.5 times
constexpr int kFirstRounds = 3;
constexpr int kLastRounds = 8;  // to a bracket of 1 / (127 x 4.5^11), below 1e-9

struct AlphaValue {
  double j = std::numeric_limits<double>::infinity();
  double alpha = 0.0, beta = 0.0;
};

// Divides the brackets of half width `width` about each of `minima`, and keeps the best of each.
void divide(const LaneProblem& problem, std::span<AlphaValue> minima, double& width) {
  std::array<double, kAlphaMinima * kDivisions> alpha, j, beta;
  const std::size_t count = minima.size() * kDivisions;
  width /= 0.5 * kDivisions + 0.5;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t k = i % kDivisions;
    const double steps = static_cast<double>(k) - (k < kDivisions / 2 ? 4.0 : 3.0);  // -4..-1, 1..4
    alpha[i] = std::clamp(minima[i / kDivisions].alpha + steps * width, 0.0, 1.0);
  }
  lane_descending(problem, std::span(alpha).first(count), j, beta);
  for (std::size_t i = 0; i < count; ++i)
    if (j[i] < minima[i / kDivisions].j) minima[i / kDivisions] = {j[i], alpha[i], beta[i]};
}

// J at each alpha_d of `line`.
void evaluate(const LaneProblem& problem, std::span<AlphaValue> line) {
  std::vector<double> alpha((line.size() + 7) / 8 * 8, 0.0), j(alpha.size()), beta(alpha.size());
  std::ranges::transform(line, alpha.begin(), &AlphaValue::alpha);
  lane_descending(problem, alpha, j, beta);
  for (std::size_t i = 0; i < line.size(); ++i) line[i] = {j[i], line[i].alpha, beta[i]};
}

std::vector<AlphaValue> line_of(const LaneProblem& problem) {
  std::vector<AlphaValue> line(kAlphas), inside;
  for (std::size_t i = 0; i < kAlphas; ++i) line[i].alpha = static_cast<double>(i) / (kAlphas - 1);
  evaluate(problem, line);
  const auto least = [&](std::size_t i) { return std::min(line[i].j, line[i + 1].j); };
  const double promising = (1.0 + kPromisingAlpha) * std::ranges::min_element(line, {}, &AlphaValue::j)->j;
  std::vector<std::size_t> intervals;
  for (std::size_t i = 0; i + 1 < kAlphas; ++i)
    if (least(i) <= promising) intervals.push_back(i);
  std::ranges::stable_sort(intervals, {}, least);
  intervals.resize(std::min(intervals.size(), kAlphaIntervals));
  for (const std::size_t i : intervals)
    for (std::size_t k = 1; k <= kInsideAlpha; ++k)
      inside.push_back(
          {0.0, (static_cast<double>(i) + static_cast<double>(k) / (kInsideAlpha + 1)) / (kAlphas - 1), 0.0});
  evaluate(problem, inside);
  line.insert(line.end(), inside.begin(), inside.end());
  std::ranges::stable_sort(line, {}, &AlphaValue::alpha);
  return line;
}

}  // namespace

double fit_descending(ElamModel& model, std::span<const CurveSamples> curves) {
  const LaneProblem problem = lane_problem(model, curves, false);
  const std::vector<AlphaValue> line = line_of(problem);
  std::vector<AlphaValue> minima;
  for (std::size_t i = 0; i < line.size(); ++i)
    if ((i == 0 || line[i].j <= line[i - 1].j) && (i + 1 == line.size() || line[i].j < line[i + 1].j))
      minima.push_back(line[i]);
  if (minima.empty()) minima.push_back(line[line.size() / 2]);  // J the same everywhere
  std::ranges::stable_sort(minima, {}, &AlphaValue::j);
  minima.resize(std::min(minima.size(), kAlphaMinima));
  double width = 1.0 / (kAlphas - 1);
  for (int round = 0; round < kFirstRounds; ++round) divide(problem, minima, width);
  AlphaValue best = *std::ranges::min_element(minima, {}, &AlphaValue::j);
  for (int round = 0; round < kLastRounds; ++round) divide(problem, std::span(&best, 1), width);
  model.parameters.alpha_d = best.alpha;
  model.parameters.beta_d = best.beta;
  return best.j;
}

}  // namespace tactbench::analysis
