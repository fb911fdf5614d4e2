// Residuals of compensated values on paths that were not fitted: inner branches are left out of the fit and compensated
// by the models of the others. Models with lag and creep also get the residual's shape over the pressure. For the
// uncertainty of compensated values.
#pragma once

#include <string>
#include <vector>

#include "analysis/identify/histories.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

// Models like `model`, each fitted without one part of the inner branches (fit_samples.h; the repeats of a branch are
// in one part): of up to 32 of its fitted taxels, evenly chosen. None where what is left carries no model.
struct LeftOut {
  std::vector<std::size_t> places;     // of the chosen taxels in `model`, in the order of theirs in each of models
  std::vector<SensorModel> models;     // one per part
  std::vector<std::vector<int>> part;  // that the sample belongs to, by fitted history; -1: of none
};
LeftOut leave_out(Histories histories, const std::vector<std::string>& sequences, const SensorModel& model,
                  int threads);

// Mean squares of the errors on inner branches.
struct InnerErrors {
  double held = 0.0, fitted = 0.0;  // with the models that did not see them, and with the one in use
};
// A path in use lies between measured ones, nearer to them than a branch that is left out: half of the residual there,
// and no less than the residual of the fitted branches.
double between_branches(const InnerErrors& errors);
// The square of a taxel's residual: halfway between that of the array and one as far above it as its `own` mean square
// on all fitted samples is above the taxels' `mean` one.
double residual2_of_taxel(double array, double own, double mean);
// Where there is no inner branch: the mean square in inputs of anything between the branches of the external loop.
double between_external_branches(const ModelTaxel& taxel);

// Fills in residual_psi of the taxels of a model without dynamics that was fitted on the named sequences (empty: all)
// of `histories`: root mean square where the external loop has its mean slope, by the above, of the samples as
// measured; of a run the last repeat of each sequence. Taxels without such samples keep 0. Threads by taxel; the result
// does not depend on them.
void find_residuals(const Histories& histories, const std::vector<std::string>& sequences, int threads,
                    SensorModel& model);

// Fills in residual_shape and the taxels' residual_psi of `model`, which was fitted to `undone` with `fit`: the outputs
// of `fitted` with lag and creep removed. As of any model, in time: streams of models that did not see a part of the
// inner branches read the whole run, and their errors on that part count. The shape is the root of half 1 and half
// those errors' squares by interval, of both directions apart and smoothed, over their mean: few branches tell an
// interval. It is 1 where no inner branch tells.
void find_dynamic_residuals(const Dataset& fitted, const Dataset& undone, const FitOptions& fit, SensorModel& model);

}  // namespace tactbench::analysis
