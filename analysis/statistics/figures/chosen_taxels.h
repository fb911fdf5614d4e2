// The taxels that a report shows besides the mean: best, median and worst by their compensation error.
#pragma once

#include <string>
#include <vector>

#include "analysis/statistics/figures/evaluation.h"

namespace tactbench::analysis {

struct ChosenTaxels {
  int best = -1, median = -1, worst = -1;  // row x columns + column; -1: no taxel is fitted
};

// By Evaluation::taxel_mean_error_psi; of equal ones the first. The median of an even number is the better of the two.
ChosenTaxels choose_taxels(const Evaluation& evaluation);

struct NamedTaxel {
  int taxel = -1;  // kMeanTaxel, -1: the mean of the fitted taxels
  std::string title;
};
// The mean, then best, median and worst, each taxel once.
std::vector<NamedTaxel> named_taxels(const ChosenTaxels& chosen, int columns);

}  // namespace tactbench::analysis
