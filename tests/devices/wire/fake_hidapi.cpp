// The functions of hidapi that hid_link.cpp calls, in place of the library's own.
#include "tests/devices/wire/fake_hidapi.h"

#include <hidapi/hidapi.h>

#include <algorithm>
#include <cerrno>
#include <memory>

using tactbench::devices::fake_hid;
using tactbench::devices::FakeHid;

struct hid_device_ {};

FakeHid& tactbench::devices::fake_hid() {
  static FakeHid hid;
  return hid;
}

namespace {

FakeHid::Result next() {
  FakeHid& hid = fake_hid();
  FakeHid::Result result = hid.usual;
  if (!hid.results.empty()) {
    result = hid.results.front();
    hid.results.pop_front();
  }
  if (result.error != 0) errno = result.error;
  return result;
}

wchar_t* text(std::optional<std::wstring>& value) { return value ? value->data() : nullptr; }

}  // namespace

extern "C" {

hid_device_info* hid_enumerate(unsigned short vendor_id, unsigned short product_id) {
  hid_device_info* first = nullptr;
  auto& devices = fake_hid().devices;
  for (auto device = devices.rbegin(); device != devices.rend(); ++device) {
    if ((vendor_id != 0 && vendor_id != device->vendor_id) || (product_id != 0 && product_id != device->product_id))
      continue;
    auto info = std::make_unique<hid_device_info>();
    info->path = device->path ? device->path->data() : nullptr;
    info->vendor_id = device->vendor_id;
    info->product_id = device->product_id;
    info->serial_number = text(device->serial);
    info->product_string = text(device->product);
    info->next = first;
    first = info.release();
  }
  ++fake_hid().lists;
  return first;
}

void hid_free_enumeration(hid_device_info* first) {
  --fake_hid().lists;
  while (first != nullptr) {
    const std::unique_ptr<hid_device_info> freed(first);
    first = freed->next;
  }
}

hid_device* hid_open(unsigned short vendor_id, unsigned short product_id, const wchar_t* serial) {
  FakeHid& hid = fake_hid();
  hid.asked_serials.push_back(serial != nullptr ? std::optional<std::wstring>(serial) : std::nullopt);
  const bool known = std::any_of(hid.devices.begin(), hid.devices.end(), [&](const FakeHid::Device& device) {
    return device.vendor_id == vendor_id && device.product_id == product_id &&
           (serial == nullptr || device.serial == serial);
  });
  if (!known) return nullptr;
  ++hid.opened;
  return std::make_unique<hid_device>().release();
}

void hid_close(hid_device* device) {
  --fake_hid().opened;
  const std::unique_ptr<hid_device> closed(device);
}

int hid_write(hid_device*, const unsigned char* bytes, std::size_t size) {
  fake_hid().written.emplace_back(bytes, bytes + size);
  return next().returned;
}

int hid_read_timeout(hid_device*, unsigned char* into, std::size_t size, int milliseconds) {
  fake_hid().waits.push_back(milliseconds);
  const int returned = next().returned;
  if (returned > 0) std::fill_n(into, std::min(size, static_cast<std::size_t>(returned)), std::uint8_t{0x5A});
  return returned;
}

const wchar_t* hid_error(hid_device*) { return text(fake_hid().error); }

}  // extern "C"
