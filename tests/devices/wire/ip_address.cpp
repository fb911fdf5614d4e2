#include "devices/wire/ip_address.h"

#include <arpa/inet.h>
#include <netinet/in.h>

#include <array>
#include <catch2/catch.hpp>

using namespace tactbench::devices;

TEST_CASE("IP address: accepts numeric IPv4 and IPv6 addresses with ports 1 to 65535, and nothing else") {
  for (const int port : {1, 2, 80, 65534, 65535}) {
    INFO("port " << port);
    const auto address = numeric_address("192.168.1.17", port);
    REQUIRE(address);
    CHECK(address->family() == AF_INET);
    CHECK(address->size == sizeof(sockaddr_in));
    const auto* ipv4 = reinterpret_cast<const sockaddr_in*>(address->get());
    CHECK(ntohs(ipv4->sin_port) == port);
    CHECK(ntohl(ipv4->sin_addr.s_addr) == 0xC0A80111);
    const auto six = numeric_address("fe80::1", port);
    REQUIRE(six);
    CHECK(six->family() == AF_INET6);
    CHECK(six->size == sizeof(sockaddr_in6));
    CHECK(ntohs(reinterpret_cast<const sockaddr_in6*>(six->get())->sin6_port) == port);
  }
  for (const int port : {-1, 0, 65536, 65537, 70000}) CHECK_FALSE(numeric_address("192.168.1.17", port));
  for (const char* host : {"", "localhost", "192.168.1", "192.168.1.256", "::g", "192.168.1.1 "}) {
    INFO("host '" << host << "'");
    const bool shortened = std::string(host) == "192.168.1";  // old forms of numbers count as numbers
    CHECK(numeric_address(host, 80).has_value() == shortened);
  }
}
