#include "analysis/identify/histories.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <utility>

#include "analysis/statistics/numbers/moments.h"
#include "analysis/workers.h"

namespace tactbench::analysis {
namespace {

// Order of TaxelStatus.
constexpr std::array<const char*, 6> kWords = {"fitted", "dead", "stuck", "saturated", "unfit", "constant"};

}  // namespace

const char* to_string(TaxelStatus status) { return kWords[static_cast<std::size_t>(status)]; }

bool status_from(std::string_view word, TaxelStatus& status) {
  const auto* const found = std::ranges::find(kWords, word);
  if (found == kWords.end()) return false;
  status = static_cast<TaxelStatus>(found - kWords.begin());
  return true;
}

TaxelStatus status_of(OutputRange outputs, bool at_limit, double dead_v) {
  if (at_limit) return TaxelStatus::kSaturated;
  if (outputs.high - outputs.low >= dead_v) return TaxelStatus::kFitted;
  return std::max(std::abs(outputs.low), std::abs(outputs.high)) < dead_v ? TaxelStatus::kDead : TaxelStatus::kStuck;
}

namespace {

struct Off {
  double mean = 0.0, rms = 0.0;
};

// The mean of some taxels as a sequence of one taxel: moving outputs to the set-points is linear in them.
SequenceData mean_sequence(const SequenceData& sequence, std::size_t width, std::span<const std::size_t> taxels) {
  SequenceData mean{sequence.name, {}};
  for (const Repeat& repeat : sequence.repeats) {
    Repeat own{repeat.steps, {}};
    own.volts.reserve(repeat.steps.size());
    for (std::size_t i = 0; i < repeat.steps.size(); ++i)
      own.volts.push_back(mean_of_chosen(std::span<const double>(repeat.volts).subspan(i * width, width), taxels));
    mean.repeats.push_back(std::move(own));
  }
  return mean;
}

double lasts_s(const Repeat& repeat) { return repeat.steps.back().time_s - repeat.steps.front().time_s; }

// Those at the pace of the first: at another one the film's output is another.
SequenceData at_first_pace(SequenceData sequence) {
  constexpr double kSamePace = 1.5;  // the longer over the shorter
  const double first_s = lasts_s(sequence.repeats.front());
  std::erase_if(sequence.repeats, [&](const Repeat& repeat) {
    return lasts_s(repeat) > kSamePace * first_s || first_s > kSamePace * lasts_s(repeat);
  });
  return sequence;
}

// A repeat less the mean of the others but the first.
Off off_from_others(const std::vector<std::vector<double>>& repeats, std::size_t which) {
  Off off;
  const std::size_t steps = repeats.front().size();
  for (std::size_t i = 0; i < steps; ++i) {
    double others = 0.0, count = 0.0;
    for (std::size_t r = 1; r < repeats.size(); ++r) {
      if (r == which) continue;
      others += repeats[r][i];
      count += 1.0;
    }
    const double here = repeats[which][i] - others / count;
    off.mean += here / static_cast<double>(steps);
    off.rms += here * here / static_cast<double>(steps);
  }
  off.rms = std::sqrt(off.rms);
  return off;
}

}  // namespace

std::vector<RepeatDrift> repeat_drifts(const Dataset& dataset, std::span<const std::size_t> taxels,
                                       const RepeatOptions& options) {
  std::vector<RepeatDrift> drifts;
  const auto width = static_cast<std::size_t>(dataset.taxels());
  for (const SequenceData& sequence : dataset.sequences) {
    const SequenceData paced = at_first_pace(sequence);
    const std::size_t count = paced.repeats.size();
    if (count < 3 || taxels.empty()) continue;
    const SequenceData mean = mean_sequence(paced, width, taxels);
    std::vector<std::vector<double>> means(count);
    for (std::size_t r = 0; r < count; ++r) {
      RepeatOptions one = options;
      one.first_repeat = one.last_repeat = static_cast<int>(r);
      means[r] = average_repeats(mean, 1, one).values;
    }
    RepeatDrift drift;
    drift.sequence = sequence.name;
    const Off first = off_from_others(means, 0);
    drift.shift_v = first.mean;
    drift.rms_v = first.rms;
    double squares = 0.0;
    for (std::size_t r = 1; r < count; ++r) {
      const Off off = off_from_others(means, r);
      squares += off.mean * off.mean;
      drift.others_rms_v = std::max(drift.others_rms_v, off.rms);
    }
    // With n others, one less the mean of the n - 1 left varies n / (n - 1) times as one repeat does, the first less
    // the mean of all n others (n + 1) / n times.
    const auto n = static_cast<double>(count - 1);
    drift.uncertainty_v = std::sqrt(squares / n * ((n - 1.0) / n) * ((n + 1.0) / n));
    drift.differs = std::abs(drift.shift_v) > 3.0 * drift.uncertainty_v || drift.rms_v > 2.0 * drift.others_rms_v;
    drifts.push_back(drift);
  }
  return drifts;
}

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

// Without the twentieth at each end, which may hold wild samples.
std::vector<double> clipped(std::vector<double> values) {
  constexpr double kOut = 0.05;
  const double low = quantile_of(values, kOut), high = quantile_of(values, 1.0 - kOut);
  for (double& value : values) value = std::clamp(value, low, high);
  return values;
}

// Of input and output over all samples of all taxels that can be fitted.
double covariance(const std::vector<TaxelHistories>& taxels) {
  double sum = 0.0;
  for (const TaxelHistories& taxel : taxels) {
    if (!taxel.usable()) continue;
    for (const History& history : taxel.fit) {
      const bool wild = !taxel.wild.empty();
      const std::vector<double> own_x = wild ? clipped(history.x) : std::vector<double>();
      const std::vector<double> own_y = wild ? clipped(history.y) : std::vector<double>();
      const std::vector<double>&x = wild ? own_x : history.x, &y = wild ? own_y : history.y;
      const double mean_x = mean_of(x), mean_y = mean_of(y);
      for (std::size_t i = 0; i < x.size(); ++i) sum += (x[i] - mean_x) * (y[i] - mean_y);
    }
  }
  return sum;
}

void negate(std::vector<History>& histories) {
  for (History& history : histories)
    for (double& y : history.y) y = -y;
}

// The mean of some taxels, sample by sample; empty when their histories are not of one shape.
std::vector<History> mean_histories(const std::vector<const TaxelHistories*>& taxels,
                                    std::vector<History> TaxelHistories::*which) {
  std::vector<History> mean = taxels.front()->*which;
  for (History& history : mean) std::ranges::fill(history.y, 0.0);
  for (const TaxelHistories* taxel : taxels) {
    const std::vector<History>& own = taxel->*which;
    if (own.size() != mean.size()) return {};
    for (std::size_t h = 0; h < own.size(); ++h) {
      if (own[h].x != mean[h].x) return {};
      for (std::size_t i = 0; i < own[h].y.size(); ++i) mean[h].y[i] += own[h].y[i];
    }
  }
  for (History& history : mean)
    for (double& y : history.y) y /= static_cast<double>(taxels.size());
  return mean;
}

}  // namespace

