// Input of every identification: histories of one taxel (or one table), their branches and external loop.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "analysis/loop.h"
#include "analysis/models/model.h"
#include "analysis/models/pattern_curve.h"

namespace tactbench::analysis {

// Inputs and outputs in measured order.
struct History {
  std::string name;
  std::vector<double> x, y;
  std::vector<Branch> branches;  // indices into x and y; the turning sample ends one branch and starts the next
  // Of each sample, where the source tells: its time, and how long its input had been commanded.
  std::vector<double> time_s = {}, held_s = {};
};

// The recording begins on a falling branch: it is assumed to have come from the highest input. Any other is assumed to
// have come from the lowest input by one rise.
[[nodiscard]] bool begins_falling(const History& history);

struct FitData {
  std::vector<History> histories;
  PatternCurve ascending, descending;  // mean full sweeps, ends common to both [A11]
  std::string no_loop = {};            // what is missing of the external loop; the patterns then give its expected ends
};

struct IdentifyOptions {
  bool free_run = false;     // branches start at the model's own ordinate instead of the measured one [A9]
  bool exact_outer = false;  // ELAM: external branches follow the pattern [A6]
  bool genetic = false;      // ELAM: the paper's genetic algorithm instead of the exact way (genetic.h)
  bool memory = false;       // ELAM: return-point memory, inner loops close; ours, not the paper's [A10]
  int splits = 1;   // ELAM: split points a branch, up to 8; more than 1 is ElamPieces, named in the paper's conclusion
  int starts = 16;  // GPI: of the search
  int cells = 30;   // Preisach: intervals of the input range
  bool by_input = false;  // Preisach: errors count as inputs, by the local slope, not as outputs
  // The model is one of the output with its readout divider inverted, where the congruency test tells its amplitude
  // (linearised_identifier.h).
  bool linearise = false;
};

// Errors over all samples but the first of each branch, its turning point.
struct ModelFit {
  std::shared_ptr<const HysteresisModel> model;
  double j = 0.0;           // Eq. (1)
  double mean_error = 0.0;  // Eq. (49)
  double max_error = 0.0;
  double full_scale = 0.0;  // what the external loop spans; the paper's sensors start near 0
  int samples = 0;
  int starts = 1;         // searches that were made
  unsigned at_bound = 0;  // ELAM: bit i: parameter i at a bound, as ElamFit::at_bound
  // Names of parameters that the data leave open: any value would fit as well. Those of ELAM are then taken near the
  // pattern, Preisach's weights small and even.
  std::vector<std::string> undetermined = {};
};

// One a model, in the model's own file; deterministic. Throw std::invalid_argument when the data cannot carry the model
// (the message states what is missing).
ModelFit identify_elam(const FitData& data, const IdentifyOptions& options);
ModelFit identify_gpi(const FitData& data, const IdentifyOptions& options);
ModelFit identify_mpi(const FitData& data, const IdentifyOptions& options);
ModelFit identify_poly(const FitData& data, const IdentifyOptions& options);
ModelFit identify_preisach(const FitData& data, const IdentifyOptions& options);
ModelFit identify_monotone(const FitData& data, const IdentifyOptions& options);

// By name: elam, gpi, mpi, poly, preisach, monotone. Throws AnalysisError TB-ANALYSIS-NO-LOOP, too: elam and poly are
// made of the external loop.
std::span<const char* const> model_names();
ModelFit identify(const std::string& name, const FitData& data, const IdentifyOptions& options = {});

// Walks `model` along a history. Without free_run each branch starts at its measured ordinate, external ones at the
// patterns' ends (where the model has such a notion).
std::vector<double> predict_history(const HysteresisModel& model, const History& history, bool free_run);

// Identification in two steps: first what depends only on the inputs, then the outputs. The taxels of an array share
// their inputs, so that the first step is made once for all of them.

class Identifier {
 public:
  virtual ~Identifier() = default;
  // From any thread. Throws std::invalid_argument when the inputs or branches are not those it was prepared for, or as
  // identify_* does.
  [[nodiscard]] virtual ModelFit fit(const FitData& data) const = 0;
};

// Throw as identify_* does. Only inputs, branches and the patterns' range of `like` are used.
std::unique_ptr<Identifier> prepare_gpi(const FitData& like, const IdentifyOptions& options);
std::unique_ptr<Identifier> prepare_mpi(const FitData& like, const IdentifyOptions& options);
std::unique_ptr<Identifier> prepare_poly(const FitData& like, const IdentifyOptions& options);
std::unique_ptr<Identifier> prepare_preisach(const FitData& like, const IdentifyOptions& options);
std::unique_ptr<Identifier> prepare_monotone(const FitData& like, const IdentifyOptions& options);

// By name, as identify(): from the `no_loop` of `like`, too.
std::unique_ptr<Identifier> prepare(const std::string& name, const FitData& like, const IdentifyOptions& options = {});

}  // namespace tactbench::analysis
