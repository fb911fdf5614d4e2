#!/usr/bin/env python3
"""Models in a device's integers: what they cost and what they err, one row a model.

    tests/benchmarks/fixed.py BUILD [--seed HEX] [--specimens paper,harsh,foam] [--every 8]

Of each specimen one sensor, its histories and all noise are drawn from the seed, by default the hash of the last commit to code, so that
nothing can have been chosen on it. Models: `elam` and `dynamic` of recipe production, and `dynamic` of three runs (descending and ascending;
rate; creep-levels). They are judged on a run of random reversals, made a dense noisy stream (`study fixed`); instructions and bytes are those
of the Cortex boards that QEMU emulates, cells those of Yosys; what is not installed is "-". Figures that need more are computed from
constants below. Costs are those of the first specimen: they hardly differ.
"""
import argparse
import hashlib
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
for room in ("device", "verilog"):
    sys.path.insert(0, str(ROOT / "tests/analysis/export" / room))
import device  # noqa: E402
import verilog  # noqa: E402

RATES = (50, 76, 100)
CYCLES = 1.4                                                # of an instruction (assumed)
CLOCKS = {"cortex-m4": 168e6, "cortex-m0plus": 133e6}       # STM32F4, RP2040
LARGEST_RATIO, LARGEST_MEDIAN = 1.02, 0.04                  # integers to doubles; % of the range
ERRORS = "| specimen, model | frames/s | doubles, psi | integers, psi | ratio | apart: median, % of the range | 99 % | above 0.3 % |\n" + 8 * "|---" + "|"
COSTS = ("| model | Cortex-M4: instructions a taxel, stream · worst frame | Cortex-M0+ | code and tables, `-Os` · `-O2` | state "
         "| frames/s, M4 at 168 MHz: stream · worst | RP2040 at 133 MHz | iCE40UP5K: cells |\n" + 8 * "|---" + "|")


def drawn(seed, *what):
    return int.from_bytes(hashlib.sha256(f"{seed} {what}".encode()).digest()[:4], "big") % 1_000_000


class Sensor(device.Bench):
    """One of a specimen, and what was fitted to it."""

    def __init__(self, program, folder, specimen, seed):
        super().__init__(program, folder)
        self.tactbench("sensors", "add", "S", "--type", "sensor.toml")
        for i, recipes in enumerate((["production"], ["random-reversal"], ["descending", "ascending"], ["rate"], ["creep-levels"])):
            own = ["--set", f"recipe.seed={drawn(seed, specimen, 'history')}"] if "random-reversal" in recipes else []
            self.tactbench("run", *recipes, "--bench", "bench.toml", "--sensor", "S", "--operator", "study", "-q", "--sensor-seed",
                           drawn(seed, specimen), "--seed", drawn(seed, specimen, i), "--set", f'simulation.specimen="{specimen}"', *own)
        self.runs[specimen], per_count = 1, self.per_count(1)
        for name, kind, fit in (("dynamic of production", "dynamic", ["1"]), ("dynamic of three runs", "dynamic", ["3", "--rate", "4", "--creep", "5"]),
                                ("elam", "elam", ["1"])):
            document, exported = f"{name}.json", name.replace(" ", "_")
            self.tactbench("fit", *fit, "--model", kind, "-q", "-o", document)
            self.tactbench("model", "export", document, "--format", "c", "-o", exported, "--frame-rate", RATES[1], "--per-count", per_count)
            self.models.append((specimen, name, document, exported, per_count))


def errors(sensor, study, seed, every):
    for specimen, name, document, _, _ in sensor.models:
        found = []
        for rate in RATES:
            row = device.run([study, "fixed", "--model", sensor.folder / document, "--store", sensor.folder / "runs.db", "--run", "2",
                              "--rate", rate, "--every", every, "--seed", seed])
            found.append([float(value) for value in row.split("|")[2:-1]])
        doubles, integers, ratio, median, _, most, _, above = ([f"{one:.{places}f}" for one in own] for own, places in
                                                               zip(zip(*found), (3, 3, 3, 3, 2, 2, 2, 1)))
        print(f"| {specimen}, {name} | {' · '.join(map(str, RATES))} | {' · '.join(doubles)} | {' · '.join(integers)} | {' · '.join(ratio)} | "
              f"{' · '.join(median)} | {' · '.join(most)} | {' · '.join(above)} % |", flush=True)
        yield all(one[2] <= LARGEST_RATIO and one[3] <= LARGEST_MEDIAN for one in found)


def cells_of(circuit):
    device.run(["yosys", "-q", "-p", verilog.SYNTHESIS], cwd=circuit)
    packed = subprocess.run(["nextpnr-ice40", "--up5k", "--package", "sg48", "--json", "pins.json", "--pack-only"], cwd=circuit,
                            capture_output=True, text=True)
    return re.search(r"ICESTORM_LC: +(\d+)", packed.stderr)[1]


def costs(sensor, work):
    emulated = all(map(shutil.which, ("arm-none-eabi-gcc", "qemu-system-arm")))
    for specimen, name, document, exported, per_count in sensor.models:
        instructions, bytes_, state, frames, cells = ["-", "-"], "-", "-", ["-", "-"], "-"
        if emulated:
            streams, taxels = device.streams_of(sensor, specimen)
            found = [device.costs_of(sensor.folder / exported, streams, taxels, cpu, work) for cpu in device.BOARDS]
            instructions = [f"{own[0]} · {own[1]}" for own in found]
            bytes_ = f"{found[0][2] / 1000:.1f} · {found[0][4] / 1000:.1f} kB"
            state = f"{found[0][3] / 1000:.1f} kB"
            frames = [" · ".join(f"{CLOCKS[cpu] / CYCLES / taxels / one:.0f}" for one in own[:2]) for cpu, own in zip(device.BOARDS, found)]
        if name == "elam" and shutil.which("yosys") and shutil.which("nextpnr-ice40"):
            sensor.tactbench("model", "export", document, "--format", "verilog", "-o", "circuit", "--per-count", per_count)
            cells = cells_of(sensor.folder / "circuit")
        print(f"| {name} | {instructions[0]} | {instructions[1]} | {bytes_} | {state} | {frames[0]} | {frames[1]} | {cells} |", flush=True)


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("build", type=pathlib.Path)
    arguments.add_argument("--seed", help="hexadecimal, up to 16 digits")
    arguments.add_argument("--specimens", default="paper,harsh,foam")
    arguments.add_argument("--every", type=int, default=8, help="taxels whose errors are taken")
    options = arguments.parse_args()
    seed = options.seed or device.run(["git", "log", "-1", "--format=%H", "--", "*.cpp", "*.h"], cwd=ROOT)[:16]
    print(f"seed {seed}\n\n{ERRORS}")
    within = []
    with tempfile.TemporaryDirectory() as folder:
        sensors = []
        for specimen in options.specimens.split(","):
            (pathlib.Path(folder) / specimen).mkdir()
            sensors.append(Sensor(options.build / "tactbench", pathlib.Path(folder) / specimen, specimen, seed))
            within += errors(sensors[-1], options.build / "tests/benchmarks/study", seed, options.every)
        print(f"\n{sum(within)} of {len(within)} models within a ratio of {LARGEST_RATIO} and a median of {LARGEST_MEDIAN} %\n\n{COSTS}", flush=True)
        costs(sensors[0], pathlib.Path(folder))


if __name__ == "__main__":
    main()
