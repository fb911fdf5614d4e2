#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "analysis/algebra/dense.h"
#include "analysis/identify/elam/ascending_search.h"
#include "analysis/identify/elam/elam_determined.h"
#include "analysis/identify/elam/elam_samples.h"
#include "analysis/identify/elam/lanes.h"

namespace tactbench::analysis {
namespace {

void check(const PatternCurve& ascending, const PatternCurve& descending, std::span<const TaxelBranch> branches) {
  if (ascending.x().size() < 2 || descending.x().size() < 2 || ascending.x().front() != descending.x().front() ||
      ascending.x().back() != descending.x().back() || ascending.y().front() != descending.y().front() ||
      ascending.y().back() != descending.y().back())
    throw std::invalid_argument("the two pattern curves do not meet at both ends");
  bool up = false, down = false;
  for (const TaxelBranch& branch : branches) {
    if (branch.volts.size() < 2 || branch.volts.size() != branch.pressure_psi.size())
      throw std::invalid_argument("a branch needs at least two samples, with a pressure each");
    const auto finite = [](double value) { return std::isfinite(value); };
    if (!std::ranges::all_of(branch.volts, finite) || !std::ranges::all_of(branch.pressure_psi, finite))
      throw std::invalid_argument("a branch holds a value that is not finite");
    (branch.ascending ? up : down) = true;
  }
  if (!up || !down) throw std::invalid_argument("branches of both directions are needed");
}

}  // namespace

unsigned bounds_met(const ElamModel& model) {
  constexpr double kNear = 1e-9;
  const ElamParameters& p = model.parameters;
  const double v = p.alpha_a1 * (model.xu() - model.x0()) + p.alpha_a0;  // phi(X); phi(0) is alpha_a0
  const double values[] = {p.alpha_d, p.beta_d, v, p.alpha_a0, p.beta_a};
  unsigned bits = 0;
  for (unsigned i = 0; i < 5; ++i)
    if (values[i] <= kNear || values[i] >= 1.0 - kNear) bits |= 1U << i;
  return bits;
}

ElamSamples searched_samples(const ElamModel& model, std::span<const TaxelBranch> branches) {
  check(model.ascending, model.descending, branches);
  ElamSamples samples = collect_samples(model, branches);
  // With exact_outer no parameter moves the external branches: they are scored, not searched.
  if (model.options.exact_outer) {
    std::erase_if(samples.descending, [&](const CurveSamples& c) { return c.x_turn == model.xu(); });
    std::erase_if(samples.ascending, [&](const CurveSamples& c) { return c.x_turn == model.x0(); });
  }
  thin(samples.descending, kSearchedSamples);
  thin(samples.ascending, kSearchedSamples);
  return samples;
}

ElamFit scored(const ElamModel& model, std::span<const TaxelBranch> branches) {
  ElamFit fit;
  fit.model = model;
  fit.full_scale_v = std::max(std::abs(model.y0()), std::abs(model.yu()));
  fit.at_bound = bounds_met(model);
  std::size_t count = 0;
  for (const TaxelBranch& branch : branches) {
    const TurningPoint turn = turning_point(model, branch);
    const ElamCurve curve(model, branch.ascending, turn.x, turn.y);
    for (std::size_t i = 1; i < branch.volts.size(); ++i, ++count) {
      const double error = curve.output(branch.pressure_psi[i]) - branch.volts[i];
      fit.j_v2 += error * error;            // (1)
      fit.mean_error_v += std::abs(error);  // (49)
      fit.max_error_v = std::max(fit.max_error_v, std::abs(error));
    }
  }
  fit.mean_error_v /= static_cast<double>(count);
  return fit;
}

std::vector<std::string> undetermined_names(const ElamFit& fit) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kElamParameterNames.size(); ++i)
    if (((fit.undetermined >> i) & 1U) != 0) names.emplace_back(kElamParameterNames[i]);
  return names;
}

