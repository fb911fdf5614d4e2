#include "bench/simulation/simulated_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "bench/config/config_modbus.h"
#include "bench/config/config_profile.h"
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

using devices::ModbusEndpoint;
using devices::SimulatedUnit;

namespace {

struct Line {
  std::vector<SimulatedUnit> units;
  std::vector<ModbusEndpoint*> endpoints;

  SimulatedUnit& unit(ModbusEndpoint& endpoint) {
    if (std::find(endpoints.begin(), endpoints.end(), &endpoint) == endpoints.end()) endpoints.push_back(&endpoint);
    const auto known =
        std::find_if(units.begin(), units.end(), [&](const auto& each) { return each.unit == endpoint.unit; });
    if (known != units.end()) return *known;
    units.push_back({endpoint.unit, {}, {}});
    return units.back();
  }
};

void wire_module(SimulatedUnit& unit, const ModuleConfig& module, const BenchConfig& config) {
  unit.profile = module.profile;
  unit.output_channel = config.regulator.output_channel;
  unit.feedback_channel = config.regulator.feedback_channel;
  unit.reference_channel = config.reference.channel;
}

}  // namespace

SimulatedLines::SimulatedLines(BenchConfig& config, Plant& plant, const devices::Clock& clock) {
  Line shared;
  if (config.module.present()) wire_module(shared.unit(config.module.endpoint), config.module, config);
  std::vector<Line> others;
  const auto line_of = [&](bool own) -> Line& { return own ? others.emplace_back() : shared; };
  if (config.input_module) {
    ModuleConfig& inputs = *config.input_module;
    wire_module(line_of(!inputs.same_line).unit(inputs.endpoint), inputs, config);
  }
  if (config.reference_gauge) {
    GaugeConfig& gauge = *config.reference_gauge;
    line_of(gauge.own_line).unit(gauge.endpoint).quantities.push_back({gauge.quantity, [&plant] {
                                                                         return plant.reference_pressure().value();
                                                                       }});
  }
  for (EnvironmentSensor& sensor : config.environment) {
    const bool temperature = sensor.quantity == "temperature_c";
    line_of(sensor.own_line).unit(sensor.endpoint).quantities.push_back({sensor.place, [&plant, temperature] {
                                                                           return temperature ? plant.temperature_c()
                                                                                              : plant.supply_bar();
                                                                         }});
  }
  devices::SimulatedModuleFaults faults = config.simulation->module_faults;
  faults.inject = [&plant] { return plant.injected(Instrument::kModule); };
  if (!shared.units.empty()) serve(std::move(shared.units), shared.endpoints, plant, clock, faults);
  for (Line& line : others) serve(std::move(line.units), line.endpoints, plant, clock, {});
}

void SimulatedLines::serve_waveshare(Plant& plant, const devices::Clock& clock) {
  SimulatedUnit output, input;
  output.unit = 1;
  output.profile = read_module_profile("waveshare-analog-output-8ch-b");
  input.unit = 2;
  input.profile = read_module_profile("waveshare-analog-input-8ch-b");
  ModbusEndpoint endpoint;
  endpoint.serial_port = kSimulatedLine;
  serve({output, input}, {&endpoint}, plant, clock, {});
}

void SimulatedLines::serve(std::vector<SimulatedUnit> units, const std::vector<ModbusEndpoint*>& endpoints,
                           Plant& plant, const devices::Clock& clock, const devices::SimulatedModuleFaults& faults) {
  const ModbusEndpoint& first = *endpoints.front();
  const bool rtu = !first.serial_port.empty();
  std::string models;
  for (const SimulatedUnit& unit : units) {
    models += fmt::format("{}unit {}: {}{}", models.empty() ? "" : "; ", unit.unit, unit.profile.model,
                          unit.quantities.empty() ? "" : fmt::format(" (+{} quantities)", unit.quantities.size()));
  }
  // A bus coupler alone on its connection answers whatever unit it is asked for.
  if (!rtu && units.size() == 1) units.front().unit = 0;
  auto server = std::make_unique<devices::SimulatedModule>(
      std::move(units), rtu ? devices::SimulatedModule::Wire::kRtu : devices::SimulatedModule::Wire::kTcp, first.port,
      plant, clock, faults);
  for (ModbusEndpoint* endpoint : endpoints) {
    if (rtu) {
      endpoint->serial_port = server->serial_port();
    } else {
      endpoint->host = "127.0.0.1";
      endpoint->port = server->port();
    }
  }
  descriptions_.push_back(rtu ? fmt::format("Modbus RTU {}, {}", first.serial_port, models)
                              : fmt::format("Modbus TCP 127.0.0.1:{}, {}", first.port, models));
  servers_.push_back(std::move(server));
}

}  // namespace tactbench::bench
