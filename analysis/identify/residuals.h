// What the streams of a sensor's models leave, by level and direction: for the uncertainty of compensated values.
#pragma once

#include <string>
#include <vector>

#include "analysis/identify/histories.h"
#include "analysis/identify/sensor_model.h"

namespace tactbench::analysis {

// Fills in residual_psi of the taxels of a model without dynamics that was fitted on the named sequences (empty: all)
// of `histories`. It is what their streams leave, root mean square, where the external loop has its mean slope. Two
// parts, added as squares. The first is twice what a taxel's stream leaves of the samples as measured, of a run the
// last repeat of each sequence: other paths leave more. The second stands for the model's own error on other paths: a
// Preisach model is fitted to the same data of up to 32 taxels and driven over random reversals, and the stream has to
// give back its inputs; its ratio to the fitted samples' is the array's. A Preisach model has the first part alone.
// Taxels without samples as measured keep 0. Threads by taxel; the result does not depend on them.
void find_residuals(const Histories& histories, const std::vector<std::string>& sequences, int threads,
                    SensorModel& model);

}  // namespace tactbench::analysis
