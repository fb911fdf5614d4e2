// The functions of hidapi that hid_link.cpp calls, in place of the library's own.

#include "tests/devices/wire/fake_libraries.h"

#include <fcntl.h>
#include <hidapi/hidapi.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <tuple>

using tactbench::devices::fake_hid;
using tactbench::devices::fake_serial_ports;
using tactbench::devices::FakeHid;
using tactbench::devices::FakeSerialPorts;

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

// The functions of libserialport that serial_link.cpp calls, in place of the library's own.

struct sp_port {
  FakeSerialPorts::Port is;
  int handle = -1;
};

FakeSerialPorts& tactbench::devices::fake_serial_ports() {
  static FakeSerialPorts ports;
  return ports;
}

namespace {

bool fails(const char* function) { return fake_serial_ports().fail_function == function; }

sp_return result_of(const char* function) { return fails(function) ? fake_serial_ports().fail_code : SP_OK; }

sp_return noted(const char* function, long value) {
  fake_serial_ports().calls.push_back(std::string(function) + " " + std::to_string(value));
  return result_of(function);
}

char* text(const std::optional<std::string>& value) {
  return value ? const_cast<char*>(value->c_str()) : nullptr;  // as the library's own prototypes have it
}

sp_port* make(const FakeSerialPorts::Port& port) {
  ++fake_serial_ports().made;
  return std::make_unique<sp_port>(sp_port{port, -1}).release();
}

}  // namespace

extern "C" {

sp_return sp_get_port_by_name(const char* name, sp_port** port) {
  if (fails("sp_get_port_by_name")) return fake_serial_ports().fail_code;
  for (const auto& each : fake_serial_ports().ports) {
    if (each.name != name) continue;
    *port = make(each);
    return SP_OK;
  }
  return SP_ERR_ARG;
}

void sp_free_port(sp_port* port) {
  --fake_serial_ports().made;
  const std::unique_ptr<sp_port> freed(port);
}

sp_return sp_list_ports(sp_port*** list) {
  if (fails("sp_list_ports")) return fake_serial_ports().fail_code;
  const auto& ports = fake_serial_ports().ports;
  *list = static_cast<sp_port**>(std::calloc(ports.size() + 1, sizeof(sp_port*)));
  for (std::size_t i = 0; i < ports.size(); ++i) (*list)[i] = make(ports[i]);
  return SP_OK;
}

void sp_free_port_list(sp_port** list) {
  for (sp_port** port = list; *port != nullptr; ++port) sp_free_port(*port);
  std::free(list);
}

char* sp_get_port_name(const sp_port* port) { return const_cast<char*>(port->is.name.c_str()); }
char* sp_get_port_description(const sp_port* port) { return text(port->is.description); }
char* sp_get_port_usb_serial(const sp_port* port) { return text(port->is.usb_serial); }

sp_return sp_get_port_usb_vid_pid(const sp_port* port, int* vendor, int* product) {
  *vendor = *product = 0x5555;  // what a refusal leaves is not to be taken
  if (!port->is.vendor_and_product) return SP_ERR_ARG;
  std::tie(*vendor, *product) = *port->is.vendor_and_product;
  return SP_OK;
}

sp_return sp_open(sp_port* port, sp_mode mode) {
  const sp_return opened = noted("sp_open", mode);
  if (opened != SP_OK) return opened;
  port->handle = ::open(port->is.opens.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
  if (port->handle < 0) std::abort();
  ++fake_serial_ports().opened;
  return SP_OK;
}

sp_return sp_close(sp_port* port) {
  ::close(port->handle);
  --fake_serial_ports().opened;
  return SP_OK;
}

sp_return sp_get_port_handle(const sp_port* port, void* handle) {
  std::memcpy(handle, &port->handle, sizeof port->handle);
  return SP_OK;
}

int sp_last_error_code() { return fake_serial_ports().error_code; }

char* sp_last_error_message() {
  const auto& message = fake_serial_ports().error_text;
  return message ? ::strdup(message->c_str()) : nullptr;
}

void sp_free_error_message(char* message) { std::free(message); }

sp_return sp_set_baudrate(sp_port*, int value) { return noted("sp_set_baudrate", value); }
sp_return sp_set_bits(sp_port*, int value) { return noted("sp_set_bits", value); }
sp_return sp_set_parity(sp_port*, sp_parity value) { return noted("sp_set_parity", value); }
sp_return sp_set_stopbits(sp_port*, int value) { return noted("sp_set_stopbits", value); }
sp_return sp_set_flowcontrol(sp_port*, sp_flowcontrol value) { return noted("sp_set_flowcontrol", value); }

sp_return sp_flush(sp_port* port, sp_buffer buffers) {
  ::tcflush(port->handle, TCIFLUSH);
  return noted("sp_flush", buffers);
}

sp_return sp_blocking_write(sp_port* port, const void* bytes, std::size_t size, unsigned milliseconds) {
  const sp_return taken = noted("sp_blocking_write", milliseconds);
  if (taken != SP_OK) return taken;
  const auto& most = fake_serial_ports().write_takes;
  if (most) size = std::min(size, static_cast<std::size_t>(*most));
  return static_cast<sp_return>(size == 0 ? 0 : ::write(port->handle, bytes, size));
}

sp_return sp_nonblocking_read(sp_port* port, void* bytes, std::size_t size) {
  if (fails("sp_nonblocking_read")) return fake_serial_ports().fail_code;
  const ssize_t got = ::read(port->handle, bytes, size);
  if (got > 0 && fake_serial_ports().swallowed > 0) {
    --fake_serial_ports().swallowed;
    return SP_OK;
  }
  return static_cast<sp_return>(got > 0 ? got : 0);
}

sp_return sp_input_waiting(sp_port* port) {
  if (fails("sp_input_waiting")) return fake_serial_ports().fail_code;
  int waiting = 0;
  ::ioctl(port->handle, FIONREAD, &waiting);
  return static_cast<sp_return>(waiting);
}

}  // extern "C"
