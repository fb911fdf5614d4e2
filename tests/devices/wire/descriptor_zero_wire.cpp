// A program without a standard input gives the descriptor 0 to what it opens first: a descriptor like any other.
#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <string>
#include <thread>

#include "devices/pressure/simulated_module.h"
#include "devices/wire/descriptor_channel.h"
#include "devices/wire/ends/loopback.h"
#include "devices/wire/ends/page_server.h"
#include "devices/wire/ends/pseudo_terminal.h"
#include "devices/wire/ends/stream_end.h"
#include "devices/wire/http_get.h"
#include "devices/wire/packet_link.h"
#include "devices/wire/stream_link.h"
#include "devices/wire/udp_link.h"
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

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

void wait_until_readable(int descriptor) {
  pollfd waited{descriptor, POLLIN, 0};
  REQUIRE(::poll(&waited, 1, 20000) == 1);
}

constexpr std::array<std::uint8_t, 3> kSome{1, 2, 3};

}  // namespace

TEST_CASE("descriptor 0: a UDP link") {
  const BoundSocket peer = bind_loopback(SOCK_DGRAM, 0, "peer");
  const NoInput none;
  {
    UdpLink link("127.0.0.1", peer.port, "peer");
    REQUIRE(zero_is_open());
    std::array<std::uint8_t, 8> into{};
    link.send(kSome);
    wait_until_readable(peer.socket);
    CHECK(::recv(peer.socket, into.data(), into.size(), 0) == 3);
    link.renew();
    CHECK_FALSE(zero_is_open());
    link.renew();
    CHECK(zero_is_open());
  }
  CHECK_FALSE(zero_is_open());
  ::close(peer.socket);
}

TEST_CASE("descriptor 0: a channel, and the descriptor attached to a packet") {
  const NoInput none;
  {
    const auto [a, b] = DescriptorChannel::make_pair();
    REQUIRE(a == 0);
    const DescriptorChannel one(a);
    DescriptorChannel other(b);
    CHECK(one.send("text", 0));
    const auto packet = other.receive(kPatient);
    REQUIRE(packet);
    CHECK(packet->text == "text");
    REQUIRE(packet->descriptor > 0);
    ::close(packet->descriptor);
    CHECK(one.send("text"));
    CHECK(other.receive(kPatient)->descriptor == -1);
  }
  CHECK_FALSE(zero_is_open());
}

TEST_CASE("descriptor 0: a stream's client, its end's listener, and its end's client") {
  const tactbench::tests::TemporaryFolder folder;
  const std::string socket = "unix:" + folder.path("end");
  for (const std::string& listen : {std::string("tcp:0"), socket}) {
    INFO(listen);
    StreamEnd end(listen);
    const NoInput none;
    {
      const auto client = open_stream(end.address());
      CHECK(client->descriptor() == 0);
      client->write(kSome);
    }
    CHECK_FALSE(zero_is_open());
    std::array<std::uint8_t, 8> into{};
    wait_until_readable(end.descriptor());
    CHECK(end.receive(into) == 0);
    CHECK(end.descriptor() == 0);
    wait_until_readable(0);
    CHECK(end.receive(into) == 3);
    end.hang_up();
    CHECK_FALSE(zero_is_open());
    CHECK(end.descriptor() == -1);
    end.plug_in();
    CHECK(end.descriptor() == 0);
    const auto client = open_stream(end.address());
    wait_until_readable(end.descriptor());
    CHECK(end.receive(into) == 0);
    end.send(kSome);
    CHECK(client->read(into, kPatient) == 3);
    end.hang_up();
    CHECK_FALSE(zero_is_open());
    if (listen == socket) CHECK_FALSE(std::filesystem::exists(folder.path("end")));
  }
  StreamEnd end("tcp:0");
  const auto client = open_stream(end.address());
  wait_until_readable(end.descriptor());
  const NoInput none;
  CHECK(fault_id_of([&] { (void)open_stream("unix:" + folder.path("nobody")); }) == "TB-SERIAL-OPEN");
  CHECK_FALSE(zero_is_open());
  std::array<std::uint8_t, 8> into{};
  CHECK(end.receive(into) == 0);
  REQUIRE(end.descriptor() == 0);
  end.send(kSome);
  CHECK(client->read(into, kPatient) == 3);
  end.hang_up();
  CHECK_FALSE(zero_is_open());
}

TEST_CASE("descriptor 0: a pseudo-terminal on either side") {
  {
    const PseudoTerminal terminal;
    const NoInput none;
    {
      const auto stream = open_stream(terminal.path());
      REQUIRE(stream->descriptor() == 0);
      stream->write(kSome);
      wait_until_readable(terminal.master());
    }
    CHECK_FALSE(zero_is_open());
  }
  const NoInput none;
  {
    PseudoTerminal terminal;
    REQUIRE(terminal.master() == 0);
    const auto stream = open_stream(terminal.path());
    stream->write(kSome);
    wait_until_readable(0);
    terminal.hang_up();
    CHECK_FALSE(zero_is_open());
  }
}

