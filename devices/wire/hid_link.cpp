#include "devices/wire/hid_link.h"

#include <fmt/format.h>
#include <hidapi/hidapi.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <string_view>

#include "devices/device.h"

namespace tactbench::devices {
namespace {

// hidapi speaks wchar_t; names of instruments are ASCII, anything else becomes '?'.
std::string narrow(const wchar_t* text) {
  std::string result;
  for (; text != nullptr && *text != L'\0'; ++text) result += *text < 128 ? static_cast<char>(*text) : '?';
  return result;
}

class HidLink final : public ReportLink {
 public:
  HidLink(hid_device* device, std::string description) : device_(device), description_(std::move(description)) {}
  ~HidLink() override { hid_close(device_); }
  HidLink(const HidLink&) = delete;
  HidLink& operator=(const HidLink&) = delete;

  void write(std::span<const std::uint8_t> report) override {
    int sent = -1;
    do {
      errno = 0;
      sent = hid_write(device_, report.data(), report.size());
    } while (sent < 0 && errno == EINTR);
    if (sent == static_cast<int>(report.size())) return;
    throw Fault(
        "TB-HID-WRITE", description_,
        fmt::format("sending a report of {} bytes to {}: {}", report.size(), description_, narrow(hid_error(device_))),
        "Plug the scanner in again and start again.");
  }

  std::size_t read(std::span<std::uint8_t> into, Nanoseconds timeout) override {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    auto left = timeout;
    for (;;) {
      errno = 0;
      const auto wait = std::chrono::ceil<std::chrono::milliseconds>(std::max(left, Nanoseconds(0)));
      const int got = hid_read_timeout(device_, into.data(), into.size(), static_cast<int>(wait.count()));
      if (got >= 0) return static_cast<std::size_t>(got);
      // hidapi does not retry an interrupted poll; a device that is gone leaves another errno, or none.
      if (errno != EINTR) lost();
      left = deadline - std::chrono::steady_clock::now();
    }
  }

  std::size_t drain() override {
    std::array<std::uint8_t, 1024> report{};
    std::size_t thrown = 0;
    while (thrown < kDrainLimit && read(report, Nanoseconds(0)) > 0) ++thrown;
    return thrown;
  }

  std::string description() const override { return description_; }

 private:
  static constexpr std::size_t kDrainLimit =
      10'000;  // the kernel keeps 63; bounds the wait for a sender that never stops

  [[noreturn]] void lost() const {
    throw Fault("TB-HID-LOST", description_,
                fmt::format("reading a report from {}: {}", description_, narrow(hid_error(device_))),
                "Plug the scanner in again and start again.");
  }

  hid_device* device_;
  std::string description_;
};

std::string devices_present() {
  std::string list;
  for (const HidInfo& info : list_hid_devices()) {
    list += fmt::format("{}{:04x}:{:04x} serial '{}' {}", list.empty() ? "" : ", ", info.vendor_id, info.product_id,
                        info.serial, info.product);
  }
  return list.empty() ? "none" : list;
}

}  // namespace

std::vector<HidInfo> list_hid_devices() {
  std::vector<HidInfo> list;
  hid_device_info* first = hid_enumerate(0, 0);
  for (const hid_device_info* info = first; info != nullptr; info = info->next) {
    list.push_back({info->vendor_id, info->product_id, narrow(info->serial_number), narrow(info->product_string),
                    info->path == nullptr ? "" : info->path});
  }
  hid_free_enumeration(first);
  return list;
}

std::unique_ptr<ReportLink> open_hid_link(const HidAddress& address) {
  const std::string name = fmt::format("HID device {:04x}:{:04x}{}", address.vendor_id, address.product_id,
                                       address.serial.empty() ? std::string() : " serial '" + address.serial + "'");
  const std::wstring serial(address.serial.begin(), address.serial.end());
  hid_device* device =
      hid_open(address.vendor_id, address.product_id, address.serial.empty() ? nullptr : serial.c_str());
  if (device == nullptr) {
    throw Fault(
        "TB-HID-OPEN", name,
        fmt::format("opening {}: {}; HID devices present: {}", name, narrow(hid_error(nullptr)), devices_present()),
        "Plug the scanner in, check ids and serial in the bench file, and check that a udev rule lets this "
        "user open it.");
  }
  return std::make_unique<HidLink>(device, name);
}

}  // namespace tactbench::devices
