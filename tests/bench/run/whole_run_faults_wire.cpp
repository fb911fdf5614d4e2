// Whole runs in which something fails, as they were recorded: a frame, a scanner, the supply, a path. A deliberate
// change of the simulation or of what a run does changes them.
#include "tests/bench/run/recorded_run.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("whole run with faults: a damaged scan costs a branch where frames are not read again, line by line") {
  check_lines(lines_of_two_branches(
                  {{"simulation.wire_faults.scanner_corrupt_scan", "6"}, {"scanner.frame_timeout_ms", "1000"}},
                  "[retry]\nframe = 0\nbranch = 1\n"),
              R"(
step 1 of 4, 0 of 4 frames: small, step 1 of 4, loading; 0.000 s 0 -0.012 -0.018 psi settled
step 2 of 4, 1 of 4 frames: small, step 2 of 4, loading; 2.650 s 0 -0.004 -0.003 psi settled
step 3 of 4, 2 of 4 frames: small, step 3 of 4, loading; 5.300 s 2 2.040 2.124 psi settled
step 3 of 4, 2 of 4 frames: back to branch 1 of repeat 1: conditioning 1 of 1; 7.950 s 4 4.032 4.132 psi settled
step 3 of 4, 2 of 4 frames: back to branch 1 of repeat 1: conditioning 1 of 1; 11.600 s 4 3.972 4.102 psi settled
step 1 of 4, 2 of 4 frames: small, step 1 of 4, loading; 14.850 s 0 0.004 0.000 psi settled
step 2 of 4, 3 of 4 frames: small, step 2 of 4, loading; 17.500 s 0 -0.008 -0.003 psi settled
step 3 of 4, 4 of 4 frames: small, step 3 of 4, loading; 20.150 s 2 2.012 2.130 psi settled
step 4 of 4, 5 of 4 frames: small, step 4 of 4, unloading; 22.800 s 4 3.980 4.102 psi settled
6 of 6 frames, 16 exchanges, 1 redone, 25.650 s, waiting 0.000 s: dwelling 54.6 %, redoing 25.3 %, settling 17.7 %, reading 1.6 %, tearing down 0.8 %
0.000 state: prepared -> running: devices open, chamber unloaded
0.000 seating: left out as asked (--no-seating)
7.950 attempt TB-SCANNER-CORRUPT: frame, 1 of 1: scan with tag 8: a report of 64 bytes is damaged (CRC, id or length); rows not yet received: 8, 9, 10, 11, 12, 13, 14, 15, on packet socket SOCKET
7.950 attempt TB-SCANNER-CORRUPT: branch 0 of repeat 0, 1 of 2: scan with tag 8: a report of 64 bytes is damaged (CRC, id or length); rows not yet received: 8, 9, 10, 11, 12, 13, 14, 15, on packet socket SOCKET
8.350 safe verified: after a fault: vented, verified (feedback 0.1 psi, reference 0.0 psi)
8.350 way-back: conditioned again, then the turning points before branch 0 of repeat 0
25.650 time: dwelling 54.6 %, redoing 25.3 %, settling 17.7 %, reading 1.6 %, tearing down 0.8 %
25.650 state: running -> stopping: all steps done
25.650 safe verified: vented, verified (feedback 0.8 psi, reference 0.7 psi)
branch 0.0.0 attempt 0: 0 to 4 psi, void: TB-SCANNER-CORRUPT: scan with tag 8: a report of 64 bytes is damaged (CRC, id or length); rows not yet received: 8, 9, 10, 11, 12, 13, 14, 15, on packet socket SOCKET
0: 2.650 s, 2.650 since command, 2.000 in band; 0 -0.004 -0.003 psi, 0 -1 -1; 2x16x16 134130; 16; 8: 11.15 0.00 -0.05 -0.05
1: 5.300 s, 2.650 since command, 2.000 in band; 2 2.040 2.124 psi, 502 512 696; 2x16x16 799403; 16; 7: 8.50 14.00 14.17 14.92
branch 0.0.0 attempt 1: 0 to 4 psi
0: 17.500 s, 2.650 since command, 2.000 in band; 0 -0.008 -0.003 psi, 0 -2 -1; 2x16x16 133802; 16; 30: 175.55 60.00 60.02 61.57
1: 20.150 s, 2.650 since command, 2.000 in band; 2 2.012 2.130 psi, 502 505 698; 2x16x16 801463; 16; 7: 8.50 14.00 14.19 14.94
2: 22.800 s, 2.650 since command, 2.000 in band; 4 3.980 4.102 psi, 1004 999 1344; 2x16x16 1806578; 16; 7: 8.50 28.00 28.05 28.88
branch 0.0.1 attempt 0: 4 to 2 psi
3: 25.450 s, 2.650 since command, 2.000 in band; 2 1.980 1.895 psi, 502 497 621; 2x16x16 1104537; 16; 7: 8.50 14.00 14.05 13.14
)");
}

