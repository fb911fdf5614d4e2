#include "devices/wire/ends/stream_end.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "devices/device.h"

namespace tactbench::devices {
namespace {

constexpr const char* kTcpForm = "tcp:";
constexpr const char* kUnixForm = "unix:";
constexpr int kOn = 1;  // of a socket's option

[[noreturn]] void fail_listen(const std::string& listen, const std::string& why) {
  throw Fault("TB-SIM-LISTEN", "simulated serial line", fmt::format("listening on {}: {}", listen, why),
              "Choose another port or path; the forms are tcp:PORT and unix:PATH.");
}

void close_all(std::initializer_list<int*> descriptors) {
  for (int* descriptor : descriptors) {
    if (*descriptor >= 0) ::close(std::exchange(*descriptor, -1));
  }
}

}  // namespace

StreamEnd::StreamEnd(std::string listen) : listen_(std::move(listen)) { plug_in(); }

void StreamEnd::plug_in() {
  hang_up();
  if (listen_.empty()) {
    terminal_.reset();  // first: the new one may then have the same path
    terminal_ = std::make_unique<PseudoTerminal>();
    address_ = terminal_->path();
  } else if (listen_.starts_with(kTcpForm)) {
    int port = -1;
    const char* text = listen_.c_str() + std::strlen(kTcpForm);
    const char* end = listen_.c_str() + listen_.size();
    if (std::from_chars(text, end, port).ptr != end || port < 0 || port > 65535) fail_listen(listen_, "no such port");
    listen_tcp(port);
  } else if (listen_.starts_with(kUnixForm)) {
    listen_unix(listen_.substr(std::strlen(kUnixForm)));
  } else {
    fail_listen(listen_, "the address is not of a known form");
  }
}

void StreamEnd::listen_at(const void* address, std::size_t size) {
  const auto* generic = static_cast<const sockaddr*>(address);
  listener_ = ::socket(generic->sa_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (listener_ >= 0) ::setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &kOn, sizeof kOn);
  if (listener_ < 0 || ::bind(listener_, generic, static_cast<socklen_t>(size)) != 0 || ::listen(listener_, 4) != 0) {
    const int error = errno;
    close_all({&listener_});
    fail_listen(listen_, std::strerror(error));
  }
}

void StreamEnd::listen_tcp(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  listen_at(&address, sizeof address);
  socklen_t size = sizeof address;
  ::getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size);
  listen_ = fmt::format("{}{}", kTcpForm, ntohs(address.sin_port));
  address_ = fmt::format("{}127.0.0.1:{}", kTcpForm, ntohs(address.sin_port));
}

void StreamEnd::listen_unix(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) fail_listen(listen_, "the path is empty or too long");
  std::copy(path.begin(), path.end(), address.sun_path);
  // A socket file without a listener was left by a program that was killed.
  const int probe = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int result = ::connect(probe, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  const bool refused = result != 0 && errno == ECONNREFUSED;  // by a file of another kind, too
  std::error_code error;
  if (refused && std::filesystem::is_socket(path, error)) ::unlink(path.c_str());
  if (probe >= 0) ::close(probe);
  listen_at(&address, sizeof address);
  address_ = listen_;
}

int StreamEnd::descriptor() const {
  if (terminal_) return terminal_->master();
  return client_ >= 0 ? client_ : listener_;
}

std::size_t StreamEnd::receive(std::span<std::uint8_t> into) {
  if (!terminal_ && client_ < 0) {
    client_ = ::accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (client_ >= 0)
      ::setsockopt(client_, IPPROTO_TCP, TCP_NODELAY, &kOn, sizeof kOn);  // without effect on a local one
    return 0;
  }
  const ssize_t got = ::read(descriptor(), into.data(), into.size());
  if (got > 0) return static_cast<std::size_t>(got);
  const bool later = got < 0 && (errno == EAGAIN || errno == EINTR);
  if (!later) close_all({&client_});
  return 0;
}

void StreamEnd::send(std::span<const std::uint8_t> bytes) {
  if (terminal_) {
    [[maybe_unused]] const ssize_t written = ::write(terminal_->master(), bytes.data(), bytes.size());
  } else if (client_ >= 0) {
    ::send(client_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
  }
}

void StreamEnd::hang_up() {
  if (terminal_) terminal_->hang_up();
  if (listener_ >= 0 && listen_.starts_with(kUnixForm)) ::unlink(listen_.c_str() + std::strlen(kUnixForm));
  // Closes the listener first: a client that sees the connection break must not get a new one.
  close_all({&listener_, &client_});
}

PseudoTerminal::PseudoTerminal() {
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  std::array<char, 128> name{};
  termios settings{};
  const bool named = master_ >= 0 && ::grantpt(master_) == 0 && ::unlockpt(master_) == 0 &&
                     ::ptsname_r(master_, name.data(), name.size()) == 0;
  // Without an open slave the master reports a hang-up until the first client comes.
  if (named) slave_ = ::open(name.data(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  bool raw = slave_ >= 0 && ::tcgetattr(slave_, &settings) == 0;
  if (raw) {
    ::cfmakeraw(&settings);
    raw = ::tcsetattr(slave_, TCSANOW, &settings) == 0;
  }
  if (!raw) {
    const int error = errno;
    close_both();
    throw Fault("TB-SIM-LISTEN", "pseudo-terminal", fmt::format("making a pseudo-terminal: {}", std::strerror(error)),
                "Check that /dev/pts is mounted and that the system has pseudo-terminals left.");
  }
  path_ = name.data();
}

void PseudoTerminal::hang_up() {
  if (master_ >= 0) ::close(std::exchange(master_, -1));
}

void PseudoTerminal::close_both() {
  for (int* descriptor : {&slave_, &master_}) {
    if (*descriptor >= 0) ::close(std::exchange(*descriptor, -1));
  }
}

BoundSocket bind_loopback(int type, int port, const std::string& device) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof address;
  auto* general = reinterpret_cast<sockaddr*>(&address);
  const int socket = ::socket(AF_INET, type | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const int one = 1;
  // A page's port is free again at once after a restart, although old connections linger.
  const bool ready = socket >= 0 && port >= 0 && port <= 65535 &&
                     (type != SOCK_STREAM || ::setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one) == 0) &&
                     ::bind(socket, general, size) == 0 && (type != SOCK_STREAM || ::listen(socket, 8) == 0) &&
                     ::getsockname(socket, general, &size) == 0;
  if (ready) return {socket, ntohs(address.sin_port)};
  const int error = errno;
  if (socket >= 0) ::close(socket);
  throw Fault("TB-SIM-LISTEN", device, fmt::format("listening on 127.0.0.1:{}: {}", port, std::strerror(error)),
              "Choose another port, or 0 to let the system choose.");
}

}  // namespace tactbench::devices
