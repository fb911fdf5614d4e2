#include "devices/tactile/frame_source.h"

#include <atomic>
#include <catch2/catch.hpp>

#include "tests/devices/scripted_server.h"

using namespace tactbench::devices;

TEST_CASE("frame source: request tags wrap without effect, and none is 0, which means damage") {
  namespace protocol = frame_protocol;
  std::atomic<bool> zero{false};
  const ScriptedServer server([&](int number, int socket, const Bytes& request) {
    const auto tag = static_cast<std::uint16_t>(request[6] | request[7] << 8);
    if (tag == 0) zero = true;
    const protocol::Body frame = protocol::Frame{0, static_cast<std::uint32_t>(number), 0, 1, 1, {1}};
    const protocol::Body identity = protocol::Description{1, 1, 1, 1.0, "", "", ""};
    ScriptedServer::send(socket, protocol::encode({tag, number == 0 ? identity : frame}));
  });
  ManualClock clock;
  FrameSourceOptions options;
  options.address = "tcp:127.0.0.1:" + std::to_string(server.port());
  options.rows = options.columns = 1;
  options.frame_timeout = std::chrono::seconds(20);
  FrameSource source(options, clock);
  for (int i = 0; i < 660; ++i) REQUIRE(source.read(100).frame_counters.size() == 100);
  CHECK_FALSE(zero);
}
