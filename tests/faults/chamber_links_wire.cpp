// Wires of a chamber run: module and scanner, each fault once and for good.
#include <catch2/catch.hpp>

#include "tests/faults/faulty_run.h"

using namespace tactbench::tests;
using tactbench::bench::FaultKind;

TEST_CASE("chamber run: module silent, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kModuleSilent));
}
TEST_CASE("chamber run: module silent once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, once(FaultKind::kModuleSilent));
}
TEST_CASE("chamber run: module late, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kModuleLate));
}
TEST_CASE("chamber run: module late once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, once(FaultKind::kModuleLate));
}
TEST_CASE("chamber run: module corrupt, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kModuleCorrupt));
}
TEST_CASE("chamber run: module corrupt once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, once(FaultKind::kModuleCorrupt));
}
TEST_CASE("chamber run: module stale, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kModuleStale));
}
TEST_CASE("chamber run: module stale once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, once(FaultKind::kModuleStale));
}
TEST_CASE("chamber run: module exception, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kModuleException));
}
TEST_CASE("chamber run: module busy, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kModuleBusy));
}
TEST_CASE("chamber run: module busy once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, once(FaultKind::kModuleBusy));
}
TEST_CASE("chamber run: module exception once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, once(FaultKind::kModuleException));
}
TEST_CASE("chamber run: module unplugged, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kModuleUnplugged));
}
TEST_CASE("chamber run: module unplugged once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, once(FaultKind::kModuleUnplugged));
}
TEST_CASE("chamber run: scanner row stuck, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kRowStuck));
}
TEST_CASE("chamber run: scanner silent, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kScannerSilent));
}
TEST_CASE("chamber run: scanner silent once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, once(FaultKind::kScannerSilent));
}
TEST_CASE("chamber run: scanner stale, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kScannerStale));
}
TEST_CASE("chamber run: scanner stale once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, once(FaultKind::kScannerStale));
}
TEST_CASE("chamber run: scanner corrupt, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kScannerCorrupt));
}
TEST_CASE("chamber run: scanner corrupt once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, once(FaultKind::kScannerCorrupt));
}
TEST_CASE("chamber run: scanner torn, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kScannerTorn));
}
TEST_CASE("chamber run: scanner torn once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, once(FaultKind::kScannerTorn));
}
TEST_CASE("chamber run: scanner unplugged, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kScannerUnplugged));
}
TEST_CASE("chamber run: scanner unplugged once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, once(FaultKind::kScannerUnplugged));
}
TEST_CASE("chamber run: module silent and without watchdog, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, on_bench("no watchdog", {{"module.profile", "generic"}, {"module.watchdog_ms", "0"}},
                                      holding(FaultKind::kModuleSilent)));
}
// Its fallback draws a vacuum.
TEST_CASE(
    "chamber run: module silent and regulator span from -1 bar, frames are kept and the reported safe state is "
    "correct") {
  check_row(Bench::kChamber,
            on_bench("0 V no vent", {{"regulator.span_bar", "[-1, 9]"}, {"regulator.relief", "'vacuum breaker'"}},
                     breakage(FaultKind::kModuleSilent)));
}
