// Results of a report beyond its evaluation: models compared, traces of chosen taxels, the previous models, further
// runs. All are computed before rendering, so that rendering stays fast.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/judgement/judgement.h"
#include "analysis/statistics/figures/usable_range.h"
#include "analysis/statistics/scoring/model_comparison.h"
#include "analysis/statistics/studies/contact_results.h"
#include "analysis/statistics/studies/studies.h"
#include "db/record.h"

namespace tactbench::analysis {

// One taxel along one sequence, means of the repeats (Figs 13, 14): the direct model is driven by the measured
// pressures, the inverse by the measured outputs.
struct TaxelTrace {
  NamedTaxel taxel;
  std::string sequence;
  std::vector<double> pressure_psi, measured_v, model_v, estimate_psi;
};

// |pressure - reference| in psi of every frame and fitted taxel read by one straight line through the ends of the mean
// taxel's external loop: what is read without any model of a taxel.
struct StraightLine {
  double mean_error_psi = 0.0, max_error_psi = 0.0, worst_taxel_mean_error_psi = 0.0;
};

// This run evaluated with models made before it (as found).
struct AsFound {
  std::string model;  // as named on the command line
  Evaluation evaluation;
  int fitted_taxels = 0;
  Judgement judgement;  // by the limits of the report
  // When they fail: since when earlier measurements are in doubt, a sentence. Without numbers of runs.
  std::string doubt;
};

struct ReportResults {
  ModelComparison models;
  std::vector<TaxelTrace> traces;  // by taxel, then sequence
  StraightLine straight;
  UsableRange usable;
  std::optional<AsFound> previous;
  Studies studies;
  std::vector<ContactResult> contacts;
};

// models, traces, straight and usable of the fit's own run; `previous` when given. GPI, MPI and POLY are fitted here,
// for four taxels: the part that takes time. Throws AnalysisError as evaluate().
ReportResults results_of(const Dataset& dataset, const SensorModel& fit, const Evaluation& evaluation,
                         const SensorModel* previous, const std::string& previous_name, int threads = 0);

// Omits names of runs, for the content hash.
void forget_run_numbers(ReportResults& results);

}  // namespace tactbench::analysis
