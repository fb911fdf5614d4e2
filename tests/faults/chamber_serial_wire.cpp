// A pressure controller on a serial line: silence, damaged and late answers, refusals, a line that is gone. It has no
// watchdog, so where it cannot be reached the chamber stays loaded, and the run has to say so.
#include <catch2/catch.hpp>

#include "tests/faults/faulty_run.h"

using namespace tactbench::tests;
using tactbench::bench::FaultKind;

namespace {

void check_serial(Breakage breakage) { check_row(Bench::kChamber, on_serial_bench(std::move(breakage))); }

}  // namespace

// It carries out commands although its answers are lost.
TEST_CASE("chamber: controller silent") { check_serial(breakage(FaultKind::kControllerSilent)); }
TEST_CASE("chamber: controller silent, once") { check_serial(once(FaultKind::kControllerSilent)); }
TEST_CASE("chamber: controller late") { check_serial(breakage(FaultKind::kControllerLate)); }
TEST_CASE("chamber: controller late, once") { check_serial(once(FaultKind::kControllerLate)); }
TEST_CASE("chamber: controller corrupt") { check_serial(breakage(FaultKind::kControllerCorrupt)); }
TEST_CASE("chamber: controller corrupt, once") { check_serial(once(FaultKind::kControllerCorrupt)); }
TEST_CASE("chamber: controller refused, once") { check_serial(once(FaultKind::kControllerRefused)); }
// No way leads to it.
TEST_CASE("chamber: controller refused") { check_serial(holding(FaultKind::kControllerRefused)); }
TEST_CASE("chamber: controller unplugged") { check_serial(holding(FaultKind::kControllerUnplugged)); }
