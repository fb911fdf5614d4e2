#include "devices/wire/descriptor_channel.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <memory>

#include "devices/wire/stream_link.h"
#include "tests/devices/fault_of.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

struct Ends {
  Ends() {
    const auto [a, b] = DescriptorChannel::make_pair();
    one = std::make_unique<DescriptorChannel>(a);
    other = std::make_unique<DescriptorChannel>(b);
  }
  std::unique_ptr<DescriptorChannel> one, other;
};

}  // namespace

TEST_CASE("descriptor channel: packets stay whole and in order, silence is not the end") {
  Ends ends;
  CHECK_FALSE(ends.other->receive(0ms));
  CHECK_FALSE(ends.other->closed());
  const std::string large(60'000, 'x');
  CHECK(ends.one->send("feed"));
  CHECK(ends.one->send(large));
  CHECK(ends.other->receive(20s)->text == "feed");
  CHECK(ends.other->receive(20s)->text == large);
  ends.one.reset();
  CHECK_FALSE(ends.other->receive(20s));
  CHECK(ends.other->closed());
  CHECK_FALSE(ends.other->send("feed"));
}

TEST_CASE("descriptor channel: never blocks on a reader that does not read") {
  Ends ends;
  int taken = 0;
  while (taken < 1'000'000 && ends.one->send("feed")) ++taken;
  CHECK(taken > 10);
  CHECK(taken < 1'000'000);
}

TEST_CASE("descriptor channel: an attached descriptor is of the same line and is closed on exec") {
  Ends ends;
  std::array<int, 2> line{};
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, line.data()) == 0);
  CHECK(ends.one->send("line", line[0]));
  auto packet = ends.other->receive(20s);
  REQUIRE(packet);
  CHECK(packet->text == "line");
  REQUIRE(packet->descriptor >= 0);
  CHECK((::fcntl(packet->descriptor, F_GETFD) & FD_CLOEXEC) != 0);
  ::close(line[0]);
  {
    const auto stream = adopt_stream(packet->descriptor, "handed over");
    const std::array<std::uint8_t, 2> bytes{1, 2};
    stream->write(bytes);
    std::array<std::uint8_t, 8> got{};
    CHECK(::recv(line[1], got.data(), got.size(), 0) == 2);
    REQUIRE(::send(line[1], "abc", 3, 0) == 3);
    CHECK(stream->read(got, 20s) == 3);
    CHECK(stream->description() == "handed over");
  }
  char byte = 0;
  CHECK(::recv(line[1], &byte, 1, 0) == 0);  // the stream has closed it
  ::close(line[1]);
}
