#!/usr/bin/env python3
"""ELAM exported as Verilog: simulated against the C header, faults, synthesis.

    verilog.py PROGRAM vectors      vectors.csv by Icarus (some) and Verilator; reversals, a dense noisy stream and counts at random, for
                                    rising and falling outputs and both rules of the outer branch; no word of lint
    verilog.py PROGRAM faults       planted faults are seen by the vectors, a changed word by the loader's hash
    verilog.py PROGRAM synthesis    cells and memories on an iCE40UP5K, a tenth left over
    verilog.py PROGRAM place        clock and frames/s there, median of five placements: by command

SAMPLES in the environment: readings of the dense stream a model, 100 000 by default. SEEDS: of `place`.
"""
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "device"))
import device  # noqa: E402  the same runs, models and streams

HERE = pathlib.Path(__file__).resolve().parent
SOURCES = ["tb_elam.v", "tb_memory.v"]
CELLS, TAXELS = 5280, 256
SYNTHESIS = ("read_verilog tb_pins.v {}; hierarchy -top tb_pins; proc; flatten; opt_expr -mux_undef; opt -full; "
             "synth_ice40 -top tb_pins -dsp -abc2 -spram -device u -json pins.json").format(" ".join(SOURCES))
FAULTS = {"rounding": (r"whole_high \+ \{11'd0, whole\[31:16\]\}", "whole_high + {11'd0, whole[31:16]} + {26'd0, whole[15]}"),
          "clamp": (r" u <= mean\[25\] \? 16'd0 : m\[19:4\];", " u <= m[19:4];"),
          "turn": (r"\{BAND, fewer\}", "{HOLD, fewer}"),
          "stack": (r"left <= left - 4'd2;", "left <= left - 4'd1;"),
          "packing": (r"top\[15:0\] <= word_;", "top[15:0] <= {word_[7:0], word_[15:8]};")}


def needs(*tools):
    missing = [tool for tool in tools if shutil.which(tool) is None]
    if missing:
        print(f"skipped: {', '.join(missing)} not installed")
        sys.exit(77)


def icarus(folder, *options):
    device.run(["iverilog", "-g2005", "-o", "bench.vvp", "tb_bench.v", *SOURCES], cwd=folder)
    return device.run(["vvp", "bench.vvp", *options], cwd=folder)


def verilated(folder):
    device.run(["verilator", "--binary", "--timing", "-O3", "-Wno-fatal", "--top-module", "tb_bench", "tb_bench.v", *SOURCES], cwd=folder)
    return lambda *options: device.run(["obj_dir/Vtb_bench", *options], cwd=folder)


def hold(name, said):
    if "\nPASSED" not in said or re.search(r"^[1-9]\d* readings, 0 differ;", said, re.M) is None:
        sys.exit(f"{name}: {said}")
    print(f"{name}: {said.splitlines()[0]}")


def measured(program, specimens, folder):
    """ELAM of each specimen, as C and as Verilog: specimen, folders."""
    bench = device.Bench(program, folder)
    for specimen in specimens:
        bench.measure(specimen)
    for specimen, kind, document, name, per_count in bench.models:
        if kind == "elam":
            bench.tactbench("model", "export", document, "--format", "verilog", "-o", f"{name}_v", "--per-count", per_count)
            yield bench, specimen, bench.folder / name, bench.folder / f"{name}_v"


def rows(source, data, taxels, flip, work):
    """Rows of vectors.csv that the C header makes of frames of counts, the first of them a tare."""
    program = work / "rows"
    device.run(["cc", "-std=c99", "-O2", "-I", source, HERE / "rows.c", "-o", program])
    done = subprocess.run([program], input=bytes(b ^ flip for b in data.tobytes()), capture_output=True, check=True)
    assert done.stdout.count(b"\n") == len(data) // taxels
    return done.stdout


def varied(c_folder, v_folder, flip, outer, work):
    """The model with another direction of output and rule of the outer branch: neither changes a word."""
    c, v = work / f"c{flip}{outer}", work / f"v{flip}{outer}"
    shutil.copytree(c_folder, c, dirs_exist_ok=True)
    shutil.copytree(v_folder, v, dirs_exist_ok=True)
    for file, pattern, by in ((c / "tb_model.h", r"(tb_model = \{\w+, \d+, \d+), \d+, (\d+), (\d+), \d+,", rf"\1, {flip}, \2, \3, {outer},"),
                              (v / "tb_model.vh", r"TB_FLIP \d+", f"TB_FLIP {flip}"),
                              (v / "tb_model.vh", r"TB_EXACT_OUTER \d+", f"TB_EXACT_OUTER {outer}")):
        text, places = re.subn(pattern, by, file.read_text())
        assert places == 1, file
        file.write_text(text)
    return c, v