ElamFit identify_elam(const PatternCurve& ascending, const PatternCurve& descending,
                      std::span<const TaxelBranch> branches, const ElamOptions& options, bool settle) {
  ElamModel model{ascending, descending, {}, options};
  const ElamSamples samples = searched_samples(model, branches);
  fit_descending(model, samples.descending);
  fit_ascending(model, samples.ascending);
  unsigned undetermined = 0;
  if (settle) {
    undetermined = settle_undetermined(model, samples.descending, samples.descending_constant, false);
    undetermined |= settle_undetermined(model, samples.ascending, samples.ascending_constant, true);
  }
  ElamFit fit = scored(model, branches);
  fit.undetermined = undetermined;
  return fit;
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

// Further split points a branch, from the optimum with one: for each way to share them between the two sides of the
// paper's split, Levenberg-Marquardt with numeric derivatives in the paper's parameters and the pieces' sizes.

namespace {

constexpr int kSteps = 30;
constexpr double kDifference = 1e-6;  // of a parameter, for derivatives
constexpr double kSettled = 1e-9;     // gain of a step, of J

// One direction's parameters in one row: the paper's, each in [0, 1], then the logarithms of the pieces' sizes.
class Direction {
 public:
  Direction(const ElamModel& model, std::span<const CurveSamples> curves, bool ascending, std::size_t low,
            std::size_t high)
      : model_(model), curves_(curves), ascending_(ascending), low_(low), high_(high) {
    for (const CurveSamples& curve : curves) samples_ += static_cast<Eigen::Index>(curve.x.size());
  }
  [[nodiscard]] Eigen::Index own() const { return ascending_ ? 3 : 2; }  // the paper's parameters
  [[nodiscard]] Eigen::VectorXd start() const {
    const std::array<double, 3> row = direction_of(model_.parameters, ascending_, length());
    Eigen::VectorXd at = Eigen::VectorXd::Zero(own() + static_cast<Eigen::Index>(low_ + high_));
    at.head(own()) = Eigen::VectorXd::Map(row.data(), own());
    return clipped(at);
  }
  [[nodiscard]] Eigen::VectorXd clipped(Eigen::VectorXd at) const {
    at.head(own()) = at.head(own()).cwiseMax(0.0).cwiseMin(1.0);
    const Eigen::Index pieces = at.size() - own();
    at.tail(pieces) = at.tail(pieces).cwiseMax(-kMaxPieceLog).cwiseMin(kMaxPieceLog);
    return at;
  }
  void put(const Eigen::VectorXd& at, ElamModel& model, ElamPieces& pieces) const {
    set_direction(model.parameters, ascending_, length(), at.data());
    const double* logs = at.data() + own();
    (ascending_ ? pieces.ascending_low : pieces.descending_low).assign(logs, logs + low_);
    (ascending_ ? pieces.ascending_high : pieces.descending_high).assign(logs + low_, logs + low_ + high_);
  }
  [[nodiscard]] Eigen::VectorXd residuals(const Eigen::VectorXd& at, ElamModel& model) const {
    ElamPieces pieces;
    pieces.descending_low.resize(low_ + high_);  // so many splits, whichever direction is looked at
    put(at, model, pieces);
    Eigen::VectorXd off(samples_);
    Eigen::Index k = 0;
    for (const CurveSamples& samples : curves_) {
      const ElamPiecedCurve curve(model, pieces, ascending_, samples.x_turn, samples.y_turn);
      for (std::size_t i = 0; i < samples.x.size(); ++i)
        off[k++] = std::sqrt(samples.weight[i]) * (curve.output(samples.x[i]) - samples.y[i]);
    }
    return off;
  }
  [[nodiscard]] ElamModel model() const { return model_; }
  [[nodiscard]] Eigen::Index samples() const { return samples_; }

 private:
  [[nodiscard]] double length() const { return model_.xu() - model_.x0(); }
  const ElamModel& model_;
  std::span<const CurveSamples> curves_;
  bool ascending_;
  std::size_t low_, high_;
  Eigen::Index samples_ = 0;
};

struct Found {
  double j = std::numeric_limits<double>::infinity();
  Eigen::VectorXd at;
};

Found descend(const Direction& direction) {
  ElamModel model = direction.model();
  Eigen::VectorXd at = direction.start();
  Eigen::VectorXd off = direction.residuals(at, model);
  Found found{off.squaredNorm(), at};
  Eigen::MatrixXd slopes(direction.samples(), at.size());
  double damping = 1e-3;
  for (int step = 0; step < kSteps; ++step) {
    for (Eigen::Index k = 0; k < at.size(); ++k) {
      Eigen::VectorXd moved = at;
      const double by = at[k] > 0.5 ? -kDifference : kDifference;  // inside the bounds
      moved[k] += by;
      slopes.col(k) = (direction.residuals(moved, model) - off) / by;
    }
    const Eigen::MatrixXd normal = gram_of(slopes);
    const Eigen::VectorXd along = slopes.transpose() * off;
    const double before = found.j;
    while (damping < 1e6) {
      Eigen::MatrixXd damped = normal;
      damped.diagonal() += damping * (normal.diagonal().array() + 1e-9 * normal.diagonal().maxCoeff()).matrix();
      const Eigen::VectorXd tried = direction.clipped(at - solve(damped, along));
      if (!tried.allFinite()) break;
      const Eigen::VectorXd there = direction.residuals(tried, model);
      if (there.squaredNorm() < found.j) {
        found = {there.squaredNorm(), tried};
        at = tried;
        off = there;
        damping = std::max(damping * 0.1, 1e-9);
        break;
      }
      damping *= 8.0;
    }
    if (before - found.j <= kSettled * before) break;
  }
  return found;
}

}  // namespace

ElamPieces fit_pieces(ElamModel& model, const ElamSamples& samples, int splits) {
  ElamPieces pieces;
  const auto more = static_cast<std::size_t>(splits - 1);
  for (const bool ascending : {false, true}) {
    const std::vector<CurveSamples>& curves = ascending ? samples.ascending : samples.descending;
    const ElamModel start = model;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t low = 0; low <= more; ++low) {
      const Direction direction(start, curves, ascending, low, more - low);
      const Found found = descend(direction);
      if (found.j >= least) continue;
      least = found.j;
      direction.put(found.at, model, pieces);
    }
  }
  return pieces;
}

}  // namespace tactbench::analysis
