// The dynamic model of an array, of three runs and of one alone: all that it holds, in sums, as it was when recorded.
#include <algorithm>

#include "analysis/identify/dynamic/dynamic_alone.h"
#include "analysis/models/linearised.h"
#include "analysis/models/model.h"
#include "tests/analysis/compensate/recorded_streams.h"
#include "tests/analysis/support/dynamic_runs.h"

using namespace synthetic;

namespace {

recorded::Summed held_by(const SensorModel& model) {
  recorded::Summed summed(100000);
  const Dynamics& shared = model.dynamics->shared;
  for (std::size_t j = 0; j < kCreepElements; ++j) summed.add(shared.creep_s[j], 100.0 * shared.creep_share[j], 0);
  summed.add(shared.creep_half, shared.lag_s, 0);
  summed.add(10.0 * shared.lag_share, 0.0, static_cast<int>(model.dynamics->rate.run + 10 * model.dynamics->creep.run));
  for (const double value : model.dynamics->residual_shape) summed.add(value, 0.0, 0);
  summed.add(model.validity.hold_s->low, model.validity.hold_s->high, 0);
  summed.add(model.validity.rate->low, model.validity.rate->high, 0);
  for (const ModelTaxel& taxel : model.taxels) {
    summed.add(taxel.creep_scale, 10.0 * taxel.lag_share, taxel.fitted() ? 1 : 0);
    summed.add(10.0 * taxel.residual_psi, 10.0 * taxel.fit.j, taxel.fit.samples);
    if (!taxel.fitted()) continue;
    summed.add(linearised_of(taxel)->divider().per_amplitude, linearised_of(taxel)->divider().zero, 0);
    for (const double y : predict(*taxel.fit.model, std::vector<double>{0, 20, 60, 35, 50, 10, 0}))
      summed.add(y, 0.0, 0);
  }
  for (const RepeatDrift& drift : model.repeats)
    summed.add(100.0 * drift.shift_v, 100.0 * drift.rms_v, drift.differs ? 1 : 0);
  return summed;
}

}  // namespace

TEST_CASE("recorded: a dynamic model of three runs and of one holds what it held when recorded", "[dynamic]") {
  const Runs runs = runs_of(dynamic_array(synthetic::kTaxels, 0.0005));
  DynamicFitOptions options;
  options.cells = 8;
  options.threads = 1;
  std::string lines;
  const std::vector<recorded::Sums> was{{703.4248477, 538.6245416, 148880}, {711.7599873, 13.8947448, 148720}};
  std::vector<recorded::Summed> now{held_by(fit_dynamic(runs.fitted, runs.rate, runs.creep, options))};
  options.by_input = false;
  now.push_back(held_by(fit_dynamic_alone(runs.fitted, options)));
  for (std::size_t i = 0; i < now.size(); ++i)
    recorded::check_sums(i == 0 ? "three runs" : "one", now[i], std::span(was).subspan(std::min(i, was.size())), lines,
                         1e-4);
  INFO("now:\n" << lines);
  CHECK(was.size() == now.size());
}
