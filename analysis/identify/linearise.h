// Identification of any model on the linearised output (analysis/models/linearised.h): the divider
// (analysis/models/linearised.h) by the congruency test, data alone, and whether it stays by cross-validation.
#pragma once

#include <functional>

#include "analysis/identify/fit_models.h"
#include "analysis/models/linearised.h"

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

using PrepareInner = std::function<std::unique_ptr<Identifier>(const FitData& like)>;

// Fits have a LinearisedModel, with c = 0 (the model of the output as it is) where the congruency test finds no divider
// or, with `cross`, where the mean error on inner branches that were held out (fit_samples.h) is not less with the
// divider than without. Where the other branches do not carry the model, the congruency test alone decides. Throws as
// `inner` does.
std::unique_ptr<Identifier> prepare_linearised(const FitData& like, bool free_run, bool cross,
                                               const PrepareInner& inner);

}  // namespace tactbench::analysis
