# One taxel's history as the peers read it: CSV with columns input and output in the order of the measurement, from a
# virgin taxel. Run by hand with /usr/bin/python3 (Debian: python3-numpy, python3-scipy).
import argparse
import csv
import time

import numpy as np


class Taxel:
    def __init__(self, description):
        parser = argparse.ArgumentParser(description=description)
        parser.add_argument("csv")
        parser.add_argument("--y-low", type=float, help="output at the lowest input (default: mean of those measured)")
        parser.add_argument("--y-high", type=float, help="output at the highest input")
        options = parser.parse_args()
        with open(options.csv, newline="") as file:
            rows = [(float(row["input"]), float(row["output"])) for row in csv.DictReader(file)]
        self.x, self.y = np.array(rows).T
        self.x_low, self.x_high = self.x.min(), self.x.max()
        self.y_low = self.y[self.x == self.x_low].mean() if options.y_low is None else options.y_low
        self.y_high = self.y[self.x == self.x_high].mean() if options.y_high is None else options.y_high
        self.u = (self.x - self.x_low) / (self.x_high - self.x_low)

    def branches(self):
        """(first, last, ascending); the turning sample belongs to both."""
        signs = np.sign(np.diff(self.x))
        turns = [0] + [i for i in range(1, len(signs)) if signs[i] != signs[i - 1]] + [len(self.x) - 1]
        return [(a, b, self.x[b] > self.x[a]) for a, b in zip(turns, turns[1:])]


def best_time(work, repeats):
    """Seconds of the fastest of several runs, and what it gave."""
    fastest = float("inf")
    for _ in range(repeats):
        start = time.perf_counter()
        result = work()
        fastest = min(fastest, time.perf_counter() - start)
    return fastest, result


def figure(name, value, unit):
    print(f"FIGURE {name} {value:.9g} {unit}")
