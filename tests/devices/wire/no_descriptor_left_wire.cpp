// Opening anything when the limit of open files is reached: a specific fault with the reason, and nothing left open.
#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "devices/force/simulated_digital_ft.h"
#include "devices/force/simulated_net_ft.h"
#include "devices/pressure/simulated_module.h"
#include "devices/tactile/simulated_frame_source.h"
#include "devices/tactile/simulated_scanner.h"
#include "devices/wire/byte_stream.h"
#include "devices/wire/descriptor_channel.h"
#include "devices/wire/ends/page_server.h"
#include "devices/wire/ends/stream_end.h"
#include "devices/wire/http_get.h"
#include "devices/wire/modbus/modbus_link.h"
#include "devices/wire/report_link.h"
#include "devices/wire/udp_link.h"
#include "tests/devices/few_descriptors.h"
#include "tests/devices/force/invented_digital.h"
#include "tests/devices/packet_listener.h"
#include "tests/devices/scripted_server.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using tactbench::tests::FewDescriptors;

namespace {

// Nothing is asserted while none is left: UndefinedBehaviorSanitizer opens a pipe to look at a pointer.
std::optional<Fault> without_descriptors(const std::function<void()>& act) {
  const FewDescriptors none(0);
  return fault_of(act);
}

// `act` needs so many descriptors; with fewer it ends in this fault.
void check_needs(int needed, const std::string& id, const std::function<void()>& act) {
  act();  // what stays open from the first time on is no leak
  for (int left = 0; left <= needed; ++left) {
    INFO(id << ", " << left << " of " << needed << " descriptors left");
    const std::vector<int> before = FewDescriptors::open();
    std::string said = "none";
    {
      const FewDescriptors limit(left);
      const auto fault = fault_of(act);
      if (fault) said = fault->id();
    }
    CHECK(said == (left < needed ? id : "none"));
    CHECK(FewDescriptors::open() == before);
  }
}

}  // namespace

TEST_CASE("no descriptor left: opening an instrument link is a fault", "[few-descriptors]") {
  const tactbench::tests::TemporaryFolder folder;
  ManualClock clock;
  const StreamEnd tcp("tcp:0");
  const StreamEnd local("unix:" + folder.path("end"));
  const PseudoTerminal terminal;
  const BoundSocket datagrams = bind_loopback(SOCK_DGRAM, 0, "test");
  check_needs(1, "TB-UDP-OPEN", [&] { const UdpLink link("127.0.0.1", datagrams.port, "box"); });
  check_needs(1, "TB-SERIAL-OPEN", [&] { (void)open_stream(tcp.address()); });
  check_needs(1, "TB-SERIAL-OPEN", [&] { (void)open_stream(local.address()); });
  check_needs(1, "TB-SERIAL-OPEN", [&] { (void)open_stream(terminal.path()); });
  check_needs(2, "TB-CHANNEL", [&] {
    const auto [a, b] = DescriptorChannel::make_pair();
    ::close(a);
    ::close(b);
  });
  ::close(datagrams.socket);
  const std::string path = folder.path("packets");
  const PacketListener listener(path);
  check_needs(1, "TB-HID-OPEN", [&] { (void)open_packet_link(path); });
}

TEST_CASE("no descriptor left: an HTTP request and a Modbus connection are faults", "[few-descriptors]") {
  ManualClock clock;
  const BoundSocket bound = bind_loopback(SOCK_STREAM, 0, "test");
  const auto get = [&] { (void)http_get({"127.0.0.1", bound.port, "/p", kShort, 4096}, "test", clock); };
  const auto page = without_descriptors(get);
  CHECK((page && page->id() == "TB-HTTP-OPEN"));
  const auto read = [&] {
    ModbusLink link({"127.0.0.1", bound.port, 1, kShort}, "device", clock);
    std::uint16_t word = 0;
    link.read_input_registers(0, std::span(&word, 1));
  };
  const auto module = without_descriptors(read);
  CHECK((module && module->id() == "TB-MODBUS-CONNECT"));
  ::close(bound.socket);
}

TEST_CASE("no descriptor left: starting a simulated instrument is a fault", "[few-descriptors]") {
  const tactbench::tests::TemporaryFolder folder;
  check_needs(1, "TB-SIM-LISTEN", [] { ::close(bind_loopback(SOCK_STREAM, 0, "test").socket); });
  check_needs(1, "TB-SIM-LISTEN", [] { const PageServer page(0, "/p", "body", "test"); });
  check_needs(2, "TB-SIM-LISTEN", [] { const PseudoTerminal terminal; });
  check_needs(1, "TB-SIM-LISTEN", [] { const StreamEnd end("tcp:0"); });
  check_needs(1, "TB-SIM-LISTEN", [&] { const StreamEnd end("unix:" + folder.path("end")); });
  check_needs(2, "TB-SIM-LISTEN", [] { const StreamEnd end(""); });
  ManualClock clock;
  TestChamber chamber(clock);
  const ModuleProfile profile = module_profile("generic");
  check_needs(2, "TB-SIM-LISTEN", [&] { const SimulatedModule module(profile, 0, chamber, clock); });
  check_needs(3, "TB-SIM-LISTEN", [&] {
    const SimulatedModule line({{1, profile, {}}}, SimulatedModule::Wire::kRtu, 0, chamber, clock);
  });
  class NoLoad final : public ForcePort {
    Wrench wrench() override { return {}; }
  } load;
  TestArray array;
  check_needs(3, "TB-SIM-LISTEN", [&] { SimulatedDigitalFt(invented_digital(), load, false); });
  check_needs(3, "TB-SIM-LISTEN", [&] { SimulatedNetFt({0, 0, NetFtPage(), {}}, load); });
  check_needs(2, "TB-SIM-LISTEN", [&] {
    SimulatedFrameSource({.description = {1, 2, 2, 1.0, "", "", ""}}, array, clock);
  });
}

TEST_CASE("no descriptor left: a failed simulated scanner leaves no socket file, and keeps that of a live one",
          "[few-descriptors]") {
  ManualClock clock;
  TestArray array;
  const tactbench::tests::TemporaryFolder folder;
  const std::string path = folder.path("scanner.sock");
  const auto start = [&] { SimulatedScanner(path, {0, 2, 2, 1.0F, "S", "1"}, array, clock); };
  const auto check_refused = [&](int left, bool there) {
    std::optional<Fault> fault;
    {
      const FewDescriptors few(left);
      fault = fault_of(start);
    }
    CHECK((fault && fault->id() == "TB-SIM-LISTEN"));
    CHECK(std::filesystem::exists(path) == there);
  };
  start();
  for (const int left : {0, 1}) check_refused(left, false);
  const SimulatedScanner living(path, {0, 2, 2, 1.0F, "S", "1"}, array, clock);
  for (int left = 0; left < 6; ++left) check_refused(left, true);
}
