// The press half of the matrix: each fault at each point of a run that presses a ring with up to 30 N.
#include <catch2/catch.hpp>

#include "tests/faults/faulty_run.h"

using namespace tactbench::tests;
using tactbench::bench::FaultKind;

TEST_CASE("press: stage stalled") { check_row(Bench::kPress, holding(FaultKind::kStageStalled)); }
TEST_CASE("press: stage silent") { check_row(Bench::kPress, breakage(FaultKind::kStageSilent)); }
TEST_CASE("press: stage silent, once") { check_row(Bench::kPress, once(FaultKind::kStageSilent)); }
TEST_CASE("press: stage late") { check_row(Bench::kPress, breakage(FaultKind::kStageLate)); }
TEST_CASE("press: stage late, once") { check_row(Bench::kPress, once(FaultKind::kStageLate)); }
TEST_CASE("press: stage corrupt") { check_row(Bench::kPress, breakage(FaultKind::kStageCorrupt)); }
TEST_CASE("press: stage corrupt, once") { check_row(Bench::kPress, once(FaultKind::kStageCorrupt)); }
TEST_CASE("press: stage torn") { check_row(Bench::kPress, breakage(FaultKind::kStageTorn)); }
TEST_CASE("press: stage torn, once") { check_row(Bench::kPress, once(FaultKind::kStageTorn)); }
TEST_CASE("press: stage unplugged") { check_row(Bench::kPress, holding(FaultKind::kStageUnplugged)); }
TEST_CASE("press: force saturated") { check_row(Bench::kPress, breakage(FaultKind::kForceSaturated)); }
TEST_CASE("press: force saturated, once") { check_row(Bench::kPress, once(FaultKind::kForceSaturated)); }
TEST_CASE("press: force stale") { check_row(Bench::kPress, breakage(FaultKind::kForceStale)); }
TEST_CASE("press: force stale, once") { check_row(Bench::kPress, once(FaultKind::kForceStale)); }
TEST_CASE("press: force silent") { check_row(Bench::kPress, breakage(FaultKind::kForceSilent)); }
TEST_CASE("press: force silent, once") { check_row(Bench::kPress, once(FaultKind::kForceSilent)); }
TEST_CASE("press: module unplugged") { check_row(Bench::kPress, breakage(FaultKind::kModuleUnplugged)); }
TEST_CASE("press: module unplugged, once") { check_row(Bench::kPress, once(FaultKind::kModuleUnplugged)); }
TEST_CASE("press: scanner unplugged") { check_row(Bench::kPress, breakage(FaultKind::kScannerUnplugged)); }
TEST_CASE("press: scanner unplugged, once") { check_row(Bench::kPress, once(FaultKind::kScannerUnplugged)); }
TEST_CASE("press: scanner torn") { check_row(Bench::kPress, breakage(FaultKind::kScannerTorn)); }
TEST_CASE("press: scanner torn, once") { check_row(Bench::kPress, once(FaultKind::kScannerTorn)); }
