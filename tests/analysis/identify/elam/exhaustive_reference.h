// Exhaustive search that the product's identification is compared with. It shares the samples and ElamCurve with the
// fast search and nothing else. Descending: a fine grid of alpha_d, beta_d being closed-form. Ascending: a branch's
// share of J depends on its own split phi(L) and beta_a alone, so that for each beta_a of a fine grid the shares are
// tabulated over phi and the whole plane of (phi(0), phi(X)) is read from the tables. The best cells are then polished.
#pragma once

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <span>
#include <vector>

#include "analysis/identify/elam/elam.h"
#include "tests/analysis/support/synthetic.h"

namespace synthetic {

using tactbench::analysis::CurveSamples;
using tactbench::analysis::ElamCurve;
using tactbench::analysis::ElamModel;

inline double curve_error(const ElamModel& model, const CurveSamples& samples, bool ascending) {
  const ElamCurve curve(model, ascending, samples.x_turn, samples.y_turn);
  double j = 0.0;
  for (std::size_t i = 0; i < samples.x.size(); ++i) {
    const double off = curve.output(samples.x[i]) - samples.y[i];
    j += samples.weight[i] * off * off;
  }
  return j;
}

// J at the best beta_d for alpha_d.
inline double descending_error(ElamModel& model, std::span<const CurveSamples> curves, double alpha) {
  model.parameters.alpha_d = alpha;
  double rg = 0.0, gg = 0.0;
  for (const CurveSamples& samples : curves) {
    model.parameters.beta_d = 0.0;
    const ElamCurve at_0(model, false, samples.x_turn, samples.y_turn);
    model.parameters.beta_d = 1.0;
    const ElamCurve at_1(model, false, samples.x_turn, samples.y_turn);
    for (std::size_t i = 0; i < samples.x.size(); ++i) {
      const double slope = at_1.output(samples.x[i]) - at_0.output(samples.x[i]);
      const double off = samples.y[i] - at_1.output(samples.x[i]), w = samples.weight[i];
      rg += w * off * slope;
      gg += w * slope * slope;
    }
  }
  const double step = gg > 0.0 ? std::clamp(rg / gg, -1.0, 0.0) : 0.0;  // of beta_d, from 1
  model.parameters.beta_d = 1.0 + step;
  double j = 0.0;
  for (const CurveSamples& samples : curves) j += curve_error(model, samples, false);
  return j;
}

inline double exhaustive_descending(ElamModel model, std::span<const CurveSamples> curves, int grid = 3000) {
  const auto n = static_cast<std::size_t>(grid);
  std::vector<double> line(n + 1);
  for (std::size_t i = 0; i <= n; ++i) line[i] = descending_error(model, curves, static_cast<double>(i) / grid);
  std::vector<std::pair<double, std::size_t>> minima;
  for (std::size_t i = 0; i <= n; ++i)
    if ((i == 0 || line[i] <= line[i - 1]) && (i == n || line[i] <= line[i + 1])) minima.emplace_back(line[i], i);
  std::ranges::sort(minima);
  double best = minima.front().first;
  for (std::size_t k = 0; k < std::min<std::size_t>(minima.size(), 12); ++k) {
    double low = std::max(0.0, (static_cast<double>(minima[k].second) - 1.0) / grid);
    double high = std::min(1.0, (static_cast<double>(minima[k].second) + 1.0) / grid);
    for (int step = 0; step < 50; ++step) {
      const double a = high - 0.618 * (high - low), b = low + 0.618 * (high - low);
      const double ja = descending_error(model, curves, a), jb = descending_error(model, curves, b);
      best = std::min({best, ja, jb});
      (ja < jb ? high : low) = ja < jb ? b : a;
    }
  }
  return best;
}

using Cube = std::array<double, 3>;  // phi(0), phi(X), beta_a

inline double ascending_error(ElamModel& model, std::span<const CurveSamples> curves, const Cube& p) {
  model.parameters.alpha_a0 = p[0];
  model.parameters.alpha_a1 = (p[1] - p[0]) / (model.xu() - model.x0());
  model.parameters.beta_a = p[2];
  double j = 0.0;
  for (const CurveSamples& samples : curves) j += curve_error(model, samples, true);
  return j;
}

// A (1+1) evolution strategy that learns the valley's shape, clamped to the cube.
inline double polish(ElamModel& model, std::span<const CurveSamples> curves, Cube p, double size, int steps) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::array<Cube, 3> shape{Cube{1, 0, 0}, Cube{0, 1, 0}, Cube{0, 0, 1}};
  double j = ascending_error(model, curves, p), success = 0.2;
  for (int k = 0; k < steps && size > 1e-12; ++k) {
    Cube z{normal(random), normal(random), normal(random)}, move{}, to{};
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) move[a] += shape[a][b] * z[b];
      to[a] = std::clamp(p[a] + size * move[a], 0.0, 1.0);
    }
    const double there = ascending_error(model, curves, to);
    const bool better = there <= j;
    success = 0.92 * success + (better ? 0.08 : 0.0);
    size *= std::exp((success - 0.18) / 2.5);
    if (!better) continue;
    p = to;
    j = there;
    if (success > 0.44) continue;
    const double zz = z[0] * z[0] + z[1] * z[1] + z[2] * z[2], forget = 0.12;
    const double grow = std::sqrt(1 - forget) / zz * (std::sqrt(1 + forget * zz / (1 - forget)) - 1);
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t b = 0; b < 3; ++b) shape[a][b] = std::sqrt(1 - forget) * shape[a][b] + grow * move[a] * z[b];
  }
  return j;
}

