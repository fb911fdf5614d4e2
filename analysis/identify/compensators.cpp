#include "analysis/identify/compensators.h"

#include <fmt/format.h>

#include <stdexcept>

#include "analysis/compensate/document.h"
#include "analysis/error.h"

namespace tactbench::analysis {
namespace {

std::unique_ptr<Compensator> make(const SensorModel& model, const ModelTaxel& taxel, bool falls, double noisier,
                                  const std::shared_ptr<PassedTime>& time) {
  CompensatorSetup setup;
  const double sign = falls ? -1.0 : 1.0;
  setup.zero = sign * taxel.zero;
  setup.gain = sign * taxel.gain;
  setup.noise = noisier * taxel.noise;
  setup.highest = taxel.loop_low + taxel.fit.full_scale;
  if (model.dynamics && taxel.fitted()) {
    setup.time = time;
    setup.creep_scale = taxel.creep_scale;
    setup.lag_share = taxel.lag_share;
    setup.residual = model.dynamics->residual_shape;
    for (double& left : setup.residual) left *= taxel.residual_psi;
    setup.options.top_share = kTopShare;
  } else {
    setup.residual = residual_by_level(taxel.ascending, taxel.descending, taxel.residual_psi);
  }
  try {
    return make_compensator(*taxel.fit.model, setup);
  } catch (const std::invalid_argument& error) {
    throw AnalysisError("TB-MODEL-COMPENSATOR",
                        fmt::format("{}, taxel {}: {}", model.source, taxel.taxel, error.what()),
                        "check its parameters (tactbench model show), or fit it again");
  }
}

std::shared_ptr<PassedTime> time_of(const SensorModel& model) {
  auto time = std::make_shared<PassedTime>();
  if (model.dynamics) time->dynamics = model.dynamics->shared;
  return time;
}

}  // namespace

std::unique_ptr<Compensator> compensator_of(const SensorModel& model, const ModelTaxel& taxel, double noisier) {
  return make(model, taxel, false, noisier, time_of(model));
}

FrameCompensator frames_of(const SensorModel& model, double noisier, int max_gap) {
  if (model.array().size() != static_cast<std::size_t>(model.rows) * static_cast<std::size_t>(model.columns))
    throw AnalysisError(
        "TB-MODEL-COMPENSATOR",
        fmt::format("{} of {} cannot compensate frames: it is not of a whole array", model.model, model.source),
        "fit a run of the array: tactbench fit RUN");
  FrameCompensator::Setup setup;
  setup.max_gap = max_gap;
  setup.in_time = model.dynamics && undoes(model.dynamics->shared);
  setup.x_low = model.pressure_psi.front();
  setup.x_high = model.pressure_psi.back();
  const auto time = time_of(model);
  for (const ModelTaxel& taxel : model.array())
    setup.taxels.push_back(taxel.fitted() ? make(model, taxel, model.falling, noisier, time) : nullptr);
  FrameCompensator frames(std::move(setup));
  frames.start(Start::kUnknown);
  return frames;
}

}  // namespace tactbench::analysis
