// ReportLink over hidapi (hidraw backend). Not verified on hardware; verified on a kernel's uhid device in a virtual
// machine (tests/vm).
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "devices/wire/options.h"
#include "devices/wire/report_link.h"

namespace tactbench::devices {

struct HidInfo {
  std::uint16_t vendor_id = 0;
  std::uint16_t product_id = 0;
  std::string serial, product, path;
};
[[nodiscard]] std::vector<HidInfo> list_hid_devices();

// Opens the device. Throws Fault TB-HID-OPEN, listing the HID devices present.
std::unique_ptr<ReportLink> open_hid_link(const HidAddress& address);

}  // namespace tactbench::devices
