// The slow search that identification is judged by: J of the model itself on a dense grid of the whole box, then a
// compass search with turning directions from the best cells. Shares nothing with the fast search but the samples.
#pragma once

#include <algorithm>
#include <array>
#include <random>
#include <span>
#include <vector>

#include "analysis/identify/elam_samples.h"

namespace synthetic {

using Cube = std::array<double, 3>;  // alpha_d, beta_d, - or phi(0), phi(X), beta_a

inline void put(tactbench::analysis::ElamModel& model, const Cube& p, bool ascending) {
  if (ascending) {
    model.parameters.alpha_a0 = p[0];
    model.parameters.alpha_a1 = (p[1] - p[0]) / (model.xu() - model.x0());
    model.parameters.beta_a = p[2];
  } else {
    model.parameters.alpha_d = p[0];
    model.parameters.beta_d = p[1];
  }
}

// Least J found (without constant); `model` gets its parameters.
inline double dense_reference(tactbench::analysis::ElamModel& model,
                              std::span<const tactbench::analysis::CurveSamples> curves, bool ascending, int grid = 36,
                              int cells = 24) {
  const auto error = [&](const Cube& p) {
    put(model, p, ascending);
    double j = 0.0;
    for (const auto& samples : curves) {
      const tactbench::analysis::ElamCurve curve(model, ascending, samples.x_turn, samples.y_turn);
      for (std::size_t i = 0; i < samples.x.size(); ++i) {
        const double off = curve.output(samples.x[i]) - samples.y[i];
        j += samples.weight[i] * off * off;
      }
    }
    return j;
  };
  std::vector<std::pair<double, Cube>> all;
  const int n = ascending ? grid : 6 * grid;
  for (int a = 0; a <= n; ++a)
    for (int b = 0; b <= n; ++b)
      for (int c = 0; c <= (ascending ? n : 0); ++c) {
        const Cube p{1.0 * a / n, 1.0 * b / n, 1.0 * c / n};
        all.emplace_back(error(p), p);
      }
  std::partial_sort(all.begin(), all.begin() + cells, all.end());
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::pair<double, Cube> best = all.front();
  for (int k = 0; k < cells; ++k) {
    auto [j, p] = all[static_cast<std::size_t>(k)];
    Cube last{0, 0, 0};
    int missed = 0;
    for (double size = 1.0 / n; size > 1e-9;) {
      // Along the last success first, then at random: valleys are narrow, curved and kinked.
      Cube step{normal(random), normal(random), ascending ? normal(random) : 0.0};
      Cube to = p;
      for (std::size_t i = 0; i < 3; ++i)
        to[i] = std::clamp(p[i] + (missed == 0 ? 1.5 * last[i] : size * step[i]), 0.0, 1.0);
      const double there = error(to);
      if (there < j) {
        for (std::size_t i = 0; i < 3; ++i) last[i] = to[i] - p[i];
        j = there;
        p = to;
        missed = 0;
      } else if (++missed > 25) {
        size *= 0.6;
        missed = 1;
      }
    }
    if (j < best.first) best = {j, p};
  }
  put(model, best.second, ascending);
  return best.first;
}

}  // namespace synthetic
