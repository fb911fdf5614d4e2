// ELAM's local searches for its rising half against their equations written down again: Levenberg-Marquardt in the unit
// cube, and the evolution strategy of Hansen's tutorial in the metric of the normal equations.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>
#include <vector>

#include "analysis/identify/elam/ascending_search.h"
#include "analysis/identify/elam/evolution.h"
#include "tests/analysis/support/synthetic.h"

using namespace synthetic;

namespace {

using Cube = Eigen::Vector3d;

Cube inside(const Cube& at) { return at.cwiseMax(0.0).cwiseMin(1.0); }
Cube cube_of(const Point& at) { return {at[0], at[1], at[2]}; }
Point point_of(const Cube& at) { return {at[0], at[1], at[2]}; }

// Rises from the lowest input and from two turns inside, of a model drawn anywhere, with noise.
struct Rises {
  ElamModel model = model_of(paper_loop(), {});
  std::vector<CurveSamples> curves;
  Rises(Random& random, double noise) {
    const double u = random(0.0, 1.0), v = random(0.0, 1.0);
    model.parameters = {0.5, 0.5, (v - u) / 60.0, u, random(0.0, 1.0)};
    for (const double turn : {0.0, random(10.0, 25.0), random(30.0, 45.0)}) {
      CurveSamples& own = curves.emplace_back();
      own.x_turn = turn;
      own.y_turn = turn == 0.0 ? model.y0() : model.descending(turn);
      const ElamCurve curve(model, true, own.x_turn, own.y_turn);
      for (int i = 1; i <= 6; ++i) {
        own.x.push_back(turn + (60.0 - turn) * i / 6.5);
        own.y.push_back(curve.output(own.x.back()) + random(-noise, noise));
        own.weight.push_back(1.0 + i % 3);
      }
    }
  }
};

struct Normal {
  double j = 0.0;
  Eigen::Matrix3d matrix;
  Cube right;
};

class RisingJ {
 public:
  explicit RisingJ(const LaneProblem& problem) : lanes_(problem, 1) {}
  Normal operator()(const Cube& at) {
    lanes_.u[0] = at[0];
    lanes_.v[0] = at[1];
    lanes_.beta[0] = at[2];
    lanes_.split(0);
    lane_ascending(lanes_, 1, Gradient::kSpace);
    Normal found{lanes_.j[0], {}, {lanes_.right[0][0], lanes_.right[1][0], lanes_.right[2][0]}};
    for (Eigen::Index a = 0, k = 0; a < 3; ++a)
      for (Eigen::Index b = 0; b <= a; ++b, ++k)
        found.matrix(a, b) = found.matrix(b, a) = lanes_.normal[static_cast<std::size_t>(k)][0];
    return found;
  }

