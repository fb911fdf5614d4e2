// Check sum of Modbus over serial line 1.02, section 6.2.2: polynomial 0xA001 reflected, start 0xFFFF; check value of
// "123456789" is 0x4B37. For frames that libmodbus does not send: simulated ends, and the Digital F/T's own functions.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace tactbench::devices {

std::uint16_t crc16_modbus(std::span<const std::uint8_t> bytes);
// `body` (unit, function, data) with its CRC, low byte first.
std::vector<std::uint8_t> rtu_frame(std::span<const std::uint8_t> body);

}  // namespace tactbench::devices
