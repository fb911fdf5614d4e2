#include "analysis/identify/elam/search.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/identify/elam/evolution.h"

namespace tactbench::analysis {
namespace {

double clip(double value) { return value > 0.0 ? std::min(value, 1.0) : 0.0; }  // what is no number to 0

// Cholesky's factor of a symmetric matrix (lower triangle row by row), its diagonal inverted.
struct Factor {
  std::array<double, 6> l{};
  Point diagonal{};
  explicit Factor(const std::array<double, 6>& a) {
    const auto root = [](double value) { return value > 0.0 ? std::sqrt(value) : 1.0; };
    l[0] = 1.0 / (diagonal[0] = root(a[0]));
    l[1] = a[1] * l[0];
    l[2] = 1.0 / (diagonal[1] = root(a[2] - l[1] * l[1]));
    l[3] = a[3] * l[0];
    l[4] = (a[4] - l[3] * l[1]) * l[2];
    l[5] = 1.0 / (diagonal[2] = root(a[5] - l[3] * l[3] - l[4] * l[4]));
  }
  [[nodiscard]] Point forward(const Point& b) const {  // L x = b
    Point x{};
    x[0] = b[0] * l[0];
    x[1] = (b[1] - l[1] * x[0]) * l[2];
    x[2] = (b[2] - l[3] * x[0] - l[4] * x[1]) * l[5];
    return x;
  }
  [[nodiscard]] Point backward(const Point& b) const {  // L' x = b
    Point x{};
    x[2] = b[2] * l[5];
    x[1] = (b[1] - l[4] * x[2]) * l[2];
    x[0] = (b[0] - l[1] * x[1] - l[3] * x[2]) * l[0];
    return x;
  }
  [[nodiscard]] Point times(const Point& z) const {  // L z
    return {diagonal[0] * z[0], l[1] * z[0] + diagonal[1] * z[1], l[3] * z[0] + l[4] * z[1] + diagonal[2] * z[2]};
  }
};

constexpr std::array<std::array<std::size_t, 3>, 3> kRow{{{0, 1, 3}, {1, 2, 4}, {3, 4, 5}}};

// The damped Gauss-Newton step. A parameter at its bound that would leave the cube rests, and one that J does not
// depend on.
Point damped_step(std::array<double, 6> a, Point b, double damping, const Point& at, bool plane) {
  for (std::size_t k = 0; k < (plane ? 2U : 3U); ++k) {
    const bool rests = a[kRow[k][k]] <= 0.0 || (at[k] <= 0.0 && b[k] < 0.0) || (at[k] >= 1.0 && b[k] > 0.0);
    a[kRow[k][k]] *= 1.0 + damping;
    if (!rests) continue;
    for (const std::size_t i : kRow[k]) a[i] = 0.0;
    a[kRow[k][k]] = 1.0;
    b[k] = 0.0;
  }
  if (plane) {
    const double by = 1.0 / (a[0] * a[2] - a[1] * a[1]);
    if (!(std::abs(by) < std::numeric_limits<double>::infinity())) return at;
    return {clip(at[0] + (b[0] * a[2] - b[1] * a[1]) * by), clip(at[1] + (b[1] * a[0] - b[0] * a[1]) * by), at[2]};
  }
  const Factor factor(a);
  const Point move = factor.backward(factor.forward(b));
  return {clip(at[0] + move[0]), clip(at[1] + move[1]), clip(at[2] + move[2])};
}

constexpr std::size_t kOffspring = 24, kParents = 12, kGenerations = 60;
constexpr int kDimensions = 3;
constexpr double kMeanLength = 1.596;  // of a normal vector

// What does not change from one evolution to the next.
struct Strategy {
  EvolutionConstants<kParents, kDimensions> constants;
  std::array<Point, kOffspring * kGenerations> variates{};
  Strategy() {
    Variates variate;
    for (Point& point : variates)
      for (double& value : point) value = variate();
  }
};

}  // namespace

void AscendingSearch::put(std::size_t i, const Point& at) {
  lanes_.u[i] = at[0];
  lanes_.v[i] = at[1];
  if (lanes_.beta[i] == at[2] && lanes_.is_split[i]) return;
  lanes_.beta[i] = at[2];
  lanes_.split(i);
}

void AscendingSearch::take(std::size_t i, Lane& lane, Gradient gradient) const {
  const std::size_t normals = gradient == Gradient::kSpace ? 6 : 3, rights = gradient == Gradient::kSpace ? 3 : 2;
  for (std::size_t k = 0; k < normals; ++k) lane.normal[k] = lanes_.normal[k][i];
  for (std::size_t k = 0; k < rights; ++k) lane.right[k] = lanes_.right[k][i];
}

void AscendingSearch::evaluate(std::span<Value> values) {
  if (values.size() > lanes_.stride) throw std::invalid_argument("more candidates than lanes");
  for (std::size_t i = 0; i < values.size(); ++i) put(i, values[i].at);
  lane_ascending(lanes_, values.size(), Gradient::kNone);
  for (std::size_t i = 0; i < values.size(); ++i) values[i].j = lanes_.j[i];
}

void AscendingSearch::descend(std::span<Value> values, int steps, Gradient gradient) {
  const std::size_t count = values.size();
  if (count > lanes_.stride) throw std::invalid_argument("more candidates than lanes");
  for (std::size_t i = 0; i < count; ++i) put(i, values[i].at);
  lane_ascending(lanes_, count, gradient);
  for (std::size_t i = 0; i < count; ++i) {
    at_[i] = {};
    values[i].j = lanes_.j[i];
    take(i, at_[i], gradient);
  }
  tried_.resize(count);
  for (int k = 0; k < steps; ++k) {
    for (std::size_t i = 0; i < count; ++i) {
      const Lane& lane = at_[i];
      tried_[i] = damped_step(lane.normal, lane.right, lane.damping, values[i].at, gradient == Gradient::kPlane);
      put(i, tried_[i]);
    }
    lane_ascending(lanes_, count, gradient);
    bool all = true;
    for (std::size_t i = 0; i < count; ++i) {
      Lane& lane = at_[i];
      if (lanes_.j[i] < values[i].j) {
        lane.settled = values[i].j - lanes_.j[i] <= 1e-13 * values[i].j;
        values[i] = {lanes_.j[i], tried_[i]};
        take(i, lane, gradient);
        lane.damping = std::max(lane.damping * 0.1, 1e-9);
      } else {
        lane.damping *= 8.0;
        lane.settled = lane.settled || lane.damping > 1e7;
      }
      all = all && lane.settled;
    }
    if (all) break;
  }
}

Value AscendingSearch::evolve(const Value& start) {
  constexpr double kFirst = 0.0548, kLast = 1e-4;  // step sizes: at them J would rise by their square, as a share
  static const Strategy strategy;
  const auto& variates = strategy.variates;
  const auto& [weight, mass, path_share, path_damping, way_share, rank_one, rank_many] = strategy.constants;

  put(0, start.at);
  lane_ascending(lanes_, 1, Gradient::kSpace);
  Lane here;
  take(0, here, Gradient::kSpace);
  // What J hardly depends on shall not run away.
  for (std::size_t k = 0; k < 3; ++k) here.normal[kRow[k][k]] = here.normal[kRow[k][k]] * (1.0 + 1e-6) + 1e-6 * start.j;
  const Factor metric(here.normal);

  Value best = start;
  Point mean{}, path{}, way{};
  std::array<double, 6> covariance{1, 0, 1, 0, 0, 1};
  double size = kFirst * std::sqrt(start.j), fading = 1.0;
  const double smallest = kLast * std::sqrt(start.j);
  std::array<Value, kOffspring> tries;
  std::array<Point, kOffspring> y{};
  std::array<double, kOffspring> outside{};  // J, and what leaving the cube costs, that the mean stays inside
  std::array<std::size_t, kOffspring> order{};
  for (std::size_t generation = 0; generation < kGenerations && size > smallest; ++generation) {
    const Factor shape(covariance);
    const Point* z = &variates[generation * kOffspring];
    for (std::size_t i = 0; i < kOffspring; ++i) {
      y[i] = shape.times(z[i]);
      Point p{};
      for (std::size_t k = 0; k < 3; ++k) p[k] = mean[k] + size * y[i][k];
      const Point move = metric.backward(p);
      outside[i] = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        tries[i].at[k] = clip(start.at[k] + move[k]);
        const double off = start.at[k] + move[k] - tries[i].at[k];
        outside[i] += here.normal[kRow[k][k]] * off * off;
      }
      order[i] = i;
    }
    evaluate(tries);
    for (const Value& tried : tries)
      if (tried.j < best.j) best = tried;
    for (std::size_t i = 0; i < kOffspring; ++i) outside[i] += tries[i].j;
    std::ranges::sort(order, {}, [&](std::size_t i) { return outside[i]; });
    Point mean_y{}, mean_z{};
    for (std::size_t i = 0; i < kParents; ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        mean_y[k] += weight[i] * y[order[i]][k];
        mean_z[k] += weight[i] * z[order[i]][k];
      }
    }
    double length = 0.0;
    for (std::size_t k = 0; k < 3; ++k) {
      mean[k] += size * mean_y[k];
      path[k] = (1.0 - path_share) * path[k] + std::sqrt(path_share * (2.0 - path_share) * mass) * mean_z[k];
      length += path[k] * path[k];
    }
    length = std::sqrt(length);
    fading *= (1.0 - path_share) * (1.0 - path_share);
    const bool steady = length < (1.4 + 2.0 / (kDimensions + 1.0)) * kMeanLength * std::sqrt(1.0 - fading);
    for (std::size_t k = 0; k < 3; ++k)
      way[k] =
          (1.0 - way_share) * way[k] + (steady ? std::sqrt(way_share * (2.0 - way_share) * mass) * mean_y[k] : 0.0);
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b <= a; ++b) {
        double many = 0.0;
        for (std::size_t i = 0; i < kParents; ++i) many += weight[i] * y[order[i]][a] * y[order[i]][b];
        double& c = covariance[kRow[a][b]];
        c = (1.0 - rank_one - rank_many) * c + rank_one * way[a] * way[b] + rank_many * many;
      }
    }
    size *= std::exp(path_share / path_damping * (length / kMeanLength - 1.0));
  }
  return best;
}

