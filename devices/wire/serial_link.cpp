#include "devices/wire/serial_link.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <libserialport.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>

#include <array>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

#include "devices/device.h"
#include "devices/wire/stream_link.h"
#include "devices/wire/wait.h"

namespace tactbench::devices {
namespace {

using Port = std::unique_ptr<sp_port, decltype(&sp_free_port)>;

constexpr unsigned kWriteMilliseconds = 1000;

// The library gives numbers of bytes, too, in its enumeration of errors, which in C++ cannot hold them: they are taken
// as int.
std::string reason(int result) {
  if (result == SP_ERR_ARG) return "no such port";
  if (result == SP_ERR_SUPP) return "the port does not support that setting";
  if (result != SP_ERR_FAIL) return fmt::format("libserialport's error {}", result);
  char* text = sp_last_error_message();
  std::string copy = text != nullptr ? text : "unknown";
  sp_free_error_message(text);
  return copy;
}

class SerialLink final : public ByteStream {
 public:
  SerialLink(Port port, int handle, std::string name)
      : port_(std::move(port)), handle_(handle), name_(std::move(name)) {}
  ~SerialLink() override { sp_close(port_.get()); }
  SerialLink(const SerialLink&) = delete;
  SerialLink& operator=(const SerialLink&) = delete;

  void write(std::span<const std::uint8_t> bytes) override {
    const int sent = sp_blocking_write(port_.get(), bytes.data(), bytes.size(), kWriteMilliseconds);
    if (sent < 0) lost("sending to", reason(sent));
    if (static_cast<std::size_t>(sent) < bytes.size()) {
      throw Fault("TB-SERIAL-TIMEOUT", name_,
                  fmt::format("sending {} bytes to {}: {} were taken within {} ms", bytes.size(), name_, sent,
                              kWriteMilliseconds),
                  "Check the cable and that no other device holds the line.");
    }
  }

  // sp_blocking_read() spins on a lost port and then reports silence; poll() waits without spinning, and after an empty
  // read the port is probed.
  std::size_t read(std::span<std::uint8_t> into, Nanoseconds timeout) override {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    for (auto left = timeout;; left = deadline - std::chrono::steady_clock::now()) {
      const short events = wait_for(handle_, POLLIN, left);
      const int got = sp_nonblocking_read(port_.get(), into.data(), into.size());
      if (got > 0) return static_cast<std::size_t>(got);
      if (got < 0) lost("reading from", reason(got));
      const int waiting = sp_input_waiting(port_.get());
      if (waiting < 0) lost("reading from", reason(waiting));
      if ((events & (POLLHUP | POLLERR | POLLNVAL)) != 0) lost("reading from", "the port hung up");
      if (events == 0) return 0;
    }
  }

  std::size_t discard() override {
    const int waiting = sp_input_waiting(port_.get());
    if (waiting < 0) lost("reading from", reason(waiting));
    const int flushed = sp_flush(port_.get(), SP_BUF_INPUT);
    if (flushed != SP_OK) lost("reading from", reason(flushed));
    return static_cast<std::size_t>(waiting);
  }

  std::string description() const override { return name_; }
  int descriptor() const override { return handle_; }

 private:
  [[noreturn]] void lost(const char* doing, const std::string& why) const {
    throw Fault("TB-SERIAL-LOST", name_, fmt::format("{} serial port {}: {}", doing, name_, why),
                "Plug the instrument in again and reconnect.");
  }

