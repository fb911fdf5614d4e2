// Wires of a chamber run: module and scanner, each fault once and for good.
#include <catch2/catch.hpp>

#include "tests/faults/faulty_run.h"

using namespace tactbench::tests;
using tactbench::bench::FaultKind;

TEST_CASE("chamber: module silent") { check_row(Bench::kChamber, breakage(FaultKind::kModuleSilent)); }
TEST_CASE("chamber: module silent, once") { check_row(Bench::kChamber, once(FaultKind::kModuleSilent)); }
TEST_CASE("chamber: module late") { check_row(Bench::kChamber, breakage(FaultKind::kModuleLate)); }
TEST_CASE("chamber: module late, once") { check_row(Bench::kChamber, once(FaultKind::kModuleLate)); }
TEST_CASE("chamber: module corrupt") { check_row(Bench::kChamber, breakage(FaultKind::kModuleCorrupt)); }
TEST_CASE("chamber: module corrupt, once") { check_row(Bench::kChamber, once(FaultKind::kModuleCorrupt)); }
TEST_CASE("chamber: module stale") { check_row(Bench::kChamber, breakage(FaultKind::kModuleStale)); }
TEST_CASE("chamber: module stale, once") { check_row(Bench::kChamber, once(FaultKind::kModuleStale)); }
TEST_CASE("chamber: module exception") { check_row(Bench::kChamber, breakage(FaultKind::kModuleException)); }
TEST_CASE("chamber: module busy") { check_row(Bench::kChamber, breakage(FaultKind::kModuleBusy)); }
TEST_CASE("chamber: module busy, once") { check_row(Bench::kChamber, once(FaultKind::kModuleBusy)); }
TEST_CASE("chamber: module exception, once") { check_row(Bench::kChamber, once(FaultKind::kModuleException)); }
TEST_CASE("chamber: module unplugged") { check_row(Bench::kChamber, breakage(FaultKind::kModuleUnplugged)); }
TEST_CASE("chamber: module unplugged, once") { check_row(Bench::kChamber, once(FaultKind::kModuleUnplugged)); }
TEST_CASE("chamber: row stuck") { check_row(Bench::kChamber, breakage(FaultKind::kRowStuck)); }
TEST_CASE("chamber: scanner silent") { check_row(Bench::kChamber, breakage(FaultKind::kScannerSilent)); }
TEST_CASE("chamber: scanner silent, once") { check_row(Bench::kChamber, once(FaultKind::kScannerSilent)); }
TEST_CASE("chamber: scanner stale") { check_row(Bench::kChamber, breakage(FaultKind::kScannerStale)); }
TEST_CASE("chamber: scanner stale, once") { check_row(Bench::kChamber, once(FaultKind::kScannerStale)); }
TEST_CASE("chamber: scanner corrupt") { check_row(Bench::kChamber, breakage(FaultKind::kScannerCorrupt)); }
TEST_CASE("chamber: scanner corrupt, once") { check_row(Bench::kChamber, once(FaultKind::kScannerCorrupt)); }
TEST_CASE("chamber: scanner torn") { check_row(Bench::kChamber, breakage(FaultKind::kScannerTorn)); }
TEST_CASE("chamber: scanner torn, once") { check_row(Bench::kChamber, once(FaultKind::kScannerTorn)); }
TEST_CASE("chamber: scanner unplugged") { check_row(Bench::kChamber, breakage(FaultKind::kScannerUnplugged)); }
TEST_CASE("chamber: scanner unplugged, once") { check_row(Bench::kChamber, once(FaultKind::kScannerUnplugged)); }
TEST_CASE("chamber: module silent, no watchdog") {
  check_row(Bench::kChamber, on_bench("no watchdog", {{"module.profile", "generic"}, {"module.watchdog_ms", "0"}},
                                      holding(FaultKind::kModuleSilent)));
}
// Its fallback draws a vacuum.
TEST_CASE("chamber: module silent, 0 V no vent") {
  check_row(Bench::kChamber,
            on_bench("0 V no vent", {{"regulator.span_bar", "[-1, 9]"}, {"regulator.relief", "'vacuum breaker'"}},
                     breakage(FaultKind::kModuleSilent)));
}
