#include "analysis/identify/sensor_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "analysis/compensate/document.h"
#include "analysis/error.h"
#include "analysis/identify/elam/elam.h"
#include "analysis/identify/elam/genetic.h"
#include "analysis/identify/fit_models.h"
#include "analysis/models/elam.h"
#include "analysis/models/linearised.h"

namespace tactbench::analysis {

double ModelTaxel::full_scale() const { return ascending.x().empty() ? 0.0 : std::max(std::abs(y0()), std::abs(yu())); }

std::string ModelTaxel::why() const {
  if (!reason.empty() || status != TaxelStatus::kUnfit) return reason.empty() ? to_string(status) : reason;
  if (fit.model == nullptr) return "its output moves, but not with the input";
  return fmt::format("its mean error is {:.4g} % of its full scale, and {:g} % at most are a fit",
                     100.0 * fit.mean_error / full_scale(), 100.0 * kUnfitShare);
}

std::vector<double> ModelTaxel::predicted(const History& history, bool free_run) const {
  History own = history;
  for (double& y : own.y) y = to_model(y);
  std::vector<double> outputs = predict_history(*fit.model, own, free_run);
  for (double& y : outputs) y = from_model(y);
  return outputs;
}

const ModelTaxel& SensorModel::taxel(int number) const {
  const auto found = std::ranges::find(taxels, number, &ModelTaxel::taxel);
  if (found != taxels.end()) return *found;
  throw AnalysisError("TB-MODEL-TAXEL",
                      fmt::format("the model of {} has no taxel {}; it has {} of them", source, number, taxels.size()),
                      "name one of these with --taxel, or give the table a column that does");
}

std::span<const ModelTaxel> SensorModel::array() const {
  const bool with_mean = !taxels.empty() && taxels.back().taxel == kMeanTaxel;
  return std::span(taxels).first(taxels.size() - (with_mean ? 1 : 0));
}

std::vector<std::size_t> SensorModel::fitted() const {
  std::vector<std::size_t> fitted;
  const std::span<const ModelTaxel> own = array();
  for (std::size_t i = 0; i < own.size(); ++i)
    if (own[i].fitted()) fitted.push_back(i);
  return fitted;
}

double SensorModel::to_model(const ModelTaxel& own, double output) const {
  return own.to_model(falling ? -output : output);
}

double SensorModel::from_model(const ModelTaxel& own, double output) const {
  const double rising = own.from_model(output);
  return falling ? -rising : rising;
}

const ElamModel* elam_of(const ModelTaxel& taxel) {
  const auto* const elam = dynamic_cast<const ElamHysteresis*>(taxel.fit.model.get());
  return elam != nullptr ? &elam->elam() : nullptr;
}

const ElamModel* paper_elam_of(const ModelTaxel& taxel) {
  const auto* const elam = dynamic_cast<const ElamHysteresis*>(taxel.fit.model.get());
  return elam != nullptr && elam->is_paper() ? &elam->elam() : nullptr;
}

const LinearisedModel* linearised_of(const ModelTaxel& taxel) {
  return dynamic_cast<const LinearisedModel*>(taxel.fit.model.get());
}

ExternalBranch::ExternalBranch(const ModelTaxel& taxel, bool up) : taxel_(&taxel), state_(taxel.fit.model->state()) {
  if (!up) state_->go(taxel.fit.model->x_high());
}

double ExternalBranch::output(double x) const { return taxel_->from_model(state_->output_at(x)); }

double ExternalBranch::input(double y) const { return state_->input_at(taxel_->to_model(y)); }

void set_loop(ModelTaxel& taxel, std::span<const double> inputs, std::span<const double> up,
              std::span<const double> down) {
  std::vector<double> x(inputs.begin(), inputs.end()), rising, falling;
  for (const double y : up) rising.push_back(taxel.from_model(y));
  for (const double y : down) falling.push_back(taxel.from_model(y));
  double low = 0.0, high = 0.0;
  if (up.empty()) {
    const ExternalBranch loading(taxel, true), unloading(taxel, false);
    for (const double at : x) {
      rising.push_back(loading.output(at));
      falling.push_back(unloading.output(at));
    }
    low = 0.5 * (rising.front() + falling.front());
    high = 0.5 * (rising.back() + falling.back());
  } else {
    low = rising.front();
    high = rising.back();
  }
  taxel.ascending = PatternCurve(x, rising, low, high);
  taxel.descending = PatternCurve(x, falling, low, high);
}

void check_same_sensor(const DataIdentity& data, const DataIdentity& other) {
  if (data.rows != other.rows || data.columns != other.columns)
    throw AnalysisError("TB-ANALYSIS-OTHER-SENSOR",
                        fmt::format("{} has {} x {} taxels, {} {} x {}", data.name, data.rows, data.columns, other.name,
                                    other.rows, other.columns),
                        "a model is bound to its array: name data and models of the same one");
  if (data.sensor_serial != other.sensor_serial || data.scanner_serial != other.scanner_serial)
    throw AnalysisError("TB-ANALYSIS-OTHER-SENSOR",
                        fmt::format("{} is of sensor {} on scanner {}, {} of {} on {}", data.name,
                                    or_not_stated(data.sensor_serial), or_not_stated(data.scanner_serial), other.name,
                                    or_not_stated(other.sensor_serial), or_not_stated(other.scanner_serial)),
                        "a model is bound to sensor and scanner: name data of this pair, or fit a run of it");
  if (data.origin != other.origin)
    throw AnalysisError("TB-ANALYSIS-ORIGIN",
                        fmt::format("{} is {}, {} {}", data.name, data.origin, other.name, other.origin),
                        "origins never mix: name data and models of the same one");
}

void check_same_sensor(const DataIdentity& data, const SensorModel& fit) {
  check_same_sensor(data, DataIdentity{fmt::format("the model of {}", fit.source), fit.origin, fit.sensor_serial,
                                       fit.scanner_serial, fit.rows, fit.columns});
  if (fit.array().size() != static_cast<std::size_t>(fit.rows) * static_cast<std::size_t>(fit.columns))
    throw AnalysisError("TB-ANALYSIS-OTHER-SENSOR", fmt::format("the model of {} is not of a whole array", fit.source),
                        "fit a run of the array");
}

void check_same_sensor(const Dataset& dataset, const SensorModel& fit) { check_same_sensor(identity_of(dataset), fit); }

DataIdentity identity_of(const Dataset& dataset) {
  return {fmt::format("run {}", dataset.run),
          dataset.origin,
          dataset.sensor_serial,
          dataset.scanner_serial,
          dataset.rows,
          dataset.columns};
}

Dataset as_modelled(Dataset dataset, const SensorModel& fit) {
  if (!fit.falling) return dataset;
  for (SequenceData& sequence : dataset.sequences)
    for (Repeat& repeat : sequence.repeats)
      for (double& volts : repeat.volts) volts = -volts;
  return dataset;
}

namespace {

// As kInputSlack.
constexpr double kTimeSlack = 0.1;  // of a hold or a rate

void widen(std::optional<Range>& range, double value) {
  if (!range) range = Range{value, value};
  range->widen(value);
}

std::string text_of(const Range& range, double factor) {
  return range.low == range.high ? fmt::format("{:.4g}", factor * range.low)
                                 : fmt::format("{:.4g} to {:.4g}", factor * range.low, factor * range.high);
}

}  // namespace

bool Range::contains(double value, double slack) const { return value >= low - slack && value <= high + slack; }

void Range::widen(double value) {
  low = std::min(low, value);
  high = std::max(high, value);
}

Validity validity_of(const std::vector<History>& histories, const std::vector<double>& temperatures_c) {
  Validity validity;
  for (const History& history : histories) {
    for (const double x : history.x) widen(validity.input, x);
    for (std::size_t i = 1; i < history.time_s.size(); ++i) {
      widen(validity.hold_s, history.held_s[i]);
      const double passed = history.time_s[i] - history.time_s[i - 1];
      if (passed > 0.0) widen(validity.rate, std::abs(history.x[i] - history.x[i - 1]) / passed);
    }
  }
  for (const double temperature : temperatures_c) widen(validity.temperature_c, temperature);
  return validity;
}

std::vector<std::string> outside_validity(const SensorModel& model, const Histories& used,
                                          const std::vector<std::string>& sequences, PressureUnit shown) {
  std::vector<std::string> outside;
  const auto serial = [&](const char* what, const std::string& own, const std::string& other) {
    if (!own.empty() && !other.empty() && own != other)
      outside.push_back(fmt::format("{} {} (fitted on {})", what, other, own));
  };
  serial("sensor", model.sensor_serial, used.sensor_serial);
  serial("scanner", model.scanner_serial, used.scanner_serial);
  const auto compare = [&](const char* what, const std::optional<Range>& box, const std::optional<Range>& seen,
                           double slack_low, double slack_high, const std::string& unit, double factor = 1.0) {
    if (!box || !seen || (seen->low >= box->low - slack_low && seen->high <= box->high + slack_high)) return;
    outside.push_back(fmt::format("{} {}{} (fitted at {})", what, text_of(*seen, factor), unit, text_of(*box, factor)));
  };
  const auto first = std::ranges::find_if(used.taxels, [](const auto& t) { return t.usable(); });
  const Validity seen = validity_of(named(first->score, sequences), used.temperatures_c);
  const Validity& box = model.validity;
  const double input_slack = box.input ? kInputSlack * (box.input->high - box.input->low) : 0.0;
  const bool in_psi = used.input_unit == "psi";
  const double factor = in_psi ? shown.of(1.0) : 1.0;
  const std::string input_unit = used.input_unit.empty() ? "" : " " + (in_psi ? shown.symbol() : used.input_unit);
  compare("input", box.input, seen.input, input_slack, input_slack, input_unit, factor);
  compare("hold", box.hold_s, seen.hold_s, box.hold_s ? kTimeSlack * box.hold_s->low : 0.0,
          box.hold_s ? kTimeSlack * box.hold_s->high : 0.0, " s");
  // Slower is what a hold is: its own line.
  compare("rate", box.rate, seen.rate, HUGE_VAL, box.rate ? kTimeSlack * box.rate->high : 0.0, input_unit + "/s",
          factor);
  compare("temperature", box.temperature_c, seen.temperature_c, kTemperatureSlack, kTemperatureSlack, " degC");
  return outside;
}

// ELAM for any data behind the interface of all models.

namespace {

constexpr int kFreeRunPasses = 4;  // at most; two to four suffice

// A recording that begins inside the range: the turn of its first branch was not measured.
bool turn_not_measured(const FitData& data, const History& history, const Branch& branch) {
  const auto inputs = data.ascending.x();
  const double first = history.x[static_cast<std::size_t>(branch.first)];
  const double inside = branch.ascending ? first - inputs.front() : inputs.back() - first;
  return branch.first == 0 && inside > kOuterShare * (inputs.back() - inputs.front());
}

// Of FitData's, those that tell of ELAM: all whose turn was measured, or all where one direction would be missing.
std::vector<const Branch*> determining_branches(const FitData& data, const History& history) {
  std::vector<const Branch*> used;
  bool up = false, down = false;
  for (const Branch& branch : history.branches) {
    if (turn_not_measured(data, history, branch)) continue;
    used.push_back(&branch);
    (branch.ascending ? up : down) = true;
  }
  if (up && down) return used;
  used.clear();
  for (const Branch& branch : history.branches) used.push_back(&branch);
  return used;
}

std::vector<TaxelBranch> branches_in(const FitData& data) {
  std::vector<TaxelBranch> branches;
  for (const History& history : data.histories) {
    for (const Branch* const used : determining_branches(data, history)) {
      const Branch& branch = *used;
      TaxelBranch own{branch.ascending, {}, {}};
      own.pressure_psi.assign(history.x.begin() + branch.first, history.x.begin() + branch.last + 1);
      own.volts.assign(history.y.begin() + branch.first, history.y.begin() + branch.last + 1);
      branches.push_back(std::move(own));
    }
  }
  return branches;
}

struct Walk {
  double j = 0.0, sum = 0.0, max = 0.0;
  int samples = 0;
  std::vector<double> starts;  // ordinate at which each branch starts
};

Walk walk(const ElamHysteresis& model, const FitData& data, bool free_run) {
  Walk result;
  for (const History& history : data.histories) {
    const auto state = model.state();
    if (begins_falling(history)) state->go(model.x_high());
    const std::vector<const Branch*> used = determining_branches(data, history);
    for (const Branch& branch : history.branches) {
      const auto first = static_cast<std::size_t>(branch.first), last = static_cast<std::size_t>(branch.last);
      state->go(history.x[first]);
      if (!free_run) state->measured(history.y[first]);
      if (std::ranges::find(used, &branch) == used.end()) {
        state->go(history.x[last]);
        continue;
      }
      result.starts.push_back(state->output_at(history.x[first]));
      // Without a turn inside the branch: measured inputs may waver.
      for (std::size_t i = first + 1; i <= last; ++i) {
        const double off = std::abs(state->output_at(history.x[i]) - history.y[i]);
        result.j += off * off;
        result.sum += off;
        result.max = std::max(result.max, off);
        ++result.samples;
      }
      state->go(history.x[last]);
    }
  }
  return result;
}

// Scored as it was identified: the walk of a model takes the same way, and rounds otherwise.
ModelFit as_model_fit(ElamFit fit, const std::vector<TaxelBranch>& branches) {
  ModelFit out;
  out.j = fit.j_v2;
  out.mean_error = fit.mean_error_v;
  out.max_error = fit.max_error_v;
  out.full_scale = fit.model.yu() - fit.model.y0();
  out.at_bound = fit.at_bound;
  out.undetermined = undetermined_names(fit);
  for (const TaxelBranch& branch : branches) out.samples += static_cast<int>(branch.volts.size()) - 1;
  out.model = std::make_shared<ElamHysteresis>(std::move(fit.model));
  return out;
}

ModelFit identified(const FitData& data, const IdentifyOptions& options) {
  const bool paper = !options.free_run && !options.memory && options.splits == 1;
  if (options.splits < 1 || options.splits > kMaxSplits)
    throw std::invalid_argument(
        fmt::format("ELAM: {} split points a branch were asked for; 1 to {} can be had", options.splits, kMaxSplits));
  std::vector<TaxelBranch> branches = branches_in(data);
  const ElamOptions elam{options.exact_outer};
  const auto identified = [&] {
    return options.genetic ? identify_elam_ga(data.ascending, data.descending, branches, elam)
                           : identify_elam(data.ascending, data.descending, branches, elam);
  };
  if (paper) return as_model_fit(identified(), branches);
  std::vector<std::string> undetermined;
  const auto fitted = [&] {
    ElamFit found = identified();
    undetermined = undetermined_names(found);
    ElamModel model = std::move(found.model);
    ElamPieces pieces;
    if (options.splits > 1) pieces = fit_pieces(model, collect_samples(model, branches), options.splits);
    return std::make_unique<ElamHysteresis>(std::move(model), options.memory, std::move(pieces));
  };
  auto model = fitted();
  Walk best = walk(*model, data, options.free_run);
  // The halves of J meet in the starting ordinates: each pass takes them from the model of the one before.
  Walk last = best;
  for (int pass = 0; options.free_run && pass < kFreeRunPasses; ++pass) {
    for (std::size_t i = 0; i < branches.size(); ++i) branches[i].volts.front() = last.starts[i];
    auto next = fitted();
    last = walk(*next, data, true);
    if (last.j >= best.j) continue;
    best = last;
    model = std::move(next);
  }
  ModelFit fit;
  fit.undetermined = std::move(undetermined);
  fit.j = best.j;
  fit.mean_error = best.sum / best.samples;
  fit.max_error = best.max;
  fit.full_scale = data.ascending.y().back() - data.ascending.y().front();
  fit.samples = best.samples;
  fit.model = std::move(model);
  return fit;
}

// ELAM has nothing that inputs alone decide.
class ElamIdentifier final : public Identifier {
 public:
  explicit ElamIdentifier(const IdentifyOptions& options) : options_(options) {}
  [[nodiscard]] ModelFit fit(const FitData& data) const override { return identified(data, options_); }

