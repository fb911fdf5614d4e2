// The Zaber driver's halt beside its sequencer's thread.
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>

#include "tests/devices/fault_of.h"
#include "tests/devices/stage/scripted_chain.h"
#include "tests/devices/timeouts.h"

using namespace tactbench::devices;
using namespace std::chrono_literals;
using enum ZaberCommand;

TEST_CASE("zaber law: a command is refused at once while a halt still waits for the axes") {
  StageAlone alone;
  alone.ready();
  std::atomic<bool> halting{false}, refused{false}, refused_meanwhile{false};
  alone.chain.script = [&](const ZaberFrame& frame) -> std::optional<ScriptedChain::Frames> {
    if (frame.command == kStatus && frame.device == 1) {
      halting = true;
      const auto end = std::chrono::steady_clock::now() + kPatient;
      while (!refused && std::chrono::steady_clock::now() < end) std::this_thread::sleep_for(1ms);
      refused_meanwhile = refused.load();
    }
    return std::nullopt;
  };
  bool stands = false;
  std::thread other([&] { stands = alone.stage.halt(); });
  while (!halting) std::this_thread::yield();
  CHECK(fault_id_of([&] { (void)alone.stage.state(Axis::kX); }) == "TB-STAGE-HALTED");
  refused = true;
  other.join();
  CHECK(stands);
  CHECK(refused_meanwhile);
  alone.stage.arm();
  CHECK(alone.stage.armed());
}

TEST_CASE("zaber law: what asks several times is broken off by a halt that waits for the line") {
  bool refused = false;
  // The halt's thread may start late, and then has nothing to break off.
  const auto end = std::chrono::steady_clock::now() + kPatient;
  while (!refused && std::chrono::steady_clock::now() < end) {
    StageAlone alone;
    alone.stage.arm();
    std::thread other;
    alone.chain.script = [&](const ZaberFrame& frame) -> std::optional<ScriptedChain::Frames> {
      if (frame.command == kDeviceId && !other.joinable()) other = std::thread([&] { (void)alone.stage.halt(); });
      if (frame.device != 0) std::this_thread::sleep_for(2ms);
      return std::nullopt;
    };
    const auto fault = fault_of([&] { (void)alone.stage.identify(); });
    other.join();
    refused = fault && fault->id() == "TB-STAGE-HALTED";
    CHECK_FALSE(alone.stage.armed());
  }
  CHECK(refused);
}
