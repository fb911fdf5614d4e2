// The functions of libserialport that serial_link.cpp calls, in place of the library's own.
#include "tests/devices/wire/fake_serialport.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <tuple>

using tactbench::devices::fake_serial_ports;
using tactbench::devices::FakeSerialPorts;

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
