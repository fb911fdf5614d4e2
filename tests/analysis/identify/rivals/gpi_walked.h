// J of a GPI evaluated sample by sample along the data.
#pragma once

#include <cstddef>
#include <vector>

#include "analysis/identify/fit_models.h"
#include "analysis/models/gpi.h"

namespace synthetic {

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
