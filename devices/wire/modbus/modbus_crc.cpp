#include "devices/wire/modbus/modbus_crc.h"

namespace tactbench::devices {

std::uint16_t crc16_modbus(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1U ^ 0xA001U : crc >> 1U;
  }
  return static_cast<std::uint16_t>(crc);
}

std::vector<std::uint8_t> rtu_frame(std::span<const std::uint8_t> body) {
  std::vector<std::uint8_t> frame(body.begin(), body.end());
  const unsigned crc = crc16_modbus(body);
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8U));
  return frame;
}

}  // namespace tactbench::devices
