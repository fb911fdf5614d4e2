#include "devices/wire/descriptor_channel.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "devices/device.h"
#include "devices/wire/wait.h"

namespace tactbench::devices {
namespace {

constexpr std::size_t kMostBytes = 1U << 17U;  // a bench file is far smaller, a socket's buffer larger

}  // namespace

std::pair<int, int> DescriptorChannel::make_pair() {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw Fault("TB-CHANNEL", "this computer", fmt::format("making a socket pair: {}", std::strerror(errno)),
                "Close programs that hold many files open.");
  }
  return {ends[0], ends[1]};
}

DescriptorChannel::~DescriptorChannel() {
  if (socket_ >= 0) ::close(socket_);
}

bool DescriptorChannel::send(const std::string& text, int descriptor) const noexcept {
  iovec part{const_cast<char*>(text.data()), text.size()};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  if (descriptor >= 0) {
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    cmsghdr* header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_SOCKET;
    header->cmsg_type = SCM_RIGHTS;
    header->cmsg_len = CMSG_LEN(sizeof(int));
    std::memcpy(CMSG_DATA(header), &descriptor, sizeof(int));
  }
  return ::sendmsg(socket_, &message, MSG_DONTWAIT | MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
}

std::optional<ChannelPacket> DescriptorChannel::receive(Nanoseconds timeout) {
  if (closed_ || wait_for(socket_, POLLIN, timeout) == 0) return std::nullopt;
  std::vector<char> bytes(kMostBytes);
  iovec part{bytes.data(), bytes.size()};
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(int))> control{};
  msghdr message{};
  message.msg_iov = &part;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t got = ::recvmsg(socket_, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return std::nullopt;
  if (got <= 0) {  // an empty packet is never sent
    closed_ = true;
    return std::nullopt;
  }
  ChannelPacket packet{std::string(bytes.data(), static_cast<std::size_t>(got)), -1};
  const cmsghdr* header = CMSG_FIRSTHDR(&message);
  if (header != nullptr && header->cmsg_level == SOL_SOCKET && header->cmsg_type == SCM_RIGHTS) {
    std::memcpy(&packet.descriptor, CMSG_DATA(header), sizeof(int));
  }
  return packet;
}

}  // namespace tactbench::devices
