// A program without a standard input gives the descriptor 0 to what it opens first: a descriptor like any other.
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "devices/pressure/simulated_module.h"
#include "devices/wire/byte_stream.h"
#include "devices/wire/descriptor_channel.h"
#include "devices/wire/ends/page_server.h"
#include "devices/wire/ends/stream_end.h"
#include "devices/wire/http_get.h"
#include "devices/wire/report_link.h"
#include "devices/wire/udp_link.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/packet_listener.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

bool zero_is_open() { return ::fcntl(0, F_GETFD) >= 0; }

// Without a standard input until the end of its block.
class NoInput {
 public:
  NoInput() : kept_(::fcntl(0, F_DUPFD_CLOEXEC, 3)) { ::close(0); }
  ~NoInput() {
    if (kept_ < 0) return;
    ::dup2(kept_, 0);
    ::close(kept_);
  }
  NoInput(const NoInput&) = delete;
  NoInput& operator=(const NoInput&) = delete;

 private:
  int kept_;
};

void wait_until_readable(int descriptor) {
  pollfd waited{descriptor, POLLIN, 0};
  REQUIRE(::poll(&waited, 1, 20000) == 1);
}

constexpr std::array<std::uint8_t, 3> kSome{1, 2, 3};

}  // namespace

TEST_CASE("descriptor 0: whichever connection gets it first uses it and closes it") {
  using Held = std::shared_ptr<void>;
  const tactbench::tests::TemporaryFolder folder;
  ManualClock clock;
  TestChamber chamber(clock);
  const ModuleProfile profile = module_profile("generic");
  const BoundSocket datagrams = bind_loopback(SOCK_DGRAM, 0, "test");
  const StreamEnd tcp("tcp:0"), local("unix:" + folder.path("end"));
  const PseudoTerminal terminal;
  const PacketListener packets(folder.path("packets"));
  const auto written = [](const std::string& address) {
    std::shared_ptr<ByteStream> stream = open_stream(address);
    CHECK(stream->descriptor() == 0);
    stream->write(kSome);
    return Held(stream);
  };
  const std::vector<std::pair<const char*, std::function<Held()>>> all = {
      {"TCP", [&] { return written(tcp.address()); }},
      {"local socket", [&] { return written(local.address()); }},
      {"terminal", [&] { return written(terminal.path()); }},
      {"UDP",
       [&] {
         auto link = std::make_shared<UdpLink>("127.0.0.1", datagrams.port, "peer");
         link->send(kSome);
         wait_until_readable(datagrams.socket);
         return Held(link);
       }},
      {"packet link",
       [&] {
         std::shared_ptr<ReportLink> link = open_packet_link(folder.path("packets"));
         link->write(kSome);
         return Held(link);
       }},
      {"channel",
       [&] {
         const auto [a, b] = DescriptorChannel::make_pair();
         REQUIRE(a == 0);
         auto one = std::make_shared<DescriptorChannel>(a);
         DescriptorChannel other(b);
         CHECK((one->send("text", 0) && one->send("text")));
         const auto packet = other.receive(kPatient);
         REQUIRE((packet && packet->descriptor > 0));
         ::close(packet->descriptor);
         CHECK(other.receive(kPatient)->descriptor == -1);
         return Held(one);
       }},
      {"the terminal's own end", [&] { return Held(std::make_shared<PseudoTerminal>()); }},
      {"listener", [&] { return Held(std::make_shared<StreamEnd>("tcp:0")); }},
      {"page", [&] { return Held(std::make_shared<PageServer>(0, "/p", "body", "test")); }},
      {"module", [&] { return Held(std::make_shared<SimulatedModule>(profile, 0, chamber, clock)); }},
      {"module on a line", [&] {
         return Held(std::make_shared<SimulatedModule>(std::vector<SimulatedUnit>{{1, profile, {}}},
                                                       SimulatedModule::Wire::kRtu, 0, chamber, clock));
       }}};
  for (const auto& [name, opens] : all) {
    INFO(name);
    const NoInput none;
    Held held = opens();
    CHECK(zero_is_open());
    held.reset();
    CHECK_FALSE(zero_is_open());
  }
  ::close(datagrams.socket);
}

TEST_CASE("descriptor 0: stays closed after a failed opening") {
  const tactbench::tests::TemporaryFolder folder;
  ManualClock clock;
  const BoundSocket datagrams = bind_loopback(SOCK_DGRAM, 0, "test"), taken = bind_loopback(SOCK_STREAM, 0, "test");
  const NoInput none;
  for (const auto& [id, opens] : std::vector<std::pair<std::string, std::function<void()>>>{
           {"TB-SERIAL-OPEN", [&] { (void)open_stream("unix:" + folder.path("nobody")); }},
           {"TB-HID-OPEN", [&] { (void)open_packet_link(folder.path("nobody")); }},
           {"TB-SIM-LISTEN", [&] { (void)bind_loopback(SOCK_STREAM, taken.port, "test"); }},
           {"TB-HTTP-OPEN", [&] {
              (void)http_get({"127.0.0.1", datagrams.port, "/p", kPatient, 4096}, "test", clock);
            }}}) {
    CHECK(fault_id_of(opens) == id);
    CHECK_FALSE(zero_is_open());
  }
  for (const BoundSocket& bound : {datagrams, taken}) ::close(bound.socket);
}

TEST_CASE("descriptor 0: renewing a UDP link frees it, and the next renewal gets it again") {
  const BoundSocket peer = bind_loopback(SOCK_DGRAM, 0, "peer");
  const NoInput none;
  UdpLink link("127.0.0.1", peer.port, "peer");
  REQUIRE(zero_is_open());
  link.renew();
  CHECK_FALSE(zero_is_open());
  link.renew();
  CHECK(zero_is_open());
  ::close(peer.socket);
}

TEST_CASE("descriptor 0: a listener's client, and the listener once plugged in again, use and close it") {
  const tactbench::tests::TemporaryFolder folder;
  for (const std::string& listen : {std::string("tcp:0"), "unix:" + folder.path("end")}) {
    INFO(listen);
    StreamEnd end(listen);
    auto client = open_stream(end.address());
    const NoInput none;
    std::array<std::uint8_t, 8> into{};
    client->write(kSome);
    wait_until_readable(end.descriptor());
    CHECK(end.receive(into) == 0);
    CHECK(end.descriptor() == 0);
    wait_until_readable(0);
    CHECK(end.receive(into) == 3);
    end.send(kSome);
    CHECK(client->read(into, kPatient) == 3);
    end.hang_up();
    CHECK_FALSE(zero_is_open());
    CHECK(end.descriptor() == -1);
    end.plug_in();
    CHECK(end.descriptor() == 0);
    client = open_stream(end.address());
    wait_until_readable(end.descriptor());
    CHECK(end.receive(into) == 0);
    end.hang_up();
    CHECK_FALSE(zero_is_open());
  }
}

TEST_CASE("descriptor 0: a client of the page server uses and closes it") {
  ManualClock clock;
  PageServer page(0, "/p", "body", "test");
  const HttpPage asked{"127.0.0.1", page.port(), "/p", kPatient, 4096};
  const auto serve_one = [&] {
    for (int events = 0; events < 2; ++events) {  // it comes, it asks
      std::vector<pollfd> descriptors;
      page.add_to(descriptors);
      REQUIRE(::poll(descriptors.data(), descriptors.size(), 20000) > 0);
      page.serve();
    }
  };
  const NoInput none;
  std::string body;
  std::thread client([&] { body = http_get(asked, "test", clock); });
  serve_one();
  client.join();
  CHECK(body == "body");
  CHECK_FALSE(zero_is_open());
}
