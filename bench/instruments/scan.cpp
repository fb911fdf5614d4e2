#include "bench/instruments/scan.h"

#include <fmt/format.h>

#include <array>
#include <cstdlib>

#include "bench/common/error.h"
#include "devices/clock.h"
#include "devices/device.h"
#include "devices/wire/daqmx/daqmx_api.h"
#include "devices/wire/hid_link.h"
#include "devices/wire/modbus/modbus_link.h"
#include "devices/wire/serial_link.h"

namespace tactbench::bench {

namespace {

void add_serial_ports(std::vector<ScanEntry>& entries) {
  for (const devices::SerialPortInfo& port : devices::list_serial_ports()) {
    const std::string usb = port.usb_vendor < 0 ? "not USB, may have nothing attached"
                                                : fmt::format("USB {:04x}:{:04x}, usb_serial = \"{}\"", port.usb_vendor,
                                                              port.usb_product, port.usb_serial);
    entries.push_back({"serial port", port.name, fmt::format("{} ({})", port.description, usb)});
  }
}

void add_hid_devices(std::vector<ScanEntry>& entries) {
  for (const devices::HidInfo& hid : devices::list_hid_devices()) {
    entries.push_back(
        {"HID device", fmt::format("vendor_id = 0x{:04x}, product_id = 0x{:04x}", hid.vendor_id, hid.product_id),
         fmt::format("{}, serial \"{}\", {}", hid.product.empty() ? "unnamed" : hid.product, hid.serial, hid.path)});
  }
}

ScanEntry ask_modbus(const std::string& text) {
  devices::ModbusEndpoint endpoint;
  const std::size_t colon = text.find(':');
  endpoint.host = text.substr(0, colon);
  if (colon != std::string::npos) endpoint.port = std::atoi(text.c_str() + colon + 1);
  if (endpoint.host.empty() || endpoint.port <= 0 || endpoint.port > 65535) {
    throw Error("TB-USAGE", fmt::format("'{}' is not HOST or HOST:PORT", text), "--modbus " + text,
                "e.g. --modbus 192.168.0.10:502");
  }
  endpoint.response_timeout = std::chrono::milliseconds(500);
  devices::SteadyClock clock;
  devices::ModbusLink link(endpoint, "Modbus server", clock);
  std::array<std::uint16_t, 1> word{};
  std::string what;
  try {
    link.read_input_registers(0, word);
    what = fmt::format("answers; input register 0 holds {}", word[0]);
  } catch (const devices::Fault& fault) {
    what = fault.id() == "TB-MODBUS-EXCEPTION" ? "answers (and refuses to read input register 0)" : fault.what();
  }
  return {"Modbus TCP", text, what};
}

void add_daqmx(std::vector<ScanEntry>& entries) {
  try {
    devices::DaqmxApi api;
    for (const devices::DaqmxDevice& device : api.list_devices()) {
      entries.push_back({"NI-DAQmx", device.name,
                         fmt::format("{}, serial {}{}", device.product_type, device.serial,
                                     device.simulated ? " (simulated by the driver)" : "")});
    }
  } catch (const devices::Fault& fault) {
    entries.push_back({"NI-DAQmx", "-", fault.what()});
  }
}

}  // namespace

std::vector<ScanEntry> scan_devices(const std::vector<std::string>& modbus_hosts) {
  std::vector<ScanEntry> entries;
  add_serial_ports(entries);
  add_hid_devices(entries);
  for (const std::string& host : modbus_hosts) entries.push_back(ask_modbus(host));
  add_daqmx(entries);
  return entries;
}

}  // namespace tactbench::bench
