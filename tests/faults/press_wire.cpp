// The press half of the matrix: each fault at each point of a run that presses a ring with up to 30 N.
#include <catch2/catch.hpp>

#include "tests/faults/faulty_run.h"

using namespace tactbench::tests;
using tactbench::bench::FaultKind;

TEST_CASE("press run: stage stalled, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, holding(FaultKind::kStageStalled));
}
TEST_CASE("press run: stage silent, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, breakage(FaultKind::kStageSilent));
}
TEST_CASE("press run: stage silent once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, once(FaultKind::kStageSilent));
}
TEST_CASE("press run: stage late, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, breakage(FaultKind::kStageLate));
}
TEST_CASE("press run: stage late once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, once(FaultKind::kStageLate));
}
TEST_CASE("press run: stage corrupt, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, breakage(FaultKind::kStageCorrupt));
}
TEST_CASE("press run: stage corrupt once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, once(FaultKind::kStageCorrupt));
}
TEST_CASE("press run: stage torn, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, breakage(FaultKind::kStageTorn));
}
TEST_CASE("press run: stage torn once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, once(FaultKind::kStageTorn));
}
TEST_CASE("press run: stage unplugged, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, holding(FaultKind::kStageUnplugged));
}
TEST_CASE("press run: force saturated, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, breakage(FaultKind::kForceSaturated));
}
TEST_CASE("press run: force saturated once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, once(FaultKind::kForceSaturated));
}
TEST_CASE("press run: force stale, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, breakage(FaultKind::kForceStale));
}
TEST_CASE("press run: force stale once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, once(FaultKind::kForceStale));
}
TEST_CASE("press run: force silent, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, breakage(FaultKind::kForceSilent));
}
TEST_CASE("press run: force silent once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, once(FaultKind::kForceSilent));
}
TEST_CASE("press run: module unplugged, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, breakage(FaultKind::kModuleUnplugged));
}
TEST_CASE("press run: module unplugged once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, once(FaultKind::kModuleUnplugged));
}
TEST_CASE("press run: scanner unplugged, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, breakage(FaultKind::kScannerUnplugged));
}
TEST_CASE("press run: scanner unplugged once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, once(FaultKind::kScannerUnplugged));
}
TEST_CASE("press run: scanner torn, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, breakage(FaultKind::kScannerTorn));
}
TEST_CASE("press run: scanner torn once, frames are kept and the reported safe state is correct") {
  check_row(Bench::kPress, once(FaultKind::kScannerTorn));
}
