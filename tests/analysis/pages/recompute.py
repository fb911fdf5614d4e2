#!/usr/bin/python3
"""Recomputes what pages 1, 4 and 5 of a report print, from the report's data, and compares. Knows no code of the program.

    tests/analysis/pages/recompute.py REPORT.html REPORT.json

Both written of the same runs with the same options. A quantile is the value at place floor(share x n) of the sorted
values. Prints what differs; exit code 1 when something does.
"""
import json
import math
import re
import sys
import xml.etree.ElementTree

KPA = 6.894757293168361
SHARE = 0.95
complaints, compared = [], 0


def quantile(values, share):
    return sorted(values)[math.floor(share * len(values))]


def same(what, printed, value, unit=KPA, beside="0"):
    """The printed number is `value` rounded to as many places as it has; to tens beside a U of a hundred and more."""
    global compared
    compared += 1
    text = printed.strip().replace("\u2212", "-").replace("\u2713", "").strip()
    if value is None or not math.isfinite(value):
        if text != "\u2013":
            complaints.append(f"{what}: printed {text}, but there is no value")
        return
    places = len(text.partition(".")[2])
    shown = float(text)
    step = 10.0 if float(beside) >= 100 else 10.0 ** -places if abs(shown) < 100 or places else max(1.0, 10.0 ** (len(text.lstrip("-")) - 2))
    if abs(shown - value * unit) > 0.5 * step + 6e-4 * abs(value * unit) + 1e-9:
        complaints.append(f"{what}: printed {text}, recomputed {value * unit:.4f}")


def equal(what, printed, value):
    global compared
    compared += 1
    if printed != value:
        complaints.append(f"{what}: printed {printed!r}, recomputed {value!r}")


def text_of(element):
    return "".join(element.itertext()).replace("\u00a0", " ")


def rows_of(page, name):
    for table in page.iter("table"):
        if table.get("id") == name:
            return [[text_of(cell) for cell in row] for row in table.find("tbody")]
    return []


class Level:
    def __init__(self, psi, branch, error, expanded):
        self.psi, self.up, self.error, self.expanded = psi, branch == "up", error, expanded
        self.there = [i for i, e in enumerate(self.error) if e is not None and self.expanded[i] is not None]
        self.sums = {i: abs(self.error[i]) + self.expanded[i] for i in self.there}
        if self.there:
            self.within = quantile(self.sums.values(), SHARE)
            self.worst = max(self.there, key=lambda i: (self.sums[i], -i))


def worst_kind(data):
    """The valid kind of history with the largest median U, its levels, and all valid kinds. The others are states."""
    four = data["sections"]["uncertainty"]["reading"]["conditions"][:4]
    kinds = [k for k in four if k["valid"] and k["pressure_psi"]]
    if not kinds:
        return None, [], []
    for kind in kinds:
        taxels = len(kind["taxel_error_psi"]) // len(kind["pressure_psi"])
        rows = [[kind[name][i * taxels:(i + 1) * taxels] for name in ("taxel_error_psi", "taxel_expanded_psi")]
                for i in range(len(kind["pressure_psi"]))]
        levels = [Level(*at, *row) for *at, row in zip(kind["pressure_psi"], kind["branch"], rows)]
        kind["levels"] = [level for level in levels if level.there]
    chosen = max(kinds, key=lambda k: k["median_expanded_psi"])
    return chosen, chosen["levels"], kinds


def longest(levels, holds):
    best, now = None, None
    for psi in levels:
        if not holds(psi):
            now = None
            continue
        now = (now[0] if now else psi, psi)
        if best is None or now[1] - now[0] > best[1] - best[0]:
            best = now
    return best


def span_text(span):
    if span is None:
        return "nowhere"
    low, high = (f"{KPA * psi:.0f}" for psi in span)
    return f"at {low} kPa alone" if low == high else f"{low} to {high} kPa"


def check_first_page(page, data, levels, kinds):
    readings = data["results"]["readings"]
    full = readings["full_psi"]
    mpes = [v["limit"] for v in data["results"]["verdicts"] if v["criterion"] == "mpe"]
    tolerance = mpes[0] if mpes else 0.02 * full
    by_direction = {up: sorted((l for l in levels if l.up == up), key=lambda l: l.psi) for up in (True, False)}
    within = {up: {l.psi: l.within for l in by_direction[up]} for up in by_direction}
    spans = {up: longest(list(within[up]), lambda psi: within[up][psi] <= tolerance) for up in within}
    both = sorted({l.psi for l in levels})
    most = {psi: max(w[psi] for w in within.values() if psi in w) for psi in both}
    heading = next(text_of(h) for h in page.iter("h2") if h.get("id") == "readings")
    for share in [tolerance / full] if mpes else [0.01, 0.02, 0.05, 0.10, 0.20]:
        headline = longest(both, lambda psi: most[psi] <= share * full * (1 + 1e-12))
        if headline and headline[1] - headline[0] >= 0.5 * (both[-1] - both[0]):
            break
    equal("tolerance of the headline", re.search(r"\((\d+) % of full pressure", heading).group(1), f"{100 * share:.0f}")
    same("the headline's tolerance", re.search("± ([0-9.]+) kPa", heading).group(1), share * full)
    equal("the headline's interval", heading.rsplit(", ", 1)[-1] if headline else "nowhere", span_text(headline))
    labels = [text_of(t) for t in page.iter("text") if (t.get("class") or "") == "mid good"]
    equal("measuring intervals", labels, [span_text(spans[up]) for up in (True, False) if spans[up]])
    worst = max(((l.sums[i], -i, l.error[i], l.expanded[i]) for k in kinds for l in k["levels"] for i in l.there),
                key=lambda w: w[:2])
    columns = data["results"]["model"]["columns"]
    said = next(text_of(p) for p in page.iter("p") if text_of(p).startswith("Worst taxel: "))
    equal("the worst taxel", re.match("Worst taxel: ([0-9]+, [0-9]+)", said).group(1),
          "{}, {}".format(*divmod(-worst[1], columns)))
    error, expanded = re.search("([\u22120-9.]+) ± ([0-9.]+) kPa", said).groups()
    same("its error", error, worst[2], beside=expanded)
    same("its U", expanded, worst[3])
    evaluations = {e["title"]: e["evaluation"] for e in data["results"]["held_out"]}
    verdicts = data["results"]["verdicts"]
    for row in rows_of(page, "runs"):
        title = next(t for t in sorted(evaluations, key=len, reverse=True) if row[0].startswith(t))
        same(f"mean error, {title}", row[1], evaluations[title]["mean_error_psi"])
        same(f"worst taxel's mean error, {title}", row[2], evaluations[title]["worst_taxel_mean_error_psi"])
        own = [v for v in verdicts if v["on"] == title]
        equal(f"checks, {title}", row[3], f"{sum(v['verdict'] in ('pass', 'conditional pass') for v in own)} of {len(own)}")
    return tolerance, spans


