// Reference for GPI: an exhaustive search that shares only the data with the product's: the equations implemented
// again, Levenberg-Marquardt with difference quotients from random starts, and a strategy that adapts to the valley's
// shape.
#pragma once

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

#include "analysis/identify/fit_models.h"
#include "analysis/models/gpi.h"

namespace synthetic {

class GpiReference {
 public:
  // ln a, l0, ln dl, ln b, r0, ln dr, ln alpha, s.
  using Point = Eigen::Matrix<double, 8, 1>;

  explicit GpiReference(const tactbench::analysis::FitData& data) {
    const double x_low = data.ascending.x().front(), x_span = data.ascending.x().back() - x_low;
    const double y_low = data.ascending.y().front();
    y_span_ = data.ascending.y().back() - y_low;
    for (const auto& history : data.histories)
      for (std::size_t i = 0; i < history.x.size(); ++i) {
        begins_.push_back(i == 0);
        u_.push_back((history.x[i] - x_low) / x_span);
        y_.push_back((history.y[i] - y_low) / y_span_);
      }
  }

  // The least J found, in the outputs' unit squared.
  [[nodiscard]] double least(int starts, unsigned seed) const {
    std::mt19937 random(seed);
    std::vector<std::pair<double, Point>> found;
    for (int n = 0; n < starts; ++n) {
      Point p;
      for (int k = 0; k < 8; ++k) p[k] = std::uniform_real_distribution<double>(kLow[k], kHigh[k])(random);
      found.push_back(descend(p, 15));
    }
    const auto sort = [&] { std::ranges::sort(found, {}, [](const auto& one) { return one.first; }); };
    sort();
    for (std::size_t k = 0; k < std::min<std::size_t>(60, found.size()); ++k) found[k] = descend(found[k].second, 60);
    sort();
    double best = found.front().first;
    for (std::size_t k = 0; k < std::min<std::size_t>(8, found.size()); ++k) {
      const auto polished = descend(polish(found[k].second, random).second, 40);
      best = std::min(best, polish(polished.second, random).first);
    }
    return best * y_span_ * y_span_;
  }

 private:
  static constexpr std::array<double, 8> kLow{-3.5, -1.0, -3.0, -3.5, -3.0, -3.0, -6.0, -1.5};
  static constexpr std::array<double, 8> kHigh{3.0, 1.0, 1.5, 3.0, 1.0, 1.5, 1.0, 4.0};

  static Point bounded(Point p) {
    for (const int k : {0, 3}) p[k] = std::clamp(p[k], std::log(1e-3), std::log(60.0));  // as the identification's
    for (const int k : {2, 5, 6}) p[k] = std::clamp(p[k], -20.0, 10.0);
    p[7] = std::clamp(p[7], -8.0, 20.0);
    return p;
  }

  void residuals(const Point& p, Eigen::VectorXd& off) const {
    off.resize(static_cast<Eigen::Index>(u_.size()));
    const double a = std::exp(p[0]), b = std::exp(p[3]), alpha = std::exp(p[6]);
    const double per_a = std::exp(p[2]) / (1.0 - std::exp(-a)), per_b = std::exp(p[5]) / (1.0 - std::exp(-b));
    std::array<double, 5> state{}, weight{};
    for (std::size_t i = 0; i < 5; ++i) weight[i] = std::exp(-p[7] * static_cast<double>(i));
    const auto go = [&](double u) {
      const double left = p[1] + per_a * (1.0 - std::exp(-a * u)), right = p[4] + per_b * (1.0 - std::exp(-b * u));
      for (std::size_t i = 0; i < 5; ++i) {
        const double r = alpha * static_cast<double>(i);
        state[i] = std::max(left - r, std::min(right + r, state[i]));
      }
    };
    for (std::size_t k = 0; k < u_.size(); ++k) {
      if (begins_[k]) {
        state = {};
        go(0.0);
      }
      go(u_[k]);
      double y = 0.0;
      for (std::size_t i = 0; i < 5; ++i) y += weight[i] * state[i];
      off[static_cast<Eigen::Index>(k)] = begins_[k] ? 0.0 : y - y_[k];  // a first sample is not scored
    }
  }

  [[nodiscard]] std::pair<double, Point> descend(Point p, int steps) const {
    Eigen::VectorXd off, there;
    residuals(p = bounded(p), off);
    double j = off.squaredNorm(), damping = 1e-2;
    for (int step = 0; step < steps; ++step) {
      Eigen::MatrixXd slope(off.size(), 8);
      for (int k = 0; k < 8; ++k) {
        Point to = p;
        to[k] += 1e-7;
        residuals(to, there);
        slope.col(k) = (there - off) / 1e-7;
      }
      const Eigen::Matrix<double, 8, 8> normal = slope.transpose() * slope;
      const Point along = slope.transpose() * off;
      const double before = j;
      for (int tries = 0; tries < 12; ++tries, damping *= 4.0) {
        Eigen::Matrix<double, 8, 8> damped = normal;
        damped.diagonal() += damping * (normal.diagonal().array() + 1e-9).matrix();
        const Point to = bounded(p - damped.ldlt().solve(along));
        residuals(to, there);
        const double now = there.squaredNorm();
        if (!(now < j)) continue;
        p = to;
        j = now;
        off = there;
        damping = std::max(damping / 5.0, 1e-12);
        break;
      }
      if (before - j <= 1e-12 * before) break;
    }
    return {j, p};
  }

  // A (1+1) strategy with a learnt covariance (Igel, Suttorp and Hansen, 2006).
  [[nodiscard]] std::pair<double, Point> polish(Point p, std::mt19937& random) const {
    std::normal_distribution<double> normal;
    Eigen::VectorXd off;
    Eigen::Matrix<double, 8, 8> shape = Eigen::Matrix<double, 8, 8>::Identity();
    residuals(p, off);
    double j = off.squaredNorm(), success = 0.2, size = 1e-3;
    for (int k = 0; k < 6000 && size > 1e-11; ++k) {
      Point z;
      for (double& value : z) value = normal(random);
      const Point move = shape * z, to = bounded(p + size * move);
      residuals(to, off);
      const double there = off.squaredNorm();
      const bool better = there <= j;
      success = 0.917 * success + (better ? 0.083 : 0.0);
      size *= std::exp((success - 0.18) / 5.0);
      if (!better) continue;
      p = to;
      j = there;
      if (success > 0.44) continue;
      const double forget = 2.0 / 66.0, zz = z.squaredNorm();
      shape = std::sqrt(1.0 - forget) * shape + std::sqrt(1.0 - forget) / zz *
                                                    (std::sqrt(1.0 + forget * zz / (1.0 - forget)) - 1.0) * move *
                                                    z.transpose();
    }
    return {j, p};
  }

  double y_span_ = 1.0;
  std::vector<double> u_, y_;
  std::vector<bool> begins_;
};

// J of a GPI evaluated sample by sample along the data.

inline double walked_j(const tactbench::analysis::GpiParameters& parameters, const tactbench::analysis::FitData& data) {
  using namespace tactbench::analysis;
  const GpiModel model(parameters, data.ascending.x().front(), data.ascending.x().back(), data.ascending.y().front());
  double j = 0.0;
  for (const History& history : data.histories) {
    const std::vector<double> y = predict_history(model, history, true);
    for (const Branch& branch : history.branches)
      for (auto i = static_cast<std::size_t>(branch.first) + 1; i <= static_cast<std::size_t>(branch.last); ++i)
        j += (y[i] - history.y[i]) * (y[i] - history.y[i]);
  }
  return j;
}

}  // namespace synthetic
