#include "devices/tactile/simulated_scanner.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <catch2/catch.hpp>

#include "devices/tactile/hid_scanner.h"
#include "devices/wire/packet_link.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;

TEST_CASE("simulated scanner: an invalid path, and one left behind by a killed program") {
  TurnedClock clock;
  TestArray array;
  const IdentityReport identity{0, 16, 16, 1.0F, "S", "1"};
  const TemporaryFolder folder;
  for (const auto& path : {folder.path("no/such/folder"), std::string(200, 'x'), std::string()}) {
    CHECK(fault_id_of([&] { SimulatedScanner(path, identity, array, clock); }) == "TB-SIM-LISTEN");
    CHECK(fault_id_of([&] { (void)open_packet_link(path); }) == "TB-HID-OPEN");
  }
  const auto path = folder.path("scanner.sock");
  const int left = ::socket(AF_UNIX, SOCK_SEQPACKET, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), address.sun_path);
  REQUIRE(::bind(left, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  ::close(left);
  {
    const SimulatedScanner scanner(path, identity, array, clock);
    CHECK(fault_id_of([&] { SimulatedScanner(path, identity, array, clock); }) == "TB-SIM-LISTEN");
    CHECK(fault_id_of([&] { (void)HidScanner(open_packet_link(path), {}, clock); }) == "none");
  }
  CHECK_FALSE(std::filesystem::exists(path));
}

TEST_CASE("simulated scanner: beside the client that is served, five may wait") {
  TurnedClock clock;
  TestArray array;
  const TemporaryFolder folder;
  const auto path = folder.path("scanner.sock");
  const SimulatedScanner scanner(path, {0, 16, 16, 1.0F, "S", "1"}, array, clock);
  const HidScanner served(open_packet_link(path), {}, clock);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), address.sun_path);
  std::vector<int> waiting;
  for (int i = 0; i < 8; ++i) {
    const int socket = ::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_NONBLOCK, 0);
    waiting.push_back(socket);
    CHECK((::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) == (i < 5));
  }
  for (const int socket : waiting) ::close(socket);
}