inline double exhaustive_ascending(ElamModel model, std::span<const CurveSamples> curves, int grid = 160,
                                   std::size_t cells = 30) {
  const auto n = static_cast<std::size_t>(grid);
  const double full = model.xu() - model.x0();
  std::vector<std::pair<double, Cube>> found;
  std::vector<std::vector<double>> table(curves.size(), std::vector<double>(n + 2));
  std::vector<double> share(curves.size());
  std::vector<double> plane((n + 1) * (n + 1));
  for (std::size_t b = 0; b <= n; ++b) {
    model.parameters.beta_a = static_cast<double>(b) / grid;
    model.parameters.alpha_a1 = 0.0;
    for (std::size_t c = 0; c < curves.size(); ++c) {
      share[c] = (model.xu() - curves[c].x_turn) / full;
      for (std::size_t i = 0; i <= n; ++i) {
        model.parameters.alpha_a0 = static_cast<double>(i) / grid;
        table[c][i] = curve_error(model, curves[c], true);
      }
      table[c][n + 1] = table[c][n];
    }
    for (std::size_t u = 0; u <= n; ++u)
      for (std::size_t v = 0; v <= n; ++v) {
        double j = 0.0;
        for (std::size_t c = 0; c < curves.size(); ++c) {
          const double at = static_cast<double>(u) * (1.0 - share[c]) + static_cast<double>(v) * share[c];
          const auto i = std::min(static_cast<std::size_t>(at), n);
          j += table[c][i] + (at - static_cast<double>(i)) * (table[c][i + 1] - table[c][i]);
        }
        plane[u * (n + 1) + v] = j;
      }
    const auto at = [&](std::size_t u, std::size_t v) { return plane[u * (n + 1) + v]; };
    for (std::size_t u = 0; u <= n; ++u)
      for (std::size_t v = 0; v <= n; ++v)
        if ((u == 0 || at(u, v) <= at(u - 1, v)) && (u == n || at(u, v) <= at(u + 1, v)) &&
            (v == 0 || at(u, v) <= at(u, v - 1)) && (v == n || at(u, v) <= at(u, v + 1)))
          found.emplace_back(at(u, v), Cube{static_cast<double>(u) / grid, static_cast<double>(v) / grid,
                                            static_cast<double>(b) / grid});
  }
  std::ranges::sort(found);
  found.resize(std::min(found.size(), cells));
  for (auto& [j, p] : found) j = polish(model, curves, p, 0.5 / grid, 250);
  double best = 1e300;
  for (const auto& [j, p] : found) best = std::min({best, j, polish(model, curves, p, 0.25 / grid, 1200)});
  return best;
}

}  // namespace synthetic

