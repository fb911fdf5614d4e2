#include "bench/page/own_addresses.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <cstring>
#include <memory>
#include <optional>

namespace tactbench::bench {

namespace ip = boost::asio::ip;

namespace {

std::optional<ip::address> address_of(const sockaddr& at, bool v6) {
  if (at.sa_family == AF_INET) {
    sockaddr_in own{};
    std::memcpy(&own, &at, sizeof own);
    const ip::address_v4 address(ntohl(own.sin_addr.s_addr));
    const bool link_local = (address.to_uint() >> 16U) == 0xA9FEU;  // 169.254/16, RFC 3927
    return link_local ? std::nullopt : std::optional<ip::address>(address);
  }
  if (at.sa_family != AF_INET6 || !v6) return std::nullopt;
  sockaddr_in6 own{};
  std::memcpy(&own, &at, sizeof own);
  ip::address_v6::bytes_type bytes{};
  std::memcpy(bytes.data(), &own.sin6_addr, bytes.size());
  const ip::address_v6 address(bytes);
  return address.is_link_local() ? std::nullopt : std::optional<ip::address>(address);
}

}  // namespace

std::vector<std::string> own_addresses(bool v6) {
  ifaddrs* listed = nullptr;
  if (::getifaddrs(&listed) != 0) return {};
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> all(listed, &::freeifaddrs);
  std::vector<std::string> addresses;
  for (const ifaddrs* one = listed; one != nullptr; one = one->ifa_next) {
    if (one->ifa_addr == nullptr || (one->ifa_flags & IFF_UP) == 0) continue;
    const std::optional<ip::address> address = address_of(*one->ifa_addr, v6);
    if (!address || address->is_loopback()) continue;
    std::string text = address->to_string();
    if (std::ranges::find(addresses, text) == addresses.end()) addresses.push_back(std::move(text));
  }
  return addresses;
}

}  // namespace tactbench::bench
