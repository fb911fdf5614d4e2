#include "analysis/identify/dynamic/track.h"

#include <algorithm>

namespace tactbench::analysis {

Track track_of(const Dataset& data) {
  Track track;
  const auto width = static_cast<std::size_t>(data.taxels());
  for (std::size_t s = 0; s < data.sequences.size(); ++s)
    for (std::size_t r = 0; r < data.sequences[s].repeats.size(); ++r) {
      const Repeat& repeat = data.sequences[s].repeats[r];
      for (std::size_t i = 0; i < repeat.steps.size(); ++i) {
        track.time.push_back(repeat.steps[i].time_s);
        track.pressure.push_back(repeat.steps[i].reference_psi);
        track.samples.push_back(&repeat.steps[i]);
        track.span = std::max(track.span, repeat.steps[i].setpoint_psi);
        track.volts.push_back(&repeat.volts[i * width]);
        track.sequence.push_back(s);
        track.repeat.push_back(r);
        track.step.push_back(i);
      }
    }
  return track;
}

DynamicsStep next_step(const Dynamics& d, DynamicsState& state, const Sample& sample, double before, double span) {
  const TimePassed passed = time_passed(sample, before);
  if (passed.worked_s > 0.0) work_unseen(d, state, passed.worked_s, span);
  return {d, passed.step_s};
}

std::vector<std::array<double, kCreepElements>> walk_creep(const Track& track, const Dynamics& d) {
  std::vector<std::array<double, kCreepElements>> psi;
  DynamicsState state;
  for (std::size_t i = 0; i < track.time.size(); ++i) {
    const DynamicsStep step = next_step(d, state, *track.samples[i], i == 0 ? -1.0 : track.time[i - 1], track.span);
    advance(d, state, step, track.pressure[i]);
    psi.push_back(state.psi);
  }
  return psi;
}

}  // namespace tactbench::analysis
