// The congruency test: which divider (analysis/models/divider.h) makes a taxel's minor loops congruent. Data alone
// decide.
#pragma once

#include "analysis/identify/fit_models.h"
#include "analysis/models/divider.h"

namespace tactbench::analysis {

struct Congruency {
  Divider divider;         // per_amplitude 0 if inverting a divider does not help, or the data cannot show it
  int pairs = 0;           // crossings of first-order falls and rises that were compared
  double plain_rms = 0.0;  // misfit of their predictions in outputs, nothing undone
  double rms = 0.0;        // and with `divider`
};

// A falling branch from an inner turn x_t on the rising external branch, and a rising one from an inner turn x_b on the
// falling external branch, give Everett's function of the same (x_t, x_b), if loops are congruent: each predicts the
// other's output where they cross. The least sum of squares over c decides; c = 0 unless that brings the misfit to
// 0.95 of what it was, or where fewer than three crossings are measured. The zero is the loop's lower end.
Congruency find_divider(const FitData& data);
FitData linearised(const FitData& data, const Divider& divider);

}  // namespace tactbench::analysis
