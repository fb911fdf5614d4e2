// The interface of all hysteresis models: outputs along any history of inputs, and inputs along any history of outputs.
// x is the input (pressure in psi on the rig), y the output (volts); any units serve.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace tactbench::analysis {

struct ModelParameter {
  std::string name;  // as in the paper
  double value = 0.0;
  std::string unit;  // in terms of the input's and output's: "1", "x", "y", "1/x"
  double low = 0.0;  // bounds of identification; infinite where there is none
  double high = 0.0;
  bool fixed = false;                   // set by convention, not identified: another parameter takes its part
  [[nodiscard]] bool at_bound() const;  // within 1e-9 of their distance
};

// What makes a model again, bit for bit, in the order of its document; "parameters/a1" is the member a1 of parameters.
using ModelMembers = std::vector<std::pair<std::string, std::variant<int, bool, double, std::vector<double>>>>;

// They come back from here. Throws std::invalid_argument where a member is missing, of another kind or not finite.
class ModelSource {
 public:
  virtual ~ModelSource() = default;
  [[nodiscard]] virtual double number(const std::string& member) const = 0;
  [[nodiscard]] virtual std::vector<double> numbers(const std::string& member) const = 0;
  [[nodiscard]] virtual bool flag(const std::string& member) const = 0;
  [[nodiscard]] double parameter(const std::string& name) const { return number("parameters/" + name); }
};

// A model's memory along one history. Outputs do not fall when the input rises, in any state.
class ModelState {
 public:
  virtual ~ModelState() = default;
  // At rest at the model's lowest input, without history.
  virtual void reset() = 0;
  // The output at x when the input goes from here to x without a turn. x is clamped to the model's range.
  [[nodiscard]] virtual double output_at(double x) const = 0;
  // The input that gives output y on the way there without a turn: of several (a flat stretch) the nearest, clamped to
  // the reachable range. output_at(input_at(y)) = y within 1e-9 of the output's span for every reachable y.
  [[nodiscard]] virtual double input_at(double y) const = 0;
  // Goes to x. Throws std::invalid_argument when x is not finite; the state is then as before.
  virtual void go(double x) = 0;
  // The output here was measured as y: a branch that starts here starts at y [A9]. Models whose output is a function of
  // the inputs alone ignore it.
  virtual void measured(double /*y*/) {}
  [[nodiscard]] virtual std::unique_ptr<ModelState> clone() const = 0;
};

class Identifier;  // of analysis/identify/fit_models.h, and what it takes and gives
struct FitData;
struct IdentifyOptions;
struct KnownModel;

class HysteresisModel {
 public:
  // Of each kind of model (all_models.h), beside its kName and its
  //   static std::unique_ptr<HysteresisModel> from(const ModelSource& source);
  //   static std::unique_ptr<Identifier> prepare(const FitData& like, const IdentifyOptions& options);
  static constexpr bool kOfLoop = false;    // it is made of the external loop
  static constexpr double kFitShare = 1.0;  // time of a fit over ELAM's: the demonstration's run, 256 taxels, two cores
  static constexpr KnownModel (*known)() = nullptr;  // one whose outputs are known, for `selfcheck`

  virtual ~HysteresisModel() = default;
  [[nodiscard]] virtual std::string name() const = 0;  // kName
  [[nodiscard]] virtual ModelMembers members() const = 0;
  [[nodiscard]] virtual std::vector<ModelParameter> parameters() const = 0;
  [[nodiscard]] virtual double x_low() const = 0;
  [[nodiscard]] virtual double x_high() const = 0;
  // Additions, multiplications, comparisons and table accesses of one sample between turns, counted by hand.
  [[nodiscard]] virtual int operations_per_sample() const = 0;
  [[nodiscard]] virtual std::unique_ptr<ModelState> state() const = 0;  // keeps a pointer to the model
};

// The range, `y_low` and the parameters.
ModelMembers range_and_parameters(const HysteresisModel& model, double y_low);

// Outputs along inputs, and inputs along outputs, from a virgin state. Throw std::invalid_argument when a value is not
// finite.
std::vector<double> predict(const HysteresisModel& model, std::span<const double> inputs);
std::vector<double> invert(const HysteresisModel& model, std::span<const double> outputs);

}  // namespace tactbench::analysis