  Port port_;
  int handle_;
  std::string name_;
};

std::string ports_present() {
  std::string list;
  for (const SerialPortInfo& port : list_serial_ports()) {
    list += list.empty() ? port.name : ", " + port.name;
    if (!port.usb_serial.empty()) list += fmt::format(" (serial {})", port.usb_serial);
  }
  return list.empty() ? "none" : list;
}

[[noreturn]] void fail_open(const std::string& name, const std::string& why) {
  throw Fault("TB-SERIAL-OPEN", name,
              fmt::format("opening serial port {}: {}; present: {}", name, why, ports_present()),
              "Plug the instrument in, correct port or usb_serial in the bench file, or join the group of the port.");
}

[[noreturn]] void busy(const std::string& name) {
  throw Fault("TB-SERIAL-BUSY", name, fmt::format("opening serial port {}: another program or device holds it", name),
              "Close the other program, or correct the port in the bench file.");
}

std::string port_with_serial(const std::string& usb_serial) {
  for (const SerialPortInfo& port : list_serial_ports()) {
    if (port.usb_serial == usb_serial) return port.name;
  }
  fail_open("with USB serial " + usb_serial, "no port carries it");
}

// libserialport does not follow links such as those below /dev/serial/by-id.
std::string resolved(const std::string& name) {
  std::error_code error;
  const auto path = std::filesystem::canonical(name, error);
  return error ? name : path.string();
}

void check_usb_serial(const sp_port* port, const SerialAddress& address, const std::string& name) {
  const char* serial = sp_get_port_usb_serial(port);
  const std::string found = serial != nullptr ? serial : "";
  if (address.usb_serial.empty() || found == address.usb_serial) return;
  fail_open(name, fmt::format("its USB serial is '{}', expected '{}'", found, address.usb_serial));
}

sp_parity parity_of(const SerialAddress& address) {
  switch (address.parity) {
    case 'N':
      return SP_PARITY_NONE;
    case 'E':
      return SP_PARITY_EVEN;
    case 'O':
      return SP_PARITY_ODD;
    default:
      fail_open(address.port, fmt::format("parity '{}' is none of N, E, O", address.parity));
  }
}

void configure(sp_port* port, const SerialAddress& address, const std::string& name) {
  const sp_parity parity = parity_of(address);
  const auto set = [&](sp_return result, const char* what) {
    if (result != SP_OK) fail_open(name, fmt::format("setting {}: {}", what, reason(result)));
  };
  set(sp_set_baudrate(port, address.baud), "baud rate");
  set(sp_set_bits(port, 8), "data bits");
  set(sp_set_parity(port, parity), "parity");
  set(sp_set_stopbits(port, address.stop_bits), "stop bits");
  set(sp_set_flowcontrol(port, SP_FLOWCONTROL_NONE), "flow control");
  set(sp_flush(port, SP_BUF_BOTH), "empty buffers");
}

}  // namespace

std::vector<SerialPortInfo> list_serial_ports() {
  std::vector<SerialPortInfo> result;
  sp_port** ports = nullptr;
  if (sp_list_ports(&ports) != SP_OK) return result;
  const auto text = [](const char* value) { return std::string(value != nullptr ? value : ""); };
  for (sp_port** port = ports; *port != nullptr; ++port) {
    SerialPortInfo info;
    info.name = text(sp_get_port_name(*port));
    info.description = text(sp_get_port_description(*port));
    info.usb_serial = text(sp_get_port_usb_serial(*port));
    if (sp_get_port_usb_vid_pid(*port, &info.usb_vendor, &info.usb_product) != SP_OK) {
      info.usb_vendor = info.usb_product = -1;
    }
    result.push_back(std::move(info));
  }
  sp_free_port_list(ports);
  return result;
}

std::unique_ptr<ByteStream> open_serial(const SerialAddress& address) {
  if (address.port.empty() && address.usb_serial.empty()) fail_open("''", "neither a port nor a USB serial is given");
  constexpr Nanoseconds kStream = std::chrono::seconds(2);
  if (is_stream_address(address.port)) return open_stream(address.port, kStream, address.lock);
  const std::string name = address.port.empty() ? port_with_serial(address.usb_serial) : resolved(address.port);
  if (is_stream_address(name)) return open_stream(name, kStream, address.lock);

  sp_port* found = nullptr;
  sp_return result = sp_get_port_by_name(name.c_str(), &found);
  if (result != SP_OK) fail_open(name, reason(result));
  Port port(found, &sp_free_port);
  check_usb_serial(port.get(), address, name);
  result = sp_open(port.get(), SP_MODE_READ_WRITE);
  if (result == SP_ERR_FAIL && sp_last_error_code() == EBUSY) busy(name);
  if (result != SP_OK) fail_open(name, reason(result));
  int handle = -1;
  sp_get_port_handle(port.get(), &handle);
  // From here the link closes the port, whatever fails. flock() keeps other tactbench programs out, TIOCEXCL all but
  // root.
  auto link = std::make_unique<SerialLink>(std::move(port), handle, name);
  if (address.lock && ::flock(handle, LOCK_EX | LOCK_NB) != 0) busy(name);
  if (address.exclusive) ::ioctl(handle, TIOCEXCL);
  ::fcntl(handle, F_SETFD, FD_CLOEXEC);  // sp_open() lets child processes inherit the port
  configure(found, address, name);
  return link;
}

}  // namespace tactbench::devices