Span span_of(const std::vector<History>& histories, std::vector<double> History::*values) {
  Span span{(histories.front().*values).front(), (histories.front().*values).front()};
  for (const History& history : histories) {
    const auto [low, high] = std::ranges::minmax(history.*values);
    span = {std::min(span.low, low), std::max(span.high, high)};
  }
  return span;
}

void finish(Histories& histories) {
  std::vector<const TaxelHistories*> usable;
  for (const TaxelHistories& taxel : histories.taxels)
    if (taxel.usable()) usable.push_back(&taxel);
  if (usable.empty())
    throw AnalysisError("TB-ANALYSIS-NO-TAXEL", fmt::format("{}: no taxel can be fitted", histories.source),
                        "check the samples: dead, stuck, saturated and constant outputs are left out");
  histories.falling = covariance(histories.taxels) < 0.0;
  for (TaxelHistories& taxel : histories.taxels) {
    if (!histories.falling) break;
    negate(taxel.fit);
    negate(taxel.score);
  }
  if (histories.taxels.size() == 1) return;
  TaxelHistories mean;
  mean.taxel = kMeanTaxel;
  mean.fit = mean_histories(usable, &TaxelHistories::fit);
  mean.score = mean_histories(usable, &TaxelHistories::score);
  for (const TaxelHistories* taxel : usable) {
    mean.noise += taxel->noise * taxel->noise;
    mean.turn = std::max(mean.turn, taxel->turn);
  }
  mean.noise = std::sqrt(mean.noise) / static_cast<double>(usable.size());
  if (!mean.fit.empty()) histories.taxels.push_back(std::move(mean));
}