 private:
  IdentifyOptions options_;
};

}  // namespace

std::unique_ptr<Identifier> ElamHysteresis::prepare(const FitData& /*like*/, const IdentifyOptions& options) {
  if (options.genetic && !has_genetic()) throw std::invalid_argument(kNoGenetic);
  return std::make_unique<ElamIdentifier>(options);
}

// Patterns of the paper's shape at 31 pressures.
KnownModel ElamHysteresis::known() {
  constexpr double kSpanPsi = 60.0;
  constexpr double kFull = 2.812897313573669, kBend = 1.3829440636103729, kGap = 0.20164693731064747;
  constexpr double kFall = 0.019262829601589903, kSplitLow = 0.56051751541486483, kSplitHigh = 0.1535427633368237;
  std::vector<double> x, up, down;
  for (int i = 0; i <= 30; ++i) {
    const double share = i / 30.0, rise = std::pow(std::sin(1.5707963 * std::pow(share, 0.8)), kBend);
    x.push_back(kSpanPsi * share);
    up.push_back(kFull * rise);
    down.push_back(kFull *
                   std::min(rise + kGap * std::sin(3.1415927 * share) * (1.0 - share) + kGap * share * (1 - rise),
                            1.0 - kFall * std::pow((1.0 - share) * 6.0, 1.3)));
  }
  down.front() = up.front();
  down.back() = up.back();
  const ElamModel elam = {
      PatternCurve(x, up, up.front(), up.back()),
      PatternCurve(x, down, up.front(), up.back()),
      {0.81963407492294863, 0.98152362703107, (kSplitHigh - kSplitLow) / kSpanPsi, kSplitLow, 0.30542499913911907},
      {}};
  return {std::make_unique<ElamHysteresis>(elam),
          {0.0, 2.10077920147374, 2.81289731357367, 2.38296550145603, 1.01073107822528, 2.47883974152128}};
}

namespace {

std::unique_ptr<Compensator> make(const SensorModel& model, const ModelTaxel& taxel, bool falls, double noisier,
                                  const std::shared_ptr<PassedTime>& time) {
  CompensatorSetup setup;
  const double sign = falls ? -1.0 : 1.0;
  setup.zero = sign * taxel.zero;
  setup.gain = sign * taxel.gain;
  setup.noise = noisier * taxel.noise;
  setup.highest = taxel.loop_low + taxel.fit.full_scale;
  if (model.dynamics && taxel.fitted()) {
    setup.time = time;
    setup.creep_scale = taxel.creep_scale;
    setup.lag_share = taxel.lag_share;
    setup.residual = model.dynamics->residual_shape;
    for (double& left : setup.residual) left *= taxel.residual_psi;
    setup.options.top_share = kTopShare;
  } else {
    setup.residual = residual_by_level(taxel.ascending, taxel.descending, taxel.residual_psi);
  }
  try {
    return make_compensator(*taxel.fit.model, setup);
  } catch (const std::invalid_argument& error) {
    throw AnalysisError("TB-MODEL-COMPENSATOR",
                        fmt::format("{}, taxel {}: {}", model.source, taxel.taxel, error.what()),
                        "check its parameters (tactbench model show), or fit it again");
  }
}

std::shared_ptr<PassedTime> time_of(const SensorModel& model) {
  auto time = std::make_shared<PassedTime>();
  if (model.dynamics) time->dynamics = model.dynamics->shared;
  return time;
}

}  // namespace

std::unique_ptr<Compensator> compensator_of(const SensorModel& model, const ModelTaxel& taxel, double noisier) {
  return make(model, taxel, false, noisier, time_of(model));
}

FrameCompensator frames_of(const SensorModel& model, double noisier, int max_gap) {
  if (model.array().size() != static_cast<std::size_t>(model.rows) * static_cast<std::size_t>(model.columns))
    throw AnalysisError(
        "TB-MODEL-COMPENSATOR",
        fmt::format("{} of {} cannot compensate frames: it is not of a whole array", model.model, model.source),
        "fit a run of the array: tactbench fit RUN");
  FrameCompensator::Setup setup;
  setup.max_gap = max_gap;
  setup.in_time = model.dynamics && undoes(model.dynamics->shared);
  setup.x_low = model.pressure_psi.front();
  setup.x_high = model.pressure_psi.back();
  const auto time = time_of(model);
  for (const ModelTaxel& taxel : model.array())
    setup.taxels.push_back(taxel.fitted() ? make(model, taxel, model.falling, noisier, time) : nullptr);
  FrameCompensator frames(std::move(setup));
  frames.start(Start::kUnknown);
  return frames;
}

}  // namespace tactbench::analysis
