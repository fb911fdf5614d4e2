// Modbus addresses in configuration files: the address of a device (TCP or serial line) and of a quantity in it.
#pragma once

#include <string>
#include <utility>

#include "devices/clock.h"
#include "devices/pressure/options.h"
#include "devices/wire/modbus/modbus_value.h"
#include "devices/wire/options.h"
#include "sequences/toml/strict_toml.h"

namespace tactbench::bench {

// Keys transport ("tcp" unless `rtu_only`), host, port | serial_port, baud, parity, stop_bits; unit,
// response_timeout_ms, max_reply_delay_ms. On a simulated bench serial_port may be left out: the simulated line is
// used.
devices::ModbusEndpoint read_endpoint(const sequences::TomlTable& table, bool simulated,
                                      devices::Nanoseconds max_reply_delay);
// Keys type, word_order.
devices::RegisterFormat read_format(const sequences::TomlTable& table, const std::string& default_type);
// Keys function, address, spare, type, word_order, raw_span; `physical_key` (such as "span_psi") is its other end.
devices::ModbusQuantity read_quantity_place(const sequences::TomlTable& table, const std::string& physical_key);

// Placeholder for the serial port of a simulated line until the line exists.
inline constexpr const char* kSimulatedLine = "simulated line";

}  // namespace tactbench::bench
