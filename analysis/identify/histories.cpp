#include "analysis/identify/histories.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "analysis/counted.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

History history_of(const std::string& name, const TaxelTable& sequence, std::size_t width, std::size_t taxel) {
  History history{name, sequence.pressure_psi, {}, sequence.branches, {}, {}};
  for (std::size_t i = 0; i < sequence.pressure_psi.size(); ++i)
    history.y.push_back(sequence.values[i * width + taxel]);
  return history;
}

History history_of(const std::string& name, const Repeat& repeat, const std::vector<Branch>& branches,
                   std::size_t width, std::size_t taxel) {
  History history{name, {}, {}, branches, {}, {}};
  for (std::size_t i = 0; i < repeat.steps.size(); ++i) {
    history.x.push_back(repeat.steps[i].reference_psi);
    history.y.push_back(repeat.volts[i * width + taxel]);
    history.time_s.push_back(repeat.steps[i].time_s);
    history.held_s.push_back(repeat.steps[i].held_s);
  }
  return history;
}

struct Span {
  double low = 0.0, high = 0.0;
  [[nodiscard]] double length() const { return high - low; }
};

Span span_of(const std::vector<History>& histories, std::vector<double> History::*values) {
  Span span{(histories.front().*values).front(), (histories.front().*values).front()};
  for (const History& history : histories) {
    const auto [low, high] = std::ranges::minmax(history.*values);
    span = {std::min(span.low, low), std::max(span.high, high)};
  }
  return span;
}

// Of input and output over all samples of all taxels that can be fitted.
double covariance(const std::vector<TaxelHistories>& taxels) {
  double sum = 0.0;
  for (const TaxelHistories& taxel : taxels) {
    if (!taxel.status.empty()) continue;
    for (const History& history : taxel.fit) {
      const double x = mean_by_shares(history.x), y = mean_by_shares(history.y);
      for (std::size_t i = 0; i < history.x.size(); ++i) sum += (history.x[i] - x) * (history.y[i] - y);
    }
  }
  return sum;
}

void negate(std::vector<History>& histories) {
  for (History& history : histories)
    for (double& y : history.y) y = -y;
}

// The mean of the taxels that can be fitted, sample by sample; empty when their histories are not of one shape.
std::vector<History> mean_histories(const std::vector<TaxelHistories>& taxels,
                                    std::vector<History> TaxelHistories::*which) {
  std::vector<History> mean;
  double count = 0.0;
  for (const TaxelHistories& taxel : taxels) {
    if (!taxel.status.empty()) continue;
    const std::vector<History>& own = taxel.*which;
    if (count == 0.0) {
      mean = own;
      for (History& history : mean) std::ranges::fill(history.y, 0.0);
    }
    count += 1.0;
    if (own.size() != mean.size()) return {};
    for (std::size_t h = 0; h < own.size(); ++h) {
      if (own[h].x != mean[h].x) return {};
      for (std::size_t i = 0; i < own[h].y.size(); ++i) mean[h].y[i] += own[h].y[i];
    }
  }
  for (History& history : mean)
    for (double& y : history.y) y /= count;
  return mean;
}

void finish(Histories& histories) {
  const auto usable = std::ranges::count_if(histories.taxels, [](const auto& t) { return t.status.empty(); });
  if (usable == 0)
    throw AnalysisError("TB-ANALYSIS-NO-TAXEL", fmt::format("{}: no taxel can be fitted", histories.source),
                        "look at the samples: dead, stuck, saturated and constant outputs are left out");
  histories.falling = covariance(histories.taxels) < 0.0;
  for (TaxelHistories& taxel : histories.taxels) {
    if (!histories.falling) break;
    negate(taxel.fit);
    negate(taxel.score);
  }
  if (histories.taxels.size() == 1) return;
  TaxelHistories mean;
  mean.taxel = kMeanTaxel;
  mean.fit = mean_histories(histories.taxels, &TaxelHistories::fit);
  mean.score = mean_histories(histories.taxels, &TaxelHistories::score);
  for (const TaxelHistories& taxel : histories.taxels)
    if (taxel.status.empty()) mean.noise += taxel.noise * taxel.noise;
  mean.noise = std::sqrt(mean.noise) / static_cast<double>(usable);
  if (!mean.fit.empty()) histories.taxels.push_back(std::move(mean));
}

}  // namespace

Histories histories_of(const Dataset& dataset, const HistoriesOptions& options) {
  Histories histories;
  histories.source = fmt::format("run {}", dataset.run);
  histories.origin = dataset.origin;
  histories.sensor_serial = dataset.sensor_serial;
  histories.scanner_serial = dataset.scanner_serial;
  histories.rows = dataset.rows;
  histories.columns = dataset.columns;
  histories.scans = dataset.scans;
  histories.temperatures_c = dataset.temperatures_c;
  const auto width = static_cast<std::size_t>(dataset.taxels());
  std::vector<TaxelTable> common;
  for (const SequenceData& sequence : dataset.sequences) {
    histories.sequences.push_back(sequence.name);
    common.push_back(bring_to_common(sequence, dataset.taxels(), options.common));
  }
  for (std::size_t taxel = 0; taxel < width; ++taxel) {
    TaxelHistories own;
    own.taxel = static_cast<int>(taxel);
    own.noise = dataset.noise_v[taxel];
    for (std::size_t s = 0; s < common.size(); ++s) {
      const SequenceData& sequence = dataset.sequences[s];
      own.fit.push_back(history_of(sequence.name, common[s], width, taxel));
      for (const Repeat& repeat : sequence.repeats)
        own.score.push_back(history_of(sequence.name, repeat, common[s].branches, width, taxel));
    }
    const Span span = span_of(own.fit, &History::y);
    if (dataset.at_limit[taxel])
      own.status = "saturated";
    else if (span.length() < options.dead_v)
      own.status = std::max(std::abs(span.low), std::abs(span.high)) < options.dead_v ? "dead" : "stuck";
    histories.taxels.push_back(std::move(own));
  }
  finish(histories);
  return histories;
}