// alpha_a1, alpha_a0, beta_a: with phi(L) = alpha_a1 L + alpha_a0 the split lies inside every branch exactly when u =
// phi(0) and v = phi(X) are in [0, 1], so the box is the unit cube in (u, v, beta_a). J is a narrow valley in it, with
// kinks and dents: damped Gauss-Newton in (u, v) on a grid of beta_a that is made finer where J is least, all three
// from the minima on it, and an evolution strategy in the valley's own metric for the kinks.

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
std::vector<std::size_t> neighbours_of(std::span<const std::size_t> places, std::size_t most, std::size_t size) {
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
  std::vector<std::size_t> intervals = neighbours_of(minima_of(line), kFirstMinima, line.size());
  std::vector<std::size_t> others;
  for (std::size_t i = 0; i + 1 < line.size(); ++i)
    if (least(i) <= promising && std::ranges::find(intervals, i) == intervals.end()) others.push_back(i);
  std::ranges::stable_sort(others, {}, least);
  intervals.insert(intervals.end(), others.begin(), others.end());
  intervals.resize(std::min(intervals.size(), kIntervals));
  refine(search, line, intervals, kInside);
  intervals = neighbours_of(minima_of(line), kMinima, line.size());
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

// alpha_d, beta_d: the target curve is affine in beta_d, so for each alpha_d the best beta_d is known in closed form
// and one variable with several minima is left: a grid, then the best brackets divided until nothing moves.

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
