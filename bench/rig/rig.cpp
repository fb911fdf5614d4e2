#include "bench/rig/rig.h"

#include <stdexcept>

#include "bench/common/process_time.h"
#include "bench/config/config_calibration.h"
#include "bench/pressure/pressure_kinds.h"
#include "bench/simulation/simulated_rig.h"
#include "devices/device.h"
#include "devices/pressure/analog_module.h"
#include "devices/pressure/pressure_reference.h"
#include "devices/wire/byte_stream.h"
#include "devices/wire/modbus/modbus_link.h"

namespace tactbench::bench {

namespace {

constexpr double kFeedSlice = 0.1;                                   // seconds between two feedings in a wait
constexpr devices::Nanoseconds kOpening = std::chrono::seconds(10);  // an instrument is opened within

}  // namespace

Rig::Rig(const BenchConfig& config) : config_(config) {
  refuse_placeholders(config_);
  if (config_.in_process) {
    own_clock_ = std::make_unique<devices::ManualClock>();
    simulated_ = std::make_unique<SimulatedRig>(config_, *own_clock_, false);
  } else {
    own_clock_ = std::make_unique<devices::SteadyClock>(config_.rate);
    if (config_.dead_man.enabled) share_lines(config_, false);
  }
  make_guard();
  make_pressure();
  if (config_.stage) {
    const auto open_line = [this, address = config_.stage->address] {
      return dead_man_ ? dead_man_->open_line() : devices::open_serial(address);
    };
    stage_ = row_of(stage_kinds(), config_.stage->kind).make(*config_.stage, open_line, *clock_);
    stage_gate_ = std::make_unique<GuardedStage>(*stage_, *guard_, [this] { prepare_arming(); });
  }
  guard_->set_actuators(&source_->inner(), stage_.get());
}

void Rig::make_guard() {
  guard_ = std::make_unique<Guard>(guard_limits(config_), *own_clock_);
  clock_ = std::make_unique<FeedingClock>(*own_clock_, seconds(kFeedSlice * (config_.in_process ? 1.0 : config_.rate)),
                                          [this] { guard_->feed(); });
  if (config_.in_process) {
    const DeadManConfig& times = config_.dead_man;
    watcher_ = std::make_unique<ProcessTimeWatcher>(seconds(times.timeout_s + times.progress_s), *own_clock_);
    guard_->set_watcher(watcher_.get());
  } else {
    // A dead-man that fired stores its own trip with more detail; a lost dead-man says nothing about the rig.
    guard_->set_trip_sink([this](const Trip& trip) {
      if (!trip.id.starts_with("TB-DEADMAN-")) (void)TripFile(config_.id).store(trip);
    });
  }
}

// Before anything is armed.
void Rig::prepare_arming() {
  refuse_tripped(config_);
  if (config_.in_process || !config_.dead_man.enabled || dead_man_) return;
  look();  // reports a missing module as such, not as a dead-man that does not start
  dead_man_ = std::make_unique<DeadManProcess>(config_);
  guard_->set_watcher(dead_man_.get());
}

void Rig::dismiss_dead_man() {
  if (dead_man_) dead_man_->goodbye();
}

std::pair<devices::Identity, std::vector<std::uint16_t>> Rig::inspect_module() {
  if (!module_) throw std::logic_error("Rig::inspect_module() without [module]");
  return {module_->identity(), module_->read_all()};
}

void Rig::look() {
  if (module_) (void)module_->read_all();
  if (input_module_) (void)input_module_->read_all();
  (void)source_->inner().feedback();
}

void Rig::make_pressure() {
  if (config_.module.present()) {
    module_ = std::make_unique<devices::AnalogModule>(config_.module.profile, config_.module.endpoint,
                                                      seconds(config_.watchdog_s), *clock_, config_.origin);
  }
  if (config_.input_module) {
    const ModuleConfig& inputs = *config_.input_module;
    input_module_ = inputs.same_line
                        ? std::make_unique<devices::AnalogModule>(inputs.profile, *module_, inputs.endpoint.unit,
                                                                  *clock_, config_.origin)
                        : std::make_unique<devices::AnalogModule>(inputs.profile, inputs.endpoint,
                                                                  devices::Nanoseconds(0), *clock_, config_.origin);
  }
  devices::AnalogModule* const inputs = input_module_ ? input_module_.get() : module_.get();
  source_ = std::make_unique<GuardedSource>(pressure_kind(config_).make(config_, module_.get(), inputs, *clock_),
                                            *guard_, [this] { prepare_arming(); });
  if (config_.reference_gauge) {
    const GaugeConfig& gauge = *config_.reference_gauge;
    const devices::TransducerOptions& named = config_.reference;
    auto made = std::make_unique<devices::ModbusGauge>(
        link_to(gauge.endpoint, gauge.own_line, "pressure gauge"),
        devices::GaugeOptions{named.model, named.serial, gauge.quantity, named.origin}, *clock_);
    gauge_ = made.get();
    reference_ = std::move(made);
  } else if (config_.reference_independent) {
    reference_ = std::make_unique<devices::ModuleTransducer>(*inputs, config_.reference);
  } else {
    reference_ = std::make_unique<devices::FeedbackReference>(source_->inner(), config_.reference);
  }
  if (!config_.reference_correction.empty()) {
    reference_ = std::make_unique<devices::CorrectedReference>(std::move(reference_), config_.reference_correction);
  }
  reference_ = std::make_unique<GuardedReference>(std::move(reference_), *guard_);
  for (const EnvironmentSensor& sensor : config_.environment) {
    environment_.push_back(link_to(sensor.endpoint, sensor.own_line, sensor.quantity + " sensor"));
  }
}

// A link of its own, or one to another unit on the module's line.
std::unique_ptr<devices::ModbusLink> Rig::link_to(const devices::ModbusEndpoint& endpoint, bool own_line,
                                                  const std::string& device) {
  return own_line ? std::make_unique<devices::ModbusLink>(endpoint, device, *clock_)
                  : std::make_unique<devices::ModbusLink>(module_->link(), endpoint.unit, device);
}

std::vector<EnvironmentReading> Rig::environment() {
  std::vector<EnvironmentReading> readings;
  for (std::size_t i = 0; i < environment_.size(); ++i) readings.push_back(environment(i));
  return readings;
}

EnvironmentReading Rig::environment(std::size_t sensor) {
  const EnvironmentSensor& place = config_.environment.at(sensor);
  return {place.quantity, devices::read_quantity(*environment_.at(sensor), place.place).value};
}

Rig::~Rig() = default;

void Rig::open() {
  source_->arm();
  if (dead_man_) dead_man_->allow(kOpening);
  open_array();
  feed_dead_man();
}

void Rig::open_array() { array_ = row_of(scanner_kinds(), config_.scanner.kind).make(config_.scanner, *clock_); }

devices::ForceSensor& Rig::open_force() {
  if (!config_.force) throw std::logic_error("Rig::open_force() without [force]");
  if (dead_man_) dead_man_->allow(kOpening);
  auto sensor = row_of(force_kinds(), config_.force->kind).make(*config_.force, *clock_);
  feed_dead_man();
  force_ = std::make_unique<GuardedForce>(std::move(sensor), *guard_);
  return *force_;
}

devices::TactileArray& Rig::array() {
  if (!array_) throw std::logic_error("Rig::array() before open()");
  return *array_;
}

void Rig::name_press_instruments() {
  if (!config_.force || !stage_) throw std::logic_error("Rig::name_press_instruments() without [stage] or [force]");
  const bool open_already = force_ != nullptr;
  const devices::ForceSensor& sensor = open_already ? *force_ : open_force();
  press_force_ = ForceIdentity{sensor.identity(), sensor.calibration_serial(), sensor.range()};
  if (!open_already) close_force();
  if (dead_man_) dead_man_->allow(kOpening);
  (void)stage_->identify();
  feed_dead_man();
}

std::vector<db::DeviceRecord> Rig::devices() const {
  std::vector<db::DeviceRecord> records;
  if (module_) records.push_back(module_record(module_->identity(), module_->profile()));
  records.push_back(regulator_record(source_->identity(), config_));
  records.push_back(reference_record(reference_->identity(), config_));
  if (input_module_) records.push_back(module_record(input_module_->identity(), input_module_->profile()));
  for (const EnvironmentSensor& sensor : config_.environment) records.push_back(environment_record(sensor, config_));
  if (press_force_) {
    const std::vector<devices::Identity> axes = stage_->identities();
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
      records.push_back(stage_record(axes[axis], axis, *config_.stage));
    }
    records.push_back(force_record(*press_force_, *config_.force));
  }
  if (array_) {
    records.push_back(scanner_record(array_->identity(), array_->volts_per_count().value(), config_));
  }
  return records;
}

