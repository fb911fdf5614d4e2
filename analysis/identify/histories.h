// Stored run or table -> what models are fitted on and scored on: per taxel, its histories in the order in which they
// were measured.
#pragma once

#include <string>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/fit_data.h"
#include "analysis/table.h"

namespace tactbench::analysis {

struct TaxelHistories {
  int taxel = 0;               // kMeanTaxel: the mean of those that can be fitted
  std::string status;          // empty: can be fitted; else dead, stuck, saturated, constant, falling
  double noise = 0.0;          // standard deviation of a sample; 0: not known
  std::vector<History> fit;    // one a sequence: a run's repeats brought to common inputs and averaged
  std::vector<History> score;  // one a sequence and repeat, as measured
};
inline constexpr int kMeanTaxel = -1;

struct Histories {
  std::string source;          // "run 3", or the table's name
  std::string origin;          // simulated | hardware | imported
  std::string content_sha256;  // of the run, or of the table's bytes
  std::string sensor_serial, scanner_serial;
  std::string input_unit = "psi", output_unit = "V";
  int rows = 1, columns = 1, scans = 1;  // scans: averaged into a sample
  bool falling = false;                  // the output falls when the input rises: all outputs here are negated [A20]
  std::vector<std::string> sequences;
  std::vector<double> temperatures_c;  // of the surroundings, where a run measured it
  std::vector<TaxelHistories> taxels;  // mean included, at the end, when there are several
};

struct HistoriesOptions {
  CommonOptions common;
  double dead_v = 0.05;       // of a run: a taxel whose output spans less is dead (0 V) or stuck
  double turn_share = 0.001;  // of a table's input span: an input that goes back by more has turned
  double noise = -1.0;        // of a table's outputs; negative: estimated by noise_of
};

// Throws AnalysisError, TB-ANALYSIS-NO-TAXEL when no taxel can be fitted.
Histories histories_of(const Dataset& dataset, const HistoriesOptions& options = {});
// Series of a table or of an imported run. Throws AnalysisError TB-TABLE-SHORT (fewer than 4 samples),
// TB-TABLE-CONSTANT.
Histories histories_of(const std::vector<TableSeries>& series, const std::string& source,
                       const HistoriesOptions& options = {});

// The mean taxel alone; one taxel stays as it is.
Histories mean_taxel_of(Histories histories);

// Standard deviation of the noise on outputs that are smooth but for it: median of their fourth differences, which see
// neither slope nor curvature of the branches, and few turns.
double noise_of(const std::vector<double>& outputs);

// The named sequences of one taxel, their external loop as patterns. Empty `names`: all. Throws AnalysisError
// TB-MODEL-SEQUENCE (says which there are) and TB-ANALYSIS-NO-LOOP.
FitData fit_data_of(const TaxelHistories& taxel, const std::vector<std::string>& names);
std::vector<History> named(const std::vector<History>& histories, const std::vector<std::string>& names);

}  // namespace tactbench::analysis
