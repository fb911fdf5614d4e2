#!/usr/bin/env python3
"""The mutation campaign: does the nightly suite go red on each deliberate defect?

    campaign.py PROGRAM [--only NAME...] [--jobs N] [--suite FILE] [--tests TESTS] [--table FILE.md]

PROGRAM is tactbench as the preset mutants builds it, with the defects of mutants.json; each is on in a process whose environment
names it in TACTBENCH_MUTANT. First every scenario that is to catch one has to be green without any. Then each mutant
carries out the scenario expected to catch it, and the whole suite (--stop-on-red) if that one stays green. A mutant that
no scenario catches has survived. What a night cannot see, for it needs a process of its own to be frozen, killed or cut
off, names a test instead, of the executable TESTS, which starts PROGRAM. Exit code 0: all were caught; 1: one survived,
or suite or tests are not green; 2: usage.
"""
import argparse
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

GREEN, RED = 0, 1  # exit codes of `tactbench nightly`
LONGEST = 120  # characters of what a table shows
LIMIT_S = "120"  # for one scenario, which takes seconds: some defects never end
BEGIN, END = "<!-- campaign -->", "<!-- end of campaign -->"


class Broken(Exception):
    """The program did something that is neither green nor red."""


def shown(wrong):
    """The first two lines of what is wrong, in one of bounded length: an outcome comes with its error."""
    lines = [text.splitlines()[0] for text in wrong if not text.startswith("there is no verdict by")] or wrong
    line = "; ".join(lines[:2])
    return line if len(line) <= LONGEST else line[:LONGEST] + " ..."


def nightly(program, suite, words, mutant, folder):
    """One call of `tactbench nightly`: the scenarios that are red, each with what is wrong."""
    environment = {**os.environ, "TMPDIR": folder, "XDG_STATE_HOME": folder}
    environment.pop("TACTBENCH_MUTANT", None)
    if mutant:
        environment["TACTBENCH_MUTANT"] = mutant
    done = subprocess.run([program, "nightly", suite, "--json", "--limit", LIMIT_S, *words], env=environment, cwd=folder,
                          stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    if done.returncode not in (GREEN, RED):
        raise Broken(f"`nightly {suite} {' '.join(words)}` with mutant {mutant or 'none'} ended with {done.returncode}: "
                     f"{done.stderr.strip() or done.stdout.strip()}")
    red = {s["name"]: shown(s["wrong"]) for s in json.loads(done.stdout)["scenarios"] if s["wrong"]}
    if bool(red) != (done.returncode == RED):
        raise Broken(f"{len(red)} red scenarios, but exit code {done.returncode}")
    return red


def test(program, tests, name, mutant, folder):
    """One test on the program: red with the first expectation that failed, or nothing."""
    environment = {**os.environ, "TMPDIR": folder, "TACTBENCH_TEST_PROGRAM": program}
    environment.pop("TACTBENCH_MUTANT", None)
    if mutant:
        environment["TACTBENCH_MUTANT"] = mutant
    pattern = name.replace(",", "\\,")  # which parts two names
    done = subprocess.run([tests, pattern, "-w", "NoTests"], env=environment, cwd=folder, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, check=False)
    if done.returncode == 0:
        return {}
    if "assertions:" not in done.stdout:
        raise Broken(f"test '{name}' with mutant {mutant or 'none'} ended with {done.returncode}: {done.stderr.strip()}")
    failed = [line.strip() for line in done.stdout.splitlines() if line.strip().startswith(("CHECK", "REQUIRE"))]
    return {name: shown(failed or ["it failed"])}


def look(program, suite, tests, mutant):
    """What caught the mutant, how it showed, and the seconds that took."""
    begun = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="tactbench-mutant-") as folder:
        if "test" in mutant:
            red = test(program, tests, mutant["test"], mutant["name"], folder)
        else:
            red = nightly(program, suite, ["--only", mutant["scenario"]], mutant["name"], folder)
            if not red:
                red = nightly(program, suite, ["--stop-on-red", "--jobs", "1"], mutant["name"], folder)
    caught, showed = next(iter(red.items()), (None, "nothing went red"))
    return {**mutant, "caught": caught, "showed": showed, "seconds": time.monotonic() - begun}


