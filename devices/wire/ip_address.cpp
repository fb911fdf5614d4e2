#include "devices/wire/ip_address.h"

#include <netdb.h>
#include <sys/socket.h>

#include <cstring>

namespace tactbench::devices {

std::optional<IpAddress> numeric_address(const std::string& host, int port) {
  if (host.empty() || port < 1 || port > 65535) return std::nullopt;
  addrinfo hints{};
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) return std::nullopt;
  IpAddress address;
  std::memcpy(&address.storage, found->ai_addr, found->ai_addrlen);
  address.size = found->ai_addrlen;
  ::freeaddrinfo(found);
  return address;
}

}  // namespace tactbench::devices
