// The chamber's half of the matrix: each fault at each point of a run between 0 and 60 psi.
#include <catch2/catch.hpp>

#include "tests/faults/faulty_run.h"

using namespace tactbench::tests;
using tactbench::bench::FaultKind;

TEST_CASE("chamber run: valve stuck, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, holding(FaultKind::kValveStuck));
}
TEST_CASE("chamber run: chamber leaks, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kLeak, 40.0));
}
TEST_CASE("chamber run: pressure overshoots, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kOvershoot));
}
TEST_CASE("chamber run: supply lost, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kSupplyLost));
}
TEST_CASE("chamber run: regulator without power, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, holding(FaultKind::kRegulatorUnpowered));
}
TEST_CASE("chamber run: feedback offset, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kFeedbackOffset));
}
TEST_CASE("chamber run: reference offset, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, breakage(FaultKind::kReferenceOffset));
}

// A supply that is lost behind a live zero reads far below 0 psi.
namespace {

constexpr double kDead = -90.0;
const Breakage kFeedbackDead = breakage(FaultKind::kFeedbackOffset, kDead);
const Breakage kReferenceDead = breakage(FaultKind::kReferenceOffset, kDead);

}  // namespace

TEST_CASE("chamber run: feedback dead, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, together("feedback dead", {kFeedbackDead}));
}
TEST_CASE("chamber run: reference dead, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, together("reference dead", {kReferenceDead}));
}
TEST_CASE("chamber run: feedback and reference dead, frames are kept and the reported safe state is correct") {
  check_row(Bench::kChamber, together("both transmitters dead", {kFeedbackDead, kReferenceDead}));
}
TEST_CASE(
    "chamber run: feedback and reference dead and valve stuck, frames are kept and the reported safe state is "
    "correct") {
  check_row(Bench::kChamber, together("both transmitters dead, valve stuck",
                                      {kFeedbackDead, kReferenceDead, holding(FaultKind::kValveStuck)}));
}