def look_all(program, suite, tests, mutants, jobs):
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for result in pool.map(lambda mutant: look(program, suite, tests, mutant), mutants):
            found = result["caught"] or "SURVIVED"
            print(f"{result['name']:<28} {found:<28} {result['seconds']:5.1f} s  {result['showed']}", flush=True)
            yield result


def not_green(program, suite, tests, mutants, jobs):
    """Of what is to catch the mutants that which is red without any, with the reason."""
    def one(catcher):
        kind, name = catcher
        with tempfile.TemporaryDirectory(prefix="tactbench-mutant-") as folder:
            if kind == "test":
                return test(program, tests, name, "", folder)
            return nightly(program, suite, ["--only", name], "", folder)
    catchers = list(dict.fromkeys(("test", m["test"]) if "test" in m else ("scenario", m["scenario"]) for m in mutants))
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        return {name: why for red in pool.map(one, catchers) for name, why in red.items()}


def table(results):
    lines = ["| mutant | part | file | what is wrong | caught by | how it showed | s |", "|---|---|---|---|---|---|---|"]
    for r in results:
        caught = r["caught"] or "**survived**"
        expected = r.get("test") or r["scenario"]
        if r["caught"] and r["caught"] != expected:
            caught += f" (expected: {expected})"
        showed = r["showed"].replace("|", "\\|")
        lines.append(f"| {r['name']} | {r['part']} | `{r['file']}` | {r['what']} | {caught} | {showed} | "
                     f"{r['seconds']:.1f} |")
    return "\n".join(lines)


def write_table(path, text):
    """Between the two marks of a file that has them, else as the whole file."""
    before = path.read_text() if path.exists() else ""
    if BEGIN in before and END in before:
        head, rest = before.split(BEGIN, 1)
        text = f"{head}{BEGIN}\n{text}\n{END}{rest.split(END, 1)[1]}"
    else:
        text += "\n"
    path.write_text(text)


def misused(why):
    print(why, file=sys.stderr)
    sys.exit(2)


def chosen(program, only):
    """The mutants to look at; only such as are built into the program."""
    known = {m["name"]: m for m in json.loads((pathlib.Path(__file__).parent / "mutants.json").read_text())}
    names = pathlib.Path(program + ".names")
    if not names.exists():
        misused(f"{program} is no program of mutants: there is no {names}")
    built = names.read_text().split()
    for name in only:
        if name not in known:
            misused(f"no mutant is named '{name}'; there are: {', '.join(known)}")
        if name not in built:
            misused(f"mutant '{name}' is not built in: cmake --workflow --preset mutants builds all")
    return [known[name] for name in only or built]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", help="tactbench as the preset mutants builds it")
    parser.add_argument("--only", nargs="+", default=[], metavar="NAME", help="these mutants alone")
    parser.add_argument("--jobs", type=int, default=1, help="mutants at once")
    parser.add_argument("--suite", default="nightly", help="suite file; the shipped one when left out")
    parser.add_argument("--tests", help="test_bench_realtime, for the mutants that a test is to catch")
    parser.add_argument("--table", type=pathlib.Path, metavar="FILE.md", help="write the table of results there")
    options = parser.parse_args()
    program = os.path.abspath(options.program)
    suite = os.path.abspath(options.suite) if os.path.exists(options.suite) else options.suite
    mutants = chosen(program, options.only)
    if not options.tests and any("test" in m for m in mutants):
        misused("some of these mutants are caught by tests: name their executable with --tests")
    tests = options.tests and os.path.abspath(options.tests)
    begun = time.monotonic()
    try:
        red = not_green(program, suite, tests, mutants, options.jobs)
        if red:
            sys.exit("\n".join(["suite or tests are not green without a mutant:", *(f"  {n}: {w}" for n, w in red.items())]))
        results = list(look_all(program, suite, tests, mutants, options.jobs))
    except Broken as broken:
        sys.exit(str(broken))
    survived = [r["name"] for r in results if not r["caught"]]
    print(f"{len(results)} mutants, {len(results) - len(survived)} caught, {len(survived)} survived"
          f"{': ' + ', '.join(survived) if survived else ''}; {time.monotonic() - begun:.0f} s")
    if options.table:
        write_table(options.table, table(results))
    sys.exit(1 if survived else 0)


if __name__ == "__main__":
    main()
