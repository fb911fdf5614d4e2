// The model of a sensor: the result of any identification on a run or table, for each taxel and their mean, with
// everything that prediction, compensation, judgement and reports need of it; independent of the kind of model.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/compensate/compensator.h"
#include "analysis/dataset.h"
#include "analysis/identify/fit_models.h"
#include "analysis/identify/histories.h"
#include "analysis/models/dynamics.h"
#include "analysis/models/elam.h"
#include "analysis/pressure_unit.h"

namespace tactbench::analysis {

class LinearisedModel;

// Where the model was fitted, so that use elsewhere can be flagged. Absent: not known.
struct Range {
  double low = 0.0, high = 0.0;
  [[nodiscard]] bool contains(double value, double slack = 0.0) const;
  void widen(double value);
};
// How far beyond a range an input is still inside it, of its length: what a rig does not repeat any better.
inline constexpr double kInputSlack = 0.02;
inline constexpr double kTemperatureSlack = 1.0;  // degC
struct Validity {
  std::optional<Range> input, hold_s, rate, temperature_c;  // rate: input units a second
  std::string mount, interface_material;
};

Validity validity_of(const std::vector<History>& histories, const std::vector<double>& temperatures_c);

// What a film does in time: the taxels' models are then those of its outputs with creep removed at the pressures that
// have arrived (dynamic/dynamic_fit.h), and a stream is given the time.
struct SensorDynamics {
  Dynamics shared;
  // What the stream leaves over what it leaves on the whole (ModelTaxel::residual_psi): by interval of the models,
  // rising, then falling.
  std::vector<double> residual_shape;
  struct Source {
    std::int64_t run = 0;
    std::string content_sha256;
  };
  Source rate, creep;  // further runs that lag and creep were taken from; 0: none
};

struct ModelTaxel {
  int taxel = 0;
  TaxelStatus status = TaxelStatus::kUnfit;
  std::string reason;     // of kUnfit: what kept the model from being fitted, where there is more to say
  double noise = 0.0;     // standard deviation of a sample; 0: not known
  double loop_low = 0.0;  // output at the lowest input of the external loop; fit.full_scale above is its highest
  double zero = 0.0, gain = 1.0;  // output = zero + gain x the model's: adjustments since the fit
  ModelFit fit;                   // figures, and the model; without one where none could be fitted
  // Of a model with SensorDynamics: its creep over the array's, its share that comes late, what its stream leaves, psi.
  double creep_scale = 1.0, lag_share = 0.0, residual_psi = 0.0;
  // The external loop on SensorModel::pressure_psi, adjustments included; empty without a model.
  PatternCurve ascending, descending;

  [[nodiscard]] bool fitted() const { return status == TaxelStatus::kFitted; }
  [[nodiscard]] std::string why() const;  // what kept a model from being fitted
  // Of the external loop. Only with a model.
  [[nodiscard]] double x0() const { return ascending.x().front(); }
  [[nodiscard]] double xu() const { return ascending.x().back(); }
  [[nodiscard]] double y0() const { return ascending.y().front(); }
  [[nodiscard]] double yu() const { return ascending.y().back(); }
  // Largest output of the external loop, without sign; 0 without a model.
  [[nodiscard]] double full_scale() const;
  [[nodiscard]] double to_model(double output) const { return (output - zero) / gain; }
  [[nodiscard]] double from_model(double output) const { return zero + gain * output; }
  // As predict_history(), in outputs as measured (those of a falling sensor negated).
  [[nodiscard]] std::vector<double> predicted(const History& history, bool free_run) const;
};

struct SensorModel {
  std::string model;  // of model_names(), or dynamic: preisach, with dynamics
  IdentifyOptions options;
  std::int64_t run = 0;  // that it was fitted on; 0: a table, or not known
  std::int64_t fit = 0;  // its number in the store; 0: not stored
  std::string source, origin, content_sha256;
  std::vector<std::string> sequences;  // that were fitted
  bool all_sequences = true;           // those are all that the source has; not known of a document
  std::string sensor_serial, scanner_serial, input_unit, output_unit, program_version;
  int rows = 0, columns = 0, scans = 1;  // scans: averaged into a sample, of which the noise is
  // The sensor's output falls when the pressure rises: all models are those of the negated output [A20].
  bool falling = false;
  Validity validity;
  std::string parent_sha256, adjustment;  // of a child: its parent's document, and what was adjusted by what
  std::vector<double> pressure_psi;       // inputs of the external loop, ascending
  std::vector<ModelTaxel> taxels;         // rows x columns, then their mean; of a table those that it has
  std::vector<RepeatDrift> repeats;       // of the mean of the fitted taxels of a run; not stored
  std::optional<SensorDynamics> dynamics;

  [[nodiscard]] const ModelTaxel& taxel(int number) const;  // AnalysisError TB-MODEL-TAXEL
  [[nodiscard]] std::span<const ModelTaxel> array() const;  // without the mean
  [[nodiscard]] std::vector<std::size_t> fitted() const;    // of array(), by place
  // The mean of the fitted taxels, or the only taxel. Not of a model without taxels.
  [[nodiscard]] const ModelTaxel& mean_taxel() const { return taxels.back(); }
  [[nodiscard]] double full_scale_v() const { return mean_taxel().full_scale(); }  // largest mean output
  // Outputs as measured and as the model's own speak of them.
  [[nodiscard]] double to_model(const ModelTaxel& taxel, double output) const;
  [[nodiscard]] double from_model(const ModelTaxel& taxel, double output) const;
};

// ELAM's own parameters and patterns, for what only the paper's model has; nullptr: another model, or none.
const ElamModel* elam_of(const ModelTaxel& taxel);
const ElamModel* paper_elam_of(const ModelTaxel& taxel);  // ELAM with one split point a branch and without memory

// Of the output with its readout divider inverted (analysis/models/linearised.h); nullptr: another, or none.
const LinearisedModel* linearised_of(const ModelTaxel& taxel);

// A branch of a taxel's external loop as its model has it, in outputs as measured (of a falling sensor negated).
class ExternalBranch {
 public:
  ExternalBranch(const ModelTaxel& taxel, bool up);  // keeps a pointer to `taxel`, which has a model
  [[nodiscard]] double output(double x) const;
  [[nodiscard]] double input(double y) const;  // clamped