std::string Rig::as_stored(const std::string& text) const {
  return simulated_ ? simulated_->ephemeral_addresses().lasting(text) : text;
}
Plant* Rig::plant() { return simulated_ ? &simulated_->plant() : nullptr; }

std::uint64_t Rig::exchanges() const {
  std::uint64_t sum = source_->exchanges() + (module_ ? module_->exchanges() : 0) +
                      (input_module_ ? input_module_->exchanges() : 0) +
                      (gauge_ != nullptr ? gauge_->link().exchanges() : 0) + (array_ ? array_->exchanges() : 0) +
                      (stage_ ? stage_->exchanges() : 0) + (force_ ? force_->exchanges() : 0);
  for (const auto& link : environment_) sum += link->exchanges();
  return sum;
}

std::vector<std::string> Rig::take_busy_report() const {
  std::vector<const devices::ModbusLink*> links;
  if (module_) links.push_back(&module_->link());
  if (input_module_) links.push_back(&input_module_->link());
  if (gauge_ != nullptr) links.push_back(&gauge_->link());
  for (const auto& link : environment_) links.push_back(link.get());
  std::vector<std::string> all;
  for (const devices::ModbusLink* link : links) {
    if (std::string text = link->take_busy_report(); !text.empty()) all.push_back(std::move(text));
  }
  return all;
}

}  // namespace tactbench::bench
