#include "devices/tactile/frame_source.h"

#include <catch2/catch.hpp>

#include "devices/tactile/simulated_frame_source.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;

TEST_CASE("frame source: tags wrap without effect") {
  TurnedClock clock;
  TestArray array;
  const SimulatedFrameSource server({.description = {1, 16, 16, 1e-4, "", "", ""}}, array, clock);
  FrameSourceOptions options;
  options.address = "tcp:127.0.0.1:" + std::to_string(server.port());
  options.frame_timeout = std::chrono::seconds(20);
  FrameSource source(options, clock);
  for (std::uint32_t scan = 0; scan < 66'000; ++scan) {
    if (source.read(1).frame_counters[0] != scan) FAIL("scan " << scan);
  }
  CHECK(source.exchanges() == 66'001);
}