 private:
  const ModelTaxel* taxel_;
  std::unique_ptr<ModelState> state_;
};

// Fills in the external loop of a taxel that has a model: `up` and `down` are the model's outputs at `inputs`; empty:
// as the model itself walks. Throws std::invalid_argument when they do not rise.
void set_loop(ModelTaxel& taxel, std::span<const double> inputs, std::span<const double> up = {},
              std::span<const double> down = {});

// What data must have in common with a model, and with each other.
struct DataIdentity {
  std::string name, origin, sensor_serial, scanner_serial;  // name: "run 3", "the models of run 3"
  int rows = 0, columns = 0;
};
// A model is bound to sensor, scanner and geometry, and origins never mix. Throws AnalysisError
// TB-ANALYSIS-OTHER-SENSOR, TB-ANALYSIS-ORIGIN.
void check_same_sensor(const DataIdentity& data, const DataIdentity& other);
void check_same_sensor(const DataIdentity& data, const SensorModel& fit);
void check_same_sensor(const Dataset& dataset, const SensorModel& fit);
DataIdentity identity_of(const Dataset& dataset);

// The dataset as the models of `fit` see it: outputs negated where they are those of a falling sensor.
Dataset as_modelled(Dataset dataset, const SensorModel& fit);

// Fits `model` to every taxel on the named sequences (empty: all); threads by taxel, the result does not depend on
// their number. Mean taxel: the mean of the taxels that were fitted. Throws AnalysisError, TB-ANALYSIS-MODEL when no
// taxel can carry the model.
SensorModel fit_models(const std::string& model, const Histories& histories, const std::vector<std::string>& sequences,
                       const IdentifyOptions& options, int threads = 0);
// The same without residuals (residuals.h), which are of models that this makes.
SensorModel fit_models_without_residuals(const std::string& model, const Histories& histories,
                                         const std::vector<std::string>& sequences, const IdentifyOptions& options,
                                         int threads = 0);

// In what the named sequences (empty: all) of `used` lie outside the model's validity, one line each: serials, inputs
// beyond 2 % of the range, holds and rates beyond 10 %, temperatures beyond 1 degC. What either does not know is
// passed. Pressures in `shown`.
std::vector<std::string> outside_validity(const SensorModel& model, const Histories& used,
                                          const std::vector<std::string>& sequences = {},
                                          PressureUnit shown = PressureUnit::kPsi);

struct FitOptions {
  std::string model = "elam";
  IdentifyOptions identify;
  std::vector<std::string> sequences;  // empty: all
  bool mean_alone = false;             // the mean of the taxels that can be fitted, and no taxel of its own
  RepeatOptions common;
  int threads = 0;         // 0: as many as there are cores
  double dead_v = kDeadV;  // a taxel whose output spans less is dead (0 V) or stuck
};

// A run's dataset all the way. Throws AnalysisError; TB-ANALYSIS-NO-TAXEL when no taxel was fitted.
SensorModel fit_array(const Dataset& dataset, const FitOptions& options = {});

// Makes streaming compensators from a sensor's model: for one taxel, for the stored samples of a dataset, for frames of
// the array.
// Of a taxel that has a model, at rest, with lag and creep removed where the model has them and the taxel is fitted.
// Outputs as measured, of a falling sensor negated. Keeps a pointer to `taxel`. `noisier`: by how much more noise a
// sample has than those that were fitted. Throws AnalysisError TB-MODEL-COMPENSATOR when the model's numbers make none.
std::unique_ptr<Compensator> compensator_of(const SensorModel& model, const ModelTaxel& taxel, double noisier = 1.0);

// Of the array, from any state; outputs as measured. Keeps a pointer to `model`. Throws as compensator_of, also when
// the model is not of a whole array.
FrameCompensator frames_of(const SensorModel& model, double noisier = 1.0, int max_gap = 10);

// The stored samples of a dataset through `stream`, in time order: state carries over from repeat to repeat and from
// sequence to sequence. `volts(repeat, i)`: the output at step i of the repeat. Calls take(s, r, i, Compensated) for
// step i of repeat r of sequence s.
template <class Volts, class Take>
void stream_samples(const Dataset& dataset, Compensator& stream, const Volts& volts, Take take) {
  double before_s = -1.0;
  for (std::size_t s = 0; s < dataset.sequences.size(); ++s) {
    const std::vector<Repeat>& repeats = dataset.sequences[s].repeats;
    for (std::size_t r = 0; r < repeats.size(); ++r)
      for (std::size_t i = 0; i < repeats[r].steps.size(); ++i) {
        const TimePassed passed = time_passed(repeats[r].steps[i], before_s);
        before_s = repeats[r].steps[i].time_s;
        if (passed.worked_s > 0.0) stream.work(passed.worked_s);
        take(s, r, i, stream.step(volts(repeats[r], i), passed.step_s));
      }
  }
}

}  // namespace tactbench::analysis
