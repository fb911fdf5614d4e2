// Replaces libserialport in the unit tests of devices/: ports defined by the test, each a terminal of its own; calls
// fail where the test specifies. For one thread.
#pragma once

#include <libserialport.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tactbench::devices {

struct FakeSerialPorts {
  struct Port {
    std::string name;
    std::optional<std::string> description, usb_serial;     // empty: the library returns no text
    std::optional<std::pair<int, int>> vendor_and_product;  // empty: no USB port
    std::string opens;                                      // the file behind it
  };
  std::vector<Port> ports;
  std::string fail_function;  // "sp_open": returns fail_code
  sp_return fail_code = SP_ERR_FAIL;
  int error_code = 0;                          // of the last error
  std::optional<std::string> error_text = "";  // empty: the library has none
  std::optional<int> write_takes;              // bytes that a write takes at most
  int swallowed = 0;                           // so many readings take what waits and return nothing

  // Record of the calls.
  std::vector<std::string> calls;  // settings, openings, flushes and writes, each with its number
  int opened = 0;                  // not closed yet
  int made = 0;                    // ports that are not freed yet
};

FakeSerialPorts& fake_serial_ports();

}  // namespace tactbench::devices
