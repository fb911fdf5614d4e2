// Replaces hidapi in the unit tests of devices/: devices defined by the test, and calls that return what it specifies.
// For one thread.
#pragma once

#include <libserialport.h>

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace tactbench::devices {

struct FakeHid {
  struct Device {
    unsigned short vendor_id = 0, product_id = 0;
    std::optional<std::wstring> serial, product;  // empty: the library returns no text
    std::optional<std::string> path;
  };
  struct Result {
    int returned = 0;
    int error = 0;  // what the call leaves in errno; 0: it leaves errno alone
  };
  std::vector<Device> devices;
  std::deque<Result> results;  // of the next writes and readings; afterwards `usual`
  Result usual;
  std::optional<std::wstring> error = L"";

  // Record of the calls.
  int opened = 0;  // not closed yet
  int lists = 0;   // not freed yet
  std::vector<std::optional<std::wstring>> asked_serials;
  std::vector<int> waits;  // of the readings, milliseconds
  std::vector<std::vector<std::uint8_t>> written;
};

FakeHid& fake_hid();

// Replaces libserialport in the unit tests of devices/: ports defined by the test, each a terminal of its own; calls
// fail where the test specifies. For one thread.

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