 private:
  AscendingLanes lanes_;
};

// A strategy of 3 unknowns, 24 children, 12 parents; beyond the cube a child costs the square of how far.
Value evolved(const LaneProblem& problem, const Value& start) {
  RisingJ j(problem);
  const double n = 3.0, chi = 1.596;  // sqrt(8 / pi), as rounded there
  std::vector<double> weights;
  double sum = 0.0, squares = 0.0;
  for (int i = 1; i <= 12; ++i) sum += weights.emplace_back(std::log(12.5 / i));
  for (double& w : weights) {
    w /= sum;
    squares += w * w;
  }
  const double mass = 1.0 / squares;
  const double c_sigma = (mass + 2.0) / (n + mass + 5.0), d_sigma = 1.0 + c_sigma;
  const double c_c = (4.0 + mass / n) / (n + 4.0 + 2.0 * mass / n);
  const double c_1 = 2.0 / (std::pow(n + 1.3, 2) + mass);
  const double c_mu = std::min(1.0 - c_1, 2.0 * (mass - 2.0 + 1.0 / mass) / (std::pow(n + 2.0, 2) + mass));
  Eigen::Matrix3d normal = j(cube_of(start.at)).matrix;
  for (int k = 0; k < 3; ++k) normal(k, k) = normal(k, k) * 1.000001 + 1e-6 * start.j;
  const Eigen::Matrix3d to_metric = normal.llt().matrixU();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
  Cube mean = Cube::Zero(), path = Cube::Zero(), path_sigma = Cube::Zero();
  double sigma = 0.0548 * std::sqrt(start.j);
  Value best = start;
  Variates variate;
  struct Child {
    Cube y, z, at;
    double j, cost;
  };
  for (int g = 1; g <= 60 && sigma > 1e-4 * std::sqrt(start.j); ++g) {
    const Eigen::Matrix3d a = covariance.llt().matrixL();
    std::vector<Child> children(24);
    for (Child& child : children) {
      for (double& value : child.z) value = variate();
      child.y = a * child.z;
      const Cube wanted = cube_of(start.at) + to_metric.inverse() * (mean + sigma * child.y);
      child.at = inside(wanted);
      child.j = j(child.at).j;
      child.cost = child.j + (wanted - child.at).cwiseAbs2().dot(normal.diagonal());
      if (child.j < best.j) best = {child.j, point_of(child.at)};
    }
    std::ranges::stable_sort(children, {}, &Child::cost);
    Cube y = Cube::Zero(), z = Cube::Zero();
    Eigen::Matrix3d rank_mu = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < 12; ++i) {
      y += weights[i] * children[i].y;
      z += weights[i] * children[i].z;
      rank_mu += weights[i] * children[i].y * children[i].y.transpose();
    }
    mean += sigma * y;
    path_sigma = (1.0 - c_sigma) * path_sigma + std::sqrt(c_sigma * (2.0 - c_sigma) * mass) * z;
    const double length = path_sigma.norm();
    const bool steady = length / std::sqrt(1.0 - std::pow(1.0 - c_sigma, 2 * g)) < (1.4 + 2.0 / (n + 1.0)) * chi;
    path = (1.0 - c_c) * path + (steady ? std::sqrt(c_c * (2.0 - c_c) * mass) : 0.0) * y;
    covariance = (1.0 - c_1 - c_mu) * covariance + c_1 * path * path.transpose() + c_mu * rank_mu;
    sigma *= std::exp(c_sigma / d_sigma * (length / chi - 1.0));
  }
  return best;
}

// Steps of one candidate; of a plane the third unknown rests.
Value descended(const LaneProblem& problem, const Point& from, int steps, Eigen::Index unknowns) {
  RisingJ j(problem);
  Cube at = cube_of(from);
  Normal here = j(at);
  double damping = 1e-3;
  for (int step = 0; step < steps; ++step) {
    std::vector<Eigen::Index> moving;
    for (Eigen::Index k = 0; k < unknowns; ++k)
      if (here.matrix(k, k) > 0.0 && !(at[k] <= 0.0 && here.right[k] < 0.0) && !(at[k] >= 1.0 && here.right[k] > 0.0))
        moving.push_back(k);
    Eigen::MatrixXd damped = here.matrix(moving, moving);
    damped.diagonal() *= 1.0 + damping;
    Cube to = at;
    if (!moving.empty()) to(moving) += damped.fullPivLu().solve(Eigen::VectorXd(here.right(moving)));
    to = inside(to);
    const Normal there = j(to);
    bool settled = false;
    if (there.j < here.j) {
      settled = here.j - there.j <= 1e-13 * here.j;
      at = to;
      here = there;
      damping = std::max(0.1 * damping, 1e-9);
    } else {
      damping *= 8.0;
      settled = damping > 1e7;
    }
    if (settled) break;
  }
  return {here.j, point_of(at)};
}

// Anywhere in the cube; each third number on one of its faces.
Point start_in_cube(Random& random, int number) {
  Point at{random(0.0, 1.0), random(0.0, 1.0), random(0.0, 1.0)};
  if (number % 2 == 1) at[static_cast<std::size_t>(number / 2 % 3)] = number % 4 == 1 ? 0.0 : 1.0;
  return at;
}

void check_same(const Value& found, const Value& expected, double margin) {
  for (std::size_t k = 0; k < 3; ++k) CHECK(found.at[k] == Approx(expected.at[k]).margin(margin).epsilon(0.0));
  CHECK(found.j == Approx(expected.j).epsilon(1e-9));
}

}  // namespace