// The fast search against an exhaustive one that shares only the samples and the model with it. Parameters that the
// data leave open are not settled here: that trades J within chance (searches.cpp).
namespace exhaustive_comparison {

using namespace synthetic;

struct Kind {
  const char* name;
  unsigned sensor_seed;
  double noise_v, play_share, spread, clip;  // clip: share of the highest output at which it is cut off; 0: not
  int scans, repeats;
};

inline constexpr Kind kKinds[] = {
    {"quiet", 77, 0.0015, 0.015, 1, 0, 2, 5},           {"12 mV", 177, 0.012, 0.015, 1, 0, 2, 5},
    {"30 mV, one repeat", 7, 0.030, 0.02, 1, 0, 1, 1},  {"spread splits", 8, 0.004, 0.03, 3, 0, 2, 5},
    {"clipped", 10, 0.0015, 0.015, 1, 0.9, 2, 5},       {"clipped, 12 mV", 11, 0.012, 0.015, 2, 0.85, 2, 2},
    {"clipped, spread", 112, 0.004, 0.03, 2, 0.7, 2, 5}};

inline std::vector<double> taxel_of(const std::vector<double>& values, std::size_t width, std::size_t taxel) {
  std::vector<double> own;
  for (std::size_t i = taxel; i < values.size(); i += width) own.push_back(values[i]);
  return own;
}

// Fits every taxel of such an array both ways.
inline void compare(const Kind& kind, int rows) {
  const Array array({.rows = rows,
                     .columns = 4,
                     .sensor_seed = kind.sensor_seed,
                     .play_share = kind.play_share,
                     .inner_spread = kind.spread});
  Dataset data = run(array, {.noise_v = kind.noise_v, .scans = kind.scans, .repeats = kind.repeats});
  const auto width = array.taxels.size();
  for (SequenceData& sequence : data.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (std::size_t i = 0; i < repeat.volts.size(); ++i)
        if (kind.clip > 0.0)
          repeat.volts[i] = std::min(
              repeat.volts[i], (kind.clip + 0.02 * static_cast<double>(i % width % 5)) * array.taxels[i % width].yu());
  std::vector<TaxelTable> sequences;
  for (const SequenceData& sequence : data.sequences) sequences.push_back(average_repeats(sequence, data.taxels()));
  const ExternalLoop loop = external_loop(sequences, data.taxels());
  for (std::size_t taxel = 0; taxel < width; ++taxel) {
    const std::vector<double> up = taxel_of(loop.ascending, width, taxel);
    const std::vector<double> down = taxel_of(loop.descending, width, taxel);
    const double y0 = 0.5 * (up.front() + down.front()), yu = 0.5 * (up.back() + down.back());
    std::vector<TaxelBranch> branches;
    for (const TaxelTable& sequence : sequences) {
      const std::vector<double> volts = taxel_of(sequence.values, width, taxel);
      for (const Branch& branch : sequence.branches)
        branches.push_back(
            {branch.ascending,
             {sequence.pressure_psi.begin() + branch.first, sequence.pressure_psi.begin() + branch.last + 1},
             {volts.begin() + branch.first, volts.begin() + branch.last + 1}});
    }
    const ElamFit fit = identify_elam(PatternCurve(loop.pressure_psi, up, y0, yu),
                                      PatternCurve(loop.pressure_psi, down, y0, yu), branches, {}, false);
    const ElamSamples samples = collect_samples(fit.model, branches);
    const double reference = exhaustive_descending(fit.model, samples.descending) +
                             exhaustive_ascending(fit.model, samples.ascending) + samples.ascending_constant +
                             samples.descending_constant;
    INFO(kind.name << ", taxel " << taxel << ": J " << fit.j_v2 << ", exhaustive " << reference);
    CHECK(fit.j_v2 <= reference * (1.0 + 1e-6));
  }
}

}  // namespace exhaustive_comparison
