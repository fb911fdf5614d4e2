# POLY by numpy: one linear least squares problem a direction (Eqs (6), (7), (47), (48)), branches from their measured
# turning points, external ones from the ends of the loop. Timed with the bases prepared and
# with their preparation.
import numpy as np

from taxel import Taxel, best_time, figure

taxel = Taxel(__doc__)
near = 0.01 * (taxel.x_high - taxel.x_low)
span, rise = taxel.x_high - taxel.x_low, taxel.y_high - taxel.y_low


def prepare():
    halves = {}
    for ascending in (True, False):
        t, sample, branch, first, outer = [], [], [], [], []
        for a, b, up in taxel.branches():
            if up != ascending:
                continue
            x1 = taxel.x[a]
            whole = (x1 - taxel.x_low if up else taxel.x_high - x1) <= near
            low = taxel.x_low if whole or not up else x1
            high = taxel.x_high if whole or up else x1
            t.append((taxel.x[a + 1:b + 1] - low) / (high - low))
            sample.append(np.arange(a + 1, b + 1))
            branch += [len(first)] * (b - a)
            first.append(a)
            outer.append(whole)
        t = np.concatenate(t)
        basis = np.stack([t ** k - t for k in range(2, 7)], axis=1)
        halves[ascending] = t, basis, np.concatenate(sample), np.array(branch), np.array(first), np.array(outer)
    return halves


def fit(halves):
    """a and b of Eqs (47), (48), J, mean and largest error."""
    errors, polynomials = [], []
    for ascending, (t, basis, sample, branch, first, outer) in halves.items():
        turn = np.where(outer, taxel.y_low if ascending else taxel.y_high, taxel.y[first])[branch]
        base, height = (turn, taxel.y_high - turn) if ascending else (taxel.y_low, turn - taxel.y_low)
        target = taxel.y[sample] - base - height * t
        rows = height[:, None] * basis
        c = np.linalg.lstsq(rows, target, rcond=None)[0]
        errors.append(rows @ c - target)
        shape = np.concatenate([c[::-1], [1.0 - c.sum(), 0.0]])
        polynomials.append(rise * shape / powers + offset)
    off = np.concatenate(errors)
    return polynomials, off @ off, np.abs(off).mean(), np.abs(off).max()


powers = span ** np.arange(6, -1, -1.0)
offset = np.array([0, 0, 0, 0, 0, 0, taxel.y_low])
halves = prepare()
seconds, (_, j, _, _) = best_time(lambda: fit(halves), 2000)
figure("poly_numpy", 1e6 * seconds, "us")
seconds, _ = best_time(lambda: fit(prepare()), 500)
figure("poly_numpy_with_bases", 1e6 * seconds, "us")
figure("poly_numpy_j", j, "y^2")