TEST_CASE("whole run with faults: a scanner that is silent for good ends it after the attempts it has, line by line") {
  check_lines(lines_of_two_branches(
                  {{"simulation.wire_faults.scanner_silent_after_scans", "6"}, {"scanner.frame_timeout_ms", "200"}},
                  "[retry]\nframe = 1\nbranch = 2\n"),
              R"(
step 1 of 4, 0 of 4 frames: small, step 1 of 4, loading; 0.000 s 0 -0.012 -0.018 psi settled
step 2 of 4, 1 of 4 frames: small, step 2 of 4, loading; 2.650 s 0 -0.004 -0.003 psi settled
step 3 of 4, 2 of 4 frames: small, step 3 of 4, loading; 5.300 s 2 2.040 2.124 psi settled
step 3 of 4, 2 of 4 frames: back to branch 1 of repeat 1: conditioning 1 of 1; 7.950 s 4 4.032 4.132 psi settled
step 3 of 4, 2 of 4 frames: back to branch 1 of repeat 1: conditioning 1 of 1; 12.200 s 4 3.996 4.108 psi settled
step 1 of 4, 2 of 4 frames: small, step 1 of 4, loading; 15.450 s 0 0.016 0.009 psi settled
step 1 of 4, 2 of 4 frames: back to branch 1 of repeat 1: conditioning 1 of 1; 18.100 s 0 0.004 -0.018 psi settled
step 1 of 4, 2 of 4 frames: back to branch 1 of repeat 1: conditioning 1 of 1; 21.950 s 4 4.028 4.123 psi settled
step 1 of 4, 2 of 4 frames: small, step 1 of 4, loading; 25.200 s 0 -0.028 0.000 psi settled
2 of 2 frames, 16 exchanges, 2 redone, 28.450 s, waiting 0.000 s: redoing 45.7 %, dwelling 35.1 %, settling 11.4 %, reading 7.0 %, tearing down 0.7 %
3 TB-SCANNER-TIMEOUT: asking scan 0 (tag 3) of packet socket .../scanner: no report within 200 ms | run 1, after frame 2, tactile scanner | Check the scanner's power and cable, then start again. | vented, verified (feedback 0.0 psi, reference 0.0 psi); run 1 kept with 2 frames
0.000 state: prepared -> running: devices open, chamber unloaded
0.000 seating: left out as asked (--no-seating)
8.150 attempt TB-SCANNER-TIMEOUT: frame, 1 of 2: asking scan 0 (tag 8) of packet socket SOCKET: no report within 200 ms
8.350 attempt TB-SCANNER-TIMEOUT: frame, 2 of 2: asking scan 0 (tag 9) of packet socket SOCKET: no report within 200 ms
8.350 attempt TB-SCANNER-TIMEOUT: branch 0 of repeat 0, 1 of 3: asking scan 0 (tag 9) of packet socket SOCKET: no report within 200 ms
8.950 safe verified: after a fault: vented, verified (feedback 0.1 psi, reference 0.0 psi)
8.950 way-back: conditioned again, then the turning points before branch 0 of repeat 0
18.300 attempt TB-SCANNER-TIMEOUT: frame, 1 of 2: asking scan 0 (tag 2) of packet socket SOCKET: no report within 200 ms
18.500 attempt TB-SCANNER-TIMEOUT: frame, 2 of 2: asking scan 0 (tag 3) of packet socket SOCKET: no report within 200 ms
18.500 attempt TB-SCANNER-TIMEOUT: branch 0 of repeat 0, 2 of 3: asking scan 0 (tag 3) of packet socket SOCKET: no report within 200 ms
18.700 safe verified: after a fault: vented, verified (feedback 0.0 psi, reference 0.0 psi)
18.700 way-back: conditioned again, then the turning points before branch 0 of repeat 0
28.050 attempt TB-SCANNER-TIMEOUT: frame, 1 of 2: asking scan 0 (tag 2) of packet socket SOCKET: no report within 200 ms
28.250 attempt TB-SCANNER-TIMEOUT: frame, 2 of 2: asking scan 0 (tag 3) of packet socket SOCKET: no report within 200 ms
28.450 fault TB-SCANNER-TIMEOUT: asking scan 0 (tag 3) of packet socket SOCKET: no report within 200 ms
28.450 time: redoing 45.7 %, dwelling 35.1 %, settling 11.4 %, reading 7.0 %, tearing down 0.7 %
28.450 state: running -> stopping: TB-SCANNER-TIMEOUT: asking scan 0 (tag 3) of packet socket SOCKET: no report within 200 ms
28.450 safe verified: vented, verified (feedback 0.0 psi, reference 0.0 psi)
branch 0.0.0 attempt 0: 0 to 4 psi, void: TB-SCANNER-TIMEOUT: asking scan 0 (tag 9) of packet socket SOCKET: no report within 200 ms
0: 2.650 s, 2.650 since command, 2.000 in band; 0 -0.004 -0.003 psi, 0 -1 -1; 2x16x16 134130; 16; 8: 11.15 0.00 -0.05 -0.05
1: 5.300 s, 2.650 since command, 2.000 in band; 2 2.040 2.124 psi, 502 512 696; 2x16x16 799403; 16; 7: 8.50 14.00 14.17 14.92
branch 0.0.0 attempt 1: 0 to 4 psi, void: TB-SCANNER-TIMEOUT: asking scan 0 (tag 3) of packet socket SOCKET: no report within 200 ms
branch 0.0.0 attempt 2: 0 to 4 psi
)");
}

