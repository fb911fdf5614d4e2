// Whole runs of pressure on the simulated rig, as they were recorded: warm-up, seating, conditioning by criterion, a
// wait for the supply, a broken branch; levels with several frames, and ramps without stops. A deliberate change of the
// simulation or of what a run does changes them.
#include "tests/bench/run/recorded_run.h"

using namespace tactbench;
using namespace tactbench::tests;

TEST_CASE("whole run: warmed up, seated, conditioned, suspended, broken and completed, line by line") {
  bench::RunRequest request =
      small_request({{"settling.trace_s", "0.1"},
                     {"environment.sensor", "[{quantity = 'supply_bar', unit = 9, address = 20, type = 'f32'}]"}});
  request.recipes = {recipe_of(
      "unit = \"psi\"\nturning_points = [0, 6, 2, 6]\nstep = 2\nrepeats = 1\n"
      "[warm_up]\ndrift_percent_per_min = 100.0\nat_most_s = 600\n"
      "[[suspend]]\nquantity = \"supply_bar\"\ntrip_below = 6\nresume_above = 6.5\nhold_s = 2\ntimeout_s = 100\n"
      "[conditioning]\ncycles = 3\npeak = 20\nchange_percent = 4\nleast = 2\n")};
  request.check_seating = true;
  request.bench.simulation->plant.faults = {planned_fault(bench::FaultKind::kSupplyLost, 68.0, 8.0, 0.001),
                                            planned_fault(bench::FaultKind::kOvershoot, 105.0, 1e6, 1.5)};
  check_lines(lines_of_run(request), R"(
step 1 of 14, 0 of 8 frames: conditioning 1 of at most 3; 48.000 s 0 0.020 0.000 psi settled
step 2 of 14, 0 of 8 frames: conditioning 1 of at most 3; 52.200 s 20 20.034 20.115 psi settled
step 3 of 14, 0 of 8 frames: conditioning 2 of at most 3; 56.200 s 0 -0.044 0.024 psi settled
step 4 of 14, 0 of 8 frames: conditioning 2 of at most 3; 60.400 s 20 19.994 20.096 psi settled
step 7 of 14, 0 of 8 frames: small, step 7 of 14, loading; 64.400 s 0 0.004 0.003 psi settled
step 8 of 14, 1 of 8 frames: small, step 8 of 14, loading; 66.800 s 0 0.028 -0.015 psi settled
step 9 of 14, 2 of 8 frames: small, step 9 of 14, loading; 69.600 s 2 2.016 2.109 psi settled
step 6 of 14, 2 of 8 frames: back to branch 1 of repeat 1: conditioning 1 of at most 3; 78.000 s 0 0.008 0.006 psi settled
step 6 of 14, 2 of 8 frames: back to branch 1 of repeat 1: conditioning 1 of at most 3; 82.200 s 20 20.010 20.127 psi settled
step 6 of 14, 2 of 8 frames: back to branch 1 of repeat 1: conditioning 2 of at most 3; 86.200 s 0 0.008 0.009 psi settled
step 6 of 14, 2 of 8 frames: back to branch 1 of repeat 1: conditioning 2 of at most 3; 90.200 s 20 19.986 20.109 psi settled
step 6 of 14, 2 of 8 frames: back to branch 1 of repeat 1: conditioning 3 of at most 3; 94.200 s 0 -0.016 -0.003 psi settled
step 6 of 14, 2 of 8 frames: back to branch 1 of repeat 1: conditioning 3 of at most 3; 98.200 s 20 20.006 20.127 psi settled
step 7 of 14, 2 of 8 frames: small, step 7 of 14, loading; 102.200 s 0 -0.004 -0.009 psi settled
step 8 of 14, 3 of 8 frames: small, step 8 of 14, loading; 104.600 s 0 -0.040 0.006 psi settled
step 9 of 14, 4 of 8 frames: small, step 9 of 14, loading; 107.400 s 2 1.996 2.115 psi settled
step 9 of 14, 4 of 8 frames: back to branch 1 of repeat 1: conditioning 1 of at most 3; 108.000 s 4 4.649 4.547 psi
step 9 of 14, 4 of 8 frames: back to branch 1 of repeat 1: conditioning 1 of at most 3; 111.800 s 20 19.966 20.109 psi settled
step 9 of 14, 4 of 8 frames: back to branch 1 of repeat 1: conditioning 2 of at most 3; 115.800 s 0 0.036 -0.006 psi settled
step 9 of 14, 4 of 8 frames: back to branch 1 of repeat 1: conditioning 2 of at most 3; 120.000 s 20 19.990 20.133 psi settled
step 9 of 14, 4 of 8 frames: back to branch 1 of repeat 1: conditioning 3 of at most 3; 124.000 s 0 -0.036 -0.009 psi settled
step 9 of 14, 4 of 8 frames: back to branch 1 of repeat 1: conditioning 3 of at most 3; 128.200 s 20 20.022 20.118 psi settled
step 7 of 14, 4 of 8 frames: small, step 7 of 14, loading; 132.200 s 0 0.028 -0.018 psi settled
step 8 of 14, 5 of 8 frames: small, step 8 of 14, loading; 134.600 s 0 0.008 0.012 psi settled
step 9 of 14, 6 of 8 frames: small, step 9 of 14, loading; 137.400 s 2 2.032 2.149 psi settled
step 10 of 14, 7 of 8 frames: small, step 10 of 14, loading; 140.200 s 4 4.012 4.111 psi settled
step 11 of 14, 8 of 8 frames: small, step 11 of 14, unloading; 142.800 s 6 6.019 6.122 psi settled
step 12 of 14, 9 of 8 frames: small, step 12 of 14, unloading; 145.600 s 4 4.008 3.894 psi settled
step 13 of 14, 10 of 8 frames: small, step 13 of 14, loading; 148.200 s 2 2.016 1.892 psi settled
step 14 of 14, 11 of 8 frames: small, step 14 of 14, loading; 151.000 s 4 3.988 4.117 psi settled
12 of 12 frames, 36 exchanges, 2 redone, 154.200 s, waiting 7.400 s: redoing 31.4 %, setting up 31.1 %, dwelling 15.6 %, conditioning 10.6 %, settling 6.2 %, waiting 4.8 %, tearing down 0.3 %
0.000 fail-safe: tactbench: every run ends vented, with proof of it; trip above 66 psi
0.000 fail-safe: Beckhoff EK9000 + EL4xxx/EL3xxx: coupler watchdog: outputs to 0 V when no write comes in time (set and read back at the start)
0.000 fail-safe: Beckhoff EK9000 + EL4xxx/EL3xxx: EL4xxx terminal watchdog: 0 V by default, 0x80n0:05, :13, :14 (neither set nor read by tactbench)
0.000 fail-safe: watchdog time 1000 ms, fed every 450 ms
0.000 environment supply_bar: 8.000
0.000 state: prepared -> running: devices open, chamber unloaded
15.000 check warm-up pass {"took_s":15.0,"last_drift_percent_per_min":0.00436313,"limit_percent_per_min":100.0,"at_most_s":600.0}: 0.00436313
48.000 check seating pass {"pressure_psi":8.10877,"rows":16,"columns":16,"volts_per_count":7.62951e-05,"mean_response_v":0.655434,"dead_taxels":[],"findings":[]}: 238.5 270.5 251 300 280 283
64.400 check conditioning pass {"cycles_at_most":3,"change_limit_percent":4.0,"cycles_done":2,"last_change_percent":1.34409}: 1.34409
70.400 state: running -> suspended: supply_bar is 0.00, below 6
70.600 safe verified: to wait: supply_bar is 0.00, below 6: vented, verified (feedback 0.8 psi, reference 0.7 psi)
78.000 state: suspended -> running: conditions hold again
78.000 way-back: conditioned again, then the turning points before branch 0 of repeat 0
108.000 branch-broken TB-BRANCH-BROKEN: branch 0 of repeat 0: rose to 5.51 and fell back to 4.55 in the branch from 0 to 6 (tolerance 0.2) psi
108.000 way-back: conditioned again, then the turning points before branch 0 of repeat 0
153.800 environment supply_bar: 8.000
154.200 time: redoing 31.4 %, setting up 31.1 %, dwelling 15.6 %, conditioning 10.6 %, settling 6.2 %, waiting 4.8 %, tearing down 0.3 %
154.200 state: running -> stopping: all steps done
154.200 safe verified: vented, verified (feedback 0.2 psi, reference 0.0 psi)
branch 0.0.0 attempt 0: 0 to 6 psi, void: suspended: supply_bar is 0.00, below 6
0: 66.800 s, 2.400 since command, 2.000 in band; 0 0.028 -0.015 psi, 0 7 -5; 2x16x16 134661; 35; 677: 23490.25 3232.00 3229.37 3261.50
1: 69.600 s, 2.800 since command, 2.000 in band; 2 2.016 2.109 psi, 502 506 691; 2x16x16 823153; 35; 26: 30.40 52.00 51.23 54.45
branch 0.0.0 attempt 1: 0 to 6 psi, void: TB-BRANCH-BROKEN: rose to 5.51 and fell back to 4.55 in the branch from 0 to 6 (tolerance 0.2) psi
0: 104.600 s, 2.400 since command, 2.000 in band; 0 -0.040 0.006 psi, 0 -10 2; 2x16x16 134478; 35; 270: 4157.30 2072.00 2065.72 2075.12
1: 107.400 s, 2.800 since command, 2.000 in band; 2 1.996 2.115 psi, 502 501 693; 2x16x16 839509; 35; 26: 30.40 52.00 51.48 54.54
branch 0.0.0 attempt 2: 0 to 6 psi
0: 134.600 s, 2.400 since command, 2.000 in band; 0 0.008 0.012 psi, 0 2 4; 2x16x16 134139; 35; 232: 3007.40 2086.00 2093.40 2101.92
1: 137.400 s, 2.800 since command, 2.000 in band; 2 2.032 2.149 psi, 502 510 704; 2x16x16 847668; 35; 26: 30.40 52.00 51.55 54.57
2: 140.200 s, 2.800 since command, 2.000 in band; 4 4.012 4.111 psi, 1004 1007 1347; 2x16x16 1920910; 36; 26: 30.40 104.00 103.13 106.15
3: 142.800 s, 2.600 since command, 2.000 in band; 6 6.019 6.122 psi, 1506 1511 2006; 2x16x16 3272921; 34; 25: 27.40 150.00 149.28 152.35
branch 0.0.1 attempt 0: 6 to 2 psi
4: 145.600 s, 2.800 since command, 2.000 in band; 4 4.008 3.894 psi, 1004 1006 1276; 2x16x16 2553378; 36; 26: 30.40 104.00 104.82 101.56
5: 148.200 s, 2.600 since command, 2.000 in band; 2 2.016 1.892 psi, 502 506 620; 2x16x16 1246907; 35; 25: 27.40 50.00 51.00 48.03
branch 0.0.2 attempt 0: 2 to 6 psi
6: 151.000 s, 2.800 since command, 2.000 in band; 4 3.988 4.117 psi, 1004 1001 1349; 2x16x16 2037245; 35; 26: 30.40 104.00 103.15 106.12
7: 153.800 s, 2.800 since command, 2.000 in band; 6 5.956 6.110 psi, 1506 1495 2002; 2x16x16 3278940; 36; 26: 30.40 156.00 155.28 158.39
)");
}

