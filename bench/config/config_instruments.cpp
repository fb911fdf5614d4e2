#include "bench/config/config_instruments.h"

#include <fmt/format.h>

#include "bench/config/config_calibration.h"
#include "devices/stage/zaber_binary.h"
#include "devices/wire/stream_link.h"

namespace tactbench::bench {

using devices::DaqmxTerminal;
using sequences::Key;
using sequences::KeyTable;
using sequences::kMilliseconds;
using sequences::kOne;
using sequences::Range;
using sequences::TomlTable;
namespace key = sequences::key;

namespace {

Key terminal_key(DaqmxTerminal& terminal, const char* meaning) {
  return key::word("terminal", terminal, {"rse", "nrse", "differential"}, meaning);
}

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
                  "NI card: samples of all columns a second"),
      key::number("convert_rate_hz", daqmx.convert_rate_hz, {"Hz"}, {1.0, 1.25e6, true},
                  "NI card: rate from one column to the next; 0: the driver chooses"),
      key::number("samples_per_row", daqmx.samples_per_row, kOne, {1, 10000},
                  "NI card: samples of a row that are averaged"),
      key::number("settle_ms", daqmx.settle, kMilliseconds, {0.0, 1000.0},
                  "NI card: time from the closing of a relay to the first sample")};
}

void read_daqmx_scanner(const TomlTable& table, BenchConfig& config) {
  devices::DaqmxScannerOptions& daqmx = config.daqmx_scanner;
  read_keys(table, daqmx_device_keys(daqmx));
  read_keys(table, daqmx_keys(daqmx));
  daqmx.expected_serial = config.scanner.expected_serial;
  daqmx.rows = config.scanner.rows;
  daqmx.columns = config.scanner.columns;
  daqmx.timeout = config.scanner.frame_timeout;
  daqmx.origin = config.origin;
}

KeyTable scanner_kind_keys(BenchConfig& config) {
  return {key::word("kind", config.scanner_kind, {"hid", "daqmx", "frame-source"},
                    "How the array is read: a USB HID scanner, an NI card with relays, or a program of yours")};
}

KeyTable scanner_keys(BenchConfig& config) {
  devices::HidScannerOptions& scanner = config.scanner;
  const bool hid = config.scanner_kind == ScannerKind::kHid;
  return {
      key::text("serial", scanner.expected_serial, "Serial number of the scanner; another one is refused. \"\": any"),
      key::number("rows", scanner.rows, kOne, {1, 64}, "Rows of the array; a frame source states its own"),
      key::number("columns", scanner.columns, kOne, hid ? Range{16, 16} : Range{1, 64},
                  "Columns of the array; a frame source states its own"),
      key::number("frame_timeout_ms", scanner.frame_timeout, kMilliseconds, {10.0, 10000.0},
                  "Longest time to wait for one scan"),
      key::text("cable", config.scanner_cable, "Which cable connects array and scanner; stored with each run"),
      key::number("scans_per_frame", config.scans_per_frame, kOne, {1, 8},
                  "Scans taken for one frame; all are stored, their mean is used")};
}

KeyTable hid_keys(BenchConfig& config) {
  return {key::text("model", config.scanner.model, "HID: maker and model, stored with each run"),
          key::number("vendor_id", config.scanner_address.vendor_id, kOne, {0, 65535},
                      "HID: USB vendor number, as lsusb prints it (there hexadecimal)"),
          key::number("product_id", config.scanner_address.product_id, kOne, {0, 65535},
                      "HID: USB product number, as lsusb prints it (there hexadecimal)"),
          key::text("socket", config.scanner_socket,
                    "HID: path of a local socket in place of USB, where a simulated scanner listens; \"\": USB")};
}

KeyTable frame_source_keys(devices::FrameSourceOptions& source, bool in_process) {
  source.address = in_process ? "tcp:127.0.0.1:0" : "";
  return {key::text("address", source.address,
                    "Frame source: where it listens, as \"tcp:HOST:PORT\" or \"unix:PATH\"; only on a simulated bench "
                    "may it be left out")};
}

