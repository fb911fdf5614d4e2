// Replies of a source beyond the simulated one's faults.
#include <sys/socket.h>

#include <catch2/catch.hpp>

#include "devices/tactile/frame_source.h"
#include "tests/devices/scripted_server.h"
#include "tests/devices/test_chamber.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
namespace protocol = tactbench::devices::frame_protocol;

namespace {

// A source with the test's replies: request number, its tag -> bytes sent.
std::optional<Fault> fault_of_script(const std::function<Bytes(int number, std::uint16_t tag)>& script, int reads = 1,
                                     Nanoseconds timeout = kPatient) {
  const ScriptedServer server([&](int number, int socket, const Bytes& request) {
    ScriptedServer::send(socket, script(number, static_cast<std::uint16_t>(request[6] | request[7] << 8)));
  });
  TurnedClock clock;
  FrameSourceOptions options;
  options.address = "tcp:127.0.0.1:" + std::to_string(server.port());
  options.rows = options.columns = 2;
  options.frame_timeout = timeout;
  return fault_of([&] {
    FrameSource source(options, clock);
    for (int i = 0; i < reads; ++i) (void)source.read(1);
  });
}

Bytes description_bytes(std::uint16_t tag) {
  return protocol::encode({tag, protocol::Description{1, 2, 2, 1.0, "", "", ""}});
}
Bytes frame_bytes(std::uint16_t tag, std::uint32_t counter) {
  return protocol::encode({tag, protocol::Frame{0, counter, 0, 2, 2, {1, 2, 3, 4}}});
}

}  // namespace

TEST_CASE("frame source: answers to older requests are ignored, and are no answer") {
  CHECK_FALSE(fault_of_script([](int number, std::uint16_t tag) {
    auto bytes = frame_bytes(static_cast<std::uint16_t>(tag + 9), 100);
    const auto answer = number == 0 ? description_bytes(tag) : frame_bytes(tag, 1);
    bytes.insert(bytes.end(), answer.begin(), answer.end());
    return bytes;
  }));
  const auto only_old = fault_of_script(
      [](int number, std::uint16_t tag) {
        return number == 0 ? description_bytes(tag) : frame_bytes(static_cast<std::uint16_t>(tag - 1), 1);
      },
      1, kShort);
  CHECK((only_old && only_old->id() == "TB-SCANNER-TIMEOUT"));
}

TEST_CASE("frame source: a flood of old answers does not delay past the deadline") {
  static constexpr auto kFlood = 20 * kShort;  // ends with the right answer, too late
  const ScriptedServer server(
      [](int number, int socket, const Bytes& request) {
        const auto tag = static_cast<std::uint16_t>(request[6] | request[7] << 8);
        const auto old = frame_bytes(static_cast<std::uint16_t>(tag - 1), 1);
        const auto end = std::chrono::steady_clock::now() + kFlood;
        while (number > 0 && std::chrono::steady_clock::now() < end) {
          if (::send(socket, old.data(), old.size(), MSG_NOSIGNAL) < 0) return;  // the driver has hung up
        }
        ScriptedServer::send(socket, number == 0 ? description_bytes(tag) : frame_bytes(tag, 2));
      },
      false);
  TurnedClock clock;
  FrameSourceOptions options;
  options.address = "tcp:127.0.0.1:" + std::to_string(server.port());
  options.rows = options.columns = 2;
  options.frame_timeout = kShort;
  CHECK(fault_id_of([&] {
          FrameSource source(options, clock);
          (void)source.read(1);
        }) == "TB-SCANNER-TIMEOUT");
}
