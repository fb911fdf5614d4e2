// Datagrams to and from one peer over a connected UDP socket, so that the kernel drops datagrams from others and
// returns an error if nobody listens on the peer's port.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "devices/clock.h"
#include "devices/wire/ip_address.h"

namespace tactbench::devices {

class UdpLink {
 public:
  // `host` is a numeric address. Throws Fault TB-UDP-OPEN; a missing listener is detected only by receive().
  UdpLink(const std::string& host, int port, std::string device);
  ~UdpLink();
  UdpLink(const UdpLink&) = delete;
  UdpLink& operator=(const UdpLink&) = delete;

  // A new socket on another local port: datagrams still on their way to the old one never arrive. Throws TB-UDP-OPEN.
  void renew();
  // Throws Fault TB-UDP-LOST.
  void send(std::span<const std::uint8_t> datagram);
  // Waits in real time for one datagram; 0 when none came before `timeout`. A datagram larger than `into` is cut to
  // its size. Throws Fault TB-UDP-LOST when the peer's host reports no listener, or the interface is gone.
  [[nodiscard]] std::size_t receive(std::span<std::uint8_t> into, Nanoseconds timeout);
  // Discards waiting datagrams (100 000 at most) and an old error; returns their number.
  std::size_t drain();
  [[nodiscard]] const std::string& peer() const { return peer_; }

 private:
  [[noreturn]] void fail(const char* id, const std::string& doing, int error) const;
  std::string device_;
  std::string peer_;
  IpAddress address_;
  int socket_ = -1;
};

}  // namespace tactbench::devices