void read_scanner(const TomlTable& table, BenchConfig& config) {
  read_keys(table, scanner_kind_keys(config));
  read_keys(table, scanner_keys(config));
  config.scanner.origin = config.origin;
  if (config.scanner_kind == ScannerKind::kHid) {
    read_keys(table, hid_keys(config));
    config.scanner_address.serial = config.scanner.expected_serial;
  } else if (config.scanner_kind == ScannerKind::kDaqmx) {
    if (config.in_process) {
      table.fail("kind", "the simulated rig has no NI-DAQmx device", "use kind = \"hid\" or \"frame-source\"");
    }
    read_daqmx_scanner(table, config);
  } else {
    devices::FrameSourceOptions& source = config.frame_source;
    read_keys(table, frame_source_keys(source, config.in_process));
    if (!devices::is_stream_address(source.address)) {
      table.fail("address", fmt::format("\"{}\" is not the address of a frame source", source.address),
                 "write \"tcp:HOST:PORT\" or \"unix:PATH\"");
    }
    source.expected_serial = config.scanner.expected_serial;
    // It states them itself; the simulated one in this process has those of `scanner`.
    source.rows = config.in_process || table.has("rows") ? config.scanner.rows : 0;
    source.columns = config.in_process || table.has("columns") ? config.scanner.columns : 0;
    source.frame_timeout = config.scanner.frame_timeout;
    source.origin = config.origin;
  }
  table.finish();
}

constexpr std::array<const char*, 3> kAxisNames = {"x", "y", "z"};

KeyTable axis_keys(devices::ZaberAxisOptions& axis) {
  return {key::number("device", axis.device, kOne, {1, 254}, "Number of the axis on the chain"),
          key::number("device_id", axis.device_id, kOne, {1, 99999},
                      "Model, by Zaber's number: 60 is the T-LA60A, 5082 the T-NA08A50; another one is refused"),
          key::number("low_mm", axis.low, {"mm"}, {0.0, 1000.0}, "Lowest position to which the axis is sent")};
}

KeyTable travel_keys(devices::ZaberAxisOptions& axis, const devices::ZaberModel& model) {
  axis.high = model.travel;
  axis.maximum_speed = model.maximum_speed;
  return {key::number("high_mm", axis.high, {"mm"}, {axis.low.value(), 1000.0},
                      "Highest position to which the axis is sent, not below low_mm"),
          key::number("maximum_speed_mm_per_s", axis.maximum_speed, {"mm/s"}, {0.001, 30.0},
                      "Fastest speed, and the one used where a move names none"),
          key::number("home_timeout_s", axis.home_timeout, {"s"}, {1.0, 600.0}, "Longest time that homing may take"),
          key::text("serial", axis.serial,
                    "Serial number, stored with each run that presses; the axis cannot be asked for it")};
}

void read_axis(const TomlTable& table, devices::ZaberAxisOptions& axis) {
  read_keys(table, axis_keys(axis));
  const devices::ZaberModel* model = devices::zaber_model(axis.device_id);
  if (model == nullptr) {
    table.fail("device_id", fmt::format("{} is not a device id that tactbench knows", axis.device_id),
               "5082 is the T-NA08A50, 60 the T-LA60A; other models need their step size added");
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
                             "Serial line of the Zaber chain: a device, best a name in /dev/serial/by-id");
  return {
      found_otherwise ? port : key::required(port),
      key::text("usb_serial", stage.address.usb_serial,
                "Serial number of the USB adapter; finds the line instead of port, or checks it"),
      key::flag("renumber", stage.options.renumber, "Number the devices 1, 2, 3 from the computer's end on before use"),
      key::flag("knob_off", stage.options.knob_off, "Switch the manual knobs off while a run uses the stage"),
      key::number("reply_timeout_ms", stage.options.reply_timeout, kMilliseconds, {20.0, 10000.0},
                  "Longest time to wait for an answer"),
      key::number("poll_interval_ms", stage.options.poll_interval, kMilliseconds, {20.0, 1000.0},
                  "Time between two questions for the position during a move")};
}

KeyTable stage_stated_keys(StatedCalibration& stated) {
  return stated_keys(stated, "expanded_uncertainty_mm", {"mm"},
                     "Number of the stage's calibration certificate; \"\": none",
                     "Expanded uncertainty U of a position (k = 2)");
}

void read_stage(const TomlTable& table, BenchConfig& config) {
  StageConfig stage = usual_stage();
  read_keys(table, stage_keys(stage, config.in_process || table.has("usb_serial")));
  stage.options.origin = config.origin;
  read_keys(table, stage_stated_keys(stage.stated));
  check_dates(table, stage.stated);
  for (std::size_t i = 0; i < kAxisNames.size(); ++i) read_axis(table.table(kAxisNames[i]), stage.options.axes[i]);
  table.finish();
  config.stage = stage;
}

