#include "bench/config/config_instruments.h"

#include <fmt/format.h>

#include "bench/common/process_time.h"
#include "bench/config/config_calibration.h"
#include "devices/stage/zaber_binary.h"
#include "devices/wire/stream_link.h"

namespace tactbench::bench {

using devices::DaqmxTerminal;
using devices::Millimetres;
using devices::MillimetresPerSecond;
using devices::Volts;
using sequences::TomlTable;

namespace {

devices::Nanoseconds milliseconds(double value) { return seconds(value / 1000.0); }

DaqmxTerminal read_terminal(const TomlTable& table, const std::string& fallback) {
  const std::string word = table.word("terminal", fallback, {"rse", "nrse", "differential"});
  return word == "rse" ? DaqmxTerminal::kRse : word == "nrse" ? DaqmxTerminal::kNrse : DaqmxTerminal::kDifferential;
}

void read_daqmx_scanner(const TomlTable& table, BenchConfig& config) {
  devices::DaqmxScannerOptions& daqmx = config.daqmx_scanner;
  daqmx.library = table.text("library", "");
  daqmx.device = table.text("device", daqmx.device);
  daqmx.expected_serial = config.scanner.expected_serial;
  daqmx.column_channels = table.text("column_channels", daqmx.device + "/ai0:15");
  daqmx.row_lines = table.text("row_lines", daqmx.device + "/port0/line0:15");
  daqmx.rows = config.scanner.rows;
  daqmx.columns = config.scanner.columns;
  daqmx.terminal = read_terminal(table, "rse");
  daqmx.range = Volts(table.number_in("range_v", daqmx.range.value(), 0.1, 10.0));
  daqmx.relays_active_low = table.boolean("relays_active_low", false);
  daqmx.sample_rate_hz = table.number_in("sample_rate_hz", daqmx.sample_rate_hz, 1.0, 1e6);
  daqmx.convert_rate_hz = table.zero_or_in("convert_rate_hz", 0.0, 1.0, 1.25e6);
  daqmx.samples_per_row = static_cast<int>(table.integer("samples_per_row", daqmx.samples_per_row, 1, 10000));
  daqmx.settle = milliseconds(table.number_in("settle_ms", 5.0, 0.0, 1000.0));
  daqmx.timeout = config.scanner.frame_timeout;
  daqmx.origin = config.origin;
}

void read_scanner(const TomlTable& table, BenchConfig& config) {
  const std::string kind = table.word("kind", "hid", {"hid", "daqmx", "frame-source"});
  config.scanner_kind = kind == "hid"     ? ScannerKind::kHid
                        : kind == "daqmx" ? ScannerKind::kDaqmx
                                          : ScannerKind::kFrameSource;
  config.scanner.expected_serial = table.text("serial", "");
  config.scanner.rows = static_cast<int>(table.integer("rows", 16, 1, 64));
  config.scanner.columns = kind == "hid" ? static_cast<int>(table.integer("columns", 16, 16, 16))
                                         : static_cast<int>(table.integer("columns", 16, 1, 64));
  config.scanner.frame_timeout = milliseconds(table.number_in("frame_timeout_ms", 500, 10, 10000));
  config.scanner.origin = config.origin;
  config.scanner_cable = table.text("cable", "");
  config.scans_per_frame = static_cast<int>(table.integer("scans_per_frame", 2, 1, 8));
  if (kind == "hid") {
    config.scanner.model = table.text("model", config.scanner.model);
    config.scanner_address.vendor_id = static_cast<std::uint16_t>(table.integer("vendor_id", 0, 0, 65535));
    config.scanner_address.product_id = static_cast<std::uint16_t>(table.integer("product_id", 0, 0, 65535));
    config.scanner_address.serial = config.scanner.expected_serial;
    config.scanner_socket = table.text("socket", "");
  } else if (kind == "daqmx") {
    if (config.in_process) {
      table.fail("kind", "the simulated rig has no NI-DAQmx device", "use kind = \"hid\" or \"frame-source\"");
    }
    read_daqmx_scanner(table, config);
  } else {
    devices::FrameSourceOptions& source = config.frame_source;
    source.address = table.text("address", config.in_process ? "tcp:127.0.0.1:0" : "");
    if (!devices::is_stream_address(source.address)) {
      table.fail("address", fmt::format("\"{}\" is not the address of a frame source", source.address),
                 "write \"tcp:HOST:PORT\" or \"unix:PATH\"");
    }
    source.expected_serial = config.scanner.expected_serial;
    source.rows = config.scanner.rows;
    source.columns = config.scanner.columns;
    source.frame_timeout = config.scanner.frame_timeout;
    source.origin = config.origin;
  }
  table.finish();
}

void read_axis(const TomlTable& table, int default_device, int default_id, devices::ZaberAxisOptions& axis) {
  axis.device = static_cast<std::uint8_t>(table.integer("device", default_device, 1, 254));
  axis.device_id = static_cast<std::int32_t>(table.integer("device_id", default_id, 1, 99999));
  const devices::ZaberModel* model = devices::zaber_model(axis.device_id);
  if (model == nullptr) {
    table.fail("device_id", fmt::format("{} is not a device id that tactbench knows", axis.device_id),
               "5082 is the T-NA08A50, 60 the T-LA60A; other models need their step size added");
  }
  axis.low = Millimetres(table.number_in("low_mm", 0.0, 0.0, 1000.0));
  axis.high = Millimetres(table.number_in("high_mm", model->travel.value(), axis.low.value(), 1000.0));
  axis.maximum_speed =
      MillimetresPerSecond(table.number_in("maximum_speed_mm_per_s", model->maximum_speed.value(), 0.001, 30.0));
  axis.home_timeout = seconds(table.number_in("home_timeout_s", 120.0, 1.0, 600.0));
  axis.serial = table.text("serial", "");
  table.finish();
}

void read_stage(const TomlTable& table, BenchConfig& config) {
  StageConfig stage;
  const bool found_otherwise = config.in_process || table.has("usb_serial");
  stage.address.port = found_otherwise ? table.text("port", "") : table.text("port");
  stage.address.usb_serial = table.text("usb_serial", "");
  stage.options.renumber = table.boolean("renumber", false);
  stage.options.knob_off = table.boolean("knob_off", true);
  stage.options.reply_timeout = milliseconds(table.number_in("reply_timeout_ms", 300, 20, 10000));
  stage.options.poll_interval = milliseconds(table.number_in("poll_interval_ms", 100, 20, 1000));
  stage.options.origin = config.origin;
  stage.stated = read_stated_calibration(table, "expanded_uncertainty_mm", 10.0);
  read_axis(table.table("x"), 1, 60, stage.options.axes[0]);
  read_axis(table.table("y"), 2, 60, stage.options.axes[1]);
  read_axis(table.table("z"), 3, 5082, stage.options.axes[2]);
  table.finish();
  config.stage = stage;
}

void read_net(const TomlTable& table, const BenchConfig& config, ForceConfig& force) {
  devices::NetFtOptions& net = force.net;
  net.model = force.model;
  net.host = table.text("host", config.in_process ? "127.0.0.1" : net.host);
  net.port = static_cast<int>(table.integer("port", config.in_process ? 0 : net.port, 0, 65535));
  net.http_port = static_cast<int>(table.integer("http_port", config.in_process ? 0 : net.http_port, 0, 65535));
  net.page_file = table.text("page_file", "");
  net.expected_serial = force.serial;
  net.overload_share = force.overload_share;
  net.reply_timeout = milliseconds(table.number_in("reply_timeout_ms", 500, 10, 10000));
  net.origin = config.origin;
}

std::array<double, 3> three(const TomlTable& table, const std::string& key) {
  if (!table.has(key)) return {};
  const std::vector<double> values = table.numbers(key);
  if (values.size() != 3) table.fail(key, fmt::format("'{}' must hold three numbers", key), "write [x, y, z]");
  return {values[0], values[1], values[2]};
}

void read_daq(const TomlTable& table, const BenchConfig& config, ForceConfig& force) {
  force.calibration_file = table.text("calibration_file");
  devices::DaqFtOptions& daq = force.daq;
  daq.model = force.model;
  daq.expected_serial = force.serial;
  daq.overload_share = force.overload_share;
  daq.temperature_compensation = table.boolean("temperature_compensation", true);
  const TomlTable tool = table.table("tool");
  daq.tool.displacement_mm = three(tool, "displacement_mm");
  daq.tool.rotation_deg = three(tool, "rotation_deg");
  tool.finish();
  devices::DaqmxGaugesOptions& gauges = force.gauges;
  gauges.library = table.text("library", "");
  gauges.device = table.text("device", gauges.device);
  gauges.expected_serial = table.text("card_serial", "");
  gauges.channels = table.text("channels", gauges.device + "/ai16:21");
  gauges.terminal = read_terminal(table, "differential");
  gauges.range = Volts(table.number_in("range_v", gauges.range.value(), 0.1, 10.0));
  daq.converter_limit = gauges.range;
  gauges.sample_rate_hz = table.number_in("sample_rate_hz", gauges.sample_rate_hz, 1.0, 1e6);
  gauges.origin = config.origin;
}

void read_digital(const TomlTable& table, const BenchConfig& config, ForceConfig& force) {
  force.address.port = table.text("port", "");
  force.address.usb_serial = table.text("usb_serial", "");
  if (force.address.port.empty() && force.address.usb_serial.empty() && !config.in_process) {
    table.fail("port", "no serial port is named", "e.g. \"/dev/ttyUSB1\", or usb_serial of its adapter");
  }
  force.address.baud = static_cast<int>(table.integer("baud", 1250000, 9600, 3000000));
  force.address.parity = table.word("parity", "E", {"N", "E", "O"})[0];
  devices::DigitalFtOptions& digital = force.digital;
  digital.model = force.model;
  digital.expected_serial = force.serial;
  digital.overload_share = force.overload_share;
  digital.unit = static_cast<int>(table.integer("unit", digital.unit, 1, 247));
  digital.low_word_first = table.boolean("low_word_first", false);
  digital.samples_per_second = table.number_in("samples_per_second", digital.samples_per_second, 1.0, 20000.0);
  digital.origin = config.origin;
}

void read_force(const TomlTable& table, BenchConfig& config) {
  ForceConfig force;
  const std::string kind = table.word("kind", "net", {"net", "daq", "digital"});
  force.kind = kind == "net" ? ForceKind::kNet : kind == "daq" ? ForceKind::kDaq : ForceKind::kDigital;
  force.model = table.text("model", "ATI Nano17");
  force.serial = table.text("serial", "");
  force.stated = read_stated_calibration(table, "expanded_uncertainty_n", 10.0);
  read_chain(table, config.origin, "drift_n", "input_limit_n", 10.0, force.stated);
  force.overload_share = table.number_in("overload_share", 1.0, 0.05, 1.0);
  force.records = static_cast<int>(table.integer("records_per_reading", 50, 1, 1000));
  if (kind == "net") {
    read_net(table, config, force);
  } else if (kind == "daq") {
    if (config.in_process) {
      table.fail("kind", "the simulated rig has no NI-DAQmx device", "use kind = \"net\" or \"digital\"");
    }
    read_daq(table, config, force);
  } else {
    read_digital(table, config, force);
  }
  table.finish();
  config.force = force;
}

}  // namespace

void read_instruments(const TomlTable& root, BenchConfig& config) {
  read_scanner(root.table("scanner"), config);
  if (root.has("stage")) read_stage(root.table("stage"), config);
  if (root.has("force")) read_force(root.table("force"), config);
}

}  // namespace tactbench::bench
