# MPI by numpy and scipy: linear least squares of the four linear parameters within a bounded scalar search of tau (Eqs (4),
# (5), (44)-(46)), the operators' outputs prepared outside of what is timed.
import numpy as np
from scipy.optimize import minimize_scalar

from taxel import Taxel, best_time, figure

taxel = Taxel(__doc__)
thresholds = np.arange(10) / 10
steps = np.arange(10) - 1.0  # n r_i - 1
state, plays = np.zeros(10), []
for u in taxel.u:
    state = np.maximum(u - thresholds, np.minimum(u, state))
    plays.append(state)
plays, u = np.array(plays)[1:], taxel.u[1:]
cubic = np.stack([u, u * u, u ** 3], axis=1)
target = taxel.y[1:] - taxel.y_low


def rows_of(tau):
    density = np.exp(-tau * steps ** 2)
    return np.column_stack([cubic, plays @ (density / density.max())])


def j_of(tau):
    rows = rows_of(tau)
    coefficients = np.linalg.lstsq(rows, target, rcond=None)[0]
    error = rows @ coefficients - target
    return error @ error


def fit():
    """tau, the four linear parameters, J, mean and largest error."""
    tau = minimize_scalar(j_of, bounds=(-5.0, 5.0), method="bounded", options={"xatol": 1e-6}).x
    rows = rows_of(tau)
    coefficients = np.linalg.lstsq(rows, target, rcond=None)[0]
    error = rows @ coefficients - target
    return tau, coefficients, error @ error, np.abs(error).mean(), np.abs(error).max()


seconds, (_, _, j, _, _) = best_time(fit, 50)
figure("mpi_scipy", 1e6 * seconds, "us")
figure("mpi_scipy_j", j, "y^2")
figure("mpi_dense_j", min(j_of(tau) for tau in np.linspace(-5.0, 5.0, 2001)), "y^2")
