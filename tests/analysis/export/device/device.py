#!/usr/bin/env python3
"""Models exported for a microcontroller, compiled for host, Cortex-M0+ and M4, and run under qemu: bits, faults, cost.

    device.py PROGRAM vectors    the exported vectors on all compilers; dense noisy streams and reversals against --as fixed
    device.py PROGRAM faults     faults planted in the header are seen by the vectors, a changed word by the hash
    device.py PROGRAM cost       instructions a taxel, code and memory, within their limits

SAMPLES in the environment: readings of the dense stream a model, 60 000 by default.
"""
import array
import csv
import os
import pathlib
import random
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
RATE = 76
SPECIMENS = ("paper", "harsh")
SAMPLES = int(os.environ.get("SAMPLES", "60000"))
HOST = [["cc", "-std=c99", "-O2"], ["c++", "-std=c++11", "-O2"],
        ["clang-16", "-std=c99", "-O1", "-fsanitize=undefined,address", "-fno-sanitize-recover=all"]]
BOARDS = {"cortex-m4": "mps2-an386", "cortex-m0plus": "mps2-an385"}  # an M0+'s code on an M3
# Instructions a taxel: of the dense stream, of the worst frame of a stored run; bytes of code and tables at -Os, of state.
LIMITS = {("elam", "cortex-m4"): (260, 650, 45000, 24000), ("elam", "cortex-m0plus"): (700, 1600, 45000, 24000),
          ("dynamic", "cortex-m4"): (280, 680, 120000, 30000), ("dynamic", "cortex-m0plus"): (700, 1600, 120000, 30000)}
# Each changes one step of the arithmetic: rounding, clamp, turn, stack, packing.
FAULTS = {"rounding": ("tb_fixed.h", r"\(\(\(\(uint32_t\)a & 0xFFFFU\) \* b\) >> 16\)", "((((uint32_t)a & 0xFFFFU) * b + 0x8000U) >> 16)"),
          "clamp": ("tb_fixed.h", r"int32_t step = TB_STEP_CEILING;", "int32_t step = 2 * TB_STEP_CEILING;"),
          "turn": ("tb_fixed.h", r"behind > tb_band\[fewer\]", "behind >= 2 * tb_band[fewer]"),
          "stack": ("tb_{}.h", r"below -= 2;", "below -= 1;"),
          "packing": ("tb_fixed.h", r"\(high & 0x8000U \? 0x10000 : 0\)\) \* 0x10000 \+ \(int32_t\)low",
                      "(high & 0x8000U ? 0x10000 : 0)) * 0x10000 + (int32_t)(low & 0xFF00U)")}


