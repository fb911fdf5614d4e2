// Addresses of instruments, as a bench file states them: a Modbus unit, a serial port, a HID device, inputs of an NI
// card.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "devices/clock.h"

namespace tactbench::devices {

struct ModbusEndpoint {
  std::string host = "127.0.0.1";
  int port = 502;
  int unit = 1;
  Nanoseconds response_timeout = std::chrono::milliseconds(500);
  // How long a request to a busy device is repeated, in process time.
  Nanoseconds busy_time = std::chrono::milliseconds(500);
  std::string serial_port = {};  // not empty: RTU on this port instead of TCP
  int baud = 9600;               // RTU: a rate that libmodbus supports (it silently uses 9600 for any other)
  char parity = 'N';             // N, E or O
  int stop_bits = 1;
  Nanoseconds max_reply_delay = std::chrono::milliseconds(1000);  // RTU: no answer comes later than this
  bool local_echo = false;  // RTU: the adapter echoes what is sent; the echo is read first and compared
  // RTU: protects the open port against other programs. A dead-man must reach the line of a hung program: the program
  // then does not set `exclusive` (its lock still keeps other tactbench programs out), and the dead-man sets neither.
  bool lock = true;       // flock()
  bool exclusive = true;  // TIOCEXCL
};

struct SerialAddress {
  std::string port;  // "/dev/ttyUSB0", a link such as /dev/serial/by-id/..., or an address for open_stream()
  int baud = 9600;
  char parity = 'N';  // 'N', 'E' or 'O'
  int stop_bits = 1;
  std::string usb_serial;  // with a port: the port must have this serial number; without: the port with this serial
                           // number is used
  bool lock = true;        // as in ModbusEndpoint; a pseudo-terminal never has TIOCEXCL
  bool exclusive = true;
};

struct HidAddress {
  std::uint16_t vendor_id = 0;
  std::uint16_t product_id = 0;
  std::string serial;  // empty: the first that matches
};

enum class DaqmxTerminal { kRse, kNrse, kDifferential };

}  // namespace tactbench::devices