Histories histories_of(const Dataset& dataset, const HistoriesOptions& options) {
  Histories histories;
  histories.run = dataset.run;
  histories.source = fmt::format("run {}", dataset.run);
  histories.origin = dataset.origin;
  histories.sensor_serial = dataset.sensor_serial;
  histories.scanner_serial = dataset.scanner_serial;
  histories.rows = dataset.rows;
  histories.columns = dataset.columns;
  histories.scans = dataset.scans;
  histories.temperatures_c = dataset.temperatures_c;
  histories.min_span = options.dead_v;
  const auto width = static_cast<std::size_t>(dataset.taxels());
  std::vector<TaxelTable> common(dataset.sequences.size());
  for (const SequenceData& sequence : dataset.sequences) histories.sequences.push_back(sequence.name);
  for_each_index(common.size(), options.threads, [&](std::size_t s) {
    common[s] = average_repeats(dataset.sequences[s], dataset.taxels(), options.common);
  });
  histories.taxels.resize(width);
  const auto add_scores = [&](std::size_t taxel) {
    for (std::size_t s = 0; s < common.size(); ++s)
      for (const Repeat& repeat : dataset.sequences[s].repeats)
        histories.taxels[taxel].score.push_back(
            history_of(dataset.sequences[s].name, repeat, common[s].branches, width, taxel));
  };
  for_each_index(width, options.threads, [&](std::size_t taxel) {
    TaxelHistories& own = histories.taxels[taxel];
    own.taxel = static_cast<int>(taxel);
    own.noise = dataset.noise_v[taxel];
    for (std::size_t s = 0; s < common.size(); ++s)
      own.fit.push_back(history_of(dataset.sequences[s].name, common[s], width, taxel));
    const Span span = span_of(own.fit, &History::y);
    own.status = status_of({span.low, span.high}, dataset.at_limit[taxel], options.dead_v);
    if (options.all_scores) add_scores(taxel);
  });
  const auto first = std::ranges::find_if(histories.taxels, [](const auto& t) { return t.usable(); });
  if (!options.all_scores && first != histories.taxels.end())
    add_scores(static_cast<std::size_t>(first - histories.taxels.begin()));
  finish(histories);
  return histories;
}

Histories mean_taxel_of(Histories histories) {
  if (histories.taxels.size() <= 1) return histories;
  if (histories.taxels.back().taxel != kMeanTaxel)
    throw AnalysisError("TB-ANALYSIS-NO-TAXEL",
                        fmt::format("{}: there is no mean taxel, for the taxels' inputs differ", histories.source),
                        "fit each taxel instead, without a mean taxel");
  histories.taxels.erase(histories.taxels.begin(), histories.taxels.end() - 1);
  return histories;
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
    throw AnalysisError("TB-MODEL-SEQUENCE",
                        fmt::format("no sequence \"{}\"; those there are: \"{}\"", name, fmt::join(there, "\", \"")),
                        "name one of these (a table without a column sequence has one, named 1)");
  }
  return chosen;
}

