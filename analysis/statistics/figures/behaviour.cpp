#include "analysis/statistics/figures/behaviour.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "analysis/loop.h"
#include "analysis/statistics/figures/levels.h"

namespace tactbench::analysis {
namespace {

double mean_at(const std::vector<double>& table, std::size_t row, std::size_t width, const std::vector<int>& taxels) {
  return mean_of_chosen(std::span<const double>(table).subspan(row * width, width), std::span<const int>(taxels));
}

RawLoop finished(RawLoop loop) {
  for (const std::vector<double>* branch : {&loop.up_v, &loop.down_v})
    for (const double v : *branch) loop.full_scale_v = std::max(loop.full_scale_v, std::abs(v));
  for (std::size_t i = 0; i < loop.up_v.size(); ++i) {
    const double distance = std::abs(loop.up_v[i] - loop.down_v[i]) / loop.full_scale_v;
    loop.hysteresis_max = std::max(loop.hysteresis_max, distance);
    loop.hysteresis_mean += distance / static_cast<double>(loop.up_v.size());
  }
  return loop;
}

RawLoop loop_of_taxel(const ExternalLoop& loop, std::size_t width, int taxel) {
  RawLoop own;
  own.taxel = taxel;
  for (std::size_t i = 0; i < loop.pressure_psi.size(); ++i) {
    own.up_v.push_back(loop.ascending[i * width + static_cast<std::size_t>(taxel)]);
    own.down_v.push_back(loop.descending[i * width + static_cast<std::size_t>(taxel)]);
  }
  return finished(own);
}

RawLoop mean_raw_loop(const ExternalLoop& loop, std::size_t width, const std::vector<int>& taxels) {
  RawLoop own;
  own.name = "mean";
  for (std::size_t i = 0; i < loop.pressure_psi.size(); ++i) {
    own.up_v.push_back(mean_at(loop.ascending, i, width, taxels));
    own.down_v.push_back(mean_at(loop.descending, i, width, taxels));
  }
  return finished(own);
}

void gather_loops(Behaviour& b, const ExternalLoop& loop, std::size_t width) {
  b.pressure_psi = loop.pressure_psi;
  b.loops.push_back(mean_raw_loop(loop, width, b.taxels));
  b.full_scale_v = b.loops.front().full_scale_v;
  std::vector<RawLoop> singles;
  for (const int taxel : b.taxels) {
    singles.push_back(loop_of_taxel(loop, width, taxel));
    b.hysteresis_max[static_cast<std::size_t>(taxel)] = singles.back().hysteresis_max;
    b.hysteresis_mean[static_cast<std::size_t>(taxel)] = singles.back().hysteresis_mean;
  }
  std::ranges::stable_sort(singles, {}, &RawLoop::hysteresis_mean);
  const auto keep = [&](std::size_t index, const char* name) {
    b.loops.push_back(singles[index]);
    b.loops.back().name = name;
  };
  keep(0, "best");
  keep((singles.size() - 1) / 2, "median");
  keep(singles.size() - 1, "worst");
}

void gather_gains(Behaviour& b, const ExternalLoop& loop, std::size_t width) {
  const double wanted = loop.pressure_psi.front() + 2.0 / 3.0 * (loop.pressure_psi.back() - loop.pressure_psi.front());
  std::size_t level = 0;
  for (std::size_t i = 0; i < loop.pressure_psi.size(); ++i) {
    if (std::abs(loop.pressure_psi[i] - wanted) < std::abs(loop.pressure_psi[level] - wanted)) level = i;
  }
  b.equilibration_psi = loop.pressure_psi[level];
  const double mean = mean_at(loop.ascending, level, width, b.taxels);
  for (const int taxel : b.taxels) {
    const auto t = static_cast<std::size_t>(taxel);
    b.gain[t] = loop.ascending[level * width + t] / mean;
  }
}

}  // namespace

std::optional<ExternalLoop> loop_of(const Dataset& dataset, const RepeatOptions& options) {
  std::vector<TaxelTable> sequences;
  for (const SequenceData& data : dataset.sequences) {
    if (options.last_repeat >= static_cast<int>(data.repeats.size())) continue;
    try {
      sequences.push_back(average_repeats(data, dataset.taxels(), options));
    } catch (const AnalysisError& error) {
      if (error.id() != "TB-ANALYSIS-NO-LOOP") throw;  // a sequence at one level has no part in a loop
    }
  }
  try {
    return external_loop(sequences, dataset.taxels());
  } catch (const AnalysisError& error) {
    if (error.id() != "TB-ANALYSIS-NO-LOOP") throw;
    return std::nullopt;
  }
}

namespace {

void gather_repeatability(Behaviour& b, const Dataset& dataset, std::size_t width) {
  std::size_t most = 0;
  for (const SequenceData& data : dataset.sequences) most = std::max(most, data.repeats.size());
  std::vector<ExternalLoop> loops;
  for (int r = 0; r < static_cast<int>(most); ++r) {
    std::optional<ExternalLoop> loop =
        loop_of(dataset, {.move_to_setpoint = true, .first_repeat = r, .last_repeat = r});
    if (loop && loop->pressure_psi == b.pressure_psi) loops.push_back(std::move(*loop));
  }
  b.repeats = static_cast<int>(loops.size());
  if (loops.size() < 2) return;
  for (std::size_t level = 0; level < b.pressure_psi.size(); ++level) {
    const auto figures = [&](std::vector<double> ExternalLoop::*branch) {
      std::vector<double> mean, own;
      for (const ExternalLoop& loop : loops) mean.push_back(mean_at(loop.*branch, level, width, b.taxels));
      double sum = 0.0;
      for (const int taxel : b.taxels) {
        own.clear();
        for (const ExternalLoop& loop : loops)
          own.push_back((loop.*branch)[level * width + static_cast<std::size_t>(taxel)]);
        sum += sample_variance(own);
      }
      return std::pair(std::sqrt(sample_variance(mean)), std::sqrt(sum / static_cast<double>(b.taxels.size())));
    };
    const auto [mean_up, taxel_up] = figures(&ExternalLoop::ascending);
    const auto [mean_down, taxel_down] = figures(&ExternalLoop::descending);
    b.repeatability.push_back({b.pressure_psi[level], mean_up, mean_down, taxel_up, taxel_down});
  }
}

std::optional<ZeroReturn> zero_return_of(const SequenceData& data, std::size_t width, const std::vector<int>& taxels) {
  const std::vector<Sample>& steps = data.repeats.front().steps;
  const double lowest = std::ranges::min_element(steps, {}, &Sample::setpoint_psi)->setpoint_psi;
  std::size_t first = steps.size(), last = 0;
  bool away = false;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i].setpoint_psi != lowest) away = away || first < steps.size();
    if (steps[i].setpoint_psi != lowest) continue;
    first = std::min(first, i);
    if (away) last = i;
  }
  if (last == 0) return std::nullopt;
  ZeroReturn result;
  result.sequence = data.name;
  result.repeats = static_cast<int>(data.repeats.size());
  std::vector<double> shift(width, 0.0);
  for (const Repeat& repeat : data.repeats) {
    double mean = 0.0;
    for (const int taxel : taxels) {
      const auto t = static_cast<std::size_t>(taxel);
      const double own = repeat.volts[last * width + t] - repeat.volts[first * width + t];
      shift[t] += own / result.repeats;
      mean += own / static_cast<double>(taxels.size());
    }
    result.mean_v += mean / result.repeats;
    if (std::abs(mean) > std::abs(result.largest_v)) result.largest_v = mean;
  }
  for (const int taxel : taxels) {
    const double own = shift[static_cast<std::size_t>(taxel)];
    if (result.worst_taxel >= 0 && std::abs(own) <= std::abs(result.worst_taxel_v)) continue;
    result.worst_taxel = taxel;
    result.worst_taxel_v = own;
  }
  return result;
}

