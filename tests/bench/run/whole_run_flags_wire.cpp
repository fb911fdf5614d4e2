// Whole runs with readings that are not as they should be, as they were recorded: flags of frames, an array that is
// stuck, witnesses that disagree, a step that takes too long, a chamber that is not vented. A deliberate change of the
// simulation or of what a run does changes them.
#include "tests/bench/run/recorded_run.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE(
    "whole run with flags: a row that is stuck, a feedback that leaves its band, dwells that are not met, line by "
    "line") {
  check_lines(lines_of_two_branches({}, "[dwell]\ntolerance_s = 0.0\n",
                                    {planned_fault(bench::FaultKind::kRowStuck, 1.0, 6.0, 3.0),
                                     planned_fault(bench::FaultKind::kFeedbackOffset, 4.0, 0.5, 0.4)}),
              R"(
step 1 of 4, 0 of 4 frames: small, step 1 of 4, loading; 0.000 s 0 -0.012 -0.018 psi settled
step 2 of 4, 1 of 4 frames: small, step 2 of 4, loading; 2.650 s 0 -0.004 -0.003 psi settled
step 3 of 4, 2 of 4 frames: small, step 3 of 4, loading; 5.300 s 2 2.040 2.124 psi settled
step 4 of 4, 3 of 4 frames: small, step 4 of 4, unloading; 7.950 s 4 4.032 4.132 psi settled
4 of 4 frames, 16 exchanges, 0 redone, 10.800 s, waiting 0.000 s: dwelling 74.1 %, settling 24.1 %, tearing down 1.9 %
0.000 state: prepared -> running: devices open, chamber unloaded
0.000 seating: left out as asked (--no-seating)
10.800 time: dwelling 74.1 %, settling 24.1 %, tearing down 1.9 %
10.800 state: running -> stopping: all steps done
10.800 safe verified: vented, verified (feedback 0.9 psi, reference 0.7 psi)
branch 0.0.0 attempt 0: 0 to 4 psi
0: 2.650 s, 2.650 since command, 2.000 in band; 0 -0.004 -0.003 psi, 0 -1 -1; 2x16x16 134172; 16; 8: 11.15 0.00 -0.05 -0.05
1: 5.300 s, 2.650 since command, 2.000 in band; 2 2.040 2.124 psi, 502 512 696; 2x16x16 749186; 16; 7: 8.50 14.00 14.97 14.92; row-stuck left-band
2: 7.950 s, 2.650 since command, 2.000 in band; 4 4.032 4.132 psi, 1004 1012 1354; 2x16x16 1803238; 16; 7: 8.50 28.00 28.01 28.88
branch 0.0.1 attempt 0: 4 to 2 psi
3: 10.600 s, 2.650 since command, 2.000 in band; 2 1.996 1.898 psi, 502 501 622; 2x16x16 1102705; 16; 7: 8.50 14.00 13.96 13.21
)");
}

TEST_CASE("whole run with flags: a scanner that repeats itself ends it, line by line") {
  check_lines(lines_of_two_branches({}, "", {planned_fault(bench::FaultKind::kScannerStale, 3.0, 1e6, 0.0)}), R"(
step 1 of 4, 0 of 4 frames: small, step 1 of 4, loading; 0.000 s 0 -0.012 -0.018 psi settled
step 2 of 4, 1 of 4 frames: small, step 2 of 4, loading; 2.650 s 0 -0.004 -0.003 psi settled
step 3 of 4, 2 of 4 frames: small, step 3 of 4, loading; 5.300 s 2 2.040 2.124 psi settled
2 of 2 frames, 16 exchanges, 0 redone, 8.350 s, waiting 0.000 s: dwelling 71.9 %, settling 23.4 %, tearing down 4.8 %
3 TB-SCANNER-STALE: the frame at 4.1 psi is to the last bit the one before, at another pressure | run 1, after frame 2, tactile scanner | the scanner repeats what it read: restart it; check its firmware's buffer | vented, verified (feedback 0.1 psi, reference 0.0 psi); run 1 kept with 2 frames
0.000 state: prepared -> running: devices open, chamber unloaded
0.000 seating: left out as asked (--no-seating)
8.350 fault TB-SCANNER-STALE: the frame at 4.1 psi is to the last bit the one before, at another pressure
8.350 time: dwelling 71.9 %, settling 23.4 %, tearing down 4.8 %
8.350 state: running -> stopping: TB-SCANNER-STALE: the frame at 4.1 psi is to the last bit the one before, at another pressure
8.350 safe verified: vented, verified (feedback 0.1 psi, reference 0.0 psi)
branch 0.0.0 attempt 0: 0 to 4 psi
0: 2.650 s, 2.650 since command, 2.000 in band; 0 -0.004 -0.003 psi, 0 -1 -1; 2x16x16 134130; 16; 8: 11.15 0.00 -0.05 -0.05
1: 5.300 s, 2.650 since command, 2.000 in band; 2 2.040 2.124 psi, 502 512 696; 2x16x16 134078; 16; 7: 8.50 14.00 14.17 14.92
)");
}

