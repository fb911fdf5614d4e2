// Modbus addresses in configuration files: the address of a device (TCP or serial line) and of a quantity in it.
#pragma once

#include <string>
#include <vector>

#include "devices/clock.h"
#include "devices/pressure/options.h"
#include "devices/wire/modbus/modbus_value.h"
#include "devices/wire/options.h"
#include "sequences/toml/key_table.h"

namespace tactbench::bench {

// Keys transport ("tcp" unless "rtu"), host, port | serial_port, baud, parity, stop_bits, local_echo; unit,
// response_timeout_ms, max_reply_delay_ms. On a simulated bench serial_port may be left out: the simulated line is
// used.
devices::ModbusEndpoint read_endpoint(const sequences::TomlTable& table, bool simulated,
                                      devices::Nanoseconds max_reply_delay);
void add_endpoint_keys(std::vector<sequences::KeyFacts>& all, const std::string& path);
// Unit number of a device on the module's line.
sequences::KeyTable unit_keys(devices::ModbusEndpoint& endpoint, long lowest);
// Keys type, word_order.
sequences::KeyTable format_keys(devices::RegisterFormat& format);
// Keys function, address, spare, type, word_order, raw_span; `physical_key` (such as "span_psi") is the range in the
// physical unit.
sequences::KeyTable quantity_keys(devices::ModbusQuantity& quantity, const char* physical_key, const char* unit,
                                  const char* physical_meaning);

// Placeholder for the serial port of a simulated line until the line exists.
inline constexpr const char* kSimulatedLine = "simulated line";

}  // namespace tactbench::bench
