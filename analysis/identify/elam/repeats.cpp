#include "analysis/identify/elam/repeats.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
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
    const SequenceData alike = at_first_pace(sequence);
    const std::size_t count = alike.repeats.size();
    if (count < 3 || taxels.empty()) continue;
    const SequenceData mean = mean_sequence(alike, width, taxels);
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

}  // namespace tactbench::analysis
