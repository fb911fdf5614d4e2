#!/usr/bin/python3
"""Random mutants against the tests of their room: what share of them do the tests notice?

    random_campaign.py BUILD_DIR [--seed N] [--mutants N] [--room R...] [--jobs N] [--table FILE.md] [--only ID...]

Draws mutants at random, as many in each room, and tries each against those tests of its room that reach it: unit tests, then
wire tests, then slow and realtime ones, then for the fleet's sources its scripts, of those that are
built in BUILD_DIR. The same seed on the same sources draws the same mutants.
Exit code 0: of the killable mutants of each room at least the goal's share was killed; 1: fewer; 2: usage, or the build
cannot be used. README.md tells the rest.
"""
import argparse
import concurrent.futures
import dataclasses
import itertools
import os
import pathlib
import queue
import random
import shutil
import sys
import time

from campaign import write_table
from random_parts import build_tree, changes, equivalents, syntax, test_runs, trial

HERE = pathlib.Path(__file__).resolve().parent
BEGIN, END = "<!-- random campaign -->", "<!-- end of random campaign -->"


@dataclasses.dataclass
class Result:
    change: changes.Change
    verdict: trial.Verdict
    reason: str  # why it was judged equivalent; empty: it was not


def say(text):
    print(text, flush=True)


def drawn(tree, judge, room, seed):
    """The changes of a room in the order in which the seed draws them, those alone that the compiler's view confirms."""
    offered = [c for source in tree.sources(room) for c in changes.changes_of(source, tree.text(source))]
    random.Random(f"{seed} {room}").shuffle(offered)
    for change in offered:
        options = syntax.options_for_clang(tree.recipes[change.file].words)
        if judge.accepts(change, str(tree.source / change.file), options):
            yield change


def draw(tree, judge, names, options):
    """Of each room as many changes, or one fewer in the last ones, as {room: {change: its Weave or none}}."""
    found = {}
    for i, name in enumerate(names):
        share = options.mutants // len(names) + (i < options.mutants % len(names))
        found[name] = {change: weave_of(tree, judge, change)
                       for change in itertools.islice(drawn(tree, judge, name, options.seed), share)}
    return found


def weave_of(tree, judge, change):
    return judge.weave(change, str(tree.source / change.file), syntax.options_for_clang(tree.recipes[change.file].words))


def by_id(tree, identity):
    """The change of an id, which the tokens alone find: what was drawn once needs no judge."""
    source = identity.split(":")[0]
    if source not in tree.recipes:
        raise build_tree.Unusable(f"'{identity}': no source {source} is built")
    found = [c for c in changes.changes_of(source, tree.text(source)) if c.id == identity]
    if not found:
        raise build_tree.Unusable(f"'{identity}': no such change; an id is FILE:LINE:COLUMN:NAME as it was printed")
    return found[0]


def line_of_result(result, seconds):
    verdict = result.verdict
    became = {"killed": f"killed by {verdict.by}", "unbuilt": "did not build",
              "survived": f"SURVIVED {verdict.reached} tests that reach it"}[verdict.state]
    if result.reason:
        became = f"judged equivalent: {result.reason}" if verdict.state == "survived" else \
            f"judged equivalent, and {became}: take it out of random_equivalents.json"
    return f"{result.change.id}  {changes.shown(result.change)}  {became}  ({seconds:.0f} s)"


def try_all(chosen, rooms, reasons, slots, all_stages):
    """Tries the changes, as many at once as there are slots, and gives each result when it is there."""
    def one(change):
        slot = slots.get()
        begun = time.monotonic()
        try:
            reason = reasons.get(change.id, "")
            stages = build_tree.STAGES[:2] if reason else all_stages
            result = Result(change, rooms[change.file.split("/")[0]].try_change(change, slot, stages), reason)
            say(line_of_result(result, time.monotonic() - begun))
            return result
        finally:
            slots.put(slot)
    with concurrent.futures.ThreadPoolExecutor(slots.qsize()) as pool:
        waiting = [pool.submit(one, change) for change in chosen]
        try:
            yield from (done.result() for done in concurrent.futures.as_completed(waiting))
        finally:
            pool.shutdown(cancel_futures=True)


def figures(results):
    """Of the results of a room: drawn, built, killed, survived, judged equivalent, and the share of the killable killed."""
    killed = sum(r.verdict.state == "killed" for r in results)
    built = sum(r.verdict.state != "unbuilt" for r in results)
    equivalent = sum(r.verdict.state == "survived" and bool(r.reason) for r in results)
    killable = built - equivalent
    return len(results), built, killed, killable - killed, equivalent, killed / killable if killable else 1.0


