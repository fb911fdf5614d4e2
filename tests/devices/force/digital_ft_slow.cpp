// The driver of the Digital F/T at a line that never falls silent.
#include <catch2/catch.hpp>

#include "devices/force/digital_ft.h"
#include "tests/devices/fault_of.h"
#include "tests/devices/force/scripted_digital.h"

using namespace tactbench::devices;
using namespace tactbench::tests;
using namespace std::chrono_literals;

TEST_CASE("Digital F/T line: opening gives up after two seconds if a stream does not stop") {
  Script script;
  script.line.endless = script.line.deaf = true;
  const auto begin = std::chrono::steady_clock::now();
  CHECK(fault_id_of([&] { (void)script.open(); }) == "TB-FORCE-TIMEOUT");
  CHECK(script.clock.now() == 2s);
  CHECK(std::chrono::steady_clock::now() - begin >= 2s);
  CHECK(script.jams() > 1);
  CHECK(static_cast<std::size_t>(script.jams()) == script.line.written.size());
}
