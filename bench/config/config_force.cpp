#include <fmt/format.h>

#include <array>

#include "bench/config/config_calibration.h"
#include "bench/config/instrument_kinds.h"
#include "devices/force/daq_ft.h"
#include "devices/force/daqmx_gauges.h"
#include "devices/force/digital_ft.h"
#include "devices/force/net_ft.h"
#include "devices/force/simulated_digital_ft.h"
#include "devices/force/simulated_net_ft.h"
#include "devices/wire/byte_stream.h"

namespace tactbench::bench {

using devices::ForceOptions;
using sequences::Key;
using sequences::KeyTable;
using sequences::kMilliseconds;
using sequences::kOne;
using sequences::TomlTable;
namespace key = sequences::key;

namespace {

KeyTable force_name_keys(ForceConfig& force) {
  return {key::word("kind", force.kind, words_of(force_kinds()),
                    "Interface of the ATI sensor: Net F/T, DAQ F/T (an NI card) or Digital F/T (a serial line)"),
          key::text("model", force.model, "Maker and model, stored with each run"),
          key::text("serial", force.expected_serial,
                    "Serial number of the transducer or its calibration; any other is refused. \"\": any")};
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
    "Limit of error of the electronics that read the transducer, from the data sheet; 0: included in the certificate, "
    "or not stated"};

KeyTable force_keys(ForceConfig& force) {
  return {key::number("overload_share", force.overload_share, kOne, {0.05, 1.0},
                      "Share of each axis' rated range above which the reading counts as an overload"),
          key::number("records_per_reading", force.records, kOne, {1, 1000},
                      "Number of records averaged into one reading")};
}

// --- Net F/T

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
                    "Net F/T: a saved netftapi2.xml, read instead of its web page; \"\": read the page"),
          key::number("reply_timeout_ms", net.reply_timeout, kMilliseconds, {10.0, 10000.0},
                      "Net F/T: longest time to wait for records, beyond the time that they take")};
}

void read_net(const TomlTable& table, const BenchConfig& config, ForceConfig& force) {
  devices::NetFtOptions& net = force.net;
  read_keys(table, net_keys(net, config.in_process));
  static_cast<devices::FtOptions&>(net) = force;
}

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

SimulatedEnd serve_net(BenchConfig& config, const SimulatedWorld& world) {
  devices::NetFtOptions& net = config.force->net;
  devices::SimulatedNetFtOptions options;
  options.rdt_port = net.port;
  options.http_port = net.http_port;
  options.page = net_page(config.force->expected_serial);
  options.faults.inject = world.inject;
  auto sensor = std::make_shared<devices::SimulatedNetFt>(options, world.force);
  net.host = "127.0.0.1";
  net.port = sensor->rdt_port();
  net.http_port = sensor->http_port();
  return {std::move(sensor),
          {{"Nano17, Net F/T (RDT over UDP)", fmt::format("127.0.0.1:{}", net.port)},
           {"Nano17, its calibration page", fmt::format("http://127.0.0.1:{}/netftapi2.xml", net.http_port)}},
          {{"force.host", net.host},
           {"force.port", std::to_string(net.port)},
           {"force.http_port", std::to_string(net.http_port)}}};
}

std::unique_ptr<devices::ForceSensor> make_net(const ForceOptions& force, devices::Clock& clock) {
  return std::make_unique<devices::NetFt>(force.net, clock);
}

// --- DAQ F/T

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
                    "DAQ F/T: use the thermistor, if the .cal file has coefficients for it")};
}

KeyTable tool_keys(devices::AtiTransform& tool) {
  return {
      three_key("displacement_mm", tool.displacement_mm, "mm",
                "DAQ F/T: origin of the frame in which the wrench is reported, [x, y, z] from the transducer's origin"),
      three_key("rotation_deg", tool.rotation_deg, "°",
                "DAQ F/T: rotation of that frame about x, then the new y, then the new z")};
}

KeyTable gauges_device_keys(devices::DaqmxGaugesOptions& gauges) {
  return {key::text("library", gauges.library, "DAQ F/T: path of the NI-DAQmx library; \"\": where NI installs it"),
          key::text("device", gauges.device, "DAQ F/T: name of the NI card in NI's configuration"),
          key::text("card_serial", gauges.expected_serial,
                    "DAQ F/T: serial number of the NI card, hexadecimal; any other is refused. \"\": any")};
}

