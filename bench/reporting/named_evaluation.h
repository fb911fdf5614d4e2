// The evaluation of one run with its title.
#pragma once

#include <string>

#include "analysis/statistics/figures/evaluation.h"

namespace tactbench::bench {

struct NamedEvaluation {
  std::string title;
  analysis::Evaluation evaluation;
};

}  // namespace tactbench::bench
