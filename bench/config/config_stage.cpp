#include <fmt/format.h>

#include <array>

#include "bench/config/config_calibration.h"
#include "bench/config/instrument_kinds.h"
#include "devices/stage/simulated_chain.h"
#include "devices/stage/zaber_retreat.h"

namespace tactbench::bench {

using sequences::Key;
using sequences::KeyTable;
using sequences::kMilliseconds;
using sequences::kOne;
using sequences::TomlTable;
namespace key = sequences::key;

namespace {

constexpr std::array<const char*, 3> kAxisNames = {"x", "y", "z"};

KeyTable axis_keys(devices::ZaberAxisOptions& axis) {
  return {key::number("device", axis.device, kOne, {1, 254}, "Number of the axis on the chain"),
          key::number("device_id", axis.device_id, kOne, {1, 99999},
                      "Model, by Zaber's number: 60 is the T-LA60A, 5082 the T-NA08A50; any other is refused"),
          key::number("low_mm", axis.low, {"mm"}, {0.0, 1000.0}, "Lowest position to which the axis is sent")};
}

KeyTable travel_keys(devices::ZaberAxisOptions& axis, const devices::ZaberModel& model) {
  axis.high = model.travel;
  axis.maximum_speed = model.maximum_speed;
  return {
      key::number("high_mm", axis.high, {"mm"}, {axis.low.value(), 1000.0},
                  "Highest position to which the axis is sent, not below low_mm"),
      key::number("maximum_speed_mm_per_s", axis.maximum_speed, {"mm/s"}, {0.001, 30.0},
                  "Highest speed, also used for moves without a speed"),
      key::number("home_timeout_s", axis.home_timeout, {"s"}, {1.0, 600.0}, "Longest time that homing may take"),
      key::text("serial", axis.serial, "Serial number, stored with each run that presses; the axis cannot report it")};
}

void read_axis(const TomlTable& table, devices::ZaberAxisOptions& axis) {
  read_keys(table, axis_keys(axis));
  const devices::ZaberModel* model = devices::zaber_model(axis.device_id);
  if (model == nullptr) {
    table.fail("device_id", fmt::format("{} is not a device id that tactbench knows", axis.device_id),
               "5082 is the T-NA08A50, 60 the T-LA60A; for other models add their step size");
  }
  axis.model = "Zaber " + std::string(model->name);
  read_whole(table, travel_keys(axis, *model));
}

// x and y T-LA60A, z T-NA08A50.
StageConfig usual_stage() {
  StageConfig stage;
  stage.options.axes[1].device = 2;
  stage.options.axes[2].device = 3;
  stage.options.axes[2].device_id = 5082;
  return stage;
}

KeyTable stage_keys(StageConfig& stage, bool found_otherwise) {
  const Key port = key::text("port", stage.address.port,
                             "Serial line of the Zaber chain: a device, preferably a name in /dev/serial/by-id");
  return {
      found_otherwise ? port : key::required(port),
      key::text("usb_serial", stage.address.usb_serial,
                "Serial number of the USB adapter; finds the line instead of port, or checks it"),
      key::flag("renumber", stage.options.renumber, "Number the devices 1, 2, 3 from the computer's end on before use"),
      key::flag("knob_off", stage.options.knob_off, "Switch the manual knobs off while a run uses the stage"),
      key::number("reply_timeout_ms", stage.options.reply_timeout, kMilliseconds, {20.0, 10000.0},
                  "Longest time to wait for an answer"),
      key::number("poll_interval_ms", stage.options.poll_interval, kMilliseconds, {20.0, 1000.0},
                  "Time between two queries of the position during a move")};
}

KeyTable stage_stated_keys(StatedCalibration& stated) {
  return stated_keys(stated, "expanded_uncertainty_mm", {"mm"},
                     "Number of the stage's calibration certificate; \"\": none",
                     "Expanded uncertainty U of a position (k = 2)");
}

SimulatedEnd serve_chain(BenchConfig& config, const SimulatedWorld& world) {
  StageConfig& stage = *config.stage;
  devices::SimulatedChainOptions options;
  options.free_running = world.free_running;
  options.devices.resize(devices::kAxes);
  for (std::size_t axis = 0; axis < devices::kAxes; ++axis) {
    options.devices[axis].device_id = stage.options.axes[axis].device_id;
    options.devices[axis].number = stage.options.axes[axis].device;
  }
  devices::SimulatedChainFaults faults;
  faults.inject = world.inject;
  faults.stall = world.stall;
  auto chain = std::make_shared<devices::SimulatedChain>(options, world.clock, faults);
  const std::string port = chain->address();
  stage.address = {};
  stage.address.port = port;
  return {chain, {{"stage, Zaber binary chain (firmware 5)", port}}, {{"stage.port", port}}, chain.get()};
}

std::unique_ptr<devices::Stage> make_chain(const devices::StageOptions& stage, StageRow::OpenLine open_line,
                                           devices::Clock& clock) {
  return std::make_unique<devices::ZaberStage>(std::move(open_line), stage.options, clock);
}

devices::StageRetreat retreat_chain(std::unique_ptr<devices::ByteStream> line, const devices::StageOptions& stage,
                                    devices::Millimetres back_off, devices::Nanoseconds move_timeout) {
  return devices::retreat(std::move(line), stage.options, back_off, move_timeout);
}

constexpr std::array kStages{StageRow{serve_chain, make_chain, retreat_chain}};

}  // namespace

std::span<const StageRow> stage_kinds() { return kStages; }

void read_stage(const TomlTable& table, BenchConfig& config) {
  StageConfig& stage = config.stage.emplace(usual_stage());
  read_keys(table, stage_keys(stage, config.in_process || table.has("usb_serial")));
  stage.options.origin = config.origin;
  read_keys(table, stage_stated_keys(stage.stated));
  check_dates(table, stage.stated);
  for (std::size_t i = 0; i < kAxisNames.size(); ++i) read_axis(table.table(kAxisNames[i]), stage.options.axes[i]);
  table.finish();
}

void add_stage_keys(std::vector<sequences::KeyFacts>& all) {
  StageConfig stage = usual_stage();
  add_facts(all, "stage", stage_keys(stage, true));
  add_facts(all, "stage", stage_stated_keys(stage.stated));
  for (std::size_t i = 0; i < kAxisNames.size(); ++i) {
    devices::ZaberAxisOptions& axis = stage.options.axes[i];
    const std::string path = std::string("stage.") + kAxisNames[i];
    add_facts(all, path, axis_keys(axis));
    add_facts(all, path, travel_keys(axis, *devices::zaber_model(axis.device_id)));
  }
}

}  // namespace tactbench::bench