TEST_CASE("whole run with faults: a branch that is broken again and again ends it, line by line") {
  check_lines(
      lines_of_two_branches({{"settling.trace_s", "0.1"}}, "[guard]\nredo = 1\n[conditioning]\ncycles = 1\npeak = 6\n",
                            {planned_fault(bench::FaultKind::kOvershoot, 9.0, 1e6, 1.5),
                             planned_fault(bench::FaultKind::kOvershoot, 17.0, 1e6, 1.5)}),
      R"(
step 1 of 6, 0 of 4 frames: conditioning 1 of 1; 0.000 s 0 -0.012 -0.018 psi settled
step 2 of 6, 0 of 4 frames: conditioning 1 of 1; 3.500 s 6 6.011 6.134 psi settled
step 3 of 6, 0 of 4 frames: small, step 3 of 6, loading; 6.800 s 0 0.004 -0.015 psi settled
step 4 of 6, 1 of 4 frames: small, step 4 of 6, loading; 9.200 s 0 0.000 -0.009 psi settled
step 4 of 6, 1 of 4 frames: back to branch 1 of repeat 1: conditioning 1 of 1; 9.800 s 2 2.665 2.582 psi
step 4 of 6, 1 of 4 frames: back to branch 1 of repeat 1: conditioning 1 of 1; 13.000 s 6 6.027 6.122 psi settled
step 3 of 6, 1 of 4 frames: small, step 3 of 6, loading; 16.300 s 0 -0.016 0.003 psi settled
step 4 of 6, 2 of 4 frames: small, step 4 of 6, loading; 18.700 s 0 0.004 0.009 psi settled
2 of 2 frames, 34 exchanges, 1 redone, 19.500 s, waiting 0.000 s: conditioning 34.9 %, redoing 33.3 %, dwelling 20.5 %, settling 10.3 %, tearing down 1.0 %
3 TB-BRANCH-BROKEN: branch 0 of repeat 0: rose to 3.51 and fell back to 2.56 in the branch from 0 to 4 (tolerance 0.2) psi, 2 times | run 1, after frame 2, sequencer | see the traces of the void branches: a leak, an overshooting valve or a tolerance below the noise; the recipe's [guard] table has tolerance_psi, redo and on_broken | vented, verified (feedback 0.9 psi, reference 0.8 psi); run 1 kept with 2 frames
0.000 state: prepared -> running: devices open, chamber unloaded
0.000 seating: left out as asked (--no-seating)
6.800 check conditioning pass {"cycles_at_most":1,"change_limit_percent":0.0}:
9.800 branch-broken TB-BRANCH-BROKEN: branch 0 of repeat 0: rose to 3.53 and fell back to 2.58 in the branch from 0 to 4 (tolerance 0.2) psi
9.800 way-back: conditioned again, then the turning points before branch 0 of repeat 0
19.300 branch-broken TB-BRANCH-BROKEN: branch 0 of repeat 0: rose to 3.51 and fell back to 2.56 in the branch from 0 to 4 (tolerance 0.2) psi
19.500 fault TB-BRANCH-BROKEN: branch 0 of repeat 0: rose to 3.51 and fell back to 2.56 in the branch from 0 to 4 (tolerance 0.2) psi, 2 times
19.500 time: conditioning 34.9 %, redoing 33.3 %, dwelling 20.5 %, settling 10.3 %, tearing down 1.0 %
19.500 state: running -> stopping: TB-BRANCH-BROKEN: branch 0 of repeat 0: rose to 3.51 and fell back to 2.56 in the branch from 0 to 4 (tolerance 0.2) psi, 2 times
19.500 safe verified: vented, verified (feedback 0.9 psi, reference 0.8 psi)
branch 0.0.0 attempt 0: 0 to 4 psi, void: TB-BRANCH-BROKEN: rose to 3.53 and fell back to 2.58 in the branch from 0 to 4 (tolerance 0.2) psi
0: 9.200 s, 2.400 since command, 2.000 in band; 0 0.000 -0.009 psi, 0 0 -3; 2x16x16 134130; 34; 81: 330.30 168.00 168.22 171.06
branch 0.0.0 attempt 1: 0 to 4 psi, void: TB-BRANCH-BROKEN: rose to 3.51 and fell back to 2.56 in the branch from 0 to 4 (tolerance 0.2) psi
0: 18.700 s, 2.400 since command, 2.000 in band; 0 0.004 0.009 psi, 0 1 3; 2x16x16 134496; 34; 81: 330.40 166.00 170.86 173.72
)");
}

