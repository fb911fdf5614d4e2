#include "bench/simulation/simulated_rig.h"

#include <algorithm>
#include <iterator>

#include "bench/pressure/pressure_kinds.h"

namespace tactbench::bench {

SimulatedRig::SimulatedRig(BenchConfig& config, const devices::Clock& clock, bool free_running)
    : plant_(config.simulation->plant, clock) {
  lines_ = std::make_unique<SimulatedLines>(config, plant_, clock);
  if (free_running) lines_->serve_waveshare(plant_, clock);
  for (const std::string& line : lines_->descriptions()) served_.push_back({"pressure and environment", line});
  // Free-running: of all kinds, on the same plant; whoever writes last drives it.
  const auto serve = [&](const auto& kinds, auto kind, Instrument instrument) {
    const auto chosen = static_cast<std::size_t>(kind);
    const SimulatedWorld world{plant_,
                               plant_,
                               plant_,
                               [this, &clock] { return stall_at(clock.now()); },
                               [this, instrument] { return plant_.injected(instrument); },
                               clock,
                               free_running,
                               sockets_.path()};
    for (std::size_t i = 0; i < kinds.size(); ++i) {
      if (kinds[i].serve == nullptr || (i != chosen && !free_running)) continue;
      const SimulatedEnd& end = ends_.emplace_back(kinds[i].serve(config, world));
      std::ranges::copy(end.served, std::back_inserter(served_));
      if (i != chosen) continue;
      if (end.stage != nullptr) plant_.set_stage(end.stage);
      std::ranges::copy(end.address, std::back_inserter(addresses_));
    }
  };
  serve(pressure_kinds(), config.regulator_kind, Instrument::kController);
  serve(scanner_kinds(), config.scanner.kind, Instrument::kScanner);
  if (config.stage) serve(stage_kinds(), config.stage->kind, Instrument::kStage);
  if (config.force) serve(force_kinds(), config.force->kind, Instrument::kForce);
  for (const Served& served : served_) ephemeral_addresses_.add(served.where);
}

SimulatedRig::~SimulatedRig() { plant_.forget_stage(); }

// Not through the plant, which may hold its lock and ask the stage.
devices::StageStall SimulatedRig::stall_at(devices::Nanoseconds time) const {
  const Faults::Window window = plant_.faults().last(FaultKind::kStageStalled, time);
  devices::StageStall stall{window.from, window.until, std::nullopt};
  if (window.value > 0.0) stall.axis = static_cast<devices::Axis>(std::min(2, static_cast<int>(window.value) - 1));
  return stall;
}

}  // namespace tactbench::bench