def vectors(program, folder, work):
    needs("iverilog", "verilator")
    for bench, specimen, c_folder, v_folder in measured(program, device.SPECIMENS, folder):
        said = subprocess.run(["verilator", "--lint-only", "-Wall", "-Wno-DECLFILENAME", "--top-module", "tb_pins", "tb_pins.v", *SOURCES],
                              cwd=v_folder, capture_output=True, text=True)
        if said.returncode != 0 or said.stderr:
            sys.exit(f"lint: {said.stderr}")
        if (v_folder / "vectors.csv").read_bytes() != (c_folder / "vectors.csv").read_bytes():
            sys.exit(f"{specimen}: other vectors than of the C export")
        hold(f"{specimen}, vectors, Icarus", icarus(v_folder, "+rows=20"))
        hold(f"{specimen}, vectors", verilated(v_folder)())
        streams, taxels = device.streams_of(bench, specimen)
        for flip, outer in ((0, 0), (0, 1), (65535, 1)):
            c, v = varied(c_folder, v_folder, flip, outer, work)
            simulate = verilated(v)
            for what, data in streams.items():
                (v / "rows.csv").write_bytes(rows(c, data, taxels, flip & 255, work))
                hold(f"{specimen}, {what}, flip {flip}, exact outer {outer}", simulate("+vectors=rows.csv"))


def faults(program, folder, work):
    needs("verilator")
    broken = work / "broken"
    for _, _, _, v_folder in measured(program, device.SPECIMENS[:1], folder):
        for fault, (pattern, by) in FAULTS.items():
            shutil.copytree(v_folder, broken, dirs_exist_ok=True)
            places = 0
            for source in ("tb_elam.v", "tb_steps.vh"):
                text, found = re.subn(pattern, by, (broken / source).read_text())
                (broken / source).write_text(text)
                places += found
            if places != 1:
                sys.exit(f"{fault}: {places} such places")
            said = verilated(broken)()
            if "\nFAILED" not in said or re.search(r"^\d+ readings, [1-9]\d* differ", said, re.M) is None:
                sys.exit(f"the fault in {fault} is not seen: {said}")
            print(f"{fault}: {said.splitlines()[-3]}")
        shutil.copytree(v_folder, broken, dirs_exist_ok=True)
        simulate = verilated(broken)
        words = (broken / "tb_model.mem").read_text().split()
        for place in (0, len(words) // 9, len(words) // 2, len(words) - 1):
            changed = [*words[:place], f"{int(words[place], 16) ^ 1:04x}", *words[place + 1:]]
            (broken / "tb_model.mem").write_text("\n".join(changed) + "\n")
            said = simulate()
            if "damaged" not in said or "\nFAILED" not in said:
                sys.exit(f"word {place} is changed, and it is not seen: {said}")
            print(f"word {place}: {said.splitlines()[0]}")


def synthesised(program, folder):
    *_, v_folder = next(measured(program, device.SPECIMENS[:1], folder))
    device.run(["yosys", "-q", "-p", SYNTHESIS], cwd=v_folder)
    return v_folder


def synthesis(program, folder, work):
    needs("yosys", "nextpnr-ice40")
    v_folder = synthesised(program, folder)
    done = subprocess.run(["nextpnr-ice40", "--up5k", "--package", "sg48", "--json", "pins.json", "--pack-only"], cwd=v_folder,
                          capture_output=True, text=True)
    used = {name: int(count) for name, count in re.findall(r"(\w+): +(\d+)/ *\d+", done.stderr)}
    print(used)
    if not 0 < used["ICESTORM_LC"] <= 0.9 * CELLS or used["ICESTORM_RAM"] > 24 or used["ICESTORM_DSP"] > 2 or used["ICESTORM_SPRAM"] > 4:
        sys.exit("it takes more than it did")


def place(program, folder, work):
    needs("yosys", "nextpnr-ice40")
    v_folder = synthesised(program, folder)
    bound = int(re.search(r"bound (\d+)", icarus(v_folder, "+rows=1"))[1])
    clocks = []
    for seed in range(1, 1 + int(os.environ.get("SEEDS", "5"))):
        done = subprocess.run(["nextpnr-ice40", "--up5k", "--package", "sg48", "--json", "pins.json", "--freq", "24", "--seed", str(seed),
                               "--timing-allow-fail"], cwd=v_folder, capture_output=True, text=True)
        clocks.append(float(re.findall(r"Max frequency for clock[^:]*: ([\d.]+) MHz", done.stderr)[-1]))
        print(f"seed {seed}: {clocks[-1]} MHz", flush=True)
    clock = statistics.median(clocks)
    print(f"median {clock} MHz: {1e6 * clock / bound / TAXELS:.0f} frames/s of {TAXELS} taxels at least, {bound} cycles a taxel at most")


def main():
    program, what = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryDirectory() as work:
        {"vectors": vectors, "faults": faults, "synthesis": synthesis, "place": place}[what](program, folder, pathlib.Path(work))


if __name__ == "__main__":
    main()
