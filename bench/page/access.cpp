#include "bench/page/access.h"

#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <openssl/crypto.h>
#include <openssl/rand.h>

#include <algorithm>
#include <array>
#include <boost/asio/ip/address.hpp>
#include <cstring>
#include <memory>
#include <optional>
#include <stdexcept>

namespace tactbench::bench {
namespace {

constexpr std::string_view kBearer = "Bearer ";

// Takes the same time for any two texts of this length.
bool equal(const std::string& one, const std::string& other) {
  return one.size() == other.size() && CRYPTO_memcmp(one.data(), other.data(), one.size()) == 0;
}

std::string token_of(const HttpRequest& request) {
  const std::string field = request.field("authorization");
  return field.starts_with(kBearer) ? field.substr(kBearer.size()) : std::string();
}

bool is_own_origin(const std::string& origin, const PageAccess& access) {
  return std::ranges::any_of(
      access.hosts, [&](const std::string& host) { return lower_case(origin) == access.scheme + "://" + host; });
}

}  // namespace

bool may_command(const HttpRequest& request, const PageAccess& access) {
  return !access.command_token.empty() && equal(token_of(request), access.command_token);
}

bool may_read(const HttpRequest& request, const PageAccess& access) {
  return equal(token_of(request), access.read_token) || may_command(request, access);
}

std::vector<std::string> hosts_of(const std::vector<std::string>& names, std::uint16_t port,
                                  const std::string& scheme) {
  std::vector<std::string> hosts;
  for (const std::string& name : names) {
    hosts.push_back(lower_case(fmt::format("{}:{}", name, port)));
    if (port == (scheme == "https" ? 443 : 80)) hosts.push_back(lower_case(name));
  }
  return hosts;
}

std::optional<HttpResponse> refusal(const HttpRequest& request, PageNeeds needs, const PageAccess& access) {
  if (std::ranges::find(access.hosts, lower_case(request.field("host"))) == access.hosts.end())
    return text_response(421, "this server does not have that name: open the address that tactbench printed\n");
  if (request.has("origin") && !is_own_origin(request.field("origin"), access))
    return text_response(403, "the request comes from another site's page\n");
  const std::string site = request.field("sec-fetch-site");
  const bool own_site = site.empty() || site == "same-origin" || site == "none";
  // A link to the page may be on any site: the page shows nothing without its token, and cannot be framed.
  if (needs != PageNeeds::kNothing && !own_site)
    return text_response(403, "the request comes from another site's page\n");
  if (needs == PageNeeds::kCommand) {
    if (request.method != "POST") return text_response(405, "a command must be a POST\n");
    if (request.field("content-type") != "application/json") return text_response(415, "a command must be JSON\n");
    if (request.field("x-tactbench") != "1") return text_response(403, "not from the page\n");
  } else if (request.method != "GET") {
    return text_response(405, "only GET is allowed here\n");
  }
  if (needs == PageNeeds::kNothing) return std::nullopt;
  if (needs == PageNeeds::kCommand ? may_command(request, access) : may_read(request, access)) return std::nullopt;
  HttpResponse refused = text_response(
      401, needs == PageNeeds::kCommand ? "commands need the operator's link\n"
                                        : "open the complete link that tactbench printed: its end is the key\n");
  refused.fields.emplace_back("WWW-Authenticate", "Bearer");
  return refused;
}

std::string new_token() {
  std::array<unsigned char, 16> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1)
    throw std::runtime_error("the system provides no random numbers");
  constexpr const char* kDigits = "0123456789abcdef";
  std::string text;
  for (const unsigned byte : bytes) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 15U];
  }
  return text;
}

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
