// Four hysteresis models side by side on a few taxels of a run, sequence by sequence (Figs 9-12, Tables 2-5 of the
// paper): ELAM as stored, GPI, MPI and POLY identified here.
#pragma once

#include <string>
#include <vector>

#include "analysis/identify/sensor_model.h"
#include "analysis/models/model.h"
#include "analysis/statistics/figures/chosen_taxels.h"

namespace tactbench::analysis {

struct ComparedModel {
  std::string model;            // elam, gpi, mpi, poly
  std::string failed;           // why it could not be fitted; the rest is then empty
  std::vector<double> model_v;  // steps; driven by the set-points, each branch from its measured ordinate [A9]
  // Over all samples but the first of each branch: Eq. (1), Eq. (49).
  double j_v2 = 0.0, mean_error_v = 0.0, max_error_v = 0.0;
  double mean_running_v = 0.0, max_running_v = 0.0;  // the same of the model free running, without measured ordinates
  int samples = 0;
  int operations_per_sample = 0;
  bool joint =
      false;  // one set of parameters for several sequences: on one of them it cannot be as close as one of its own
  std::vector<ModelParameter> parameters;
};

struct ComparedSequence {
  std::string name;
  std::vector<double> pressure_psi, measured_v;  // set-points, mean of the repeats moved there
  std::vector<ComparedModel> models;             // in the order of kComparedModels
};
inline constexpr const char* kComparedModels[] = {"gpi", "mpi", "poly", "elam"};

struct ComparedTaxel {
  NamedTaxel taxel;
  double full_scale_v = 0.0;  // ModelTaxel::full_scale() of its model
  std::vector<ComparedSequence> sequences;
};

struct ModelComparison {
  std::vector<ComparedTaxel> taxels;
};

// As in the paper GPI, MPI and POLY get parameters of their own for each sequence, ELAM has one set for all: those of
// `fit`, which must be of this dataset. Threads by taxel and sequence; the result does not depend on their number.
// Throws as evaluate().
ModelComparison compare_models(const Dataset& dataset, const SensorModel& fit, const ChosenTaxels& chosen,
                               int threads = 0);

}  // namespace tactbench::analysis
