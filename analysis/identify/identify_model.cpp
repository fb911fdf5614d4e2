#include <algorithm>
#include <array>
#include <stdexcept>

#include "analysis/error.h"
#include "analysis/identify/elam/genetic.h"
#include "analysis/identify/identifier.h"
#include "analysis/identify/linearised_identifier.h"

namespace tactbench::analysis {
namespace {

using Prepare = std::unique_ptr<Identifier> (*)(const FitData&, const IdentifyOptions&);

// ELAM has nothing that inputs alone decide.
class ElamIdentifier final : public Identifier {
 public:
  explicit ElamIdentifier(const IdentifyOptions& options) : options_(options) {}
  [[nodiscard]] ModelFit fit(const FitData& data) const override { return identify_elam(data, options_); }

 private:
  IdentifyOptions options_;
};

std::unique_ptr<Identifier> prepare_elam(const FitData& /*like*/, const IdentifyOptions& options) {
  if (options.genetic && !has_genetic()) throw std::invalid_argument(kNoGenetic);
  return std::make_unique<ElamIdentifier>(options);
}

constexpr std::array<const char*, 6> kModelNames = {"elam", "gpi", "mpi", "poly", "preisach", "monotone"};
constexpr std::array<Prepare, 6> kPrepare = {prepare_elam, prepare_gpi,      prepare_mpi,
                                             prepare_poly, prepare_preisach, prepare_monotone};

}  // namespace

std::span<const char* const> model_names() { return kModelNames; }

std::unique_ptr<Identifier> prepare(const std::string& name, const FitData& like, const IdentifyOptions& options) {
  const auto found = std::ranges::find(kModelNames, name);
  if (found == kModelNames.end()) throw std::invalid_argument("there is no model named \"" + name + "\"");
  if (!like.no_loop.empty() && (name == "elam" || name == "poly"))
    throw AnalysisError("TB-ANALYSIS-NO-LOOP", name + " is made of the external loop: " + like.no_loop,
                        "measure from the lowest to the highest and back without a turn, or fit a model that needs no "
                        "external loop: --model gpi,mpi,preisach,monotone");
  const Prepare own = kPrepare[static_cast<std::size_t>(found - kModelNames.begin())];
  if (!options.linearise) return own(like, options);
  // The congruency test is about Preisach's kind of model, and tells of it what held branches would: there errors are
  // more of weights that the others leave open.
  return prepare_linearised(like, options.free_run, name != "preisach",
                            [&](const FitData& data) { return own(data, options); });
}

ModelFit identify(const std::string& name, const FitData& data, const IdentifyOptions& options) {
  return prepare(name, data, options)->fit(data);
}

ModelFit identify_gpi(const FitData& data, const IdentifyOptions& options) {
  return prepare_gpi(data, options)->fit(data);
}
ModelFit identify_mpi(const FitData& data, const IdentifyOptions& options) {
  return prepare_mpi(data, options)->fit(data);
}
ModelFit identify_poly(const FitData& data, const IdentifyOptions& options) {
  return prepare_poly(data, options)->fit(data);
}
ModelFit identify_preisach(const FitData& data, const IdentifyOptions& options) {
  return prepare_preisach(data, options)->fit(data);
}
ModelFit identify_monotone(const FitData& data, const IdentifyOptions& options) {
  return prepare_monotone(data, options)->fit(data);
}

bool begins_falling(const History& history) {
  return !history.branches.empty() && history.branches.front().first == 0 && !history.branches.front().ascending;
}

// Samples outside of any branch are walked one by one. Within a branch the way is the one from its first sample: an
// input that steps back there (noise of a measured reference) is no turn.
std::vector<double> predict_history(const HysteresisModel& model, const History& history, bool free_run) {
  const auto state = model.state();
  if (begins_falling(history)) state->go(model.x_high());
  std::vector<double> outputs(history.x.size());
  std::size_t next = 0;
  const auto walk_to = [&](std::size_t end) {
    for (; next < end; ++next) {
      state->go(history.x[next]);
      outputs[next] = state->output_at(history.x[next]);
    }
  };
  for (const Branch& branch : history.branches) {
    const auto first = static_cast<std::size_t>(branch.first), last = static_cast<std::size_t>(branch.last);
    walk_to(first);
    state->go(history.x[first]);
    if (!free_run) state->measured(history.y[first]);
    for (std::size_t i = next; i <= last; ++i) outputs[i] = state->output_at(history.x[i]);
    state->go(history.x[last]);
    next = last + 1;
  }
  walk_to(history.x.size());
  return outputs;
}

}  // namespace tactbench::analysis
