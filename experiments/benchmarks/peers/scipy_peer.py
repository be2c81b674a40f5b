"""scipy's LSODA with the Jacobian on the smoothed nonlinear model."""

import functools
from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
import scipy.integrate
from jaxtyping import Array, Float

from experiments.benchmarks.peers.diffrax_peers import WIDTH
from experiments.benchmarks.problem import DURATION, LOG, ROWS, TORQUE_STEP, robot_of, start_of
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.dynamics import accelerations
from scdpr_jax.robot.parameters import smoothed
from scdpr_jax.robot.state import State

RTOL = 1e-6
NAME = f"scipy LSODA {RTOL:g}, with Jacobian"


def run(values: Float[np.ndarray, "4"]) -> Float[np.ndarray, "rows 5"]:
    """The problem's run, one call of the solver for each stretch of constant command.

    Args:
        values: Values of `experiments.benchmarks.problem.FREE`.

    Returns:
        Positions at the log's instants [m, rad, m, m, m].
    """
    slope, jacobian = _compiled()
    begin = start_of(robot_of(jnp.asarray(values)))
    state = np.concatenate([begin.position, begin.velocity])
    rows, half = [state], ROWS // 2
    for voltage in TORQUE_STEP[::half]:
        solution = scipy.integrate.solve_ivp(
            lambda _, at, v=voltage: np.asarray(slope(at, values, v)),
            (0.0, DURATION / 2),
            state,
            method="LSODA",
            t_eval=LOG * np.arange(1, half + 1),
            jac=lambda _, at, v=voltage: np.asarray(jacobian(at, values, v)),
            rtol=RTOL,
            atol=RTOL / 100,
        )
        rows.extend(solution.y.T)
        state = solution.y[:, -1]
    return np.stack(rows)[:, :5]


@functools.cache
def _compiled() -> tuple[Callable[..., Array], Callable[..., Array]]:
    def slope(
        state: Float[Array, "10"], values: Float[Array, "4"], voltage: Float[Array, "2"]
    ) -> Float[Array, "10"]:
        robot = smoothed(robot_of(values), width=WIDTH)
        at = State(state[:5], state[5:])
        torque = motor_torque(robot.drive, voltage)
        force = accelerations(robot, at, torque=torque, knock=jnp.zeros((), state.dtype))
        return jnp.concatenate([at.velocity, force])

    return jax.jit(slope), jax.jit(jax.jacfwd(slope))