void gather_traces(Behaviour& b, const Dataset& dataset, std::size_t width) {
  for (const SequenceData& data : dataset.sequences) {
    RawTrace trace{data.name, {}, {}};
    const auto repeats = static_cast<double>(data.repeats.size());
    for (std::size_t i = 0; i < data.repeats.front().steps.size(); ++i) {
      double pressure = 0.0, output = 0.0;
      for (const Repeat& repeat : data.repeats) {
        pressure += repeat.steps[i].reference_psi / repeats;
        output += mean_at(repeat.volts, i, width, b.taxels) / repeats;
      }
      trace.pressure_psi.push_back(pressure);
      trace.output_v.push_back(output);
    }
    b.traces.push_back(std::move(trace));
  }
}

}  // namespace

Behaviour behaviour_of(const Dataset& dataset, const std::vector<int>& taxels) {
  if (taxels.empty()) throw std::invalid_argument("behaviour_of: no taxel counts");
  const auto width = static_cast<std::size_t>(dataset.taxels());
  Behaviour b;
  b.taxels = taxels;
  b.hysteresis_max.assign(width, kNan);
  b.hysteresis_mean = b.gain = b.hysteresis_max;
  b.equilibration_psi = kNan;
  gather_traces(b, dataset, width);
  b.creep = creep_of(dataset, taxels);
  for (const SequenceData& data : dataset.sequences) {
    if (const auto zero = zero_return_of(data, width, taxels)) b.zero_returns.push_back(*zero);
  }
  const std::optional<ExternalLoop> loop = loop_of(dataset, {});
  if (!loop) return b;
  gather_loops(b, *loop, width);
  gather_gains(b, *loop, width);
  gather_repeatability(b, dataset, width);
  return b;
}

}  // namespace tactbench::analysis
