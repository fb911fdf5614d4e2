#include "bench/config/config_modbus.h"

#include <fmt/format.h>

namespace tactbench::bench {

using sequences::KeyTable;
using sequences::kMilliseconds;
using sequences::kOne;
using sequences::TomlTable;
namespace key = sequences::key;

namespace {

KeyTable transport_keys(bool& rtu) {
  return {
      key::word("transport", rtu, {"tcp", "rtu"}, "rtu", "Modbus over the network (tcp) or over a serial line (rtu)")};
}

KeyTable rtu_keys(devices::ModbusEndpoint& endpoint, bool simulated) {
  if (simulated) endpoint.serial_port = kSimulatedLine;
  const sequences::Key port =
      key::text("serial_port", endpoint.serial_port,
                "Serial line, for transport = \"rtu\": a device, preferably a name in /dev/serial/by-id");
  return {
      simulated ? port : key::required(port),
      key::number("baud", endpoint.baud, {"bit/s"}, {110, 921600}, "Speed of the serial line"),
      key::word("parity", endpoint.parity, {"N", "E", "O"}, "Parity of the serial line: none, even or odd"),
      key::number("stop_bits", endpoint.stop_bits, kOne, {1, 2}, "Stop bits of the serial line"),
      key::number("unit", endpoint.unit, kOne, {1, 247}, ""),
      key::flag("local_echo", endpoint.local_echo,
                "Whether the adapter of the serial line echoes what is sent; the echo is read first and compared"),
      key::number("max_reply_delay_ms", endpoint.max_reply_delay, kMilliseconds, {1.0, 60000.0},
                  "Longest delay of an answer on a serial line; after an error the line is not used for this long")};
}

KeyTable tcp_keys(devices::ModbusEndpoint& endpoint) {
  return {key::text("host", endpoint.host, "Address of the instrument in the network"),
          key::number("port", endpoint.port, kOne, {0, 65535},
                      "Port of the instrument in the network; 0 on a simulated bench: any free one"),
          key::number("unit", endpoint.unit, kOne, {0, 255},
                      "Modbus unit number; without a host or serial_port of its own, a unit on the module's line")};
}

KeyTable response_keys(devices::ModbusEndpoint& endpoint) {
  return {key::number("response_timeout_ms", endpoint.response_timeout, kMilliseconds, {10.0, 10000.0},
                      "Longest time to wait for an answer")};
}

}  // namespace

devices::ModbusEndpoint read_endpoint(const TomlTable& table, bool simulated, devices::Nanoseconds max_reply_delay) {
  devices::ModbusEndpoint endpoint;
  endpoint.max_reply_delay = max_reply_delay;
  bool rtu = false;
  read_keys(table, transport_keys(rtu));
  if (rtu) {
    read_keys(table, rtu_keys(endpoint, simulated));
    if (endpoint.serial_port.empty()) table.fail("serial_port", "no serial port is named", "e.g. \"/dev/ttyUSB0\"");
  } else {
    for (const char* key : {"serial_port", "baud", "parity", "stop_bits", "local_echo", "max_reply_delay_ms"}) {
      if (table.has(key)) table.fail(key, fmt::format("'{}' belongs to a serial line", key), "add transport = \"rtu\"");
    }
    read_keys(table, tcp_keys(endpoint));
  }
  read_keys(table, response_keys(endpoint));
  endpoint.busy_time = endpoint.response_timeout;
  return endpoint;
}

void add_endpoint_keys(std::vector<sequences::KeyFacts>& all, const std::string& path) {
  devices::ModbusEndpoint endpoint;
  bool rtu = false;
  for (const KeyTable& keys :
       {transport_keys(rtu), tcp_keys(endpoint), rtu_keys(endpoint, false), response_keys(endpoint)})
    add_facts(all, path, keys);
}

KeyTable unit_keys(devices::ModbusEndpoint& endpoint, long lowest) {
  return {key::required(key::number("unit", endpoint.unit, kOne, {static_cast<double>(lowest), 247},
                                    "Number of a unit on the module's line"))};
}

KeyTable format_keys(devices::RegisterFormat& format) {
  return {key::word("type", format.type, {devices::kRegisterTypes.begin(), devices::kRegisterTypes.end()},
                    "How the registers hold the number"),
          key::word("word_order", format.low_word_first, {"high-first", "low-first"}, "low-first",
                    "Which of two registers comes first")};
}

KeyTable quantity_keys(devices::ModbusQuantity& quantity, const char* physical_key, const char* unit,
                       const char* physical_meaning) {
  KeyTable keys = {key::number("function", quantity.function, kOne, {3, 4},
                               "Modbus function that reads it: 3 holding registers, 4 input registers"),
                   key::required(key::number("address", quantity.address, kOne, {0, 65535},
                                             "Address of its first register, counted from 0")),
                   key::number("spare", quantity.spare, kOne, {0, 8},
                               "Readable registers after it; RTU readings then change length, which shows a stale "
                               "answer")};
  for (const sequences::Key& row : format_keys(quantity.format)) keys.push_back(row);
  keys.push_back(key::span("raw_span", quantity.scale.raw_low, quantity.scale.raw_high, {"counts"},
                           "Two values of the register; they correspond to the ends of the physical span"));
  keys.push_back(key::span(physical_key, quantity.scale.low, quantity.scale.high, {unit}, physical_meaning));
  return keys;
}

}  // namespace tactbench::bench