TEST_CASE("whole run: two sequences, several frames a level, ramps without stops, line by line") {
  bench::RunRequest request = small_request();
  request.recipes = {
      recipe_of("unit = \"psi\"\nturning_points = [20, 10]\nstep = 10\nframes_per_level = 2\nframe_interval_s = 1.5\n"
                "[conditioning]\ncycles = 1\npeak = 15\n"),
      recipe_of("unit = \"psi\"\nturning_points = [0, 8, 0]\nstep = 4\nsettle = \"none\"\nramp_psi_per_s = [2.0, 8.0]\n"
                "repeats = 2\n")};
  check_lines(lines_of_run(request), R"(
step 1 of 16, 0 of 14 frames: conditioning 1 of 1; 0.000 s 0 -0.012 -0.018 psi settled
step 2 of 16, 0 of 14 frames: conditioning 1 of 1; 3.850 s 15 15.003 15.131 psi settled
step 3 of 16, 0 of 14 frames: small, step 3 of 16, unloading; 7.700 s 0 0.000 -0.009 psi settled
step 4 of 16, 1 of 14 frames: small, step 4 of 16, unloading; 11.750 s 20 20.030 20.127 psi settled
step 5 of 16, 2 of 14 frames: small, step 5 of 16, unloading; 13.250 s 20 20.030 20.124 psi settled
step 6 of 16, 3 of 14 frames: small, step 6 of 16, unloading; 16.800 s 10 10.027 9.885 psi settled
step 7 of 16, 4 of 14 frames: small, step 7 of 16, repeat 1 of 2, loading; 18.300 s 10 10.043 9.894 psi settled
step 8 of 16, 5 of 14 frames: small, step 8 of 16, repeat 1 of 2, loading; 24.350 s 0 0.012 -0.021 psi
step 9 of 16, 6 of 14 frames: small, step 9 of 16, repeat 1 of 2, loading; 26.350 s 4 3.725 3.873 psi
step 10 of 16, 7 of 14 frames: small, step 10 of 16, repeat 1 of 2, unloading; 28.350 s 8 7.752 7.880 psi
step 11 of 16, 8 of 14 frames: small, step 11 of 16, repeat 1 of 2, unloading; 30.350 s 4 4.275 4.117 psi
step 12 of 16, 9 of 14 frames: small, step 12 of 16, repeat 2 of 2, loading; 32.350 s 0 0.247 0.137 psi
step 13 of 16, 10 of 14 frames: small, step 13 of 16, repeat 2 of 2, loading; 33.000 s 0 -0.004 0.012 psi
step 14 of 16, 11 of 14 frames: small, step 14 of 16, repeat 2 of 2, loading; 33.500 s 4 2.888 3.061 psi
step 15 of 16, 12 of 14 frames: small, step 15 of 16, repeat 2 of 2, unloading; 34.000 s 8 6.924 7.096 psi
step 16 of 16, 13 of 14 frames: small, step 16 of 16, repeat 2 of 2, unloading; 34.500 s 4 5.143 4.990 psi
14 of 14 frames, 154 exchanges, 0 redone, 35.200 s, waiting 0.000 s: moving 50.3 %, conditioning 21.9 %, dwelling 19.9 %, settling 7.4 %, tearing down 0.6 %
0.000 fail-safe: tactbench: every run ends vented, with proof of it; trip above 66 psi
0.000 fail-safe: Beckhoff EK9000 + EL4xxx/EL3xxx: coupler watchdog: outputs to 0 V when no write comes in time (set and read back at the start)
0.000 fail-safe: Beckhoff EK9000 + EL4xxx/EL3xxx: EL4xxx terminal watchdog: 0 V by default, 0x80n0:05, :13, :14 (neither set nor read by tactbench)
0.000 fail-safe: watchdog time 1000 ms, fed every 450 ms
0.000 state: prepared -> running: devices open, chamber unloaded
0.000 seating: left out as asked (--no-seating)
7.700 check conditioning pass {"cycles_at_most":1,"change_limit_percent":0.0}:
35.200 time: moving 50.3 %, conditioning 21.9 %, dwelling 19.9 %, settling 7.4 %, tearing down 0.6 %
35.200 state: running -> stopping: all steps done
35.200 safe verified: vented, verified (feedback 0.1 psi, reference 0.0 psi)
branch 0.0.0 attempt 0: 20 to 10 psi
0: 11.750 s, 4.050 since command, 2.000 in band; 20 20.030 20.127 psi, 5020 5028 6595; 2x16x16 13102145; 43; 45: 284.80 440.00 417.86 420.63
1: 13.250 s, 5.550 since command, 3.500 in band; 20 20.030 20.124 psi, 5020 5028 6594; 2x16x16 13157519; 11; 5: 3.10 100.00 99.98 100.56
2: 16.800 s, 3.550 since command, 2.000 in band; 10 10.027 9.885 psi, 2510 2517 3239; 2x16x16 10015258; 28; 11: 21.70 130.00 139.23 137.94
3: 18.300 s, 5.050 since command, 3.500 in band; 10 10.043 9.894 psi, 2510 2521 3242; 2x16x16 9994624; 11; 5: 3.10 50.00 50.04 49.40
branch 1.0.0 attempt 0: 0 to 8 psi
0: 24.350 s, 6.050 since command, 0.000 in band; 0 0.012 -0.021 psi, 0 3 -7; 2x16x16 133968; 154; 51: 174.15 245.00 257.64 251.14
1: 26.350 s, 2.000 since command, 2.000 in band; 4 3.725 3.873 psi, 1004 935 1269; 2x16x16 1650838; 62; 20: 19.00 42.00 36.99 38.69
2: 28.350 s, 2.000 since command, 2.000 in band; 8 7.752 7.880 psi, 2008 1946 2582; 2x16x16 4319588; 62; 20: 19.00 122.00 116.85 119.46
branch 1.0.1 attempt 0: 8 to 0 psi
3: 30.350 s, 2.000 since command, 2.000 in band; 4 4.275 4.117 psi, 1004 1073 1349; 2x16x16 3110350; 62; 20: 19.00 118.00 123.04 121.48
4: 32.350 s, 2.000 since command, 2.000 in band; 0 0.247 0.137 psi, 0 62 45; 2x16x16 144958; 62; 20: 19.00 38.00 43.18 40.58
branch 1.1.0 attempt 0: 0 to 8 psi
0: 33.000 s, 0.650 since command, 0.000 in band; 0 -0.004 0.012 psi, 0 -1 4; 2x16x16 134009; 7; 2: 0.20 0.00 0.01 0.02
1: 33.500 s, 0.500 since command, 0.500 in band; 4 2.888 3.061 psi, 1004 725 1003; 2x16x16 1212670; 17; 5: 1.00 12.00 7.23 7.56
2: 34.000 s, 0.500 since command, 0.500 in band; 8 6.924 7.096 psi, 2008 1738 2325; 2x16x16 3628082; 17; 5: 1.00 32.00 26.71 27.47
branch 1.1.1 attempt 0: 8 to 0 psi
3: 34.500 s, 0.500 since command, 0.500 in band; 4 5.143 4.990 psi, 1004 1291 1635; 2x16x16 3292382; 17; 5: 1.00 28.00 32.43 32.34
4: 35.000 s, 0.500 since command, 0.500 in band; 0 1.056 0.903 psi, 0 265 296; 2x16x16 612187; 17; 5: 1.00 8.00 13.23 12.55
)");
}

