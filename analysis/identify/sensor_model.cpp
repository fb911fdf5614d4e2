#include "analysis/identify/sensor_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/models/elam_hysteresis.h"
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

}  // namespace tactbench::analysis
