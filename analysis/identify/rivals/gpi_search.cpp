#include "analysis/identify/rivals/gpi_search.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "analysis/identify/fit_models.h"
#include "analysis/models/invert.h"

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

namespace {

constexpr std::size_t kGpiOffspring = 32, kGpiParents = 16;
constexpr double kGpiMeanLength = 2.7416;  // of a normal vector in 8 dimensions
constexpr double kSmallestStep = 1e-5;     // times the root of J
constexpr double kOpenCurvature = 1e-3;    // times J: what J hardly depends on shall not run away

}  // namespace

GpiEvolution::GpiEvolution(GpiLanes& lanes, const GpiTree::Target& target, const GpiFound& start, double size)
    : start_(start), best_(start), size_(size * std::sqrt(start.j)), smallest_(kSmallestStep * std::sqrt(start.j)) {
  lanes.at.fill(start.at);
  lanes.evaluate(target, true);
  GpiMatrix normal = GpiNormal(lanes, 0).matrix;
  for (int k = 0; k < kGpiUnknowns; ++k) normal(k, k) = normal(k, k) * (1.0 + 1e-6) + kOpenCurvature * start.j;
  metric_.compute(normal);
}

void GpiEvolution::go(GpiLanes& lanes, const GpiTree::Target& target, int last) {
  for (; generation_ < last && size_ > smallest_; ++generation_) generation(lanes, target);
}

void GpiEvolution::generation(GpiLanes& lanes, const GpiTree::Target& target) {
  static const EvolutionConstants<kGpiParents, kGpiUnknowns> constants;
  const auto& [weight, mass, path_share, path_damping, way_share, rank_one, rank_many] = constants;
  std::array<GpiVector, kGpiOffspring> z, y;
  std::array<GpiFound, kGpiOffspring> tried;
  std::array<std::size_t, kGpiOffspring> order{};
  const GpiMatrix shape = Eigen::LLT<GpiMatrix>(covariance_).matrixL();
  for (std::size_t i = 0; i < kGpiOffspring; ++i) {
    for (double& value : z[i]) value = variate_();
    y[i] = shape * z[i];
    tried[i].at = gpi_within(vector_of(start_.at) + metric_.matrixU().solve(GpiVector(mean_ + size_ * y[i])));
    order[i] = i;
  }
  for (std::size_t first = 0; first < kGpiOffspring; first += GpiLanes::kMost) {
    for (std::size_t lane = 0; lane < GpiLanes::kMost; ++lane) lanes.at[lane] = tried[first + lane].at;
    lanes.evaluate(target, false);
    for (std::size_t lane = 0; lane < GpiLanes::kMost; ++lane) tried[first + lane].j = lanes.j[lane];
  }
  std::ranges::sort(order, {}, [&](std::size_t i) { return tried[i].j; });
  if (tried[order[0]].j < best_.j) best_ = tried[order[0]];
  GpiVector mean_y = GpiVector::Zero(), mean_z = GpiVector::Zero();
  GpiMatrix many = GpiMatrix::Zero();
  for (std::size_t i = 0; i < kGpiParents; ++i) {
    mean_y += weight[i] * y[order[i]];
    mean_z += weight[i] * z[order[i]];
    many.noalias() += weight[i] * y[order[i]] * y[order[i]].transpose();
  }
  mean_ += size_ * mean_y;
  path_ = (1.0 - path_share) * path_ + std::sqrt(path_share * (2.0 - path_share) * mass) * mean_z;
  fading_ *= (1.0 - path_share) * (1.0 - path_share);
  const double length = path_.norm();
  const bool steady = length < (1.4 + 2.0 / 9.0) * kGpiMeanLength * std::sqrt(1.0 - fading_);
  way_ *= 1.0 - way_share;
  if (steady) way_ += std::sqrt(way_share * (2.0 - way_share) * mass) * mean_y;
  covariance_ = (1.0 - rank_one - rank_many) * covariance_ + rank_one * way_ * way_.transpose() + rank_many * many;
  size_ *= std::exp(path_share / path_damping * (length / kGpiMeanLength - 1.0));
}

// GPI has many minima: local searches from fixed starts, spread evenly over the shapes that loops have.

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

std::unique_ptr<Identifier> GpiModel::prepare(const FitData& like, const IdentifyOptions& options) {
  return std::make_unique<GpiIdentifier>(like, options.starts);
}

KnownModel GpiModel::known() {
  const GpiParameters parameters{0.62, 0.047, 1.05, 1.55, 11.0, 0.091, -1.8, 1.6, 0.33, 1.6, 3.9};
  return {
      std::make_unique<GpiModel>(parameters, 0.0, 60.0, 0.0),
      {-0.349260432699923, 2.19584686504441, 2.91544955531854, 2.91544955531854, 1.99337208204905, 2.65185898820238}};
}

}  // namespace tactbench::analysis