TEST_CASE("whole run with flags: witnesses that disagree for longer than they may end it, line by line") {
  check_lines(lines_of_two_branches({}, "",
                                    {planned_fault(bench::FaultKind::kReferenceOffset, 3.0, 0.5, 5.0),
                                     planned_fault(bench::FaultKind::kReferenceOffset, 5.5, 1e6, 5.0)}),
              R"(
step 1 of 4, 0 of 4 frames: small, step 1 of 4, loading; 0.000 s 0 -0.012 -0.018 psi settled
step 2 of 4, 1 of 4 frames: small, step 2 of 4, loading; 2.650 s 0 -0.004 -0.003 psi settled
step 2 of 4, 1 of 4 frames: back to branch 1 of repeat 1: conditioning 1 of 1; 3.550 s 2 1.992 2.115 psi settled
step 2 of 4, 1 of 4 frames: back to branch 1 of repeat 1: conditioning 1 of 1; 6.200 s 4 4.008 9.116 psi settled
1 of 1 frames, 16 exchanges, 1 redone, 29.450 s, waiting 0.000 s: tearing down 67.9 %, redoing 20.0 %, dwelling 7.6 %, settling 4.4 %
7 TB-CHAMBER-DISAGREE: the regulator's feedback reads -0.04 psi and the reference 5.00 psi, apart for 1.3 s | run 1, after frame 1, chamber | check both against a hand gauge (`tactbench devices calibrate-reference`), the transducer's wiring and spans; the limits are [limits] disagreement_psi and disagreement_s | NOT SAFE: pressure remains (feedback 0.0 psi, reference 5.0 psi, tactile array back at its unloaded baseline); run 1 kept with 1 frame
0.000 state: prepared -> running: devices open, chamber unloaded
0.000 seating: left out as asked (--no-seating)
3.550 branch-broken TB-BRANCH-BROKEN: branch 0 of repeat 0: rose to 7.18 and fell back to 2.11 in the branch from 0 to 4 (tolerance 0.2) psi
3.550 way-back: conditioned again, then the turning points before branch 0 of repeat 0
29.450 fault TB-CHAMBER-DISAGREE: the regulator's feedback reads -0.04 psi and the reference 5.00 psi, apart for 1.3 s
29.450 time: tearing down 67.9 %, redoing 20.0 %, dwelling 7.6 %, settling 4.4 %
29.450 state: running -> stopping: TB-CHAMBER-DISAGREE: the regulator's feedback reads -0.04 psi and the reference 5.00 psi, apart for 1.3 s
29.450 safe failed: NOT SAFE: pressure remains (feedback 0.0 psi, reference 5.0 psi, tactile array back at its unloaded baseline)
branch 0.0.0 attempt 0: 0 to 4 psi, void: TB-BRANCH-BROKEN: rose to 7.18 and fell back to 2.11 in the branch from 0 to 4 (tolerance 0.2) psi
0: 2.650 s, 2.650 since command, 2.000 in band; 0 -0.004 -0.003 psi, 0 -1 -1; 2x16x16 134130; 16; 8: 11.15 0.00 -0.05 -0.05
)");
}

