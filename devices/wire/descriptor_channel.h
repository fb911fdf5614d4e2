// One end of a local socket pair on which two processes exchange short packets, with a descriptor attached if needed
// (SCM_RIGHTS). Every descriptor is closed on exec. Any thread may send; one thread receives.
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "devices/clock.h"

namespace tactbench::devices {

struct ChannelPacket {
  std::string text;
  int descriptor = -1;  // owned by the receiver; -1: none was attached
};

class DescriptorChannel {
 public:
  explicit DescriptorChannel(int socket) : socket_(socket) {}  // owns it from now on
  ~DescriptorChannel();
  DescriptorChannel(const DescriptorChannel&) = delete;
  DescriptorChannel& operator=(const DescriptorChannel&) = delete;
  // Two connected sockets, SOCK_SEQPACKET: packets stay whole, and each side detects when the other ends. Throws Fault
  // TB-CHANNEL.
  static std::pair<int, int> make_pair();

  // False when the other side is gone or accepts nothing. Never blocks, raises no signal.
  bool send(const std::string& text, int descriptor = -1) const noexcept;
  // The next packet; none when none came within `timeout` or the other side is gone (then closed() is true).
  [[nodiscard]] std::optional<ChannelPacket> receive(Nanoseconds timeout);
  [[nodiscard]] bool closed() const { return closed_; }
  [[nodiscard]] int socket() const { return socket_; }

 private:
  int socket_;
  bool closed_ = false;
};

}  // namespace tactbench::devices
