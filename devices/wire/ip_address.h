// A numeric IP address in the form that sockets need. Names are not resolved: we cannot set a time limit on a resolver.
#pragma once

#include <netinet/in.h>

#include <optional>
#include <string>

namespace tactbench::devices {

struct IpAddress {
  sockaddr_storage storage{};
  socklen_t size = 0;
  [[nodiscard]] const sockaddr* get() const { return reinterpret_cast<const sockaddr*>(&storage); }
  [[nodiscard]] int family() const { return storage.ss_family; }
};

// Empty when `host` is not a numeric IPv4 or IPv6 address, or the port is not 1..65535.
[[nodiscard]] std::optional<IpAddress> numeric_address(const std::string& host, int port);

}  // namespace tactbench::devices