KeyTable gauges_keys(devices::DaqmxGaugesOptions& gauges) {
  gauges.channels = gauges.device + "/ai16:21";
  return {key::text("channels", gauges.channels,
                    "DAQ F/T: analog inputs of the six gauges, then of the thermistor, in NI's notation"),
          terminal_key(gauges.terminal, "DAQ F/T: how the analog inputs are wired"),
          key::number("range_v", gauges.range, {"V"}, {0.1, 10.0},
                      "DAQ F/T: inputs measure from minus this voltage to plus this"),
          key::number("sample_rate_hz", gauges.sample_rate_hz, {"Hz"}, {1.0, 1e6},
                      "DAQ F/T: samples of all gauges per second")};
}

void read_daq(const TomlTable& table, const BenchConfig& config, ForceConfig& force) {
  if (config.in_process) {
    table.fail("kind", "the simulated rig has no NI-DAQmx device", "use kind = \"net\" or \"digital\"");
  }
  read_keys(table, daq_keys(force));
  devices::DaqFtOptions& daq = force.daq;
  static_cast<devices::FtOptions&>(daq) = force;
  const TomlTable tool = table.table("tool");
  read_whole(tool, tool_keys(daq.tool));
  devices::DaqmxGaugesOptions& gauges = force.gauges;
  read_keys(table, gauges_device_keys(gauges));
  read_keys(table, gauges_keys(gauges));
  daq.converter_limit = gauges.range;
  gauges.origin = config.origin;
}

std::unique_ptr<devices::ForceSensor> make_daq(const ForceOptions& force, devices::Clock& clock) {
  return std::make_unique<devices::DaqFt>(std::make_unique<devices::DaqmxGauges>(force.gauges, clock),
                                          devices::read_ati_calibration(force.calibration_file), force.daq);
}

// --- Digital F/T

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
      key::flag("local_echo", digital.local_echo, "Digital F/T: whether the adapter of the line echoes what is sent"),
      key::number("samples_per_second", digital.samples_per_second, {"1/s"}, {1.0, 20000.0},
                  "Digital F/T: rate of its stream")};
}

void read_digital(const TomlTable& table, const BenchConfig& config, ForceConfig& force) {
  read_keys(table, digital_keys(force));
  if (force.address.port.empty() && force.address.usb_serial.empty() && !config.in_process) {
    table.fail("port", "no serial port is named", "e.g. \"/dev/ttyUSB1\", or usb_serial of its adapter");
  }
  devices::DigitalFtOptions& digital = force.digital;
  static_cast<devices::FtOptions&>(digital) = force;
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

SimulatedEnd serve_digital(BenchConfig& config, const SimulatedWorld& world) {
  ForceConfig& force = *config.force;
  devices::SimulatedDigitalFtFaults faults;
  faults.inject = world.inject;
  auto sensor = std::make_shared<devices::SimulatedDigitalFt>(digital_calibration(force.expected_serial), world.force,
                                                              world.free_running, faults);
  const std::string port = force.address.port = sensor->path();
  return {std::move(sensor), {{"Nano17, Digital F/T (RS-485)", port}}, {{"force.port", port}}};
}

std::unique_ptr<devices::ForceSensor> make_digital(const ForceOptions& force, devices::Clock& clock) {
  return std::make_unique<devices::DigitalFt>(devices::open_serial(force.address), force.digital, clock);
}

constexpr std::array kForces{ForceRow{"net", read_net, serve_net, make_net},
                             ForceRow{"daq", read_daq, nullptr, make_daq},
                             ForceRow{"digital", read_digital, serve_digital, make_digital}};

}  // namespace

std::span<const ForceRow> force_kinds() { return kForces; }

void read_force(const TomlTable& table, BenchConfig& config) {
  ForceConfig& force = config.force.emplace();
  force.origin = config.origin;
  read_keys(table, force_name_keys(force));
  read_keys(table, force_stated_keys(force.stated));
  check_dates(table, force.stated);
  read_keys(table, chain_keys(force.stated, config.origin, kForceChain));
  check_chain(table, force.stated, kForceChain.input);
  read_keys(table, force_keys(force));
  row_of(kForces, force.kind).read(table, config, force);
  table.finish();
}

void add_force_keys(std::vector<sequences::KeyFacts>& all) {
  ForceConfig force;
  const auto add = [&](std::initializer_list<KeyTable> tables) {
    for (const KeyTable& keys : tables) add_facts(all, "force", keys);
  };
  add({force_name_keys(force), force_stated_keys(force.stated),
       chain_keys(force.stated, devices::Origin::kSimulated, kForceChain), force_keys(force),
       net_keys(force.net, false), daq_keys(force)});
  add_facts(all, "force.tool", tool_keys(force.daq.tool));
  add({gauges_device_keys(force.gauges), gauges_keys(force.gauges), digital_keys(force)});
}

}  // namespace tactbench::bench