TEST_CASE("ELAM: its evolution strategy does what the tutorial's equations do, at the faces of the cube too") {
  Random random(11);
  int better = 0;
  for (int problem = 0; problem < 16; ++problem) {
    CAPTURE(problem);
    const Rises rises(random, problem % 3 == 0 ? 0.3 : 0.05);
    const LaneProblem lanes = lane_problem(rises.model, rises.curves, true);
    AscendingSearch search(lanes, 24);
    Value start;
    start.at = start_in_cube(random, problem);
    search.evaluate(std::span(&start, 1));
    if (problem % 5 != 0) search.descend(std::span(&start, 1), problem % 5, Gradient::kSpace);
    const Value found = search.evolve(start);
    check_same(found, evolved(lanes, start), 1e-6);
    better += found.j < start.j ? 1 : 0;
  }
  CHECK(better >= 12);
}

TEST_CASE("ELAM: its descents do what Levenberg-Marquardt's equations do, step by step") {
  Random random(12);
  for (int problem = 0; problem < 12; ++problem) {
    CAPTURE(problem);
    const Rises rises(random, problem % 3 == 0 ? 0.3 : 0.02);
    const LaneProblem lanes = lane_problem(rises.model, rises.curves, true);
    for (int number = 0; number < 7; ++number)
      for (const int steps : {0, 1, 2, 3, 8, 60}) {
        CAPTURE(number, steps);
        AscendingSearch search(lanes, 1);
        Value plane, space;
        plane.at = space.at = start_in_cube(random, number);
        const Point from = plane.at;
        search.descend(std::span(&plane, 1), steps, Gradient::kPlane);
        check_same(plane, descended(lanes, from, steps, 2), 1e-6);
        CHECK(plane.at[2] == from[2]);
        search.descend(std::span(&space, 1), steps, Gradient::kSpace);
        check_same(space, descended(lanes, from, steps, 3), 1e-6);
      }
  }
}

TEST_CASE("ELAM: candidates beside each other have the J that each has alone, as many as there are lanes") {
  Random random(13);
  const Rises rises(random, 0.1);
  const LaneProblem lanes = lane_problem(rises.model, rises.curves, true);
  RisingJ j(lanes);
  AscendingSearch search(lanes, 9);  // makes 16
  std::vector<Value> values(16);
  for (int round = 0; round < 3; ++round) {
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i].at = {random(0.0, 1.0), random(0.0, 1.0), round == 0 && i % 2 == 0 ? 0.5 : random(0.0, 1.0)};
      if (round == 2) values[i].at[2] = 0.25;
    }
    search.evaluate(values);
    for (const Value& value : values) CHECK(value.j == Approx(j(cube_of(value.at)).j).epsilon(1e-12));
  }
  const std::vector<Value> before = values;
  search.descend(values, 1, Gradient::kSpace);
  for (std::size_t i = 0; i < values.size(); ++i) check_same(values[i], descended(lanes, before[i].at, 1, 3), 1e-9);
  std::vector<Value> many(17);
  CHECK_THROWS_AS(search.evaluate(many), std::invalid_argument);
  CHECK_THROWS_AS(search.descend(many, 1, Gradient::kPlane), std::invalid_argument);
  AscendingSearch eight(lanes, 8);
  CHECK_THROWS_AS(eight.evaluate(std::span(many).first(9)), std::invalid_argument);
  CHECK_NOTHROW(eight.evaluate(std::span(many).first(8)));
}

TEST_CASE("ELAM: searches rest where J depends on nothing, or not on the split of the shortest rises") {
  Random random(14);
  const Rises rises(random, 0.1);
  Value start;
  start.at = {0.2, 0.4, 0.7};
  for (const Gradient gradient : {Gradient::kPlane, Gradient::kSpace}) {
    const LaneProblem none = lane_problem(rises.model, {}, true);
    AscendingSearch search(none, 24);
    Value there = start;
    search.descend(std::span(&there, 1), 3, gradient);
    CHECK(there.at == start.at);
    CHECK(there.j == 0.0);
    CHECK(search.evolve(there).at == start.at);
    // Rises from the lowest input are split at v alone.
    const LaneProblem longest = lane_problem(rises.model, std::span(rises.curves).first(1), true);
    AscendingSearch of_one(longest, 1);
    there = start;
    of_one.descend(std::span(&there, 1), 5, gradient);
    CHECK(there.at[0] == start.at[0]);
    CHECK(there.at[1] != start.at[1]);
    check_same(there, descended(longest, start.at, 5, gradient == Gradient::kPlane ? 2 : 3), 1e-8);
  }
}
