#include <fmt/format.h>

#include <array>

#include "bench/config/instrument_kinds.h"
#include "devices/tactile/daqmx_scanner.h"
#include "devices/tactile/frame_source.h"
#include "devices/tactile/hid_scanner.h"
#include "devices/tactile/simulated_frame_source.h"
#include "devices/wire/byte_stream.h"
#include "devices/wire/report_link.h"

namespace tactbench::bench {

using devices::ScannerOptions;
using sequences::Key;
using sequences::KeyTable;
using sequences::kMilliseconds;
using sequences::kOne;
using sequences::Range;
using sequences::TomlTable;
namespace key = sequences::key;

namespace {

KeyTable scanner_kind_keys(devices::ScannerOptions& scanner) {
  return {key::word("kind", scanner.kind, words_of(scanner_kinds()),
                    "How the array is read: a USB HID scanner, an NI card with relays, or your own program")};
}

KeyTable scanner_keys(BenchConfig& config) {
  devices::ScannerOptions& scanner = config.scanner;
  const bool hid = scanner.kind == devices::ScannerKind::kHid;
  return {key::text("serial", scanner.expected_serial, "Serial number of the scanner; any other is refused. \"\": any"),
          key::number("rows", scanner.rows, kOne, {1, 64}, "Rows of the array; a frame source reports its own"),
          key::number("columns", scanner.columns, kOne, hid ? Range{16, 16} : Range{1, 64},
                      "Columns of the array; a frame source reports its own"),
          key::number("frame_timeout_ms", scanner.frame_timeout, kMilliseconds, {10.0, 10000.0},
                      "Longest time to wait for one scan"),
          key::text("cable", config.scanner_cable, "Cable between array and scanner; stored with each run"),
          key::number("scans_per_frame", config.scans_per_frame, kOne, {1, 8},
                      "Scans taken for one frame; all are stored, their mean is used")};
}

// --- a USB HID scanner

KeyTable hid_keys(devices::ScannerOptions& scanner) {
  return {key::text("model", scanner.model, "HID: maker and model, stored with each run"),
          key::number("vendor_id", scanner.address.vendor_id, kOne, {0, 65535},
                      "HID: USB vendor number, as lsusb prints it (there hexadecimal)"),
          key::number("product_id", scanner.address.product_id, kOne, {0, 65535},
                      "HID: USB product number, as lsusb prints it (there hexadecimal)"),
          key::text("socket", scanner.socket,
                    "HID: path of a local socket of a simulated scanner, used instead of USB; \"\": USB")};
}

void read_hid(const TomlTable& table, BenchConfig& config) {
  read_keys(table, hid_keys(config.scanner));
  config.scanner.address.serial = config.scanner.expected_serial;
}

SimulatedEnd serve_hid(BenchConfig& config, const SimulatedWorld& world) {
  const SimulationConfig& simulation = *config.simulation;
  devices::IdentityReport identity;
  identity.rows = static_cast<std::uint8_t>(config.scanner.rows);
  identity.columns = static_cast<std::uint8_t>(config.scanner.columns);
  identity.volts_per_count = static_cast<float>(simulation.plant.scanner.volts_per_count);
  identity.serial = simulation.scanner_serial;
  identity.firmware = "sim-1";
  devices::SimulatedScannerFaults faults = simulation.scanner_faults;
  faults.inject = world.inject;
  const std::string socket = config.scanner.socket = world.folder + "/scanner";
  return {std::make_shared<devices::SimulatedScanner>(socket, identity, world.array, world.clock, faults),
          {{"tactile scanner, HID reports over SOCK_SEQPACKET", socket}},
          {{"scanner.socket", socket}}};
}

std::unique_ptr<devices::TactileArray> make_hid(const ScannerOptions& scanner, devices::Clock& clock) {
  auto link =
      scanner.socket.empty() ? devices::open_hid_link(scanner.address) : devices::open_packet_link(scanner.socket);
  return std::make_unique<devices::HidScanner>(std::move(link), scanner, clock);
}

// --- relays and an NI card

KeyTable daqmx_device_keys(devices::DaqmxScannerOptions& daqmx) {
  return {key::text("library", daqmx.library, "NI card: path of the NI-DAQmx library; \"\": where NI installs it"),
          key::text("device", daqmx.device, "NI card: its name in NI's configuration")};
}

KeyTable daqmx_keys(devices::DaqmxScannerOptions& daqmx) {
  daqmx.column_channels = daqmx.device + "/ai0:15";
  daqmx.row_lines = daqmx.device + "/port0/line0:15";
  return {
      key::text("column_channels", daqmx.column_channels, "NI card: analog inputs of the columns, in NI's notation"),
      key::text("row_lines", daqmx.row_lines,
                "NI card: digital outputs that switch the rows' relays, in NI's notation"),
      terminal_key(daqmx.terminal, "NI card: how the analog inputs are wired"),
      key::number("range_v", daqmx.range, {"V"}, {0.1, 10.0},
                  "NI card: inputs measure from minus this voltage to plus this"),
      key::flag("relays_active_low", daqmx.relays_active_low, "NI card: whether a relay closes when its line is at 0"),
      key::number("sample_rate_hz", daqmx.sample_rate_hz, {"Hz"}, {1.0, 1e6},
                  "NI card: samples of all columns per second"),
      key::number("convert_rate_hz", daqmx.convert_rate_hz, {"Hz"}, {1.0, 1.25e6, true},
                  "NI card: rate from one column to the next; 0: the driver chooses"),
      key::number("samples_per_row", daqmx.samples_per_row, kOne, {1, 10000},
                  "NI card: number of samples of a row that are averaged"),
      key::number("settle_ms", daqmx.settle, kMilliseconds, {0.0, 1000.0},
                  "NI card: time from the closing of a relay to the first sample")};
}

void read_daqmx_scanner(const TomlTable& table, BenchConfig& config) {
  if (config.in_process) {
    table.fail("kind", "the simulated rig has no NI-DAQmx device", "use kind = \"hid\" or \"frame-source\"");
  }
  devices::DaqmxScannerOptions& daqmx = config.scanner.daqmx;
  read_keys(table, daqmx_device_keys(daqmx));
  read_keys(table, daqmx_keys(daqmx));
  static_cast<devices::ArrayOptions&>(daqmx) = config.scanner;
}

std::unique_ptr<devices::TactileArray> make_daqmx(const ScannerOptions& scanner, devices::Clock& clock) {
  return std::make_unique<devices::DaqmxScanner>(scanner.daqmx, clock);
}

// --- a program that sends frames

KeyTable frame_source_keys(devices::FrameSourceOptions& source, bool in_process) {
  source.address = in_process ? "tcp:127.0.0.1:0" : "";
  return {key::text("address", source.address,
                    "Frame source: its address, as \"tcp:HOST:PORT\" or \"unix:PATH\"; only on a simulated bench may "
                    "it be left out")};
}

void read_frame_source(const TomlTable& table, BenchConfig& config) {
  devices::FrameSourceOptions& source = config.scanner.frame_source;
  read_keys(table, frame_source_keys(source, config.in_process));
  if (!devices::is_stream_address(source.address)) {
    table.fail("address", fmt::format("\"{}\" is not the address of a frame source", source.address),
               "write \"tcp:HOST:PORT\" or \"unix:PATH\"");
  }
  static_cast<devices::ArrayOptions&>(source) = config.scanner;
  // It states them itself; the simulated one in this process has those of `scanner`.
  if (!config.in_process && !table.has("rows")) source.rows = 0;
  if (!config.in_process && !table.has("columns")) source.columns = 0;
}

SimulatedEnd serve_frame_source(BenchConfig& config, const SimulatedWorld& world) {
  devices::SimulatedFrameSourceOptions options;
  options.description.rows = static_cast<std::uint16_t>(config.scanner.rows);
  options.description.columns = static_cast<std::uint16_t>(config.scanner.columns);
  options.description.volts_per_count = config.simulation->plant.scanner.volts_per_count;
  options.description.model = "tactbench simulated frame source";
  options.description.serial = config.simulation->scanner_serial;
  options.description.firmware = "sim-1";
  options.port = config.simulation->frame_source_port;
  options.faults.inject = world.inject;
  auto source = std::make_shared<devices::SimulatedFrameSource>(options, world.array, world.clock);
  const std::string address = config.scanner.frame_source.address = fmt::format("tcp:127.0.0.1:{}", source->port());
  return {std::move(source),
          {{"tactile scanner, frame-source protocol over TCP", address}},
          {{"scanner.address", address}}};
}

std::unique_ptr<devices::TactileArray> make_frame_source(const ScannerOptions& scanner, devices::Clock& clock) {
  return std::make_unique<devices::FrameSource>(scanner.frame_source, clock);
}

constexpr std::array kScanners{ScannerRow{"hid", read_hid, serve_hid, make_hid},
                               ScannerRow{"daqmx", read_daqmx_scanner, nullptr, make_daqmx},
                               ScannerRow{"frame-source", read_frame_source, serve_frame_source, make_frame_source}};

}  // namespace

std::span<const ScannerRow> scanner_kinds() { return kScanners; }

sequences::Key terminal_key(devices::DaqmxTerminal& terminal, const char* meaning) {
  return key::word("terminal", terminal, {"rse", "nrse", "differential"}, meaning);
}

void read_scanner(const TomlTable& table, BenchConfig& config) {
  read_keys(table, scanner_kind_keys(config.scanner));
  read_keys(table, scanner_keys(config));
  config.scanner.origin = config.origin;
  row_of(kScanners, config.scanner.kind).read(table, config);
  table.finish();
}

void add_scanner_keys(std::vector<sequences::KeyFacts>& all) {
  BenchConfig config, other;
  ScannerOptions& scanner = config.scanner;
  other.scanner.kind = devices::ScannerKind::kDaqmx;
  for (const KeyTable& keys :
       {scanner_kind_keys(scanner), scanner_keys(config), scanner_keys(other), hid_keys(scanner),
        frame_source_keys(scanner.frame_source, true), daqmx_device_keys(scanner.daqmx), daqmx_keys(scanner.daqmx)}) {
    add_facts(all, "scanner", keys);
  }
}

}  // namespace tactbench::bench
