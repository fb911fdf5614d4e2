#include "devices/wire/udp_link.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "devices/device.h"
#include "devices/wire/wait.h"

namespace tactbench::devices {
namespace {

constexpr std::size_t kDrainLimit = 100'000;  // bounds the wait for a sender that never stops

bool is_nothing_yet(int error) { return error == EAGAIN || error == EINTR; }

}  // namespace

UdpLink::UdpLink(const std::string& host, int port, std::string device)
    : device_(std::move(device)), peer_(fmt::format("{} port {} (UDP)", host, port)) {
  const auto address = numeric_address(host, port);
  if (!address) {
    throw Fault("TB-UDP-OPEN", device_, fmt::format("{} at {}: no address in numbers or no port", device_, peer_),
                "Write the address in numbers, as 192.168.1.1, and a port from 1 to 65535 in the bench file.");
  }
  address_ = *address;
  renew();
}

UdpLink::~UdpLink() {
  if (socket_ >= 0) ::close(socket_);
}

void UdpLink::renew() {
  const int socket = ::socket(address_.family(), SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (socket < 0) fail("TB-UDP-OPEN", "making a socket for", errno);
  if (::connect(socket, address_.get(), address_.size) != 0) {
    const int error = errno;
    ::close(socket);
    fail("TB-UDP-OPEN", "connecting to", error);
  }
  if (socket_ >= 0) ::close(socket_);  // only now, so that the new one cannot get the old one's port
  socket_ = socket;
}

void UdpLink::send(std::span<const std::uint8_t> datagram) {
  const ssize_t sent = ::send(socket_, datagram.data(), datagram.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  if (sent != static_cast<ssize_t>(datagram.size())) fail("TB-UDP-LOST", "sending to", sent < 0 ? errno : EMSGSIZE);
}

std::size_t UdpLink::receive(std::span<std::uint8_t> into, Nanoseconds timeout) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  for (;;) {
    // First the time, then the look: a datagram that comes between the two is found.
    const Nanoseconds left = timeout > Nanoseconds(0) ? left_until(deadline) : timeout;
    const ssize_t got = ::recv(socket_, into.data(), into.size(), MSG_DONTWAIT);
    if (got > 0) return static_cast<std::size_t>(got);  // an empty datagram is ignored
    if (got < 0 && !is_nothing_yet(errno)) fail("TB-UDP-LOST", "receiving from", errno);
    if (left <= Nanoseconds(0)) return 0;
    (void)wait_for(socket_, POLLIN, left);
  }
}

std::size_t UdpLink::drain() {
  std::size_t thrown = 0;
  std::array<std::uint8_t, 1> sink{};
  while (thrown < kDrainLimit) {
    const ssize_t got = ::recv(socket_, sink.data(), sink.size(), MSG_DONTWAIT | MSG_TRUNC);
    if (got < 0 && errno == EAGAIN) break;
    ++thrown;
  }
  return thrown;
}

void UdpLink::fail(const char* id, const std::string& doing, int error) const {
  throw Fault(id, device_, fmt::format("{} {} at {}: {}", doing, device_, peer_, std::strerror(error)),
              error == ECONNREFUSED ? "No program listens there: check address and port in the bench file."
                                    : "Check power, network cable and address of the device.");
}

}  // namespace tactbench::devices
