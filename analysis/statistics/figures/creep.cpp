// Creep at held levels: the slope of the output over the logarithm of time.
#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "analysis/statistics/figures/behaviour.h"
#include "analysis/statistics/figures/creep_effect.h"
#include "analysis/statistics/numbers/moments.h"

namespace tactbench::analysis {
namespace {

Creep line_through(const std::vector<double>& held_s, const std::vector<double>& output_v) {
  std::vector<double> decades;
  for (const double time : held_s) decades.push_back(std::log10(time));
  const LineFit line = line_fit_by_shares(decades, output_v);
  const double rest = squares_off(line, decades, output_v);
  Creep creep;
  creep.from_s = held_s.front();
  creep.to_s = held_s.back();
  creep.first_v = output_v.front();
  creep.last_v = output_v.back();
  creep.per_decade = line.slope() / creep.first_v;
  creep.per_decade_u = std::sqrt(rest / (static_cast<double>(held_s.size()) - 2.0) / line.xx) / std::abs(creep.first_v);
  creep.samples = static_cast<int>(held_s.size());
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
    std::vector<double> held_s, output_v;
    for (std::size_t i = hold.first; i < hold.end; ++i) {
      held_s.push_back(hold.held_s(repeat, i));  // since the command
      output_v.push_back(mean_of_chosen(std::span<const double>(repeat.volts).subspan(i * width, width),
                                        std::span<const int>(taxels)));
    }
    if (output_v.front() == 0.0) continue;
    found.push_back(line_through(held_s, output_v));
    found.back().run = dataset.run;
    found.back().sequence = data.name;
    found.back().pressure_psi = repeat.steps[hold.first].setpoint_psi;
    found.back().up = hold.rose;
  }
  return found;
}

}  // namespace tactbench::analysis
