#include "bench/rig.h"

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "bench/process_time.h"
#include "devices/fault.h"
#include "devices/pressure/regulator.h"
#include "devices/wire/packet_link.h"

namespace tactbench::bench {

using devices::Origin;

namespace {

// A private folder (mode 0700) for the simulated scanner's socket file.
std::string make_socket_folder() {
  std::string pattern = (std::filesystem::temp_directory_path() / "tactbench-XXXXXX").string();
  if (mkdtemp(pattern.data()) == nullptr) {
    throw devices::Fault("TB-SIM-LISTEN", "simulated scanner", "cannot make a temporary folder at " + pattern,
                         "check that the folder for temporary files exists and can be written (TMPDIR)");
  }
  return pattern;
}

nlohmann::ordered_json span_json(const devices::LinearSpan& span) {
  return {{"volts_low", span.volts_low.value()},
          {"volts_high", span.volts_high.value()},
          {"psi_low", span.low.value()},
          {"psi_high", span.high.value()}};
}

db::DeviceRecord record_of(const devices::Identity& identity, const nlohmann::ordered_json& calibration) {
  return {identity.role,
          identity.model,
          identity.serial,
          identity.firmware,
          identity.origin == Origin::kSimulated ? "simulated" : "hardware",
          calibration.dump()};
}

}  // namespace

Rig::Rig(const BenchConfig& config) : config_(config) {
  if (config_.simulation) {
    clock_ = std::make_unique<devices::TurnedClock>();
    plant_ = std::make_unique<Plant>(config_.simulation->plant, *clock_);
    simulated_module_ =
        std::make_unique<devices::SimulatedModule>(devices::module_profile(config_.module_profile), config_.module.port,
                                                   *plant_, *clock_, config_.simulation->module_faults);
    config_.module.host = "127.0.0.1";
    config_.module.port = simulated_module_->port();
    socket_folder_ = make_socket_folder();
    devices::IdentityReport identity;
    identity.rows = static_cast<std::uint8_t>(config_.scanner.rows);
    identity.columns = static_cast<std::uint8_t>(config_.scanner.columns);
    identity.volts_per_count = static_cast<float>(config_.simulation->plant.scanner.volts_per_count);
    identity.serial = config_.simulation->scanner_serial;
    identity.firmware = "sim-1";
    simulated_scanner_ = std::make_unique<devices::SimulatedScanner>(socket_folder_ + "/scanner", identity, *plant_,
                                                                     *clock_, config_.simulation->scanner_faults);
  } else {
    clock_ = std::make_unique<devices::SteadyClock>();
  }
  module_ = std::make_unique<devices::AnalogModule>(devices::module_profile(config_.module_profile), config_.module,
                                                    seconds(config_.watchdog_s), *clock_, config_.origin);
  source_ = std::make_unique<devices::Regulator>(*module_, config_.regulator, *clock_);
  reference_ = std::make_unique<devices::ModuleTransducer>(*module_, config_.reference);
}

Rig::~Rig() {
  array_.reset();  // the driver's end first, so that no simulated end is left waiting
  simulated_scanner_.reset();
  if (!socket_folder_.empty()) {
    std::error_code ignored;
    std::filesystem::remove_all(socket_folder_, ignored);
  }
}

void Rig::open() {
  module_->bring_up();
  auto link = config_.simulation ? devices::open_packet_link(socket_folder_ + "/scanner")
                                 : devices::open_hid_link(config_.scanner_address);
  array_ = std::make_unique<devices::HidScanner>(std::move(link), config_.scanner, *clock_);
}

devices::TactileArray& Rig::array() {
  if (!array_) throw std::logic_error("Rig::array() before open()");
  return *array_;
}

std::vector<db::DeviceRecord> Rig::devices() const {
  nlohmann::ordered_json module = {{"raw_full_scale", module_->profile().raw_full_scale},
                                   {"volts_full_scale", module_->profile().volts_full_scale.value()}};
  nlohmann::ordered_json reference = span_json(config_.reference.span);
  reference["independent"] = config_.reference_independent;
  reference["certificate"] = config_.reference_certificate;
  reference["due"] = config_.reference_due;
  std::vector<db::DeviceRecord> records = {
      record_of(module_->identity(), module),
      record_of(source_->identity(), span_json(config_.regulator.command_span)),
      record_of(reference_->identity(), reference),
  };
  if (array_) {
    records.push_back(record_of(array_->identity(), {{"volts_per_count", array_->volts_per_count().value()}}));
  }
  return records;
}

std::uint64_t Rig::exchanges() const { return module_->exchanges() + (array_ ? array_->exchanges() : 0); }

}  // namespace tactbench::bench
