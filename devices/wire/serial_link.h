// ByteStream over a serial port (libserialport), without its pitfalls: unplugging is an immediate fault instead of
// silence, waiting does not load a core, and only one program can hold a port.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "devices/wire/byte_stream.h"
#include "devices/wire/options.h"

namespace tactbench::devices {

struct SerialPortInfo {
  std::string name;
  std::string description;
  int usb_vendor = -1;  // -1: not a USB port
  int usb_product = -1;
  std::string usb_serial;
};

// Ports of the system, without pseudo-terminals; a port may have nothing attached.
[[nodiscard]] std::vector<SerialPortInfo> list_serial_ports();

// Opens the port with eight data bits and no handshake; discards unread bytes. Addresses for open_stream() are passed
// to it, because libserialport opens only ports. Throws Fault TB-SERIAL-OPEN, and TB-SERIAL-BUSY when another program
// holds the port. Each write() takes at most one second.
[[nodiscard]] std::unique_ptr<ByteStream> open_serial(const SerialAddress& address);

}  // namespace tactbench::devices