TEST_CASE("whole run with flags: a step that takes longer than its recipe allows ends it, line by line") {
  check_lines(lines_of_two_branches({}, "dwell_s = 2.0\n[timeout]\nstep_s = 2.55\n"), R"(
step 1 of 4, 0 of 4 frames: small, step 1 of 4, loading; 0.000 s 0 -0.012 -0.018 psi settled
0 of 0 frames, 0 exchanges, 0 redone, 2.650 s, waiting 0.000 s: dwelling 75.5 %, settling 24.5 %
3 TB-STEP-TIMEOUT: a step took longer than 2.55 s | run 1, after frame 0, sequencer | see the trace of the last frames; the limit is the recipe's [timeout] step_s | vented, verified (feedback 0.0 psi, reference 0.0 psi); run 1 kept with 0 frames
0.000 state: prepared -> running: devices open, chamber unloaded
0.000 seating: left out as asked (--no-seating)
2.650 fault TB-STEP-TIMEOUT: a step took longer than 2.55 s
2.650 time: dwelling 75.5 %, settling 24.5 %
2.650 state: running -> stopping: TB-STEP-TIMEOUT: a step took longer than 2.55 s
2.650 safe verified: vented, verified (feedback 0.0 psi, reference 0.0 psi)
branch 0.0.0 attempt 0: 0 to 4 psi
)");
}

TEST_CASE("whole run with flags: a chamber that is not vented is not begun with, line by line") {
  check_lines(lines_of_two_branches({}, "", {planned_fault(bench::FaultKind::kReferenceOffset, 0.0, 1e6, 1.25)}), R"(
0 of 0 frames, 0 exchanges, 0 redone, 20.000 s, waiting 0.000 s: tearing down 100.0 %
7 TB-CHAMBER-NOT-VENTED: the chamber holds 1.2 psi before the first command | run 1, after frame 0, chamber | vent the chamber; check the zero of regulator and reference | NOT SAFE: pressure remains (feedback 0.0 psi, reference 1.2 psi); run 1 kept with 0 frames
20.000 fault TB-CHAMBER-NOT-VENTED: the chamber holds 1.2 psi before the first command
20.000 time: tearing down 100.0 %
20.000 state: prepared -> stopping: TB-CHAMBER-NOT-VENTED: the chamber holds 1.2 psi before the first command
20.000 safe failed: NOT SAFE: pressure remains (feedback 0.0 psi, reference 1.2 psi)
)");
}

TEST_CASE("whole run with flags: a step may take just as long as its recipe allows") {
  const std::vector<std::string> lines = lines_of_two_branches({}, "dwell_s = 2.0\n[timeout]\nstep_s = 2.65\n");
  CHECK(std::ranges::any_of(lines, [](const std::string& line) { return line.starts_with("4 of 4 frames, "); }));
}

TEST_CASE("whole run with flags: a wait shorter than the rest that its recipe allows costs its own branch alone") {
  const std::vector<sequences::Override> sensor = {
      {"environment.sensor", "[{quantity = 'supply_bar', unit = 9, address = 20, type = 'f32'}]"}};
  const std::string rule =
      "dwell_s = 4.0\nrest_restart_s = 15\n[[suspend]]\nquantity = \"supply_bar\"\ntrip_below = 6\nresume_above = "
      "6.5\nhold_s = 2\n";
  std::vector<std::string> branches =
      lines_of_two_branches(sensor, rule, {planned_fault(bench::FaultKind::kSupplyLost, 14.0, 5.0, 0.001)});
  std::erase_if(branches, [](const std::string& line) { return !line.starts_with("branch "); });
  CHECK(branches == std::vector<std::string>{"branch 0.0.0 attempt 0: 0 to 4 psi",
                                             "branch 0.0.1 attempt 0: 4 to 2 psi, void: suspended: supply_bar is 0.00, "
                                             "below 6",
                                             "branch 0.0.1 attempt 1: 4 to 2 psi"});
}