def check_levels(page, levels, spans, columns):
    rows = rows_of(page, "levels")
    equal("number of levels", len(rows), len({l.psi for l in levels}))
    for row, psi in zip(rows, sorted({l.psi for l in levels})):
        same("level", row[0], psi)
        same("level in psi", row[1], psi, 1.0)
        for up, cells in ((True, row[2:7]), (False, row[7:12])):
            where = f"{row[0]} kPa {'increasing' if up else 'decreasing'}"
            level = next((l for l in levels if l.psi == psi and l.up == up), None)
            if level is None:
                equal(where, cells, ["\u2013"] * 5)
                continue
            same(f"median error, {where}", cells[0], quantile([level.error[i] for i in level.there], 0.5))
            same(f"median U, {where}", cells[1], quantile([level.expanded[i] for i in level.there], 0.5))
            same(f"95 % of taxels, {where}", cells[2], level.within)
            same(f"worst taxel, {where}", cells[3], level.sums[level.worst])
            ties = [i for i in level.there if level.sums[i] > level.sums[level.worst] * (1 - 1e-3)]
            equal(f"which, {where}", cells[4] in ["{}, {}".format(*divmod(i, columns)) for i in ties], True)
            inside = spans[up] is not None and spans[up][0] <= psi <= spans[up][1]
            equal(f"mark of the interval, {where}", "\u2713" in cells[2], inside)


def check_array(page, levels, tolerance, columns):
    maps = [figure for figure in page.iter("figure") if text_of(figure).find("|error| + U in kPa at") >= 0]
    if not maps:
        return
    for figure in maps:
        said = text_of(figure.find("figcaption"))
        kpa, direction = re.search(r"at ([0-9.]+) kPa \(.*?\), (\w+)", said).groups()
        level = min((l for l in levels if l.up == (direction == "increasing")), key=lambda l: abs(l.psi * KPA - float(kpa)))
        cells = [t for t in figure.iter("text") if (t.get("class") or "").startswith("cell")]
        equal(f"cells of the map, {direction}", len(cells), len(level.there))
        for i, cell in zip(level.there, cells):
            same(f"taxel {i}, {direction}", cell.text, level.sums[i])
            if abs(level.sums[i] - tolerance) > 1e-3 * tolerance:
                equal(f"bold, taxel {i}, {direction}", "b" in cell.get("class").split(), level.sums[i] > tolerance)
        equal(f"taxels within, {direction}", re.search(r"([0-9]+) of ([0-9]+) taxels", said).groups(),
              (str(sum(s <= tolerance for s in level.sums.values())), str(len(level.there))))
        if direction == "increasing":
            labels = [text_of(t) for t in page.iter("text")]
            for name, value in (("median ", quantile(level.sums.values(), 0.5)), ("95 %: ", level.within)):
                marked = [label[len(name):] for label in labels if re.fullmatch(name + "[0-9.]+", label)]
                same(f"mark {name}of the spread", marked[0], value)
    up, down = (next(l for l in levels if l.up == way and abs(l.psi - level.psi) < 1e-9) for way in (True, False))
    for row in rows_of(page, "largest"):
        taxel = int(row[0].split(", ")[0]) * columns + int(row[0].split(", ")[1])
        for cell, own in ((row[1], up), (row[2], down)):
            error, expanded = cell.split(" ± ")
            same(f"error of taxel {row[0]}", error, own.error[taxel], beside=expanded)
            same(f"U of taxel {row[0]}", expanded, own.expanded[taxel])


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    text = re.sub("^<!DOCTYPE html>", "", open(sys.argv[1], encoding="utf-8").read())
    page = xml.etree.ElementTree.fromstring(text)
    data = json.load(open(sys.argv[2], encoding="utf-8"))
    title = text_of(page.find("head/title"))
    equal("number", data["number"] in title, True)
    chosen, levels, kinds = worst_kind(data)
    if chosen is None:
        print("no kind of history has a valid U: nothing to recompute")
    else:
        equal("kind of history", data["results"]["readings"]["kind"], chosen["name"])
        columns = data["results"]["model"]["columns"]
        tolerance, spans = check_first_page(page, data, levels, kinds)
        check_levels(page, levels, spans, columns)
        check_array(page, levels, tolerance, columns)
    for complaint in complaints:
        print("DIFFERS", complaint)
    print(f"{compared} figures compared, {len(complaints)} differ")
    sys.exit(1 if complaints else 0)


main()