TEST_CASE("whole run with faults: a broken branch that is kept where its recipe says so, line by line") {
  check_lines(lines_of_two_branches({{"settling.trace_s", "0.1"}}, "[guard]\nredo = 0\non_broken = \"flag\"\n",
                                    {planned_fault(bench::FaultKind::kOvershoot, 3.0, 1e6, 1.5)}),
              R"(
step 1 of 4, 0 of 4 frames: small, step 1 of 4, loading; 0.000 s 0 -0.012 -0.018 psi settled
step 2 of 4, 1 of 4 frames: small, step 2 of 4, loading; 2.400 s 0 0.032 0.000 psi settled
step 3 of 4, 2 of 4 frames: small, step 3 of 4, loading; 5.000 s 2 1.992 2.124 psi settled
step 4 of 4, 3 of 4 frames: small, step 4 of 4, unloading; 8.000 s 4 4.000 3.873 psi settled
4 of 4 frames, 38 exchanges, 0 redone, 11.000 s, waiting 0.000 s: dwelling 72.7 %, settling 25.5 %, tearing down 1.8 %
0.000 state: prepared -> running: devices open, chamber unloaded
0.000 seating: left out as asked (--no-seating)
11.000 time: dwelling 72.7 %, settling 25.5 %, tearing down 1.8 %
11.000 state: running -> stopping: all steps done
11.000 safe verified: vented, verified (feedback 0.8 psi, reference 0.7 psi)
branch 0.0.0 attempt 0: 0 to 4 psi
0: 2.400 s, 2.400 since command, 2.000 in band; 0 0.032 0.000 psi, 0 8 0; 2x16x16 134130; 34; 26: 28.30 0.00 0.02 -0.08
1: 5.000 s, 2.600 since command, 2.000 in band; 2 1.992 2.124 psi, 502 500 696; 2x16x16 798924; 34; 25: 27.40 50.00 49.48 52.43
2: 8.000 s, 3.000 since command, 2.000 in band; 4 4.000 3.873 psi, 1004 1004 1269; 2x16x16 2192609; 38; 28: 33.70 112.00 113.91 110.93; broken
branch 0.0.1 attempt 0: 4 to 2 psi
3: 10.800 s, 2.800 since command, 2.000 in band; 2 2.052 1.895 psi, 502 515 621; 2x16x16 1206795; 35; 26: 30.40 52.00 53.10 49.90
)");
}

