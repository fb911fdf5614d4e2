# GPI by scipy's differential evolution on the 8 independent parameters (Eqs (2), (3), (40)-(43)), vectorised over the
# population, run until it has converged by its own tolerance and polished by its own L-BFGS-B.
import numpy as np
from scipy.optimize import differential_evolution

from taxel import Taxel, best_time, figure

taxel = Taxel(__doc__)
u = taxel.u
y = (taxel.y - taxel.y_low) / (taxel.y_high - taxel.y_low)
index = np.arange(5)[:, None]


def j_of(p):
    """p: 8 or 8 x candidates: ln a, l0, ln dl, ln b, r0, ln dr, ln alpha, s; rho is 1."""
    p = np.asarray(p)
    one = p.ndim == 1
    p = p.reshape(8, -1)
    a, l0, dl, b, r0, dr = np.exp(p[0]), p[1], np.exp(p[2]), np.exp(p[3]), p[4], np.exp(p[5])
    r, weight = np.exp(p[6]) * index, np.exp(-p[7] * index)
    left = l0 + dl * np.expm1(-np.multiply.outer(u, a)) / np.expm1(-a)
    right = r0 + dr * np.expm1(-np.multiply.outer(u, b)) / np.expm1(-b)
    state, j = np.zeros((5, p.shape[1])), np.zeros(p.shape[1])
    for k in range(len(u)):
        state = np.maximum(left[k] - r, np.minimum(right[k] + r, state))
        if k > 0:
            j += ((weight * state).sum(axis=0) - y[k]) ** 2
    return j[0] if one else j


bounds = [(-1.5, 3.0), (-1.0, 1.0), (-3.0, 1.5), (-1.5, 3.0), (-3.0, 1.0), (-3.0, 1.5), (-4.0, 1.0), (-1.5, 4.0)]
seconds, found = best_time(
    lambda: differential_evolution(j_of, bounds, vectorized=True, updating="deferred", maxiter=2000, seed=1, tol=1e-6), 1)
figure("gpi_scipy", 1e6 * seconds, "us")
figure("gpi_scipy_j", found.fun * (taxel.y_high - taxel.y_low) ** 2, "y^2")
