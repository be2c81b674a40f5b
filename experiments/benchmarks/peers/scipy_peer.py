"""scipy's LSODA with the Jacobian on the smoothed nonlinear model."""

import jax
import numpy as np
import scipy.integrate
from jaxtyping import Float

from experiments.benchmarks.peers.smoothed_robot import begin, slope
from experiments.benchmarks.problem import DURATION, LOG, ROWS, TORQUE_STEP

RTOL = 1e-6
NAME = f"scipy LSODA {RTOL:g}, with Jacobian"
_slope, _jacobian = jax.jit(slope), jax.jit(jax.jacfwd(slope))


def run(values: Float[np.ndarray, "4"]) -> Float[np.ndarray, "rows 5"]:
    """The problem's run, one call of the solver for each stretch of constant command.

    Args:
        values: Values of `experiments.benchmarks.problem.FREE`.

    Returns:
        Positions at the log's instants [m, rad, m, m, m].
    """
    state = np.asarray(begin(values))
    rows, half = [state], ROWS // 2
    for voltage in TORQUE_STEP[::half]:
        solution = scipy.integrate.solve_ivp(
            lambda _, at, v=voltage: np.asarray(_slope(at, values, v)),
            (0.0, DURATION / 2),
            state,
            method="LSODA",
            t_eval=LOG * np.arange(1, half + 1),
            jac=lambda _, at, v=voltage: np.asarray(_jacobian(at, values, v)),
            rtol=RTOL,
            atol=RTOL / 100,
        )
        rows.extend(solution.y.T)
        state = solution.y[:, -1]
    return np.stack(rows)[:, :5]
