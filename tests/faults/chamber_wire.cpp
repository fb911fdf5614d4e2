// The chamber's half of the matrix: each fault at each point of a run between 0 and 60 psi.
#include <catch2/catch.hpp>

#include "tests/faults/faulty_run.h"

using namespace tactbench::tests;
using tactbench::bench::FaultKind;

TEST_CASE("chamber: valve stuck") { check_row(Bench::kChamber, holding(FaultKind::kValveStuck)); }
TEST_CASE("chamber: leak") { check_row(Bench::kChamber, breakage(FaultKind::kLeak, 40.0)); }
TEST_CASE("chamber: overshoot") { check_row(Bench::kChamber, breakage(FaultKind::kOvershoot)); }
TEST_CASE("chamber: supply lost") { check_row(Bench::kChamber, breakage(FaultKind::kSupplyLost)); }
TEST_CASE("chamber: regulator without power") { check_row(Bench::kChamber, holding(FaultKind::kRegulatorUnpowered)); }
TEST_CASE("chamber: feedback offset") { check_row(Bench::kChamber, breakage(FaultKind::kFeedbackOffset)); }
TEST_CASE("chamber: reference offset") { check_row(Bench::kChamber, breakage(FaultKind::kReferenceOffset)); }

// A supply that is lost behind a live zero reads far below 0 psi.
namespace {

constexpr double kDead = -90.0;
const Breakage kFeedbackDead = breakage(FaultKind::kFeedbackOffset, kDead);
const Breakage kReferenceDead = breakage(FaultKind::kReferenceOffset, kDead);

}  // namespace

TEST_CASE("chamber: feedback dead") { check_row(Bench::kChamber, together("feedback dead", {kFeedbackDead})); }
TEST_CASE("chamber: reference dead") { check_row(Bench::kChamber, together("reference dead", {kReferenceDead})); }
TEST_CASE("chamber: both transmitters dead") {
  check_row(Bench::kChamber, together("both transmitters dead", {kFeedbackDead, kReferenceDead}));
}
TEST_CASE("chamber: both transmitters dead, valve stuck") {
  check_row(Bench::kChamber, together("both transmitters dead, valve stuck",
                                      {kFeedbackDead, kReferenceDead, holding(FaultKind::kValveStuck)}));
}
