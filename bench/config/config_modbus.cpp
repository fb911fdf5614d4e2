#include "bench/config/config_modbus.h"

#include <fmt/format.h>

#include "bench/common/process_time.h"

namespace tactbench::bench {

using sequences::TomlTable;

devices::ModbusEndpoint read_endpoint(const TomlTable& table, bool simulated, devices::Nanoseconds max_reply_delay) {
  devices::ModbusEndpoint endpoint;
  const bool rtu = table.word("transport", "tcp", {"tcp", "rtu"}) == "rtu";
  if (rtu) {
    endpoint.serial_port = simulated ? table.text("serial_port", kSimulatedLine) : table.text("serial_port");
    if (endpoint.serial_port.empty()) table.fail("serial_port", "no serial port is named", "e.g. \"/dev/ttyUSB0\"");
    endpoint.baud = static_cast<int>(table.integer("baud", 9600, 110, 921600));
    endpoint.parity = table.word("parity", "N", {"N", "E", "O"})[0];
    endpoint.stop_bits = static_cast<int>(table.integer("stop_bits", 1, 1, 2));
    endpoint.unit = static_cast<int>(table.integer("unit", 1, 1, 247));
    endpoint.max_reply_delay = seconds(
        table.number_in("max_reply_delay_ms", static_cast<double>(max_reply_delay.count()) * 1e-6, 1, 60000) / 1000.0);
  } else {
    for (const char* key : {"serial_port", "baud", "parity", "stop_bits", "max_reply_delay_ms"}) {
      if (table.has(key)) table.fail(key, fmt::format("'{}' belongs to a serial line", key), "add transport = \"rtu\"");
    }
    endpoint.host = table.text("host", endpoint.host);
    endpoint.port = static_cast<int>(table.integer("port", 502, 0, 65535));
    endpoint.unit = static_cast<int>(table.integer("unit", 1, 0, 255));
  }
  endpoint.response_timeout = seconds(table.number_in("response_timeout_ms", 500, 10, 10000) / 1000.0);
  return endpoint;
}

devices::RegisterFormat read_format(const TomlTable& table, const std::string& default_type) {
  const std::vector<std::string> names(devices::kRegisterTypes.begin(), devices::kRegisterTypes.end());
  const std::string type = table.word("type", default_type, names);
  devices::RegisterFormat format;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == type) format.type = static_cast<devices::RegisterType>(i);
  }
  format.low_word_first = table.word("word_order", "high-first", {"high-first", "low-first"}) == "low-first";
  return format;
}

devices::ModbusQuantity read_quantity_place(const TomlTable& table, const std::string& physical_key) {
  devices::ModbusQuantity quantity;
  quantity.function = static_cast<int>(table.integer("function", 4, 3, 4));
  quantity.address = static_cast<int>(table.integer("address", 0, 65535));
  quantity.spare = static_cast<int>(table.integer("spare", 0, 0, 8));
  quantity.format = read_format(table, "u16");
  const auto raw = table.span("raw_span", {0.0, 1.0});
  const auto physical = table.span(physical_key, {0.0, 1.0});
  quantity.scale = {raw.first, raw.second, physical.first, physical.second};
  return quantity;
}

}  // namespace tactbench::bench
