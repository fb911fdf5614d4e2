// Whole runs of the second platform on the simulated rig, as they were recorded: a ring pressed to two levels, and a
// point whose touches tell where the taxels lie. A deliberate change of the simulation or of what a run does changes
// them.
#include "tests/bench/run/recorded_run.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("whole press run: a ring pressed in one place, line by line") {
  bench::RunRequest request = small_request();
  request.recipes = {recipe_of(press_text(1))};
  check_lines(lines_of_run(request), R"(
step 0 of 12, 0 of 3 frames: homing the stage; 0.000 s 0 -0.012 -0.018 psi settled
step 0 of 12, 0 of 3 frames: zeroing the force sensor; 0.000 s 0 -0.012 -0.018 psi settled
step 0 of 12, 0 of 3 frames: moving to x 30 mm, y 30 mm; 0.000 s 0 -0.012 -0.018 psi settled
step 4 of 12, 0 of 3 frames: conditioning 1 of 1; 0.000 s 0 -0.012 -0.018 psi settled
step 5 of 12, 0 of 3 frames: conditioning 1 of 1, 10 N; 0.000 s 0 -0.012 -0.018 psi settled
step 6 of 12, 0 of 3 frames: conditioning 1 of 1; 41.808 s 0 -0.012 -0.018 psi settled 9.997 N
step 6 of 12, 0 of 3 frames: approaching the specimen; 41.808 s 0 -0.012 -0.018 psi settled 9.997 N
step 8 of 12, 0 of 3 frames: small, step 8 of 12, loading, 5 N; 41.808 s 0 -0.012 -0.018 psi settled 9.997 N
step 9 of 12, 1 of 3 frames: small, step 9 of 12, loading, 30 N; 62.237 s 0 -0.012 -0.018 psi settled 4.988 N
step 10 of 12, 2 of 3 frames: small, step 10 of 12, unloading, 5 N; 78.413 s 0 -0.012 -0.018 psi settled 29.936 N
step 10 of 12, 3 of 3 frames: retracting the stage; 94.108 s 0 -0.012 -0.018 psi settled 5.004 N
step 10 of 12, 3 of 3 frames: zeroing the force sensor; 94.108 s 0 -0.012 -0.018 psi settled 5.004 N
3 of 3 frames, 40 exchanges, 0 redone, 95.099 s, waiting 0.000 s: dwelling 38.3 %, moving 32.7 %, conditioning 28.9 %, tearing down 0.1 %
0.000 fail-safe: tactbench: every run ends vented, with proof of it; trip above 66 psi
0.000 fail-safe: Beckhoff EK9000 + EL4xxx/EL3xxx: coupler watchdog: outputs to 0 V when no write comes in time (set and read back at the start)
0.000 fail-safe: Beckhoff EK9000 + EL4xxx/EL3xxx: EL4xxx terminal watchdog: 0 V by default, 0x80n0:05, :13, :14 (neither set nor read by tactbench)
0.000 fail-safe: watchdog time 1000 ms, fed every 450 ms
0.000 state: prepared -> running: devices open, chamber unloaded
0.000 seating: left out as asked (--no-seating)
0.000 command stage z: homing
3.900 command stage x: homing
5.800 command stage y: homing
7.700 stage home: z, x and y stand at their home sensors
7.700 stage tare: Fz offset 0.000 N
7.700 command stage x: a move to 30 mm at 4 mm/s
7.700 command stage y: a move to 30 mm at 4 mm/s
7.700 check tare pass {"removed_fz_n":0.00021714}: 0.00102432 0.00081748 0.00021714 -0.0031261 0.00585118 -0.00422424
15.250 command stage z: a move to 25 mm at 8 mm/s
18.509 command stage z: a move to 50.79 mm at 0.5 mm/s
28.649 command stage z: a move to 29.9206 mm at 0.05 mm/s
30.699 command stage z: a move to 29.9306 mm at 0.05 mm/s
30.949 command stage z: a move to 29.9406 mm at 0.05 mm/s
31.199 command stage z: a move to 29.9506 mm at 0.05 mm/s
31.449 command stage z: a move to 29.9606 mm at 0.05 mm/s
31.699 command stage z: a move to 29.9706 mm at 0.05 mm/s
31.949 command stage z: a move to 29.9806 mm at 0.05 mm/s
32.199 command stage z: a move to 29.9906 mm at 0.05 mm/s
32.449 command stage z: a move to 30.0006 mm at 0.05 mm/s
32.699 command stage z: a move to 30.0106 mm at 0.05 mm/s
32.949 command stage z: a move to 30.0206 mm at 0.05 mm/s
33.199 stage contact: at z 30.0004 mm +- 0.0152 mm, 21.3 N/mm; 0.43 N felt on the way
33.199 command stage z: a move to 30.0454 mm at 0.05 mm/s
33.746 command stage z: a move to 30.0977 mm at 0.05 mm/s
34.842 command stage z: a move to 30.2092 mm at 0.05 mm/s
37.122 command stage z: a move to 30.3546 mm at 0.05 mm/s
40.081 command stage z: a move to 30.4071 mm at 0.05 mm/s
41.179 command stage z: a move to 30.411 mm at 0.05 mm/s
41.808 command stage z: a move to 25 mm at 8 mm/s
42.719 command stage z: a move to 25 mm at 8 mm/s
42.719 check conditioning pass {"cycles_at_most":1,"change_limit_percent":0.0}:
42.769 command stage z: a move to 50.79 mm at 0.5 mm/s
52.909 command stage z: a move to 29.9206 mm at 0.05 mm/s
54.959 command stage z: a move to 29.9306 mm at 0.05 mm/s
55.209 command stage z: a move to 29.9406 mm at 0.05 mm/s
55.459 command stage z: a move to 29.9506 mm at 0.05 mm/s
55.709 command stage z: a move to 29.9606 mm at 0.05 mm/s
55.959 command stage z: a move to 29.9706 mm at 0.05 mm/s
56.209 command stage z: a move to 29.9806 mm at 0.05 mm/s
56.459 command stage z: a move to 29.9906 mm at 0.05 mm/s
56.709 command stage z: a move to 30.0006 mm at 0.05 mm/s
56.959 command stage z: a move to 30.0106 mm at 0.05 mm/s
57.209 command stage z: a move to 30.0206 mm at 0.05 mm/s
57.459 command stage z: a move to 30.0306 mm at 0.05 mm/s
57.709 stage contact: at z 30.0015 mm +- 0.0241 mm, 21.1 N/mm; 0.61 N felt on the way
57.709 command stage z: a move to 30.0664 mm at 0.05 mm/s
58.475 command stage z: a move to 30.1407 mm at 0.05 mm/s
60.011 command stage z: a move to 30.2059 mm at 0.05 mm/s
61.365 command stage z: a move to 30.222 mm at 0.05 mm/s
62.237 command stage z: a move to 30.4863 mm at 0.05 mm/s
67.573 command stage z: a move to 30.8837 mm at 0.05 mm/s
75.572 command stage z: a move to 30.9983 mm at 0.05 mm/s
78.413 command stage z: a move to 30.5928 mm at 0.05 mm/s
86.573 command stage z: a move to 30.3912 mm at 0.05 mm/s
90.656 command stage z: a move to 30.2783 mm at 0.05 mm/s
92.963 command stage z: a move to 30.2534 mm at 0.05 mm/s
93.511 command stage z: a move to 30.251 mm at 0.05 mm/s
94.108 command stage z: a move to 25 mm at 8 mm/s
94.999 stage tare: Fz offset 0.000 N, drifted 0.000 N
94.999 check tare pass {"removed_fz_n":0.00042766,"drift_fz_n":0.00021052}: 6.618e-05 -0.00063692 0.00042766 0.00193554 -0.00127238 -0.00451926
95.099 time: dwelling 38.3 %, moving 32.7 %, conditioning 28.9 %, tearing down 0.1 %
95.099 state: running -> stopping: all steps done
95.099 safe verified: vented, verified (feedback 0.0 psi, reference 0.0 psi); retracted, verified (z 25.000 mm, 0.00 N)
branch 0.0.0 attempt 0: 0 to 0 psi, 0 to 30 N
0: 62.237 s, 4.528 since command, 0.500 in band; 0 0.000 0.000 psi, 0 0 0; 2x16x16 318514; 33; 1: 62.24 0.00 -0.01 -0.02; 5 N from 4.988, -0.001 -0.001 -4.971 0.004 -0.008 0.005 at 30 30 30.2220, raw 426 -648 -4970586 1127 -2482 555
1: 78.413 s, 16.175 since command, 0.500 in band; 0 0.000 0.000 psi, 0 0 0; 2x16x16 1504005; 29; 0: 0.00 0.00 0.00 0.00; 30 N from 29.936, -0.001 -0.001 -29.895 0.000 -0.006 0.005 at 30 30 30.9983, raw -64 132 -29894692 -2713 -320 916
branch 0.0.1 attempt 0: 0 to 0 psi, 30 to 5 N
2: 94.108 s, 15.696 since command, 0.500 in band; 0 0.000 0.000 psi, 0 0 0; 2x16x16 653183; 40; 0: 0.00 0.00 0.00 0.00; 5 N from 5.004, -0.001 -0.001 -5.028 0.004 -0.006 0.007 at 30 30 30.2510, raw -283 -269 -5027472 528 239 2821
)");
}

