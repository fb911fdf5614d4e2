"""compensator_test.py VALUES-PROGRAM LIBRARY: the binding gives what the C++ side gives, bit for bit."""

import math
import os
import subprocess
import sys
import tempfile

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
with tempfile.TemporaryDirectory() as folder:
    rows = [line.split() for line in subprocess.run([program, folder], capture_output=True, text=True, check=True).stdout.splitlines()]
    documents = {}
    for name in ("elam", "in_time"):
        with open(os.path.join(folder, name + ".json"), "rb") as file:
            documents[name] = file.read()


def make(name, **options):
    return tc.Compensator(documents[name], library=library, **options)


for name in documents:
    of_model = [[float(value) for value in row[1:]] for row in rows if row[0] == name]
    check(len(of_model) == 200, "200 frames")
    with make(name, at_rest=True, worked_seconds=30.0) as stream:
        for values in of_model:
            frame = stream.volts(values[:3], 0.4)
            check(list(frame.pressure) == values[3:6] and list(frame.uncertainty) == values[6:9], "values of " + name)
            check(list(frame.status) == values[9:], "bits of " + name)
        check(stream.volts([math.nan] * 3, 0.4).status[0] & tc.LOST, "what is no number is lost")
        stream.set_outside_validity(True)
        check(stream.volts(values[:3], 0.4).status[0] & (tc.OUTSIDE | tc.VALID) == tc.OUTSIDE, "outside validity")
        check(frame.status[1] == tc.DEAD, "a dead taxel")
        check(stream.tare([50.0] * 3) == 2, "a tare too far off")
        stream.start()
        stream.volts(values[:3])  # the first
        if name == "in_time":
            refused(lambda: stream.volts(values[:3]), "seconds")
            refused(stream.lost_frame, "seconds")
        else:
            stream.volts(values[:3])
            stream.lost_frame()
        refused(lambda: stream.volts(values[:3], -1.0), "-3")
        refused(lambda: stream.volts([1.0, 2.0]), "2 samples")
    refused(lambda: stream.volts(values[:3], 0.4), "closed")
    stream.close()
    check(make(name).volts(of_model[20][:3]).status[0] & tc.UNKNOWN, "unknown start")
# A film that was worked just before has crept already: the same output tells less pressure.
loaded = of_model[20][:3]
pairs = list(zip(make("in_time", at_rest=True).volts(loaded).pressure,
                 make("in_time", at_rest=True, worked_seconds=600.0).volts(loaded).pressure))
check(all(b <= a for a, b in pairs) and any(b < a for a, b in pairs), "conditioning")
refused(lambda: make("in_time", worked_seconds=-1.0), "-3")
documents["elam"] = documents["elam"].replace(b'"alpha_d"', b'"alpha_x"')
refused(lambda: make("elam"), "alpha_d")
print("as the C++ side,", "with numpy" if tc.numpy else "without numpy")
