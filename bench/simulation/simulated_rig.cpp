#include "bench/simulation/simulated_rig.h"

#include <fmt/format.h>

#include <algorithm>

#include "devices/device.h"

namespace tactbench::bench {

namespace {

// The Nano17's SI-25-0.25 calibration: ranges from protocols' real .cal files, the rest invented.
constexpr std::array<double, 6> kNano17Range{25.0, 25.0, 35.0, 250.0, 250.0, 250.0};

devices::NetFtPage net_page(const std::string& serial) {
  devices::NetFtPage page;
  page.product = "tactbench simulated Net F/T";
  page.box_serial = "SIM-NETBOX-1";
  page.firmware = "sim-1";
  page.calibration_serial = serial.empty() ? "SIM-FT-1" : serial;
  page.range = kNano17Range;
  return page;
}

devices::DigitalCalibration digital_calibration(const std::string& serial) {
  devices::DigitalCalibration calibration;
  calibration.serial = serial.empty() ? "SIMFT2" : serial;
  calibration.part_number = "SI-25-0.25";
  calibration.date = "simulated";
  for (std::size_t i = 0; i < 6; ++i) {
    for (std::size_t j = 0; j < 6; ++j) calibration.matrix[i][j] = i == j ? 30.0F : 0.5F * static_cast<float>(i + 1);
  }
  calibration.torque_unit = 3;
  calibration.range = {25.0F, 25.0F, 35.0F, 0.25F, 0.25F, 0.25F};
  calibration.counts_per_force = 12800;
  calibration.counts_per_torque = 2560000;
  return calibration;
}

}  // namespace

SimulatedRig::SimulatedRig(BenchConfig& config, const devices::Clock& clock, bool free_running)
    : clock_(clock), free_running_(free_running), plant_(config.simulation->plant, clock) {
  lines_ = std::make_unique<SimulatedLines>(config, plant_, clock_);
  if (free_running_) lines_->serve_waveshare(plant_, clock_);
  for (const std::string& line : lines_->descriptions()) served_.push_back({"pressure and environment", line});
  serve_pressure(config);
  serve_scanner(config);
  if (config.stage) serve_stage(config);
  if (config.force) serve_force(config);
  for (const Served& served : served_) ephemeral_addresses_.add(served.where);
}

SimulatedRig::~SimulatedRig() {
  net_ft_.reset();
  digital_ft_.reset();
  plant_.forget_stage();
  chain_.reset();
  pressure_ends_.clear();
  scanner_.reset();
  frame_source_.reset();
}

devices::FaultInjector SimulatedRig::injector_of(Instrument instrument) {
  return [this, instrument] { return plant_.injected(instrument); };
}

// Free-running: of all kinds, on the same plant; whoever writes last drives it.
void SimulatedRig::serve_pressure(BenchConfig& config) {
  for (const RegulatorKind kind : {RegulatorKind::kModule, RegulatorKind::kSerial}) {
    const auto serve = pressure_kind(kind).serve;
    if (serve == nullptr || (kind != config.regulator_kind && !free_running_)) continue;
    pressure_ends_.push_back(serve(config, plant_, injector_of(Instrument::kController)));
    served_.push_back({pressure_ends_.back().what, pressure_ends_.back().where});
  }
}

void SimulatedRig::serve_scanner(BenchConfig& config) {
  const SimulationConfig& simulation = *config.simulation;
  const double volts_per_count = simulation.plant.scanner.volts_per_count;
  if (config.scanner_kind != ScannerKind::kFrameSource || free_running_) {
    devices::IdentityReport identity;
    identity.rows = static_cast<std::uint8_t>(config.scanner.rows);
    identity.columns = static_cast<std::uint8_t>(config.scanner.columns);
    identity.volts_per_count = static_cast<float>(volts_per_count);
    identity.serial = simulation.scanner_serial;
    identity.firmware = "sim-1";
    config.scanner_socket = sockets_.path() + "/scanner";
    devices::SimulatedScannerFaults faults = simulation.scanner_faults;
    faults.inject = injector_of(Instrument::kScanner);
    scanner_ = std::make_unique<devices::SimulatedScanner>(config.scanner_socket, identity, plant_, clock_, faults);
    served_.push_back({"tactile scanner, HID reports over SOCK_SEQPACKET", config.scanner_socket});
  }
  if (config.scanner_kind == ScannerKind::kFrameSource || free_running_) {
    devices::SimulatedFrameSourceOptions options;
    options.description.rows = static_cast<std::uint16_t>(config.scanner.rows);
    options.description.columns = static_cast<std::uint16_t>(config.scanner.columns);
    options.description.volts_per_count = volts_per_count;
    options.description.model = "tactbench simulated frame source";
    options.description.serial = simulation.scanner_serial;
    options.description.firmware = "sim-1";
    options.port = config.simulation->frame_source_port;
    options.faults.inject = injector_of(Instrument::kScanner);
    frame_source_ = std::make_unique<devices::SimulatedFrameSource>(options, plant_, clock_);
    config.frame_source.address = fmt::format("tcp:127.0.0.1:{}", frame_source_->port());
    served_.push_back({"tactile scanner, frame-source protocol over TCP", config.frame_source.address});
  }
}

void SimulatedRig::serve_stage(BenchConfig& config) {
  devices::SimulatedChainOptions options;
  options.free_running = free_running_;
  options.devices.resize(devices::kAxes);
  for (std::size_t axis = 0; axis < devices::kAxes; ++axis) {
    options.devices[axis].device_id = config.stage->options.axes[axis].device_id;
    options.devices[axis].number = config.stage->options.axes[axis].device;
  }
  devices::SimulatedChainFaults faults;
  faults.inject = injector_of(Instrument::kStage);
  faults.stall = [this] {  // not through the plant, which may hold its lock and ask the chain
    const Faults::Window window = plant_.faults().last(FaultKind::kStageStalled, clock_.now());
    devices::StageStall stall{window.from, window.until, std::nullopt};
    if (window.value > 0.0) stall.axis = static_cast<devices::Axis>(std::min(2, static_cast<int>(window.value) - 1));
    return stall;
  };
  chain_ = std::make_unique<devices::SimulatedChain>(options, clock_, faults);
  config.stage->address = {};
  config.stage->address.port = chain_->address();
  plant_.set_stage(chain_.get());
  served_.push_back({"stage, Zaber binary chain (firmware 5)", chain_->address()});
}

void SimulatedRig::serve_force(BenchConfig& config) {
  ForceConfig& force = *config.force;
  if (force.kind == ForceKind::kNet || free_running_) {
    devices::SimulatedNetFtOptions options;
    options.rdt_port = force.net.port;
    options.http_port = force.net.http_port;
    options.page = net_page(force.serial);
    options.faults.inject = injector_of(Instrument::kForce);
    net_ft_ = std::make_unique<devices::SimulatedNetFt>(options, plant_);
    force.net.host = "127.0.0.1";
    force.net.port = net_ft_->rdt_port();
    force.net.http_port = net_ft_->http_port();
    served_.push_back({"Nano17, Net F/T (RDT over UDP)", fmt::format("127.0.0.1:{}", net_ft_->rdt_port())});
    served_.push_back(
        {"Nano17, its calibration page", fmt::format("http://127.0.0.1:{}/netftapi2.xml", net_ft_->http_port())});
  }
  if (force.kind == ForceKind::kDigital || free_running_) {
    devices::SimulatedDigitalFtFaults faults;
    faults.inject = injector_of(Instrument::kForce);
    digital_ft_ =
        std::make_unique<devices::SimulatedDigitalFt>(digital_calibration(force.serial), plant_, free_running_, faults);
    force.address.port = digital_ft_->path();
    served_.push_back({"Nano17, Digital F/T (RS-485)", digital_ft_->path()});
  }
}

}  // namespace tactbench::bench
