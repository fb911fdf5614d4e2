#include "devices/wire/byte_stream.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <libserialport.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "devices/device.h"
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

namespace {

constexpr const char* kPty = "/dev/pts/";
constexpr const char* kTcp = "tcp:";
constexpr const char* kUnix = "unix:";

class Descriptor {
 public:
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  Descriptor& operator=(Descriptor&&) = delete;
  [[nodiscard]] int get() const { return number_; }

 private:
  int number_;
};

class StreamLink final : public ByteStream {
 public:
  StreamLink(Descriptor descriptor, std::string address, bool socket, Nanoseconds write_timeout)
      : descriptor_(std::move(descriptor)),
        address_(std::move(address)),
        socket_(socket),
        write_timeout_(write_timeout) {}

  void write(std::span<const std::uint8_t> bytes) override {
    const auto deadline = std::chrono::steady_clock::now() + write_timeout_;
    const std::size_t asked = bytes.size();
    while (!bytes.empty()) {
      const ssize_t sent = socket_ ? ::send(descriptor_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL)
                                   : ::write(descriptor_.get(), bytes.data(), bytes.size());
      if (sent > 0) {
        bytes = bytes.subspan(static_cast<std::size_t>(sent));
      } else if (sent == 0 || (errno != EAGAIN && errno != EINTR)) {
        lost("sending to", sent == 0 ? "it takes no bytes" : std::strerror(errno));
      } else if (wait_for(descriptor_.get(), POLLOUT, deadline - std::chrono::steady_clock::now()) == 0) {
        throw Fault("TB-SERIAL-TIMEOUT", address_,
                    fmt::format("sending {} bytes to {}: {} were not taken within {:g} s", asked, address_,
                                bytes.size(), std::chrono::duration<double>(write_timeout_).count()),
                    "Check that the program or instrument at the other end still runs.");
      }
    }
  }

  std::size_t read(std::span<std::uint8_t> into, Nanoseconds timeout) override {
    const auto deadline = std::chrono::steady_clock::now() + timeout;
    for (auto left = timeout;; left = deadline - std::chrono::steady_clock::now()) {
      if (wait_for(descriptor_.get(), POLLIN, left) == 0) return 0;
      const ssize_t got = ::read(descriptor_.get(), into.data(), into.size());
      if (got > 0) return static_cast<std::size_t>(got);
      // Readable without a byte: a closed socket, or a pseudo-terminal that was hung up.
      if (got == 0) lost("reading from", "closed by the other side");
      if (errno != EAGAIN && errno != EINTR) lost("reading from", std::strerror(errno));
    }
  }

  std::size_t discard() override {
    std::array<std::uint8_t, 4096> bytes{};
    std::size_t thrown = 0;
    while (thrown < kDiscardLimit) {
      const std::size_t got = read(bytes, Nanoseconds(0));
      if (got == 0) break;
      thrown += got;
    }
    return thrown;
  }

  std::string description() const override { return address_; }
  int descriptor() const override { return descriptor_.get(); }

 private:
  static constexpr std::size_t kDiscardLimit = 1U << 20U;  // bounds the wait for a sender that never stops

  [[noreturn]] void lost(const char* doing, const char* why) const {
    throw Fault("TB-SERIAL-LOST", address_, fmt::format("{} {}: {}", doing, address_, why),
                "Plug the instrument in again (or start its program) and reconnect.");
  }

