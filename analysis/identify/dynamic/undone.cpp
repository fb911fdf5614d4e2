#include "analysis/identify/dynamic/undone.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "analysis/error.h"
#include "analysis/identify/dynamic/dynamic_alone.h"
#include "analysis/identify/dynamic/track.h"

namespace tactbench::analysis {
namespace {

void check_times(const SensorModel& model, const Histories& histories) {
  for (const TaxelHistories& taxel : histories.taxels)
    for (const History& history : taxel.score)
      if (history.time_s.size() != history.x.size())
        throw AnalysisError("TB-MODEL-DYNAMIC",
                            fmt::format("{} tells no times, and without them the dynamic model of {} cannot undo lag "
                                        "and creep",
                                        histories.source, model.source),
                            "give a run, or a table with a column time_s in seconds");
}

void undo(const Dynamics& d, const ModelTaxel& taxel, bool run, std::vector<History>& histories) {
  const HysteresisModel& film = *taxel.fit.model;
  const double x_low = film.x_low(), span = film.x_high() - x_low;
  const double zero = taxel.from_model(film.state()->output_at(x_low));
  DynamicsState state;
  double before = -1.0;
  for (History& history : histories) {
    if (!run) {
      state = {};
      before = -1.0;
    }
    for (std::size_t i = 0; i < history.x.size(); ++i) {
      const double time = history.time_s[i], pressure = history.x[i] - x_low;
      const DynamicsStep step = run ? next_step(d, state, {0.0, 0.0, time, history.held_s[i]}, before, span)
                                    : DynamicsStep(d, before < 0.0 ? 0.0 : std::max(time - before, 0.0));
      const double factor = creep_factor(d, state, step, pressure, taxel.creep_scale);
      history.y[i] = zero + (history.y[i] - zero) / factor;
      history.x[i] = x_low + arrived(taxel.lag_share, state, step, pressure);
      advance(d, state, step, pressure);
      before = time;
    }
  }
}

}  // namespace

Histories creep_and_lag_undone(const SensorModel& model, Histories histories) {
  if (!in_time(*model.dynamics)) return histories;
  check_times(model, histories);
  for (TaxelHistories& taxel : histories.taxels) {
    const auto own = std::ranges::find(model.taxels, taxel.taxel, &ModelTaxel::taxel);
    if (own == model.taxels.end() || !own->fitted()) continue;
    undo(model.dynamics->shared, *own, histories.run != 0, taxel.score);
  }
  return histories;
}

}  // namespace tactbench::analysis