def table(results, rooms):
    lines = ["| room | drawn | built | killed | survived | judged equivalent | killed of killable |",
             "|---|---|---|---|---|---|---|"]
    for name, own in [*((room, [r for r in results if r.change.file.startswith(room + "/")]) for room in rooms),
                      ("all", results)]:
        *counts, share = figures(own)
        lines.append(f"| {name} | {' | '.join(map(str, counts))} | {100 * share:.0f} % |")
    return "\n".join(lines)


def report(results, names, tree, options):
    text = table(results, names)
    survivors = [r.change for r in results if r.verdict.state == "survived" and not r.reason]
    for change in survivors:
        say(f"\nsurvived: {change.id}\n  {changes.line_of(tree.text(change.file), change.line)}\n"
            f"  {changes.shown(change)}\n"
            f"  again: {sys.argv[0]} {options.build_dir} --only {change.id}\n"
            f"  if no test can tell: {equivalents.entry_of(change, tree.text(change.file))}")
    say(f"\n{text}")
    if options.table:
        seed = "" if options.only else f"Seed {options.seed}, {options.mutants} mutants.\n\n"
        write_table(options.table, seed + text, BEGIN, END)
    shares = [figures([r for r in results if r.change.file.startswith(room + "/")])[-1] for room in names]
    return all(100 * share >= options.goal for share in shares)


def campaign(options, scratch):
    tree = build_tree.BuildTree(options.build_dir)
    reasons = equivalents.reasons(HERE / "random_equivalents.json", tree.text)
    wanted = [by_id(tree, identity) for identity in options.only]
    asked = options.room or {change.file.split("/")[0] for change in wanted} or build_tree.ROOMS
    names = [room for room in build_tree.ROOMS if room in asked]
    rooms = {name: trial.Room(tree, name, scratch, say) for name in names}
    slots = queue.Queue()
    for i in range(options.jobs):
        (scratch / f"slot{i}").mkdir(parents=True)
        slots.put(scratch / f"slot{i}")
    begun, judge, results = time.monotonic(), syntax.Syntax(), []
    chosen = draw(tree, judge, names, options) if not wanted else \
        {name: {c: weave_of(tree, judge, c) for c in wanted if c.file.startswith(name + "/")} for name in names}
    for path, why in judge.unreadable.items():
        say(f"{path}: clang cannot read it, nothing was drawn there: {why}")
    stages = build_tree.STAGES[:2] if options.quick else build_tree.STAGES
    for name, own in chosen.items():
        rooms[name].build(list(own), {change.id: weave for change, weave in own.items()}, scratch / "slot0")
        results += sorted(try_all(own, rooms, reasons, slots, stages), key=lambda result: list(own).index(result.change))
    enough = report(results, names, tree, options)
    say(f"{time.monotonic() - begun:.0f} s")
    return enough


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("build_dir", help="built folder of the default preset")
    parser.add_argument("--seed", type=int, default=1, help="what is drawn follows from it")
    parser.add_argument("--mutants", type=int, default=100, help="in all, the same number in each room")
    parser.add_argument("--room", nargs="+", default=[], choices=build_tree.ROOMS, help="these rooms alone")
    parser.add_argument("--quick", action="store_true", help="unit and wire tests alone: the rate is a lower bound")
    parser.add_argument("--jobs", type=int, default=1, help="mutants at once")
    parser.add_argument("--goal", type=float, default=90, metavar="PERCENT", help="share to kill in each room (90)")
    parser.add_argument("--table", type=pathlib.Path, metavar="FILE.md", help="write the table of rooms there")
    parser.add_argument("--only", nargs="+", default=[], metavar="ID", help="these mutants alone, as they were printed")
    options = parser.parse_args()
    scratch = pathlib.Path(options.build_dir).resolve() / f"random_mutants.{os.getpid()}"
    test_runs.begin_campaign()
    try:
        enough = campaign(options, scratch)
    except (build_tree.Unusable, equivalents.Wrong) as error:
        print(error, file=sys.stderr)
        sys.exit(2)
    finally:
        shutil.rmtree(scratch, ignore_errors=True)
    sys.exit(0 if enough else 1)


if __name__ == "__main__":
    main()
