// A program without a standard input gives the descriptor 0 to what it opens first: a descriptor like any other.

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
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
#include "tests/devices/fault_of.h"
#include "tests/devices/few_descriptors.h"
#include "tests/devices/force/scripted_digital.h"
#include "tests/devices/packet_listener.h"
#include "tests/devices/scripted_server.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"
#include "tests/support/process.h"

using namespace std::chrono_literals;
using namespace tactbench::devices;
using tactbench::tests::FewDescriptors;
using tactbench::tests::TemporaryFolder;

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

TEST_CASE("descriptor 0: each kind of connection treats it as valid and closes it") {
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

// Opening anything when the limit of open files is reached: a specific fault with the reason, and nothing left open.

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

// The smallest thing that a wire carries, and its end, each with the error number that an earlier call has left.

namespace {

using Some = std::array<std::uint8_t, 16>;
constexpr std::array<std::uint8_t, 1> kByte{7};
constexpr int kLeft[] = {0, EAGAIN, EINTR, EIO};  // errors of earlier calls

// The bytes that the end returns at its next event.
std::size_t received(StreamEnd& end, Some& into, int left) {
  pollfd waited{end.descriptor(), POLLIN, 0};
  REQUIRE(::poll(&waited, 1, 20000) == 1);
  errno = left;
  return end.receive(into);
}

// Whether a client has gone: the next one is then waited for on another descriptor.
bool waits_for_a_client(const StreamEnd& end, int of_client) { return end.descriptor() != of_client; }

}  // namespace

TEST_CASE("stream listener: receives a single byte and detects a closed client, whatever errno was before") {
  for (const char* listen : {"tcp:0", "unix:"}) {
    const TemporaryFolder folder;
    StreamEnd end(listen == std::string("unix:") ? "unix:" + folder.path("end") : listen);
    for (const int left : kLeft) {
      INFO(listen << ", error " << left);
      Some some{};
      auto client = open_stream(end.address());
      CHECK(received(end, some, left) == 0);  // it came
      const int descriptor = end.descriptor();
      client->write(kByte);
      CHECK(received(end, some, left) == 1);
      CHECK(some[0] == 7);
      CHECK_FALSE(waits_for_a_client(end, descriptor));
      end.send(kByte);
      CHECK(client->read(some, 20s) == 1);
      client.reset();
      CHECK(received(end, some, left) == 0);
      CHECK(waits_for_a_client(end, descriptor));
    }
  }
}

TEST_CASE("stream: reads a single byte and reports the end of the connection, whatever errno was before") {
  for (const int left : kLeft) {
    INFO("error " << left);
    std::array<int, 2> line{};
    REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, line.data()) == 0);
    const auto stream = adopt_stream(line[0], "line");
    REQUIRE(::send(line[1], kByte.data(), 1, 0) == 1);
    Some some{};
    errno = left;
    CHECK(stream->read(some, 20s) == 1);
    ::close(line[1]);
    errno = left;
    CHECK(fault_id_of([&] { (void)stream->read(some, 20s); }) != "none");
  }
}

TEST_CASE("descriptor channel: receives a single byte and reports the end, whatever errno was before") {
  for (const int left : kLeft) {
    INFO("error " << left);
    const auto [a, b] = DescriptorChannel::make_pair();
    auto one = std::make_unique<DescriptorChannel>(a);
    DescriptorChannel other(b);
    CHECK(one->send("x"));
    errno = left;
    CHECK(other.receive(20s)->text == "x");
    one.reset();
    errno = left;
    CHECK_FALSE(other.receive(20s));
    CHECK(other.closed());
  }
}

TEST_CASE("UDP: a datagram of one byte is received, an empty one is not, and both are drained") {
  const BoundSocket peer = bind_loopback(SOCK_DGRAM, 0, "test");
  UdpLink link("127.0.0.1", peer.port, "peer");
  link.send(kByte);
  Some some{};
  sockaddr_in client{};
  socklen_t length = sizeof client;
  REQUIRE(::recvfrom(peer.socket, some.data(), some.size(), 0, reinterpret_cast<sockaddr*>(&client), &length) == 1);
  const auto answer = [&](std::size_t bytes) {
    return ::sendto(peer.socket, some.data(), bytes, 0, reinterpret_cast<const sockaddr*>(&client), length);
  };
  for (const int left : kLeft) {
    INFO("error " << left);
    REQUIRE(answer(0) == 0);
    REQUIRE(answer(1) == 1);
    errno = left;
    CHECK(link.receive(some, 20s) == 1);
    CHECK(link.receive(some, 0ns) == 0);
    REQUIRE(answer(0) == 0);
    REQUIRE(answer(3) == 3);
    REQUIRE(answer(1) == 1);
    errno = left;
    CHECK(link.drain() == 3);
    CHECK(link.drain() == 0);
  }
  ::close(peer.socket);
}
