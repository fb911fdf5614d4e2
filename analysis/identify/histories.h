// Stored run or table -> what models are fitted on and scored on: per taxel, its histories in the order in which they
// were measured; which taxels can be modelled, and which were, the only place that decides dead, stuck and saturated;
// and whether a sequence's first repeat is like the others.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "analysis/dataset.h"
#include "analysis/identify/fit_models.h"
#include "analysis/loop.h"
#include "analysis/table.h"

namespace tactbench::analysis {

// Of histories kFitted says: can be fitted.
enum class TaxelStatus { kFitted, kDead, kStuck, kSaturated, kUnfit, kConstant };
const char* to_string(TaxelStatus status);  // fitted, dead, stuck, saturated, unfit, constant
// False: `word` is none of these, `status` is as before.
[[nodiscard]] bool status_from(std::string_view word, TaxelStatus& status);

inline constexpr double kDeadV = 0.05;       // an output that spans less is dead (near 0 V) or stuck
inline constexpr double kUnfitShare = 0.10;  // a mean error above this share of the taxel's full scale is unfit

// Of one taxel's outputs as measured, before those of a falling sensor are negated: kSaturated (also one that stands at
// the converter's limit for ever), kDead, kStuck, or kFitted. Dead: lowest and highest output are both nearer to 0 V
// than `dead_v`.
struct OutputRange {
  double low = 0.0, high = 0.0;
};
TaxelStatus status_of(OutputRange outputs, bool at_limit, double dead_v = kDeadV);

// Outputs of the mean of some taxels, moved to the set-points; the first repeat against the mean of the others.
struct RepeatDrift {
  std::string sequence;
  double shift_v = 0.0;        // mean over the steps of first - others
  double uncertainty_v = 0.0;  // standard deviation of such a shift, from the others among themselves
  double rms_v = 0.0;          // root mean square over the steps of first - others
  double others_rms_v = 0.0;   // the largest such value of another repeat against the rest of the others
  bool differs = false;        // |shift| above 3 uncertainties, or rms above twice the others'
};

// One per sequence of three or more repeats at the pace of the first: with two none could say which one drifted. To
// leave the first one out of a fit: RepeatOptions::first_repeat.
std::vector<RepeatDrift> repeat_drifts(const Dataset& dataset, std::span<const std::size_t> taxels,
                                       const RepeatOptions& options);

inline constexpr double kBandInNoises = 6.0;  // dead band of compensation, in standard deviations of a sample

struct TaxelHistories {
  int taxel = 0;                              // kMeanTaxel: the mean of those that can be fitted
  TaxelStatus status = TaxelStatus::kFitted;  // dead, stuck, saturated and constant ones cannot be fitted
  double noise = 0.0;                         // standard deviation of a sample; 0: not known
  double turn = 0.0;         // of a table: an input that goes back by more has turned; 0: inputs are commanded
  std::string wild;          // of a table: the first of the samples to fit that no sensor can have, in words (table.h)
  std::vector<History> fit;  // one per sequence: a run's repeats brought to common inputs and averaged
  std::vector<History> score;  // one per sequence and repeat, as measured
  [[nodiscard]] bool usable() const { return status == TaxelStatus::kFitted; }
};
inline constexpr int kMeanTaxel = -1;

struct Histories {
  std::int64_t run = 0;        // 0: a table
  std::string source;          // "run 3", or the table's name
  std::string origin;          // simulated | hardware | imported
  std::string content_sha256;  // of the run, or of the table's bytes
  std::string sensor_serial, scanner_serial;
  std::string input_unit = "psi", output_unit = "V";
  int rows = 1, columns = 1, scans = 1;  // scans: averaged into a sample
  double min_span = 0.0;                 // a taxel whose loop rises by less does not follow the input
  // The output falls when the input rises: all outputs here are negated [A20]. Decided by the sign of the covariance of
  // input and output over all taxels that can be fitted.
  bool falling = false;
  std::vector<std::string> sequences;
  std::vector<double> temperatures_c;  // of the surroundings, where a run measured it
  std::vector<TaxelHistories> taxels;  // mean included, at the end, when there are several
  std::vector<std::string> assumed;    // of a table: what was taken for granted in reading it, one line each
  std::vector<std::string> warnings;   // of a table: what is doubtful about it, one line each
};

struct HistoriesOptions {
  RepeatOptions common;
  double dead_v = kDeadV;  // of a run: a taxel whose output spans less is dead (0 V) or stuck
  bool all_scores = true;  // of a run; false: only the first taxel that can be fitted has TaxelHistories::score
  int threads = 0;         // of a run; 0: as many as there are cores
  // Of a table:
  std::vector<std::string> fitted;  // sequences that models are fitted on: noise is theirs alone; empty: all
  double turn = -1.0;   // an input that goes back by more has turned; negative: by more than seven times the noise of
                        // the inputs, and 0.1 % of their span
  double noise = -1.0;  // of the outputs; negative: from differences within the branches that are fitted
  bool timed = false;   // histories must have times: TB-MODEL-DYNAMIC
};

// Throws AnalysisError, TB-ANALYSIS-NO-TAXEL when no taxel can be fitted.
Histories histories_of(const Dataset& dataset, const HistoriesOptions& options = {});
// Series of a table or of an imported run (table_histories.cpp). Throws AnalysisError TB-TABLE-SHORT (fewer than 4
// samples), TB-TABLE-CONSTANT.
Histories histories_of(const std::vector<TableSeries>& series, const std::string& source,
                       const HistoriesOptions& options = {});

// Of the inputs or outputs of some histories, none of them empty.
struct Span {
  double low = 0.0, high = 0.0;
  [[nodiscard]] double length() const { return high - low; }
};
Span span_of(const std::vector<History>& histories, std::vector<double> History::*values);

// Puts the sign of the outputs right and adds the mean taxel: the last step of both above.
void finish(Histories& histories);

// The mean taxel alone; one taxel stays as it is. Throws TB-ANALYSIS-NO-TAXEL where several taxels have no mean, since
// their inputs differ.
Histories mean_taxel_of(Histories histories);

// The named sequences of one taxel, their external loop as patterns. Without a full sweep up and one down FitData says
// so, and its patterns are straight lines between the mean outputs at both ends of the inputs. Empty `names`: all.
// Throws AnalysisError TB-MODEL-SEQUENCE (says which there are) and TB-ANALYSIS-FALLING (the loop does not rise).
FitData fit_data_of(const TaxelHistories& taxel, const std::vector<std::string>& names);
// The same of the mean of some taxels, given by their places: their loops' mean. Nothing when they do not share their
// inputs.
std::optional<FitData> mean_fit_data(const Histories& histories, const std::vector<std::size_t>& taxels,
                                     const std::vector<std::string>& names);
std::vector<History> named(const std::vector<History>& histories, const std::vector<std::string>& names);

}  // namespace tactbench::analysis