  Descriptor descriptor_;
  std::string address_;
  bool socket_;
  Nanoseconds write_timeout_;
};

[[noreturn]] void fail_open_stream(const std::string& address, const std::string& why) {
  throw Fault("TB-SERIAL-OPEN", address, fmt::format("opening {}: {}", address, why),
              "Check that the instrument or its simulator runs and that the address in the bench file is its own.");
}

// O_NOCTTY: the terminal must not become the controlling one, which could hang up this program. flock() alone keeps a
// second client out: TIOCEXCL would stay set after a killed client, since the simulated end keeps the terminal open.
Descriptor open_pty(const std::string& path, bool lock) {
  Descriptor opened(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (opened.get() < 0) fail_open_stream(path, std::strerror(errno));
  if (lock && ::flock(opened.get(), LOCK_EX | LOCK_NB) != 0) {
    if (errno != EWOULDBLOCK) fail_open_stream(path, std::strerror(errno));
    throw Fault("TB-SERIAL-BUSY", path, fmt::format("opening {}: another program or device holds it", path),
                "Close the other program, or correct the address in the bench file.");
  }
  termios settings{};
  if (::tcgetattr(opened.get(), &settings) != 0) fail_open_stream(path, std::strerror(errno));
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cc[VMIN] = 1;
  settings.c_cc[VTIME] = 0;
  if (::tcsetattr(opened.get(), TCSANOW, &settings) != 0) fail_open_stream(path, std::strerror(errno));
  ::tcflush(opened.get(), TCIFLUSH);  // replies left by an earlier client
  return opened;
}

// -1 when the other end refused or did not answer in time; `why` then holds the reason.
int connect_within(int domain, const sockaddr* address, socklen_t size, Nanoseconds timeout, std::string& why) {
  const int socket = ::socket(domain, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  int error = socket < 0 ? errno : 0;
  if (error == 0 && ::connect(socket, address, size) != 0) {
    error = errno;
    if (error == EINPROGRESS) {
      error = ETIMEDOUT;
      socklen_t length = sizeof error;
      if (wait_for(socket, POLLOUT, timeout) != 0) ::getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &length);
    }
  }
  if (error == 0) return socket;
  why = std::strerror(error);
  if (socket >= 0) ::close(socket);
  return -1;
}

Descriptor connect_unix(const std::string& address, Nanoseconds timeout) {
  const std::string path = address.substr(std::strlen(kUnix));
  sockaddr_un local{};
  local.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof local.sun_path) fail_open_stream(address, "the path is empty or too long");
  std::copy(path.begin(), path.end(), local.sun_path);
  std::string why;
  Descriptor opened(connect_within(AF_UNIX, reinterpret_cast<const sockaddr*>(&local), sizeof local, timeout, why));
  if (opened.get() < 0) fail_open_stream(address, why);
  return opened;
}

Descriptor connect_tcp(const std::string& address, Nanoseconds timeout) {
  const std::string rest = address.substr(std::strlen(kTcp));
  const std::size_t colon = rest.rfind(':');
  if (colon == std::string::npos || colon == 0 || colon + 1 == rest.size()) {
    fail_open_stream(address, "the address is not of the form tcp:HOST:PORT");
  }
  std::string host = rest.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') host = host.substr(1, host.size() - 2);
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int result = ::getaddrinfo(host.c_str(), rest.substr(colon + 1).c_str(), &hints, &found);
  if (result != 0) fail_open_stream(address, ::gai_strerror(result));
  std::string why = "no address";
  int socket = -1;
  for (const addrinfo* one = found; one != nullptr && socket < 0; one = one->ai_next) {
    socket = connect_within(one->ai_family, one->ai_addr, one->ai_addrlen, timeout, why);
  }
  ::freeaddrinfo(found);
  if (socket < 0) fail_open_stream(address, why);
  const int one = 1;
  ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &one, sizeof one);
  return Descriptor(socket);
}

}  // namespace

bool is_stream_address(const std::string& address) {
  return address.starts_with(kPty) || address.starts_with(kTcp) || address.starts_with(kUnix);
}

std::unique_ptr<ByteStream> open_stream(const std::string& address, Nanoseconds timeout, bool lock) {
  if (address.starts_with(kPty)) return std::make_unique<StreamLink>(open_pty(address, lock), address, false, timeout);
  if (address.starts_with(kUnix)) {
    return std::make_unique<StreamLink>(connect_unix(address, timeout), address, true, timeout);
  }
  if (address.starts_with(kTcp)) {
    return std::make_unique<StreamLink>(connect_tcp(address, timeout), address, true, timeout);
  }
  fail_open_stream(address, "a stream's address is /dev/pts/N, tcp:HOST:PORT or unix:PATH");
}

std::unique_ptr<ByteStream> adopt_stream(int descriptor, const std::string& address, Nanoseconds timeout) {
  int type = 0;
  socklen_t size = sizeof type;
  const bool socket = ::getsockopt(descriptor, SOL_SOCKET, SO_TYPE, &type, &size) == 0;
  return std::make_unique<StreamLink>(Descriptor(descriptor), address, socket, timeout);
}

}  // namespace tactbench::devices