TEST_CASE("whole press run: a point that holds its force in three places and registers them, line by line") {
  bench::RunRequest request = small_request();
  request.recipes = {recipe_of(
      "kind = \"press\"\ndwell_s = 1.0\n[press]\nobject = \"point\"\npositions_mm = [[20, 24], [40, 28], [30, 40]]\n"
      "forces_n = [3]\nhold = \"force\"\nregisters = true\napproach_mm_per_s = 0.6\ncontact_n = 0.15\nclear_mm = "
      "4.0\n")};
  check_lines(lines_of_run(request), R"(
step 0 of 15, 0 of 3 frames: homing the stage; 0.000 s 0 -0.012 -0.018 psi settled
step 0 of 15, 0 of 3 frames: zeroing the force sensor; 0.000 s 0 -0.012 -0.018 psi settled
step 0 of 15, 0 of 3 frames: moving to x 20 mm, y 24 mm; 0.000 s 0 -0.012 -0.018 psi settled
step 0 of 15, 0 of 3 frames: approaching the specimen; 0.000 s 0 -0.012 -0.018 psi settled
step 5 of 15, 0 of 3 frames: small, step 5 of 15, loading, 3 N; 0.000 s 0 -0.012 -0.018 psi settled
step 5 of 15, 1 of 3 frames: retracting the stage; 33.760 s 0 -0.012 -0.018 psi settled 2.973 N
step 5 of 15, 1 of 3 frames: moving to x 40 mm, y 28 mm; 33.760 s 0 -0.012 -0.018 psi settled 2.973 N
step 5 of 15, 1 of 3 frames: approaching the specimen; 33.760 s 0 -0.012 -0.018 psi settled 2.973 N
step 9 of 15, 1 of 3 frames: small, step 9 of 15, loading, 3 N; 33.760 s 0 -0.012 -0.018 psi settled 2.973 N
step 9 of 15, 2 of 3 frames: retracting the stage; 56.489 s 0 -0.012 -0.018 psi settled 2.974 N
step 9 of 15, 2 of 3 frames: moving to x 30 mm, y 40 mm; 56.489 s 0 -0.012 -0.018 psi settled 2.974 N
step 9 of 15, 2 of 3 frames: approaching the specimen; 56.489 s 0 -0.012 -0.018 psi settled 2.974 N
step 13 of 15, 2 of 3 frames: small, step 13 of 15, loading, 3 N; 56.489 s 0 -0.012 -0.018 psi settled 2.974 N
step 13 of 15, 3 of 3 frames: retracting the stage; 77.148 s 0 -0.012 -0.018 psi settled 2.998 N
step 13 of 15, 3 of 3 frames: zeroing the force sensor; 77.148 s 0 -0.012 -0.018 psi settled 2.998 N
3 of 3 frames, 41 exchanges, 0 redone, 78.125 s, waiting 0.000 s: moving 86.6 %, dwelling 13.3 %, tearing down 0.1 %
0.000 fail-safe: tactbench: every run ends vented, with proof of it; trip above 66 psi
0.000 fail-safe: Beckhoff EK9000 + EL4xxx/EL3xxx: coupler watchdog: outputs to 0 V when no write comes in time (set and read back at the start)
0.000 fail-safe: Beckhoff EK9000 + EL4xxx/EL3xxx: EL4xxx terminal watchdog: 0 V by default, 0x80n0:05, :13, :14 (neither set nor read by tactbench)
0.000 fail-safe: watchdog time 1000 ms, fed every 450 ms
0.000 state: prepared -> running: devices open, chamber unloaded
0.000 seating: left out as asked (--no-seating)
0.000 command stage z: homing
3.900 command stage x: homing
5.800 command stage y: homing
7.700 stage home: z, x and y stand at their home sensors
7.700 stage tare: Fz offset 0.000 N
7.700 command stage x: a move to 20 mm at 4 mm/s
7.700 command stage y: a move to 24 mm at 4 mm/s
7.700 check tare pass {"removed_fz_n":0.00021714}: 0.00102432 0.00081748 0.00021714 -0.0031261 0.00585118 -0.00422424
13.750 command stage z: a move to 25 mm at 8 mm/s
17.009 command stage z: a move to 50.79 mm at 0.6 mm/s
25.469 command stage z: a move to 29.9166 mm at 0.05 mm/s
27.519 command stage z: a move to 29.9266 mm at 0.05 mm/s
27.769 command stage z: a move to 29.9366 mm at 0.05 mm/s
28.019 command stage z: a move to 29.9466 mm at 0.05 mm/s
28.269 command stage z: a move to 29.9566 mm at 0.05 mm/s
28.519 command stage z: a move to 29.9666 mm at 0.05 mm/s
28.769 command stage z: a move to 29.9766 mm at 0.05 mm/s
29.019 command stage z: a move to 29.9866 mm at 0.05 mm/s
29.269 command stage z: a move to 29.9966 mm at 0.05 mm/s
29.519 command stage z: a move to 30.0066 mm at 0.05 mm/s
29.769 command stage z: a move to 30.0166 mm at 0.05 mm/s
30.019 command stage z: a move to 30.0266 mm at 0.05 mm/s
30.269 stage contact: at z 30.0001 mm +- 0.0215 mm, 21.0 N/mm; 0.56 N felt on the way
30.269 command stage z: a move to 30.0592 mm at 0.05 mm/s
30.972 command stage z: a move to 30.1096 mm at 0.05 mm/s
32.030 command stage z: a move to 30.1337 mm at 0.05 mm/s
32.561 command stage z: a move to 30.1375 mm at 0.05 mm/s
33.687 command stage z: a move to 30.1386 mm at 0.05 mm/s
33.760 command stage z: a move to 25 mm at 8 mm/s
34.636 command stage x: a move to 40 mm at 4 mm/s
34.636 command stage y: a move to 28 mm at 4 mm/s
39.686 command stage z: a move to 25 mm at 8 mm/s
39.736 command stage z: a move to 50.79 mm at 0.6 mm/s
48.196 command stage z: a move to 29.9166 mm at 0.05 mm/s
50.246 command stage z: a move to 29.9266 mm at 0.05 mm/s
50.496 command stage z: a move to 29.9366 mm at 0.05 mm/s
50.746 command stage z: a move to 29.9466 mm at 0.05 mm/s
50.996 command stage z: a move to 29.9566 mm at 0.05 mm/s
51.246 command stage z: a move to 29.9666 mm at 0.05 mm/s
51.496 command stage z: a move to 29.9766 mm at 0.05 mm/s
51.746 command stage z: a move to 29.9866 mm at 0.05 mm/s
51.996 command stage z: a move to 29.9966 mm at 0.05 mm/s
52.246 command stage z: a move to 30.0066 mm at 0.05 mm/s
52.496 command stage z: a move to 30.0166 mm at 0.05 mm/s
52.746 command stage z: a move to 30.0266 mm at 0.05 mm/s
52.996 stage contact: at z 30.0004 mm +- 0.0212 mm, 21.1 N/mm; 0.55 N felt on the way
52.996 command stage z: a move to 30.0588 mm at 0.05 mm/s
53.690 command stage z: a move to 30.1095 mm at 0.05 mm/s
54.754 command stage z: a move to 30.1337 mm at 0.05 mm/s
55.289 command stage z: a move to 30.1376 mm at 0.05 mm/s
56.417 command stage z: a move to 30.1387 mm at 0.05 mm/s
56.489 command stage z: a move to 25 mm at 8 mm/s
57.366 command stage x: a move to 30 mm at 4 mm/s
57.366 command stage y: a move to 40 mm at 4 mm/s
60.416 command stage z: a move to 25 mm at 8 mm/s
60.466 command stage z: a move to 50.79 mm at 0.6 mm/s
68.926 command stage z: a move to 29.9166 mm at 0.05 mm/s
70.976 command stage z: a move to 29.9266 mm at 0.05 mm/s
71.226 command stage z: a move to 29.9366 mm at 0.05 mm/s
71.476 command stage z: a move to 29.9466 mm at 0.05 mm/s
71.726 command stage z: a move to 29.9566 mm at 0.05 mm/s
71.976 command stage z: a move to 29.9666 mm at 0.05 mm/s
72.226 command stage z: a move to 29.9766 mm at 0.05 mm/s
72.476 command stage z: a move to 29.9866 mm at 0.05 mm/s
72.726 command stage z: a move to 29.9966 mm at 0.05 mm/s
72.976 command stage z: a move to 30.0066 mm at 0.05 mm/s
73.226 command stage z: a move to 30.0166 mm at 0.05 mm/s
73.476 command stage z: a move to 30.0266 mm at 0.05 mm/s
73.726 stage contact: at z 30.0005 mm +- 0.0211 mm, 21.1 N/mm; 0.55 N felt on the way
73.726 command stage z: a move to 30.0588 mm at 0.05 mm/s
74.419 command stage z: a move to 30.1096 mm at 0.05 mm/s
75.486 command stage z: a move to 30.1338 mm at 0.05 mm/s
76.020 command stage z: a move to 30.1377 mm at 0.05 mm/s
77.148 command stage z: a move to 25 mm at 8 mm/s
78.025 stage tare: Fz offset -0.000 N, drifted -0.001 N
78.025 check tare pass {"removed_fz_n":-0.00037226,"drift_fz_n":-0.0005894}: -0.00015776 -0.00054574 -0.00037226 0.0013959 0.00071806 -0.00088886
78.025 check mount pass {"angle_deg":-1.15179,"offset_mm":[10.7186,11.5329],"flipped":false,"scale":0.998321,"pitch_mm":2.54,"rms_mm":0.227716,"other_flip_rms_mm":10.0778,"touches":[{"stage_mm":[20.0,24.0],"taxel_mm":[8.85664,12.7],"residual_mm":0.189182},{"stage_mm":[40.0,28.0],"taxel_mm":[29.089,17.2933],"residual_mm":0.232503},{"stage_mm":[30.0,40.0],"taxel_mm":[18.8284,28.6576],"residual_mm":0.256352}]}: -1.15179 10.7186 11.5329 0.227716
78.125 time: moving 86.6 %, dwelling 13.3 %, tearing down 0.1 %
78.125 state: running -> stopping: all steps done
78.125 safe verified: vented, verified (feedback 0.0 psi, reference 0.0 psi); retracted, verified (z 25.000 mm, 0.00 N)
branch 0.0.0 attempt 0: 0 to 0 psi, 0 to 3 N
0: 33.760 s, 3.490 since command, 1.072 in band; 0 0.000 0.000 psi, 0 0 0; 2x16x16 236485; 41; 1: 33.76 0.00 -0.01 -0.02; 3 N from 2.996, -0.001 -0.001 -2.998 0.004 -0.004 0.004 at 20 24 30.1386, raw -196 -15 -2998015 1191 1803 -310
branch 0.0.2 attempt 0: 0 to 0 psi, 0 to 3 N
1: 56.489 s, 3.492 since command, 1.072 in band; 0 0.000 0.000 psi, 0 0 0; 2x16x16 332631; 41; 0: 0.00 0.00 0.00 0.00; 3 N from 2.998, -0.000 -0.001 -2.998 0.005 -0.002 0.002 at 40 28 30.1387, raw 540 53 -2997438 2175 3823 -2672
branch 0.0.4 attempt 0: 0 to 0 psi, 0 to 3 N
2: 77.148 s, 3.422 since command, 1.000 in band; 0 0.000 0.000 psi, 0 0 0; 2x16x16 273019; 34; 0: 0.00 0.00 0.00 0.00; 3 N from 2.998, -0.001 -0.001 -2.976 0.006 -0.007 0.005 at 30 40 30.1377, raw 23 -175 -2975831 2422 -1286 477
)");
}