namespace {

// What stands for the loop where there is none: from the mean output at the lowest inputs to that at the highest.
ExternalLoop ends_of(const std::vector<TaxelTable>& sequences) {
  constexpr double kEnd = 0.01;  // of the span
  double low = sequences.front().pressure_psi.front(), high = low;
  for (const TaxelTable& sequence : sequences) {
    const auto [least, most] = std::ranges::minmax(sequence.pressure_psi);
    low = std::min(low, least);
    high = std::max(high, most);
  }
  std::vector<double> at_low, at_high;
  for (const TaxelTable& sequence : sequences) {
    for (std::size_t i = 0; i < sequence.values.size(); ++i) {
      if (sequence.pressure_psi[i] - low <= kEnd * (high - low)) at_low.push_back(sequence.values[i]);
      if (high - sequence.pressure_psi[i] <= kEnd * (high - low)) at_high.push_back(sequence.values[i]);
    }
  }
  const std::vector<double> line = {mean_of(at_low), mean_of(at_high)};
  return {{low, high}, line, line};
}

struct LoopOrEnds {
  ExternalLoop loop;    // or its ends
  std::string no_loop;  // what is missing of it
};

LoopOrEnds loop_of(const std::vector<History>& histories, double turn) {
  std::vector<TaxelTable> sequences;
  for (const History& history : histories) sequences.push_back({history.x, history.y, history.branches});
  try {
    return {external_loop(sequences, 1, turn), {}};
  } catch (const AnalysisError& error) {
    return {ends_of(sequences), error.what()};
  }
}

FitData with_patterns(std::vector<History> histories, const LoopOrEnds& own) {
  const ExternalLoop& loop = own.loop;
  // Both patterns start and end in the mean of the two measured ends [A11].
  const double low = 0.5 * (loop.ascending.front() + loop.descending.front());
  const double high = 0.5 * (loop.ascending.back() + loop.descending.back());
  if (high <= low)
    throw AnalysisError("TB-ANALYSIS-FALLING",
                        fmt::format("the output goes from {:g} to {:g} where the input rises", low, high),
                        "only outputs that change with the input the same way all along are modelled");
  return {std::move(histories), PatternCurve(loop.pressure_psi, loop.ascending, low, high),
          PatternCurve(loop.pressure_psi, loop.descending, low, high), own.no_loop};
}

}  // namespace

FitData fit_data_of(const TaxelHistories& taxel, const std::vector<std::string>& names) {
  std::vector<History> histories = named(taxel.fit, names);
  const LoopOrEnds loop = loop_of(histories, taxel.turn);
  return with_patterns(std::move(histories), loop);
}

std::optional<FitData> mean_fit_data(const Histories& histories, const std::vector<std::size_t>& taxels,
                                     const std::vector<std::string>& names) {
  std::vector<const TaxelHistories*> chosen;
  for (const std::size_t taxel : taxels) chosen.push_back(&histories.taxels[taxel]);
  std::vector<History> means = mean_histories(chosen, &TaxelHistories::fit);
  if (means.empty()) return std::nullopt;
  LoopOrEnds mean;
  for (const TaxelHistories* taxel : chosen) {
    const LoopOrEnds own = loop_of(named(taxel->fit, names), taxel->turn);
    if (mean.loop.pressure_psi.empty()) {
      const std::vector<double> none(own.loop.ascending.size(), 0.0);
      mean = {{own.loop.pressure_psi, none, none, own.loop.left_out}, own.no_loop};
    }
    if (own.loop.pressure_psi != mean.loop.pressure_psi) return std::nullopt;
    for (std::size_t i = 0; i < own.loop.ascending.size(); ++i) {
      mean.loop.ascending[i] += own.loop.ascending[i];
      mean.loop.descending[i] += own.loop.descending[i];
    }
  }
  for (std::vector<double>* outputs : {&mean.loop.ascending, &mean.loop.descending})
    for (double& y : *outputs) y /= static_cast<double>(chosen.size());
  return with_patterns(named(means, names), mean);
}

}  // namespace tactbench::analysis
