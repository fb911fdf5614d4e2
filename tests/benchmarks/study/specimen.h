// Properties of a simulated sensor, each measured on its outputs: the same figures for each specimen. Percent FS are of
// the span between 0 and 60 psi, of the taxel or the mean taxel that the figure is about.
#pragma once

#include <span>
#include <vector>

#include "bench/config/plant_options.h"
#include "tests/benchmarks/study/study_value.h"

namespace tactbench::bench {

// External loop of the mean taxel after three cycles, 2 psi steps, 2 s dwell.
struct LoopFigures {
  double max_percent_fs = 0.0, mean_percent_fs = 0.0, full_scale_v = 0.0;
};
LoopFigures measure_loop(const SpecimenOptions& options);

// Standard deviation from one cycle 0-60-0 psi to the next at the same level and direction, without noise: rms over
// levels and taxels. From differences of successive cycles, so that what drifts or creeps over all of them does not
// count.
struct CycleFigures {
  double taxel_percent_fs = 0.0, mean_taxel_percent_fs = 0.0;
};
CycleFigures measure_cycles(const SpecimenOptions& options, int cycles);

// What the mean taxel keeps of three cycles from new, so long after they have ended.
double measure_remanence_percent_fs(const SpecimenOptions& options, double after_s);

// Change of the mean taxel at `level_psi` between two times after a jump there from rest.
double measure_creep_percent_fs(const SpecimenOptions& options, double level_psi, double from_s, double to_s);

// Standard deviation of an hour's change over taxels and hours: of the zero unloaded, of the gain under 40 psi. The
// gain is that of one run against another of the same sensor, so that creep, which both have, does not count.
struct WalkFigures {
  double zero_mv = 0.0, gain_percent = 0.0;
};
WalkFigures measure_walk(const SpecimenOptions& options, int hours);

// What a neighbour's output rises by when one taxel alone is pressed, as a share of that taxel's rise.
struct CrosstalkFigures {
  double beside = 0.0, corner = 0.0, two_away = 0.0;
};
CrosstalkFigures measure_crosstalk(const SpecimenOptions& options);

// What no Preisach model can follow, at a speed at which nothing creeps, means of eight runs, rms over taxels.
struct MemoryFigures {
  double congruency_percent_fs = 0.0;  // minor loops of equal ends entered from 0 and from 60 psi: difference of their
                                       // heights, each output through the divider that makes it least
  double closure_percent_fs = 0.0;     // up to 30, back to 20 and up again: the output does not come back
};
MemoryFigures measure_memory(const SpecimenOptions& options);
// A taxel's outputs at the two ends of a minor loop that was entered from 0 and from 60 psi.
struct MinorLoop {
  double low_from_below = 0.0, high_from_below = 0.0, low_from_above = 0.0, high_from_above = 0.0;
};
// The first of the two as a share of the taxel's span, rms over the loops; `bottom` and `top`: its outputs at 0 and 60
// psi. Without a divider, or by that of eight, above 1.02 `top`, which makes it least.
double height_difference(std::span<const MinorLoop> loops, double bottom, double top);

// What `components` common shapes (principal components over the taxels) leave of the taxels' external loops, each
// scaled by its own span: rms.
double measure_shape_percent_fs(const SpecimenOptions& options, int components);

// Scans of a held pressure against the plant's true outputs.
struct NoiseFigures {
  double white_mv = 0.0, kurtosis = 0.0;             // of single samples unloaded; normal noise has 3
  double beyond_five = 0.0;                          // share of them beyond five standard deviations
  double slope = 0.0, slow_percent_of_output = 0.0;  // at 40 psi, one scan per second: slope of log power over log
                                                     // frequency below 0.03 Hz; standard deviation of means over 32 s
};
NoiseFigures measure_noise(const PlantOptions& options);

// All of them for each of `kinds`, sensor seed 1.
std::vector<Figure> benchmark_specimen(const std::vector<SpecimenKind>& kinds);

}  // namespace tactbench::bench