TEST_CASE("descriptor 0: a bound socket, and one whose port is taken") {
  const NoInput none;
  const BoundSocket bound = bind_loopback(SOCK_STREAM, 0, "test");
  REQUIRE(bound.socket == 0);
  const int moved = ::fcntl(0, F_DUPFD_CLOEXEC, 3);
  ::close(0);
  CHECK(fault_id_of([&] { (void)bind_loopback(SOCK_STREAM, bound.port, "test"); }) == "TB-SIM-LISTEN");
  CHECK_FALSE(zero_is_open());
  ::close(moved);
}

TEST_CASE("descriptor 0: a page's client at either end") {
  TurnedClock clock;
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
  {
    const NoInput none;
    std::string body;
    std::thread client([&] { body = http_get(asked, "test", clock); });
    serve_one();
    client.join();
    CHECK(body == "body");
    CHECK_FALSE(zero_is_open());
  }
  // Here the server's side gets it: the client has its descriptor already.
  const int client = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = loopback(page.port());
  const NoInput none;
  REQUIRE(::connect(client, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  const std::string request = "GET /p HTTP/1.0\r\n\r\n";
  REQUIRE(::send(client, request.data(), request.size(), 0) == static_cast<ssize_t>(request.size()));
  serve_one();
  CHECK_FALSE(zero_is_open());
  std::array<char, 512> answer{};
  const ssize_t got = ::recv(client, answer.data(), answer.size(), 0);
  CHECK_THAT(std::string(answer.data(), static_cast<std::size_t>(std::max<ssize_t>(got, 0))), Catch::EndsWith("body"));
  ::close(client);
}

TEST_CASE("descriptor 0: an exchange with a page that fails closes its socket") {
  TurnedClock clock;
  const BoundSocket bound = bind_loopback(SOCK_DGRAM, 0, "test");  // no TCP there
  const NoInput none;
  CHECK(fault_id_of([&] {
          (void)http_get({"127.0.0.1", bound.port, "/p", kPatient, 4096}, "test", clock);
        }) == "TB-HTTP-OPEN");
  CHECK_FALSE(zero_is_open());
  ::close(bound.socket);
}

TEST_CASE("descriptor 0: a packet link") {
  const tactbench::tests::TemporaryFolder folder;
  const std::string path = folder.path("peer");
  PacketListener listener(path);
  const NoInput none;
  {
    const auto link = open_packet_link(path);
    REQUIRE(zero_is_open());
    link->write(kSome);
  }
  CHECK_FALSE(zero_is_open());
  listener.close();
  CHECK(fault_id_of([&] { (void)open_packet_link(path); }) == "TB-HID-OPEN");
  CHECK_FALSE(zero_is_open());
}

TEST_CASE("descriptor 0: a simulated module that was made first, and its client") {
  TurnedClock clock;
  TestChamber chamber(clock);
  const ModuleProfile profile = module_profile("generic");
  const std::array<std::uint8_t, 12> request{0, 1, 0, 0, 0, 6, 1, 3, 0, 0, 0, 1};
  const std::array<std::uint8_t, 11> answer{0, 1, 0, 0, 0, 5, 1, 3, 2, 0, 0};
  const auto asks = [&](int client, int port) {
    const sockaddr_in address = loopback(port);
    REQUIRE(::connect(client, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
    REQUIRE(::send(client, request.data(), request.size(), 0) == 12);
    std::array<std::uint8_t, 11> reply{};
    CHECK(::recv(client, reply.data(), reply.size(), MSG_WAITALL) == 11);
    CHECK(reply == answer);
  };
  const int client = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  {
    const SimulatedModule module(profile, 0, chamber, clock);
    const NoInput none;
    asks(client, module.port());
    CHECK(zero_is_open());
    ::shutdown(client, SHUT_RDWR);
    for (int i = 0; i < 2000 && zero_is_open(); ++i) std::this_thread::sleep_for(10ms);
    CHECK_FALSE(zero_is_open());
  }
  ::close(client);
  const int other = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const NoInput none;
  {
    const SimulatedModule module(profile, 0, chamber, clock);
    CHECK(zero_is_open());
    asks(other, module.port());
  }
  CHECK_FALSE(zero_is_open());
  {
    const SimulatedModule line({{1, profile, {}}}, SimulatedModule::Wire::kRtu, 0, chamber, clock);
    CHECK(zero_is_open());
  }
  CHECK_FALSE(zero_is_open());
  ::close(other);
}
