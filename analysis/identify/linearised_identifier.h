// Identification of any model on the linearised output (analysis/models/linearised.h): the divider by the congruency
// test, and whether it stays by cross-validation.
#pragma once

#include <functional>

#include "analysis/identify/fit_models.h"

namespace tactbench::analysis {

using PrepareInner = std::function<std::unique_ptr<Identifier>(const FitData& like)>;

// Fits have a LinearisedModel, with c = 0 (the model of the output as it is) where the congruency test finds no divider
// or, with `cross`, where the mean error on inner branches that were held out (fit_samples.h) is not less with the
// divider than without. Where the other branches do not carry the model, the congruency test alone decides. Throws as
// `inner` does.
std::unique_ptr<Identifier> prepare_linearised(const FitData& like, bool free_run, bool cross,
                                               const PrepareInner& inner);

}  // namespace tactbench::analysis
