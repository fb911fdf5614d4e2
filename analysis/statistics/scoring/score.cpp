#include "analysis/statistics/scoring/score.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "analysis/compensate/compensator.h"
#include "analysis/identify/dynamic/dynamic_fit.h"
#include "analysis/identify/fit_samples.h"
#include "analysis/identify/sensor_model.h"
#include "analysis/workers.h"

namespace tactbench::analysis {
namespace {

constexpr double kAtRest = 0.01;  // of the input's span

// 0.1, 0.2, 0.5, 1, ...: a value belongs to the bin whose lower bound is the greatest not above it.
Bin bin_of(double value) {
  const double decade = std::pow(10.0, std::floor(std::log10(value)));
  constexpr double kBinSteps[] = {1.0, 2.0, 5.0, 10.0};
  std::size_t i = 2;
  while (i > 0 && value < kBinSteps[i] * decade * (1.0 - 1e-6)) --i;
  return {kBinSteps[i] * decade, kBinSteps[i + 1] * decade, {}};
}

void add_to(std::vector<Bin>& bins, const Bin& bin) {
  const auto place = std::ranges::lower_bound(bins, 0.99 * bin.low, {}, &Bin::low);
  if (place != bins.end() && place->low < 1.01 * bin.low)
    place->error.add(bin.error);
  else
    bins.insert(place, bin);
}

void add_error(std::vector<Bin>& bins, double value, double error) {
  if (!(value > 0.0)) return;
  Bin bin = bin_of(value);
  bin.error.add(error);
  add_to(bins, bin);
}

}  // namespace

void ErrorSum::add(double error) {
  sum += error;
  max = std::max(max, error);
  ++samples;
}

void ErrorSum::add(const ErrorSum& other) {
  sum += other.sum;
  max = std::max(max, other.max);
  samples += other.samples;
}

void Score::add(const Score& other) {
  direct.add(other.direct);
  free_running.add(other.free_running);
  compensated.add(other.compensated);
  raw.add(other.raw);
  for (const Bin& bin : other.by_hold) add_to(by_hold, bin);
  for (const Bin& bin : other.by_rate) add_to(by_rate, bin);
}

void Score::add_sample(double error, double hold_s, double rate) {
  compensated.add(error);
  add_error(by_hold, hold_s, error);
  add_error(by_rate, rate, error);
}

Score score(const HysteresisModel& model, std::span<const History> histories, const ScoreOptions& options) {
  Score score;
  const double per_output = (options.x_high - options.x_low) / (options.y_high - options.y_low);
  const double near_low = options.x_low + kAtRest * (options.x_high - options.x_low);
  CompensatorSetup setup;
  setup.noise = options.noise;
  const auto inverse = make_compensator(model, setup);
  for (const History& history : histories) {
    const std::vector<double> predicted = predict_history(model, history, false);
    const std::vector<double> running = predict_history(model, history, true);
    inverse->start(history.x.empty() || history.x.front() <= near_low ? Start::kAtRest : Start::kUnknown);
    std::vector<double> estimates;
    for (const double y : history.y) estimates.push_back(inverse->step(y, 0.0).pressure_psi);
    for (const Branch& branch : history.branches) {
      for (auto i = static_cast<std::size_t>(branch.first) + 1; i <= static_cast<std::size_t>(branch.last); ++i) {
        const double off = std::abs(estimates[i] - history.x[i]);
        score.direct.add(std::abs(predicted[i] - history.y[i]));
        score.free_running.add(std::abs(running[i] - history.y[i]));
        score.compensated.add(off);
        score.raw.add(std::abs(options.x_low + (history.y[i] - options.y_low) * per_output - history.x[i]));
        if (history.time_s.empty()) continue;
        add_error(score.by_hold, history.held_s[i], off);
        const double passed = history.time_s[i] - history.time_s[i - 1];
        if (passed > 0.0) add_error(score.by_rate, std::abs(history.x[i] - history.x[i - 1]) / passed, off);
      }
    }
  }
  return score;
}

namespace {

std::string units_of(const std::string& input, const std::string& output) {
  if (input.empty() && output.empty()) return "no units stated";
  return fmt::format("the input unit {} and the output unit {}", or_not_stated(input), or_not_stated(output));
}

}  // namespace

void check_same_source(const SensorModel& document, const Histories& histories) {
  check_same_sensor({histories.source, histories.origin, histories.sensor_serial, histories.scanner_serial, 0, 0},
                    DataIdentity{"the model", document.origin, document.sensor_serial, document.scanner_serial, 0, 0});
  if (document.input_unit != histories.input_unit || document.output_unit != histories.output_unit)
    throw AnalysisError("TB-MODEL-UNITS",
                        fmt::format("the model has {}, {} has {}", units_of(document.input_unit, document.output_unit),
                                    histories.source, units_of(histories.input_unit, histories.output_unit)),
                        "give the units of the table: --input-unit U --output-unit U");
  if (document.falling != histories.falling)
    throw AnalysisError("TB-ANALYSIS-FALLING",
                        fmt::format("the output of the model {} with the input, that of {} does not",
                                    document.falling ? "falls" : "rises", histories.source),
                        "check the polarity of the wiring and the assignment of the columns");
}

namespace {

// Of a table: its sequences are recordings of their own.
bool are_recordings(const Histories& histories) { return histories.run == 0 || histories.origin == "imported"; }

// The errors of a history's estimates, one a sample, in its branches, as score() counts them.
void add_compensated(const History& history, const std::vector<double>& estimates, Score& score) {
  const bool timed = !history.time_s.empty();
  for (const Branch& branch : history.branches)
    for (auto i = static_cast<std::size_t>(branch.first) + 1; i <= static_cast<std::size_t>(branch.last); ++i) {
      const double passed = timed ? history.time_s[i] - history.time_s[i - 1] : 0.0;
      score.add_sample(std::abs(estimates[i] - history.x[i]), timed ? history.held_s[i] : 0.0,
                       passed > 0.0 ? std::abs(history.x[i] - history.x[i - 1]) / passed : 0.0);
    }
}

// What `compensate` leaves of the samples as measured, in place of the static model's inverse.
void compensate_recording(const SensorModel& document, const ModelTaxel& model, const Histories& source,
                          const TaxelHistories& taxel, const std::vector<std::string>& sequences, Score& score) {
  score.compensated = {};
  score.by_hold.clear();
  score.by_rate.clear();
  const auto stream = compensator_of(document, model);
  double before = -1.0;
  for (const History& history : named(taxel.score, sequences)) {
    if (are_recordings(source)) {
      stream->start(history.y.empty() || stream->at_rest(history.y.front()) ? Start::kAtRest : Start::kUnknown);
      before = -1.0;
    }
    std::vector<double> estimates;
    for (std::size_t i = 0; i < history.x.size(); ++i) {
      TimePassed passed;
      if (!history.time_s.empty()) {
        const double time = history.time_s[i];
        if (!are_recordings(source))
          passed = time_passed({0.0, 0.0, time, history.held_s[i]}, before);
        else if (before >= 0.0)
          passed.step_s = std::max(time - before, 0.0);
        before = time;
      }
      if (passed.worked_s > 0.0) stream->work(passed.worked_s);
      estimates.push_back(stream->step(history.y[i], passed.step_s).pressure_psi);
    }
    add_compensated(history, estimates, score);
  }
}

Score score_taxel(const ModelTaxel& model, const TaxelHistories& taxel, const std::vector<std::string>& sequences) {
  std::vector<History> histories = named(taxel.score, sequences);
  for (History& history : histories)
    for (double& y : history.y) y = (y - model.zero) / model.gain;
  const HysteresisModel& own = *model.fit.model;
  ScoreOptions options;
  options.noise = model.noise / model.gain;
  options.x_low = own.x_low();
  options.x_high = own.x_high();
  options.y_low = model.loop_low;
  options.y_high = model.loop_low + model.fit.full_scale;
  return score(own, histories, options);
}

}  // namespace

ModelScore score_model(const SensorModel& document, const Histories& histories,
                       const std::vector<std::string>& sequences, int threads) {
  check_same_source(document, histories);
  // The direct models of a dynamic one are the static film's.
  std::optional<Histories> undone;
  if (document.dynamics) undone = histories_without_dynamics(document, histories);
  const Histories& direct = undone ? *undone : histories;
  std::vector<Score> scores(document.taxels.size());
  for_each_index(scores.size(), threads, [&](std::size_t i) {
    const ModelTaxel& model = document.taxels[i];
    const auto own = std::ranges::find(direct.taxels, model.taxel, &TaxelHistories::taxel);
    if (model.fit.model == nullptr || own == direct.taxels.end() || !own->usable()) return;
    scores[i] = score_taxel(model, *own, sequences);
    const auto measured = histories.taxels.begin() + (own - direct.taxels.begin());
    if ((document.dynamics || are_recordings(histories)) && model.fitted())
      compensate_recording(document, model, histories, *measured, sequences, scores[i]);
  });
  ModelScore result;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const ModelTaxel& model = document.taxels[i];
    if (scores[i].direct.samples == 0) continue;
    if (model.taxel == kMeanTaxel || document.taxels.size() == 1) {
      result.mean = scores[i];
      result.full_scale = model.fit.full_scale;
    }
    if (model.taxel == kMeanTaxel && document.taxels.size() > 1) continue;
    result.taxels.add(scores[i]);
    ++result.count;
  }
  if (result.count == 0)
    throw AnalysisError("TB-ANALYSIS-NO-TAXEL",
                        fmt::format("the model of {} and {} have no taxel in common that can be scored",
                                    document.source, histories.source),
                        "score on data of the array that was fitted");
  return result;
}

ErrorSum cross_validate(const std::string& model, const FitData& data, const IdentifyOptions& options, int folds) {
  ErrorSum errors;
  for (const Fold& fold : folds_of(data, folds)) {
    ModelFit fit;
    try {
      fit = identify(model, with_branches(data, fold.kept), options);
    } catch (const std::invalid_argument&) {
      return {};  // a part without branches of both directions carries no model
    }
    const FitData held = with_branches(data, fold.held);
    for (const History& history : held.histories) {
      if (history.branches.empty()) continue;
      const std::vector<double> predicted = predict_history(*fit.model, history, options.free_run);
      for (const Branch& branch : history.branches)
        for (auto i = static_cast<std::size_t>(branch.first) + 1; i <= static_cast<std::size_t>(branch.last); ++i)
          errors.add(std::abs(predicted[i] - history.y[i]));
    }
  }
  return errors;
}

}  // namespace tactbench::analysis
