#pragma once
// The fast search against an exhaustive one that shares only the samples and the model with it. Parameters that the
// data leave open are not settled here: that trades J within chance (undetermined_parameters.cpp).
#include <catch2/catch.hpp>

#include "analysis/identify/elam/elam.h"
#include "tests/analysis/identify/elam/exhaustive_reference.h"
#include "tests/analysis/support/synthetic.h"

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
  ArrayOptions options;
  options.rows = rows;
  options.columns = 4;
  options.sensor_seed = kind.sensor_seed;
  options.play_share = kind.play_share;
  options.inner_spread = kind.spread;
  const Array array(options);
  RunOptions how;
  how.noise_v = kind.noise_v;
  how.scans = kind.scans;
  how.repeats = kind.repeats;
  Dataset data = run(array, how);
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
