// GPI's evolution strategy, generation by generation, against the equations of Hansen's tutorial written down again.
#include <Eigen/Cholesky>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "analysis/identify/rivals/gpi_evolution.h"
#include "tests/analysis/support/fit_samples.h"

using namespace synthetic;

namespace {

struct Problem {
  FitData data = paper_both(0.03, 0.02);
  FitSamples samples{data};
  GpiTree tree{samples};
  GpiTree::Target target = tree.target(shares());
  GpiLanes lanes{tree};
  GpiFound start;
  Problem() {
    start.at = {0.8, 0.1, -0.5, 0.3, -0.1, -0.2, -2.0, 0.3};
    start.j = j(start.at);
  }
  double j(const GpiPoint& at) {
    lanes.at.fill(at);
    lanes.evaluate(target, false);
    return lanes.j[0];
  }

 private:
  [[nodiscard]] std::vector<double> shares() const {
    std::vector<double> y = samples.outputs(data);
    for (double& value : y) value /= data.ascending.y().back();
    return y;
  }
};

// "The CMA Evolution Strategy: A Tutorial", 8 unknowns, 32 children, 16 parents.
class Reference {
 public:
  Reference(Problem& problem, double size) : problem_(problem), best_(problem.start) {
    sigma_ = size * std::sqrt(problem.start.j);
    problem.lanes.at.fill(problem.start.at);
    problem.lanes.evaluate(problem.target, true);
    GpiMatrix normal = GpiNormal(problem.lanes, 0).matrix;
    normal.diagonal() *= 1.000001;
    normal.diagonal().array() += 0.001 * problem.start.j;
    metric_ = normal.llt().matrixU();
    for (int i = 1; i <= 16; ++i) weights_.push_back(std::log(16.5 / i));
    double sum = 0.0, squares = 0.0;
    for (const double w : weights_) sum += w;
    for (double& w : weights_) {
      w /= sum;
      squares += w * w;
    }
    mass_ = 1.0 / squares;
  }
  void generation() {
    struct Child {
      GpiVector y;
      GpiFound found;
    };
    std::vector<Child> children(32);
    const GpiMatrix a = covariance_.llt().matrixL();
    for (Child& child : children) {
      GpiVector z;
      for (int k = 0; k < 8; ++k) z[k] = variate_();
      child.y = a * z;
      const GpiVector step = metric_.inverse() * (mean_ + sigma_ * child.y);
      child.found.at = gpi_within(vector_of(problem_.start.at) + step);
      child.found.j = problem_.j(child.found.at);
    }
    std::ranges::sort(children, {}, [](const Child& child) { return child.found.j; });
    if (children[0].found.j < best_.j) best_ = children[0].found;
    GpiVector y = GpiVector::Zero();
    GpiMatrix rank_mu = GpiMatrix::Zero();
    for (std::size_t i = 0; i < 16; ++i) {
      y += weights_[i] * children[i].y;
      rank_mu += weights_[i] * children[i].y * children[i].y.transpose();
    }
    mean_ += sigma_ * y;
    const double n = 8.0, chi = 2.7416;  // sqrt(2) Gamma(4.5) / Gamma(4), as rounded there
    const double c_sigma = (mass_ + 2.0) / (n + mass_ + 5.0);
    const double d_sigma = 1.0 + 2.0 * std::max(0.0, std::sqrt((mass_ - 1.0) / (n + 1.0)) - 1.0) + c_sigma;
    const double c_c = (4.0 + mass_ / n) / (n + 4.0 + 2.0 * mass_ / n);
    const double c_1 = 2.0 / (std::pow(n + 1.3, 2) + mass_);
    const double c_mu = std::min(1.0 - c_1, 2.0 * (mass_ - 2.0 + 1.0 / mass_) / (std::pow(n + 2.0, 2) + mass_));
    const GpiVector z = a.inverse() * y;
    path_sigma_ = (1.0 - c_sigma) * path_sigma_ + std::sqrt(c_sigma * (2.0 - c_sigma) * mass_) * z;
    const double length = path_sigma_.norm();
    ++generation_;
    const bool steady =
        length / std::sqrt(1.0 - std::pow(1.0 - c_sigma, 2 * generation_)) < (1.4 + 2.0 / (n + 1.0)) * chi;
    stalled += steady ? 0 : 1;
    path_ = (1.0 - c_c) * path_ + (steady ? std::sqrt(c_c * (2.0 - c_c) * mass_) : 0.0) * y;
    covariance_ = (1.0 - c_1 - c_mu) * covariance_ + c_1 * path_ * path_.transpose() + c_mu * rank_mu;
    sigma_ *= std::exp(c_sigma / d_sigma * (length / chi - 1.0));
  }
  [[nodiscard]] const GpiFound& best() const { return best_; }
  int stalled = 0;  // generations whose path was too long for the covariance to follow it

 private:
  Problem& problem_;
  GpiFound best_;
  Variates variate_;
  GpiMatrix metric_, covariance_ = GpiMatrix::Identity();
  GpiVector mean_ = GpiVector::Zero(), path_ = GpiVector::Zero(), path_sigma_ = GpiVector::Zero();
  std::vector<double> weights_;
  double sigma_ = 0.0, mass_ = 0.0;
  int generation_ = 0;
};

}  // namespace

TEST_CASE("GPI: its evolution strategy does what the tutorial's equations do, generation by generation") {
  Problem problem;
  int stalled = 0;
  for (const double size : {0.001, 0.05, 2.0}) {
    GpiEvolution evolution(problem.lanes, problem.target, problem.start, size);
    Reference reference(problem, size);
    int better = 0;
    for (int generation = 1; generation <= 12; ++generation) {
      CAPTURE(size, generation);
      const double before = evolution.best().j;
      evolution.go(problem.lanes, problem.target, generation);
      reference.generation();
      CHECK(evolution.best().j == Approx(reference.best().j).epsilon(1e-9));
      for (std::size_t k = 0; k < kGpiUnknowns; ++k)
        CHECK(evolution.best().at[k] == Approx(reference.best().at[k]).margin(1e-8));
      CHECK(problem.j(evolution.best().at) == Approx(evolution.best().j).epsilon(1e-12));
      better += evolution.best().j < before ? 1 : 0;
    }
    CHECK(better >= 2);
    stalled += reference.stalled;
  }
  CHECK(stalled > 0);
}

TEST_CASE("GPI: its evolution strategy ends at its last generation, or when steps no longer matter") {
  Problem problem;
  GpiEvolution small(problem.lanes, problem.target, problem.start, 1e-5);
  small.go(problem.lanes, problem.target, 100);
  CHECK(small.best().at == problem.start.at);
  GpiEvolution once(problem.lanes, problem.target, problem.start, 0.05), twice = once;
  once.go(problem.lanes, problem.target, 6);
  for (const int last : {3, 3, 6}) twice.go(problem.lanes, problem.target, last);
  CHECK(twice.best().at == once.best().at);
  CHECK(once.best().j < problem.start.j);
}
