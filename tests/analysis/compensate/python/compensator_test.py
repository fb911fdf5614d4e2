"""compensator_test.py VALUES-PROGRAM LIBRARY: the binding gives what the C++ side gives, bit for bit."""

import math
import subprocess
import sys

import tactbench_compensator as tc


def check(holds, what):
    if not holds:
        sys.exit("failed: " + what)


def refused(act, word):
    try:
        act()
    except tc.CompensatorError as error:
        check(word in str(error), f"'{error}' does not say '{word}'")
        return
    sys.exit("failed: not refused, " + word)


program, library = sys.argv[1:]
rows = [line.split() for line in subprocess.run([program], capture_output=True, text=True, check=True).stdout.splitlines()]
rows = [(row[0], [float(value) for value in row[1:]]) for row in rows]
setup = dict(rows[:2])
of = lambda name: [values for key, values in rows if key == name]
taxels = [tc.Taxel(up, down, parameters[:5], parameters[5], usable=usable[0] == 1, residual=residual)
          for usable, up, down, parameters, residual in zip(of("usable"), of("ascending"), of("descending"), of("parameters"),
                                                            of("residual"))]


def make(**options):
    return tc.Compensator(setup["pressure"], taxels, setup["volts_per_count"][0], library=library, **options)


with make(at_rest=True, double=True) as whole, make(at_rest=True) as single:
    for counts, pressure, doubt, low, status in zip(of("counts"), of("whole"), of("uncertainty"), of("single"),
                                                    of("status")):
        counts = [int(count) for count in counts]
        frame = whole.counts(counts)
        check(list(frame.pressure) == pressure and list(frame.uncertainty) == doubt, "double results")
        frame = single.counts(counts)
        check(list(frame.pressure) == low and list(frame.status) == status, "float results")
    check(len(of("counts")) == 300, "300 frames")
    check(single.volts([math.nan] * len(taxels)).status[0] == tc.LOST, "NaN is lost")
    check(single.counts(counts).status[3] == tc.DEAD, "dead taxel")
    single.set_outside_validity(True)
    check(single.counts(counts).status[0] & (tc.OUTSIDE | tc.VALID) == tc.OUTSIDE, "outside validity")
    check(single.tare([65535] * len(taxels)) == len(taxels) - 1, "a tare too far off")
    single.reset()
    single.lost_frame()
    refused(lambda: single.counts([1, 2, 3]), "3 samples for 20 taxels")
refused(lambda: single.counts(counts), "closed")
single.close()
with make() as unknown:
    check(unknown.counts([30000] * len(taxels)).status[0] & tc.UNKNOWN, "unknown start")
taxels[5].residual[7] = -0.1
refused(make, "taxel 5")
taxels[5].residual[7] = 0.1
taxels[6].residual.pop()
refused(make, "11 values, not 12")
taxels[6].residual = []
make().close()
taxels[5].parameters = (0.5, 7.0, 0.0, 0.5, 0.5)
refused(make, "taxel 5")
taxels[5].ascending = [0.0, 1.0]
refused(make, "2 values")
dynamic = [tc.DynamicTaxel(table, *numbers, usable=usable[0] == 1)
           for usable, table, numbers in zip(of("dynamic_usable"), of("everett"), of("dynamic"))]
half, lag = of("half_and_lag")[0]


def make_dynamic(**options):
    return tc.DynamicCompensator(20, dynamic, setup["volts_per_count"][0], 0.0, 60.0, at_rest=True, library=library,
                                 creep=list(zip(of("creep_s")[0], of("creep_share")[0])), creep_half=half,
                                 lag_seconds=lag, **options)


with make_dynamic() as single:
    single.set_interval(0.4)
    for counts, pressure in zip(of("dynamic_counts"), of("dynamic_single")):
        frame = single.counts([int(count) for count in counts])
        check(list(frame.pressure) == pressure, "dynamic results")
    check(len(of("dynamic_counts")) == 200 and frame.status[2] == tc.DEAD, "200 frames, a dead taxel")
    single.lost_frame()
    refused(lambda: single.set_interval(-1.0), "code -3")
# A film that was worked just before has crept already: the same output tells less pressure.
loaded = [int(count) for count in of("dynamic_counts")[-1]]
with make_dynamic() as rested, make_dynamic(worked_seconds=600.0) as worked:
    for compensator in (rested, worked):
        compensator.set_interval(0.4)
    pairs = list(zip(rested.counts(loaded).pressure, worked.counts(loaded).pressure))
    check(all(b <= a for a, b in pairs) and any(b < a for a, b in pairs), "conditioning")
refused(lambda: make_dynamic(worked_seconds=-1.0), "worked_s")
dynamic[4].everett[3] = -5.0
refused(make_dynamic, "taxel 4")
dynamic[4].everett.pop()
refused(make_dynamic, "230 values")
print("as the C++ side,", "with numpy" if tc.numpy else "without numpy")
