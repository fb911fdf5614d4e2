// Replaces hidapi in the unit tests of devices/: devices defined by the test, and calls that return what it specifies.
// For one thread.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
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

}  // namespace tactbench::devices