TEST_CASE("whole run with faults: a supply that stays away ends it, line by line") {
  const std::vector<sequences::Override> sensor = {
      {"environment.sensor", "[{quantity = 'supply_bar', unit = 9, address = 20, type = 'f32'}]"}};
  const std::string rule =
      "[[suspend]]\nquantity = \"supply_bar\"\ntrip_below = 6\nresume_above = 6.5\nhold_s = 2\ntimeout_s = 3\n";
  check_lines(lines_of_two_branches(sensor, rule, {planned_fault(bench::FaultKind::kSupplyLost, 4.0, 1e6, 0.001)}), R"(
step 1 of 4, 0 of 4 frames: small, step 1 of 4, loading; 0.000 s 0 -0.012 -0.018 psi settled
step 2 of 4, 1 of 4 frames: small, step 2 of 4, loading; 2.650 s 0 -0.004 -0.003 psi settled
step 3 of 4, 2 of 4 frames: small, step 3 of 4, loading; 5.300 s 2 2.036 2.121 psi settled
2 of 2 frames, 17 exchanges, 1 redone, 9.150 s, waiting 3.200 s: dwelling 43.7 %, waiting 35.0 %, settling 21.3 %
3 TB-RUN-SUSPENDED: supply_bar is 0.00, below 6, and it did not come back within 3 s | run 1, after frame 2, surroundings | restore the supply or the room's temperature, then `tactbench resume`; the recipe's [[suspend]] has timeout_s | vented, verified (feedback 0.0 psi, reference 0.0 psi); run 1 kept with 2 frames
0.000 environment supply_bar: 8.000
0.000 state: prepared -> running: devices open, chamber unloaded
0.000 seating: left out as asked (--no-seating)
5.750 state: running -> suspended: supply_bar is 0.00, below 6
5.950 safe verified: to wait: supply_bar is 0.00, below 6: vented, verified (feedback 0.8 psi, reference 0.7 psi)
9.150 fault TB-RUN-SUSPENDED: supply_bar is 0.00, below 6, and it did not come back within 3 s
9.150 time: dwelling 43.7 %, waiting 35.0 %, settling 21.3 %
9.150 state: suspended -> stopping: TB-RUN-SUSPENDED: supply_bar is 0.00, below 6, and it did not come back within 3 s
9.150 safe verified: vented, verified (feedback 0.0 psi, reference 0.0 psi)
branch 0.0.0 attempt 0: 0 to 4 psi, void: suspended: supply_bar is 0.00, below 6
0: 2.650 s, 2.650 since command, 2.000 in band; 0 -0.004 -0.003 psi, 0 -1 -1; 2x16x16 134130; 17; 8: 11.15 0.00 -0.05 -0.05
1: 5.300 s, 2.650 since command, 2.000 in band; 2 2.036 2.121 psi, 502 511 695; 2x16x16 798548; 16; 7: 8.50 14.00 14.17 14.92
)");
}