TEST_CASE("whole run: a chamber that does not reach its level ends it, line by line") {
  bench::RunRequest request = small_request({{"simulation.chamber.leak_psi_per_s", "40"}, {"settling.timeout_s", "3"}});
  request.recipes = {recipe_of("unit = \"psi\"\nturning_points = [0, 4]\nstep = 4\n")};
  check_lines(lines_of_run(request), R"(
step 1 of 2, 0 of 2 frames: small, step 1 of 2, loading; 0.000 s 0 -0.012 -0.018 psi settled
step 2 of 2, 1 of 2 frames: small, step 2 of 2, loading; 2.650 s 0 -0.004 -0.003 psi settled
1 of 1 frames, 16 exchanges, 0 redone, 6.300 s, waiting 0.000 s: settling 58.7 %, dwelling 31.7 %, moving 9.5 %
3 TB-CHAMBER-TIMEOUT: chamber did not reach 4.0 psi (27.6 kPa) within 3 s; last reading 0.01 psi by the regulator, 0.00 psi by the reference, moving 0.03 psi/s | run 1, after frame 1, chamber | check the compressor supply and for leaks; raise [settling] timeout_s or band_psi | vented, verified (feedback 0.0 psi, reference 0.0 psi); run 1 kept with 1 frame
0.000 fail-safe: tactbench: every run ends vented, with proof of it; trip above 66 psi
0.000 fail-safe: Beckhoff EK9000 + EL4xxx/EL3xxx: coupler watchdog: outputs to 0 V when no write comes in time (set and read back at the start)
0.000 fail-safe: Beckhoff EK9000 + EL4xxx/EL3xxx: EL4xxx terminal watchdog: 0 V by default, 0x80n0:05, :13, :14 (neither set nor read by tactbench)
0.000 fail-safe: watchdog time 1000 ms, fed every 450 ms
0.000 state: prepared -> running: devices open, chamber unloaded
0.000 seating: left out as asked (--no-seating)
6.300 fault TB-CHAMBER-TIMEOUT: chamber did not reach 4.0 psi (27.6 kPa) within 3 s; last reading 0.01 psi by the regulator, 0.00 psi by the reference, moving 0.03 psi/s
6.300 time: settling 58.7 %, dwelling 31.7 %, moving 9.5 %
6.300 state: running -> stopping: TB-CHAMBER-TIMEOUT: chamber did not reach 4.0 psi (27.6 kPa) within 3 s; last reading 0.01 psi by the regulator, 0.00 psi by the reference, moving 0.03 psi/s
6.300 safe verified: vented, verified (feedback 0.0 psi, reference 0.0 psi)
branch 0.0.0 attempt 0: 0 to 4 psi
0: 2.650 s, 2.650 since command, 2.000 in band; 0 -0.004 -0.003 psi, 0 -1 -1; 2x16x16 134130; 16; 8: 11.15 0.00 -0.05 -0.05
)");
}
