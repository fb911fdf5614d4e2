// The packet link at a peer that goes with something unread, which the kernel tells as an error and not as an end.
#include "devices/wire/packet_link.h"

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <string>

#include "tests/devices/fault_of.h"
#include "tests/devices/packet_listener.h"
#include "tests/devices/timeouts.h"
#include "tests/support/process.h"

using namespace tactbench::devices;
using namespace tactbench::tests;

TEST_CASE("a packet link whose peer goes with reports unread is lost") {
  const TemporaryFolder folder;
  const std::string path = folder.path("peer.sock");
  PacketListener listener(path);
  const auto link = open_packet_link(path);
  const int peer = listener.accept();
  std::array<std::uint8_t, 64> into{};
  CHECK(link->read(into, Nanoseconds(0)) == 0);
  const std::array<std::uint8_t, 3> report{1, 2, 3};
  link->write(report);
  ::close(peer);
  listener.close();
  for (int i = 0; i < 2; ++i) CHECK(fault_id_of([&] { (void)link->read(into, kPatient); }) == "TB-HID-LOST");
  CHECK(fault_id_of([&] { (void)link->drain(); }) == "TB-HID-LOST");
}