KeyTable net_keys(devices::NetFtOptions& net, bool in_process) {
  if (in_process) {
    net.host = "127.0.0.1";
    net.port = net.http_port = 0;
  }
  return {key::text("host", net.host, "Net F/T: its address in the network"),
          key::number("port", net.port, kOne, {0, 65535},
                      "Net F/T: UDP port of its data (a number); 0 on a simulated bench: any free one"),
          key::number("http_port", net.http_port, kOne, {0, 65535},
                      "Net F/T: port of its web page, where the calibration is read; 0 on a simulated bench: any free "
                      "one"),
          key::text("page_file", net.page_file,
                    "Net F/T: a saved netftapi2.xml, read in place of its web page; \"\": read the page"),
          key::number("reply_timeout_ms", net.reply_timeout, kMilliseconds, {10.0, 10000.0},
                      "Net F/T: longest time to wait for records, beyond the time that they take")};
}

void read_net(const TomlTable& table, const BenchConfig& config, ForceConfig& force) {
  devices::NetFtOptions& net = force.net;
  read_keys(table, net_keys(net, config.in_process));
  net.model = force.model;
  net.expected_serial = force.serial;
  net.overload_share = force.overload_share;
  net.origin = config.origin;
}

Key three_key(const char* name, std::array<double, 3>& values, const char* unit, const char* meaning) {
  return key::made({name, "list of numbers", unit, "three", "`[0, 0, 0]`", meaning},
                   [name, &values](const TomlTable& table) {
                     if (!table.has(name)) return;
                     const std::vector<double> read = table.numbers(name);
                     if (read.size() != 3)
                       table.fail(name, fmt::format("'{}' must hold three numbers", name), "write [x, y, z]");
                     values = {read[0], read[1], read[2]};
                   });
}

KeyTable daq_keys(ForceConfig& force) {
  return {key::required(key::text("calibration_file", force.calibration_file, "DAQ F/T: the transducer's .cal file")),
          key::flag("temperature_compensation", force.daq.temperature_compensation,
                    "DAQ F/T: use the thermistor, where the .cal file has coefficients for it")};
}

KeyTable tool_keys(devices::AtiTransform& tool) {
  return {three_key("displacement_mm", tool.displacement_mm, "mm",
                    "DAQ F/T: where the wrench is reported, [x, y, z] from the transducer's origin"),
          three_key("rotation_deg", tool.rotation_deg, "°",
                    "DAQ F/T: turn of that frame about x, then the new y, then the new z")};
}

KeyTable gauges_device_keys(devices::DaqmxGaugesOptions& gauges) {
  return {key::text("library", gauges.library, "DAQ F/T: path of the NI-DAQmx library; \"\": where NI installs it"),
          key::text("device", gauges.device, "DAQ F/T: name of the NI card in NI's configuration"),
          key::text("card_serial", gauges.expected_serial,
                    "DAQ F/T: serial number of the NI card, hexadecimal; another one is refused. \"\": any")};
}

KeyTable gauges_keys(devices::DaqmxGaugesOptions& gauges) {
  gauges.channels = gauges.device + "/ai16:21";
  return {key::text("channels", gauges.channels,
                    "DAQ F/T: analog inputs of the six gauges, then of the thermistor, in NI's notation"),
          terminal_key(gauges.terminal, "DAQ F/T: how the analog inputs are wired"),
          key::number("range_v", gauges.range, {"V"}, {0.1, 10.0},
                      "DAQ F/T: inputs measure from minus this voltage to plus this"),
          key::number("sample_rate_hz", gauges.sample_rate_hz, {"Hz"}, {1.0, 1e6},
                      "DAQ F/T: samples of all gauges a second")};
}

void read_daq(const TomlTable& table, const BenchConfig& config, ForceConfig& force) {
  read_keys(table, daq_keys(force));
  devices::DaqFtOptions& daq = force.daq;
  daq.model = force.model;
  daq.expected_serial = force.serial;
  daq.overload_share = force.overload_share;
  const TomlTable tool = table.table("tool");
  read_whole(tool, tool_keys(daq.tool));
  devices::DaqmxGaugesOptions& gauges = force.gauges;
  read_keys(table, gauges_device_keys(gauges));
  read_keys(table, gauges_keys(gauges));
  daq.converter_limit = gauges.range;
  gauges.origin = config.origin;
}

