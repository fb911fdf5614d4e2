// Creep at held levels: the slope of the output over the logarithm of time.
#include <algorithm>
#include <cmath>

#include "analysis/statistics/behaviour.h"
#include "analysis/statistics/creep_effect.h"

namespace tactbench::analysis {
namespace {

struct Held {
  double time_s = 0.0;  // since the command
  double output_v = 0.0;
};

Creep line_through(const std::vector<Held>& held) {
  Creep creep;
  const auto n = static_cast<double>(held.size());
  double mean_x = 0.0, mean_y = 0.0;
  for (const Held& h : held) {
    mean_x += std::log10(h.time_s) / n;
    mean_y += h.output_v / n;
  }
  double xx = 0.0, xy = 0.0, rest = 0.0;
  for (const Held& h : held) {
    const double dx = std::log10(h.time_s) - mean_x;
    xx += dx * dx;
    xy += dx * (h.output_v - mean_y);
  }
  const double slope = xy / xx;
  for (const Held& h : held) {
    const double off = h.output_v - mean_y - slope * (std::log10(h.time_s) - mean_x);
    rest += off * off;
  }
  creep.from_s = held.front().time_s;
  creep.to_s = held.back().time_s;
  creep.first_v = held.front().output_v;
  creep.last_v = held.back().output_v;
  creep.per_decade = slope / creep.first_v;
  creep.per_decade_u = std::sqrt(rest / (n - 2.0) / xx) / std::abs(creep.first_v);
  creep.samples = static_cast<int>(held.size());
  return creep;
}

}  // namespace

std::vector<HeldFrames> held_frames_of(const Dataset& dataset, std::size_t fewest_frames) {
  std::vector<HeldFrames> holds;
  for (std::size_t s = 0; s < dataset.sequences.size(); ++s) {
    const std::vector<Repeat>& repeats = dataset.sequences[s].repeats;
    for (std::size_t r = 0; r < repeats.size(); ++r) {
      const std::vector<Sample>& steps = repeats[r].steps;
      for (std::size_t first = 0; first < steps.size();) {
        std::size_t end = first + 1;
        while (end < steps.size() && steps[end].setpoint_psi == steps[first].setpoint_psi) ++end;
        const bool rose = first == 0 || steps[first - 1].setpoint_psi < steps[first].setpoint_psi;
        if (end - first >= fewest_frames && steps[first].setpoint_psi > kHeldAbovePsi && steps[first].held_s > 0.0 &&
            steps[end - 1].time_s > steps[first].time_s)
          holds.push_back({s, r, first, end, rose});
        first = end;
      }
    }
  }
  return holds;
}

std::vector<Creep> creep_of(const Dataset& dataset, const std::vector<int>& taxels) {
  const auto width = static_cast<std::size_t>(dataset.taxels());
  std::vector<Creep> found;
  for (const HeldFrames& hold : held_frames_of(dataset)) {
    const SequenceData& data = dataset.sequences[hold.sequence];
    const Repeat& repeat = data.repeats[hold.repeat];
    std::vector<Held> held;
    for (std::size_t i = hold.first; i < hold.end; ++i) {
      double output = 0.0;
      for (const int taxel : taxels) output += repeat.volts[i * width + static_cast<std::size_t>(taxel)];
      held.push_back({hold.held_s(repeat, i), output / static_cast<double>(taxels.size())});
    }
    if (held.front().output_v == 0.0) continue;
    found.push_back(line_through(held));
    found.back().run = dataset.run;
    found.back().sequence = data.name;
    found.back().pressure_psi = repeat.steps[hold.first].setpoint_psi;
    found.back().up = hold.rose;
  }
  return found;
}

}  // namespace tactbench::analysis
