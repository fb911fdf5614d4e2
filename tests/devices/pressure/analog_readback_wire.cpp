// Reading an output back: within a dead band, and within a deadline of process time.
#include <array>
#include <atomic>
#include <catch2/catch.hpp>

#include "devices/pressure/analog_module.h"
#include "tests/devices/scripted_server.h"
#include "tests/devices/test_chamber.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;

namespace {

// A slow output: it takes each write, but shows `first` for the first `stale` readings and what was written, plus
// `off`, from then on.
struct SlowOutput {
  SlowOutput(int stale, int off)
      : server([this, stale, off](int, int socket, const Bytes& request) {
          if (request[7] == 16) {
            written = request[13] * 256 + request[14];
            Bytes echo(request.begin(), request.begin() + 12);
            echo[4] = 0;
            echo[5] = 6;
            ScriptedServer::send(socket, echo);
          } else {
            const bool old = request[7] == 3 && readings++ < stale;
            ScriptedServer::send(
                socket, ScriptedServer::answer(request, {static_cast<std::uint16_t>(old ? 0 : written + off)}));
          }
        }),
        profile(module_profile("generic")) {
    profile.inputs.channels = 1;
  }
  std::atomic<int> readings{0};
  std::atomic<int> written{0};
  ScriptedServer server;
  ModuleProfile profile;
  TurnedClock clock;
  std::string write() {
    AnalogModule module(profile, {"127.0.0.1", server.port(), 1, 20s}, 0s, clock, Origin::kSimulated);
    return fault_id_of([&] { module.write(0, 1000); });
  }
};

}  // namespace

TEST_CASE("read-back: another value is a fault, unless it lies in the dead band") {
  SlowOutput exact(0, 0);
  CHECK(exact.write() == "none");
  SlowOutput off(0, 3);
  CHECK(off.write() == "TB-MODULE-READBACK");
  off.profile.outputs.dead_band = 2;
  CHECK(off.write() == "TB-MODULE-READBACK");
  off.profile.outputs.dead_band = 3;
  CHECK(off.write() == "none");
  CHECK(off.clock.now() == 0ns);
}

TEST_CASE("read-back: an output that follows late is waited for until the deadline") {
  SlowOutput late(3, 0);
  late.profile.outputs.deadline = 200ms;
  CHECK(late.write() == "none");
  CHECK(late.readings == 5);  // three stale, one that fits, one that decides
  CHECK(late.clock.now() == 60ms);
  SlowOutput never(1000, 0);
  never.profile.outputs.deadline = 200ms;
  CHECK(never.write() == "TB-MODULE-READBACK");
  CHECK(never.clock.now() == 200ms);
}

TEST_CASE("outputs that are written one word at a time are zeroed one word at a time") {
  std::array<std::atomic<std::uint16_t>, 2> stands{7, 7};
  ScriptedServer server([&](int, int socket, const Bytes& request) {
    const auto at = [&](std::size_t i) { return static_cast<std::uint16_t>(request[i] * 256 + request[i + 1]); };
    if (request[7] == 6) {
      stands.at(at(8)) = at(10);
      return ScriptedServer::send(socket, request);
    }
    if (request[7] == 3) return ScriptedServer::send(socket, ScriptedServer::answer(request, {stands[0], stands[1]}));
    ScriptedServer::send(socket, {request[0], request[1], 0, 0, 0, 3, request[6], 0x90, 1});  // not known to it
  });
  ModuleProfile profile = module_profile("generic");
  profile.outputs.function = 6;
  profile.outputs.channels = 2;
  profile.inputs.channels = 0;
  TurnedClock clock;
  AnalogModule module(profile, {"127.0.0.1", server.port(), 1, 20s}, 0s, clock, Origin::kSimulated);
  module.write(1, 1000);
  CHECK(stands[0] == 0);
  CHECK(stands[1] == 1000);
  CHECK(module.zero_outputs());
  CHECK(stands[1] == 0);
  stands[1] = 5;
  profile.outputs.function = 16;
  AnalogModule all(profile, {"127.0.0.1", server.port(), 1, 20s}, 0s, clock, Origin::kSimulated);
  CHECK_FALSE(all.zero_outputs());  // refused, and read back as it was
}