def run(command, **options):
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}\nended with {done.returncode}: {done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


class Bench:
    """Runs, models and exported folders, in a folder of its own."""

    def __init__(self, program, folder):
        self.program, self.folder = os.path.abspath(program), pathlib.Path(folder)
        self.tactbench("init")
        self.models, self.runs = [], {}

    def tactbench(self, *words):
        return run([self.program, *words], cwd=self.folder)

    def measure(self, specimen):
        serial = f"S-{specimen}"
        self.tactbench("sensors", "add", serial, "--type", "sensor.toml")
        for recipe in ("production", "random-reversal"):
            self.tactbench("run", recipe, "--bench", "bench.toml", "--sensor", serial, "--operator", "ci", "-q",
                           "--set", f'simulation.specimen="{specimen}"', "--sensor-seed", "42")
        first = 1 + 2 * len(self.runs)
        self.runs[specimen] = first
        for kind in ("dynamic", "elam"):
            document = f"{specimen}-{kind}.json"
            self.tactbench("fit", first, "--model", kind, "-q", "-o", document)
            name = f"{specimen}_{kind}"
            per_count = self.per_count(first)
            self.tactbench("model", "export", document, "--format", "c", "-o", name, "--frame-rate", RATE, "--per-count", per_count)
            self.models.append((specimen, kind, document, name, per_count))

    def per_count(self, number):
        self.tactbench("runs", "export", number, "-o", "head.csv", "-q", "--replace")
        return next(line.split(": ")[1] for line in (self.folder / "head.csv").read_text().splitlines() if "volts_per_count" in line)

    def frames_of(self, specimen):
        """Of the run of random reversals: times and mean counts."""
        self.tactbench("runs", "export", self.runs[specimen] + 1, "-o", "frames.csv", "-q", "--replace")
        lines = [line for line in (self.folder / "frames.csv").read_text().splitlines() if not line.startswith("#")]
        head = lines[0].split(",")
        columns = [i for i, name in enumerate(head) if name.startswith("counts_")]
        scans = {}
        for row in csv.reader(lines[1:]):
            scans.setdefault(float(row[head.index("time_s")]), []).append([int(row[i]) for i in columns])
        times = sorted(scans)
        return times, [[sum(own) / len(own) for own in zip(*scans[time])] for time in times]


def dense(times, frames, count, seed):
    """Between the stored frames, RATE a second, with a scan's noise."""
    noise, j = random.Random(seed), 0
    for i in range(count):
        now = times[0] + i / RATE % (times[-1] - times[0])
        if now < times[j]:
            j = 0
        while now > times[j + 1]:
            j += 1
        share = (now - times[j]) / (times[j + 1] - times[j])
        yield [a + share * (b - a) + noise.gauss(0, 20) for a, b in zip(frames[j], frames[j + 1])]


def at_random(taxels, count, seed):
    numbers = random.Random(seed)
    return ([numbers.randrange(65536) for _ in range(taxels)] for _ in range(count))


def words(frames):
    made = array.array("H")
    for frame in frames:
        made.extend(max(0, min(65535, round(value))) for value in frame)
    return made


def on_host(compiler, folder, source, work):
    """Compiles a program, which takes input and gives what it says."""
    program = work / "host"
    run([*compiler, "-Wall", "-Wextra", "-Werror", "-I", folder, "-x", "c++" if compiler[0] == "c++" else "c", source, "-o", program])
    return lambda data: said_by([program], work, input=data)


def on_board(cpu, options, folder, source, work):
    program = work / f"{cpu}.elf"
    run(["arm-none-eabi-gcc", f"-mcpu={cpu}", "-mthumb", "-std=c99", *options, "-nostartfiles", "--specs=rdimon.specs", "-T",
         HERE / "board.ld", "-I", folder, "-x", "c", source, HERE / "board.c", "-o", program])
    command = ["qemu-system-arm", "-M", BOARDS[cpu], "-display", "none", "-monitor", "none", "-serial", "none",
               "-semihosting-config", "enable=on,target=native", "-kernel", program, "-icount", "shift=0"]

    def emulated(data):
        (work / "input").write_bytes(data)
        return said_by(command if "-DCOST" in options else command[:-2], work)
    return emulated


def said_by(command, work, **options):
    done = subprocess.run(command, cwd=work, capture_output=True, timeout=300, **options)
    return done.stdout.decode() + done.stderr.decode()


def none_differ(said):
    return re.search(r"^[1-9]\d* readings, 0 differ$", said, re.M) is not None


def streams_of(bench, specimen):
    times, frames = bench.frames_of(specimen)
    taxels = len(frames[0])
    return {"stored reversals": words([frames[0], *frames]),
            "a dense noisy stream": words([frames[0], *dense(times, frames, SAMPLES // taxels, 1)]),
            "counts at random": words([frames[0], *at_random(taxels, 60, 2)])}, taxels


def recomputed(bench, document, per_count, data, taxels):
    """The counts of pressure that --as fixed makes of a log, after its first frame."""
    with open(bench.folder / "log.csv", "w", encoding="utf-8") as log:
        log.write(",".join(f"taxel{i}" for i in range(taxels)) + "\n")
        for i in range(0, len(data), taxels):
            log.write(",".join(map(str, data[i:i + taxels])) + "\n")
    bench.tactbench("compensate", document, "log.csv", "--map", f"output=1-{taxels}", "--as", "fixed", "--counts", "--tared",
                    "--frame-rate", RATE, "--per-count", per_count, "-o", "recomputed.csv", "--replace")
    with open(bench.folder / "recomputed.csv", encoding="utf-8") as file:
        table = list(csv.reader(file))
    places = [i for i, column in enumerate(table[0]) if column.startswith("pressure_count")]
    return [row[i] for row in table[2:] for i in places]


def vectors(bench, work):
    for specimen in SPECIMENS:
        bench.measure(specimen)
    for specimen, kind, document, name, per_count in bench.models:
        folder = bench.folder / name
        example, rows = folder / f"{name}.ino", (folder / "vectors.csv").read_bytes().splitlines(keepends=True)
        for compiler in HOST:
            said = on_host(compiler, folder, example, work)(b"".join(rows))
            if not none_differ(said):
                sys.exit(f"{name}, {' '.join(compiler)}: {said}")
        run(["c++", "-std=c++11", "-Wall", "-Wextra", "-Werror", "-DARDUINO=10819", "-include", HERE / "arduino.h", "-I", folder,
             "-fsyntax-only", "-x", "c++", example])  # as a sketch
        for cpu in BOARDS:
            for option in ("-O0", "-Os"):
                said = on_board(cpu, [option], folder, example, work)(b"".join(rows[:44]))
                if not none_differ(said):
                    sys.exit(f"{name}, {cpu} {option}: {said}")
        streams, taxels = streams_of(bench, specimen)
        host = on_host([*HOST[0], "-DALL"], folder, HERE / "readings.c", work)
        boards = {cpu: on_board(cpu, ["-Os"], folder, HERE / "readings.c", work) for cpu in BOARDS}
        for what, data in streams.items():
            *seen, last = host(data.tobytes()).splitlines()
            again = recomputed(bench, document, per_count, data, taxels)
            if not seen or seen != again:
                sys.exit(f"{name}, {what}: {sum(a != b for a, b in zip(seen, again))} of {len(seen)} readings differ")
            for cpu, board in boards.items():
                said = board(data.tobytes())
                if said.strip() != last:
                    sys.exit(f"{name}, {what}, {cpu}: {said}, and the host {last}")
            print(f"{name}, {what}: {len(seen)} readings, the same by host, boards and --as fixed")


def faults(bench, work):
    bench.measure(SPECIMENS[0])
    for specimen, kind, document, name, per_count in bench.models:
        folder, broken = bench.folder / name, work / "broken"
        rows = (folder / "vectors.csv").read_bytes()
        for fault, (file, pattern, by) in FAULTS.items():
            shutil.copytree(folder, broken, dirs_exist_ok=True)
            header = broken / file.format(kind)
            text, places = re.subn(pattern, by, header.read_text(), flags=re.S)
            if places == 0:
                sys.exit(f"{fault}: {header.name} has no such place")
            header.write_text(text)
            said = on_host(["cc", "-std=c99", "-O2", "-Wno-error"], broken, broken / f"{name}.ino", work)(rows)
            if not re.search(r"^\d+ readings, [1-9]\d* differ$", said, re.M):
                sys.exit(f"{name}: the fault in {fault} is not seen: {said}")
            print(f"{name}, {fault}: {said.strip()}")
        shutil.copytree(folder, broken, dirs_exist_ok=True)
        header = broken / "tb_model.h"
        table = header.read_text()
        place = table.index(",", table.index("tb_table[]") + len(table) // 2) + 1
        digits = re.compile(r"\s*(\d+)").match(table, place)
        header.write_text(table[:digits.start(1)] + str(int(digits[1]) ^ 1) + table[digits.end(1):])
        said = on_host(HOST[0], broken, broken / f"{name}.ino", work)(rows)
        if "readings" in said:
            sys.exit(f"{name}: a changed word is not seen: {said}")
        print(f"{name}, a word of the table: {said.strip()}")


def costs_of(folder, streams, taxels, cpu, work):
    """Instructions a taxel: of a stream, of the worst frame; bytes of code and tables at -Os, of state, of the former at -O2."""
    board = on_board(cpu, ["-O2", "-DCOST"], folder, HERE / "readings.c", work)
    found = [int(board(streams[what].tobytes()).split()[place])
             for what, place in (("a dense noisy stream", 0), ("stored reversals", 1))]
    sizes = {}
    for option in ("-Os", "-O2"):
        run(["arm-none-eabi-gcc", f"-mcpu={cpu}", "-mthumb", "-std=c99", option, "-I", folder, "-c", HERE / "readings.c", "-o",
             work / "size.o"])
        sizes[option], _, bss = map(int, run(["arm-none-eabi-size", work / "size.o"]).splitlines()[1].split()[:3])
    return [*found, sizes["-Os"], bss - 6 * taxels, sizes["-O2"]]


def cost(bench, work):
    bench.measure(SPECIMENS[0])
    over = []
    for specimen, kind, document, name, per_count in bench.models:
        streams, taxels = streams_of(bench, specimen)
        for cpu in BOARDS:
            found = costs_of(bench.folder / name, streams, taxels, cpu, work)
            print(f"{name}, {cpu}: {found[0]} instructions a taxel of a stream, {found[1]} of the worst frame; {found[2]} bytes of code "
                  f"and tables, {found[4]} at -O2, {found[3]} of state")
            over += [f"{name}, {cpu}: {own} above {most}" for own, most in zip(found, LIMITS[kind, cpu]) if own > most]
    if over:
        sys.exit("\n".join(over))


def main():
    program, what = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as work:
        {"vectors": vectors, "faults": faults, "cost": cost}[what](Bench(program, folder), pathlib.Path(work))


if __name__ == "__main__":
    main()