Histories histories_of(const std::vector<TableSeries>& series, const std::string& source,
                       const HistoriesOptions& options) {
  Histories histories;
  histories.source = source;
  histories.origin = "imported";
  std::map<int, TaxelHistories> taxels;
  for (const TableSeries& own : series) {
    if (own.input.size() < 4)
      throw AnalysisError(Cause::kUsage, "TB-TABLE-SHORT",
                          fmt::format("{}: sequence {} of taxel {} has {}", source, own.sequence, own.taxel,
                                      counted(own.input.size(), "sample")),
                          "a history of at least 4 samples is needed to see a loop");
    if (std::ranges::find(histories.sequences, own.sequence) == histories.sequences.end())
      histories.sequences.push_back(own.sequence);
    TaxelHistories& taxel = taxels[own.taxel];
    taxel.taxel = own.taxel;
    taxel.fit.push_back({own.sequence, own.input, own.output, {}, {}, {}});
  }
  for (auto& [number, taxel] : taxels) {
    const Span x = span_of(taxel.fit, &History::x), y = span_of(taxel.fit, &History::y);
    if (x.length() <= 0.0)
      throw AnalysisError(Cause::kUsage, "TB-TABLE-CONSTANT",
                          fmt::format("{}: the input of taxel {} is {} in all rows", source, number, x.low),
                          "a history needs inputs that rise and fall; --map input=COL names another column");
    for (History& history : taxel.fit) history.branches = branches_along(history.x, options.turn_share * x.length());
    if (y.length() <= 0.0) taxel.status = "constant";
    for (const History& history : taxel.fit)
      taxel.noise = std::max(taxel.noise, options.noise < 0.0 ? noise_of(history.y) : options.noise);
    taxel.score = taxel.fit;
    histories.taxels.push_back(std::move(taxel));
  }
  histories.rows = static_cast<int>(histories.taxels.size());
  finish(histories);
  return histories;
}

Histories mean_taxel_of(Histories histories) {
  if (histories.taxels.size() > 1) histories.taxels.erase(histories.taxels.begin(), histories.taxels.end() - 1);
  return histories;
}

double noise_of(const std::vector<double>& outputs) {
  std::vector<double> differences;
  for (std::size_t i = 4; i < outputs.size(); ++i)
    differences.push_back(
        std::abs(outputs[i] - 4.0 * outputs[i - 1] + 6.0 * outputs[i - 2] - 4.0 * outputs[i - 3] + outputs[i - 4]));
  if (differences.empty()) return 0.0;
  constexpr double kMedianOfNormal = 0.67449;  // of its absolute value, in standard deviations
  return quantile_of(std::move(differences), 0.5) / (kMedianOfNormal * std::sqrt(70.0));  // 1 + 16 + 36 + 16 + 1
}

std::vector<History> named(const std::vector<History>& histories, const std::vector<std::string>& names) {
  if (names.empty()) return histories;
  std::vector<History> chosen;
  for (const std::string& name : names) {
    const auto count = chosen.size();
    for (const History& history : histories)
      if (history.name == name) chosen.push_back(history);
    if (chosen.size() > count) continue;
    std::vector<std::string> there;
    for (const History& history : histories)
      if (std::ranges::find(there, history.name) == there.end()) there.push_back(history.name);
    throw AnalysisError(Cause::kUsage, "TB-MODEL-SEQUENCE",
                        fmt::format("no sequence \"{}\"; those there are: \"{}\"", name, fmt::join(there, "\", \"")),
                        "name one of these (a table without a column sequence has one, named 1)");
  }
  return chosen;
}

FitData fit_data_of(const TaxelHistories& taxel, const std::vector<std::string>& names) {
  FitData data;
  data.histories = named(taxel.fit, names);
  std::vector<TaxelTable> sequences;
  for (const History& history : data.histories) sequences.push_back({history.x, history.y, history.branches});
  const ExternalLoop loop = external_loop(sequences, 1);
  // Both patterns start and end in the mean of the two measured ends [A11].
  const double low = 0.5 * (loop.ascending.front() + loop.descending.front());
  const double high = 0.5 * (loop.ascending.back() + loop.descending.back());
  if (high <= low)
    throw AnalysisError("TB-ANALYSIS-FALLING",
                        fmt::format("the output goes from {:g} to {:g} where the input rises", low, high),
                        "only outputs that change with the input the same way all along are modelled");
  data.ascending = PatternCurve(loop.pressure_psi, loop.ascending, low, high);
  data.descending = PatternCurve(loop.pressure_psi, loop.descending, low, high);
  return data;
}

}  // namespace tactbench::analysis
