// Compares the values of a figure with its baseline: by an EWMA control chart, by a wide band for gross changes, or
// exactly.
#pragma once

#include <optional>
#include <span>
#include <string_view>

#include "analysis/statistics/control/control_band.h"
#include "analysis/statistics/control/ewma_control_chart.h"

namespace tactbench::analysis {

enum class FigureKind {
  kMean,    // of many samples or taxels: close to normal
  kMaximum  // the largest of many, without sign: skewed, charted by its logarithm
};
// Of the figures of runs, rigs and scenarios, by name (figures.h, rig_figures.h); kMean for any other. Counts (frames,
// taxels that are not fitted) are constants in sound runs; one that varied in the start-up is charted as a mean is.
FigureKind figure_kind(std::string_view name);

struct ControlChart {
  FigureKind kind = FigureKind::kMean;
  bool constant = false;            // all start-up values are equal (1e-9): the band has the width of rounding
  bool logarithmic = false;         // a maximum whose values are all above 0: band and chart are of logarithms
  std::optional<ControlBand> band;  // the wide one, in the figure's unit; none from fewer than three start-up values
  std::optional<EwmaState> ewma;    // after the last later value, of logarithms where so said; none from fewer than
                                    // kMinStartUpRuns start-up values, from equal ones, or without later values
  double probability = 1.0;         // EwmaControlChart::probability()
  double level = 0.0;               // the EWMA in the figure's unit; with `ewma`
  std::optional<double> slope;      // Theil-Sen, of the last fourteen later values, in the figure's unit a run
};

// All values finite, in time order.
ControlChart control_chart(std::string_view name, std::span<const double> start_up, std::span<const double> later);

}  // namespace tactbench::analysis
