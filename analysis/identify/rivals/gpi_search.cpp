#include "analysis/identify/rivals/gpi_search.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "analysis/identify/rivals/gpi_evolution.h"
#include "analysis/identify/rivals/gpi_normal.h"

namespace tactbench::analysis {
namespace {

constexpr double kConverged = 1e-12;  // share by which J fell
constexpr double kLargestDamping = 1e9;
constexpr int kFirstRound = 10;  // generations of a tournament

struct Descent {
  GpiNormal here;
  GpiPoint to{};
  double damping = 1e-2, faster = 2.0;

  void aim(const GpiPoint& from) {
    GpiMatrix damped = here.matrix;
    for (int k = 0; k < kGpiUnknowns; ++k) damped(k, k) += damping * (here.matrix(k, k) + 1e-9);
    to = gpi_within(vector_of(from) - damped.ldlt().solve(here.slope));
  }
  // false: settled, after a try in vain.
  bool damp() {
    damping *= faster;
    faster *= 2.0;
    return damping < kLargestDamping;
  }
  // Goes on from `to`, where J is `j`; false: settled there.
  bool take(GpiFound& best, double j, const GpiNormal& there) {
    bool going = true;
    if (std::isfinite(best.j)) {
      const GpiVector moved = vector_of(to) - vector_of(best.at);
      const double promised = -moved.dot(2.0 * here.slope + here.matrix * moved);
      const double kept = promised > 0.0 ? (best.j - j) / promised : 0.0;
      damping *= std::clamp(1.0 - std::pow(2.0 * kept - 1.0, 3.0), 1.0 / 3.0, 2.0);  // after Nielsen
      faster = 2.0;
      going = best.j - j > kConverged * best.j;
    }
    best = {to, j};
    here = there;
    return going;
  }
};

}  // namespace

GpiPoint gpi_within(const GpiVector& to) {
  const double low = std::log(1e-3), high = std::log(60.0);
  GpiPoint p;
  for (int k = 0; k < kGpiUnknowns; ++k) p[static_cast<std::size_t>(k)] = std::isfinite(to[k]) ? to[k] : 0.0;
  for (const auto k : {kLnA, kLnB}) p[k] = std::clamp(p[k], low, high);
  for (const auto k : {kLnDl, kLnDr}) p[k] = std::clamp(p[k], -20.0, 10.0);
  p[kLnAlpha] = std::clamp(p[kLnAlpha], -10.0, 4.0);
  p[kS] = std::clamp(p[kS], -8.0, 20.0);
  for (const auto k : {kL0, kR0}) p[k] = std::clamp(p[k], -1e3, 1e3);
  return p;
}

GpiNormal::GpiNormal(const GpiLanes& lanes, std::size_t lane) {
  for (int a = 0, k = 0; a < kGpiUnknowns; ++a) {
    slope[a] = lanes.slope[static_cast<std::size_t>(a)][lane];
    for (int b = 0; b <= a; ++b, ++k) matrix(a, b) = matrix(b, a) = lanes.normal[static_cast<std::size_t>(k)][lane];
  }
}

GpiParameters gpi_parameters(const GpiPoint& p, double x_span, double y_span) {
  GpiParameters found;
  const auto envelope = [&](double ln_a, double start, double ln_rise, double& a0, double& a1, double& a3) {
    const double a = std::exp(ln_a);
    a0 = y_span * std::exp(ln_rise) / -std::expm1(-a);
    a1 = a / x_span;
    a3 = y_span * start + a0;
  };
  envelope(p[kLnA], p[kL0], p[kLnDl], found.a0, found.a1, found.a3);
  envelope(p[kLnB], p[kR0], p[kLnDr], found.b0, found.b1, found.b3);
  found.alpha = y_span * std::exp(p[kLnAlpha]);
  found.tau = p[kS] / found.alpha;
  return found;
}

void GpiSearch::each(std::span<const std::size_t> chosen, bool gradient, const auto& point, const auto& visit) {
  for (std::size_t first = 0; first < chosen.size(); first += GpiLanes::kMost) {
    const std::size_t count = std::min(GpiLanes::kMost, chosen.size() - first);
    for (std::size_t lane = 0; lane < count; ++lane) lanes_.at[lane] = point(chosen[first + lane]);
    lanes_.evaluate(*target_, gradient);
    for (std::size_t lane = 0; lane < count; ++lane) visit(chosen[first + lane], lane);
  }
}

void GpiSearch::rate(std::span<GpiFound> found) {
  std::vector<std::size_t> all(found.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  each(
      all, false, [&](std::size_t i) { return found[i].at; },
      [&](std::size_t i, std::size_t lane) { found[i].j = lanes_.j[lane]; });
}

void GpiSearch::descend(std::span<GpiFound> found, int steps) {
  std::vector<Descent> descents(found.size());
  std::vector<std::size_t> active(found.size()), falling, going;
  std::iota(active.begin(), active.end(), std::size_t{0});
  for (std::size_t i = 0; i < found.size(); ++i) {
    descents[i].to = gpi_within(vector_of(found[i].at));
    found[i].j = std::numeric_limits<double>::infinity();
  }
  const auto to = [&](std::size_t i) { return descents[i].to; };
  for (int step = 0; step <= steps && !active.empty(); ++step) {
    going.clear();
    falling.clear();
    const auto judge = [&](std::size_t i, std::size_t lane) {
      if (lanes_.j[lane] < found[i].j)
        falling.push_back(i);
      else if (std::isfinite(found[i].j) && descents[i].damp())
        going.push_back(i);
    };
    if (step == 0)
      falling = active;
    else
      each(active, false, to, judge);
    // The slopes cost several times what J alone does.
    each(falling, true, to, [&](std::size_t i, std::size_t lane) {
      const double j = lanes_.j[lane];
      if (std::isfinite(j) && descents[i].take(found[i], j, GpiNormal(lanes_, lane))) going.push_back(i);
    });
    for (const std::size_t i : going) descents[i].aim(found[i].at);
    std::ranges::sort(going);
    std::swap(active, going);
  }
}

GpiPoint GpiSearch::errors(const GpiFound& found, double variance) {
  lanes_.at.fill(found.at);
  lanes_.evaluate(*target_, true);
  const GpiNormal normal(lanes_, 0);
  const Eigen::SelfAdjointEigenSolver<GpiMatrix> solver(normal.matrix);
  const GpiVector spread =
      (variance / solver.eigenvalues().array().max(1e-14 * std::max(normal.matrix.trace(), 1e-12))).matrix();
  GpiPoint errors{};
  for (int k = 0; k < kGpiUnknowns; ++k)
    errors[static_cast<std::size_t>(k)] = std::sqrt(solver.eigenvectors().row(k).cwiseAbs2().dot(spread));
  return errors;
}

GpiFound GpiSearch::evolve(const GpiFound& start, double size, int generations) {
  GpiEvolution evolution(lanes_, *target_, start, size);
  evolution.go(lanes_, *target_, generations);
  return evolution.best();
}

std::vector<GpiFound> GpiSearch::tournament(std::span<const GpiFound> starts, double size, std::size_t most,
                                            int generations, double apart) {
  std::vector<GpiEvolution> evolutions;
  for (const GpiFound& start : starts) evolutions.emplace_back(lanes_, *target_, start, size);
  const auto on_to = [&](int generation) {
    for (GpiEvolution& evolution : evolutions) evolution.go(lanes_, *target_, generation);
    std::ranges::stable_sort(evolutions, {}, [](const GpiEvolution& one) { return one.best().j; });
  };
  for (int last = kFirstRound; last < generations && most >= 2; last *= 2, most /= 2) {
    on_to(last);
    keep_apart(evolutions, most, apart, [](const GpiEvolution& one) { return one.best().j; });
  }
  on_to(generations);
  std::vector<GpiFound> ends;
  for (const GpiEvolution& evolution : evolutions) ends.push_back(evolution.best());
  return ends;
}

}  // namespace tactbench::analysis