KeyTable digital_keys(ForceConfig& force) {
  devices::DigitalFtOptions& digital = force.digital;
  force.address.baud = 1250000;
  force.address.parity = 'E';
  return {
      key::text("port", force.address.port, "Digital F/T: the serial line (a text)"),
      key::text("usb_serial", force.address.usb_serial,
                "Digital F/T: serial number of the USB adapter; finds the line instead of port, or checks it"),
      key::number("baud", force.address.baud, {"bit/s"}, {9600, 3000000}, "Digital F/T: speed of the serial line"),
      key::word("parity", force.address.parity, {"N", "E", "O"},
                "Digital F/T: parity of the serial line: none, even or odd"),
      key::number("unit", digital.unit, kOne, {1, 247}, "Digital F/T: Modbus unit number"),
      key::flag("low_word_first", digital.low_word_first,
                "Digital F/T: whether the lower of two calibration registers comes first"),
      key::flag("local_echo", digital.local_echo, "Digital F/T: whether the adapter of the line returns what it sends"),
      key::number("samples_per_second", digital.samples_per_second, {"1/s"}, {1.0, 20000.0},
                  "Digital F/T: rate of its stream")};
}

void read_digital(const TomlTable& table, const BenchConfig& config, ForceConfig& force) {
  read_keys(table, digital_keys(force));
  if (force.address.port.empty() && force.address.usb_serial.empty() && !config.in_process) {
    table.fail("port", "no serial port is named", "e.g. \"/dev/ttyUSB1\", or usb_serial of its adapter");
  }
  devices::DigitalFtOptions& digital = force.digital;
  digital.model = force.model;
  digital.expected_serial = force.serial;
  digital.overload_share = force.overload_share;
  digital.origin = config.origin;
}

KeyTable force_name_keys(ForceConfig& force) {
  return {key::word("kind", force.kind, {"net", "daq", "digital"},
                    "Interface of the ATI sensor: Net F/T, DAQ F/T (an NI card) or Digital F/T (a serial line)"),
          key::text("model", force.model, "Maker and model, stored with each run"),
          key::text("serial", force.serial,
                    "Serial number of the transducer or its calibration; another one is refused. \"\": any")};
}

KeyTable force_stated_keys(StatedCalibration& stated) {
  return stated_keys(stated, "expanded_uncertainty_n", {"N"},
                     "Number of the calibration certificate; \"\": none, and reports say \"force not traceable\"",
                     "Expanded uncertainty U of Fz (k = 2)");
}

constexpr ChainKeys kForceChain = {
    "drift_n",
    "N",
    "input_limit_n",
    "N",
    "What the certificate covers: the transducer together with the electronics that read it, or the transducer alone",
    "Limit of error of what reads the transducer, by its data sheet; 0: contained in the certificate, or not stated"};

KeyTable force_keys(ForceConfig& force) {
  return {
      key::number("overload_share", force.overload_share, kOne, {0.05, 1.0},
                  "Share of each axis' rated range from which on the reading counts as an overload"),
      key::number("records_per_reading", force.records, kOne, {1, 1000}, "Records that are averaged into one reading")};
}

void read_force(const TomlTable& table, BenchConfig& config) {
  ForceConfig force;
  read_keys(table, force_name_keys(force));
  read_keys(table, force_stated_keys(force.stated));
  check_dates(table, force.stated);
  read_keys(table, chain_keys(force.stated, config.origin, kForceChain));
  check_chain(table, force.stated, kForceChain.input);
  read_keys(table, force_keys(force));
  if (force.kind == ForceKind::kNet) {
    read_net(table, config, force);
  } else if (force.kind == ForceKind::kDaq) {
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

void add_instrument_keys(std::vector<sequences::KeyFacts>& all) {
  const auto add = [&](const std::string& path, std::initializer_list<KeyTable> tables) {
    for (const KeyTable& keys : tables) add_facts(all, path, keys);
  };
  BenchConfig config, other;
  other.scanner_kind = ScannerKind::kDaqmx;
  add("scanner", {scanner_kind_keys(config), scanner_keys(config), scanner_keys(other), hid_keys(config),
                  frame_source_keys(config.frame_source, true), daqmx_device_keys(config.daqmx_scanner),
                  daqmx_keys(config.daqmx_scanner)});
  StageConfig stage = usual_stage();
  add("stage", {stage_keys(stage, true), stage_stated_keys(stage.stated)});
  for (std::size_t i = 0; i < kAxisNames.size(); ++i) {
    devices::ZaberAxisOptions& axis = stage.options.axes[i];
    add(std::string("stage.") + kAxisNames[i],
        {axis_keys(axis), travel_keys(axis, *devices::zaber_model(axis.device_id))});
  }
  ForceConfig force;
  add("force", {force_name_keys(force), force_stated_keys(force.stated),
                chain_keys(force.stated, devices::Origin::kSimulated, kForceChain), force_keys(force),
                net_keys(force.net, false), daq_keys(force)});
  add("force.tool", {tool_keys(force.daq.tool)});
  add("force", {gauges_device_keys(force.gauges), gauges_keys(force.gauges), digital_keys(force)});
}

}  // namespace tactbench::bench
