// Fits a model to one taxel: what every fit starts from (the histories of the taxel, or of one imported table, cut into
// branches, and the external loop, which spans the whole range), what it returns, and the choice of the model.
#pragma once

#include <array>
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
  // Of each sample, if the source has them: its time, and how long its input had been commanded.
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
  // The model is one of the output with its readout divider inverted, if the congruency test shows its amplitude
  // (linearise.h).
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

// One row a kind of model, of AllModels (analysis/models/all_models.h).
struct ModelKind {
  const char* name;
  bool of_loop;      // made of the external loop
  double fit_share;  // time of a fit over ELAM's
  std::unique_ptr<Identifier> (*prepare)(const FitData& like, const IdentifyOptions& options);
  KnownModel (*known)();  // null: none is known
};
std::span<const ModelKind> model_kinds();
std::vector<std::string> model_names();

// Identification of the model of this name; deterministic. Throws std::invalid_argument when there is none, or the data
// cannot carry it (the message states what is missing), and AnalysisError TB-ANALYSIS-NO-LOOP.
ModelFit identify(const std::string& name, const FitData& data, const IdentifyOptions& options = {});

// A model of known parameters and its outputs, in V, at kKnownInputs, as another program, in Python, worked them out of
// the equations.
inline constexpr std::array kKnownInputs = {0.0, 30.0, 60.0, 30.0, 10.0, 40.0};  // psi
struct KnownModel {
  std::unique_ptr<HysteresisModel> model;
  std::array<double, kKnownInputs.size()> volts;
};

// Walks `model` along a history. Without free_run each branch starts at its measured ordinate, external ones at the
// patterns' ends (where the model has such a notion).
std::vector<double> predict_history(const HysteresisModel& model, const History& history, bool free_run);

// Identification in two steps: first what depends only on the inputs, then the outputs. The taxels of an array share
// their inputs, so that the first step is made once for all of them.
class Identifier {
 public:
  virtual ~Identifier() = default;
  // From any thread. Throws std::invalid_argument when the inputs or branches are not those it was prepared for, or as
  // identify does.
  [[nodiscard]] virtual ModelFit fit(const FitData& data) const = 0;
};

// Throws as identify does. Only inputs, branches, the patterns' range and `no_loop` of `like` are used.
std::unique_ptr<Identifier> prepare(const std::string& name, const FitData& like, const IdentifyOptions& options = {});

}  // namespace tactbench::analysis
