"""One manoeuvre of Table 3, simulated and written as a table."""

import csv
import io

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import Controller, published_pd
from scdpr_jax.command.shaper import ShapedTrajectory, Shaper
from scdpr_jax.command.trajectory import Trajectory, table_3
from scdpr_jax.engines.closed_loop import ClosedLoop, closed_loop
from scdpr_jax.robot.dynamics import rest
from scdpr_jax.robot.parameters import Robot
from tuning.result.types import Tuning

HOLD = 1.0
"""Time that is simulated after the reference has ended [s]."""

MANOEUVRES = ("horizontal", "vertical", "diagonal")
"""Names of the manoeuvres of Table 3."""

_HEADER = (
    "t [s]",
    "voltage_1 [V]",
    "voltage_2 [V]",
    "x_ref [m]",
    "y_ref [m]",
    "x_e [m]",
    "y_e [m]",
    "delta_e [rad]",
    "q_3 [m]",
    "q_4 [m]",
)


def manoeuvre(name: str, leg_time: float) -> Trajectory:
    """A manoeuvre of Table 3 with legs of a given time.

    Args:
        name: One of `MANOEUVRES`.
        leg_time: Time of each leg [s].

    Returns:
        Its reference.

    Raises:
        ValueError: If there is no manoeuvre of that name, or the time isn't positive.
    """
    if name not in MANOEUVRES:
        raise ValueError(
            f"`--manoeuvre` is unknown, got {name!r}, expected one of: "
            f"{', '.join(MANOEUVRES)}. Table 3 has no other."
        )
    if not leg_time > 0:
        raise ValueError(
            f"`--leg-time` must be positive [s], got {leg_time:g}. Table 3's horizontal "
            'manoeuvre was run at "2 s" a leg.'
        )
    return getattr(table_3(leg_times=(leg_time,) * 3), name)


def simulate(
    robot: Robot, reference: Trajectory, tuning: Tuning | None, pretension: float
) -> tuple[ClosedLoop, Float[np.ndarray, "samples 2"]]:
    """A manoeuvre under the tuned controller and shaper, or under the PD of Eq. (25).

    Args:
        robot: The robot.
        reference: The manoeuvre.
        tuning: Gains and shapers; None for Eq. (25) without a shaper.
        pretension: Nominal pretension, which the shaper is chosen for [N].

    Returns:
        The run and the reference that the controller was given [m].
    """
    controller: Controller = published_pd()
    shaper = Shaper(jnp.zeros(1), jnp.ones(1))
    if tuning is not None:
        x, y = (float(part) for part in reference.position(jnp.asarray(reference.duration)))
        controller, shaper = tuning.controller, tuning.shaper_at(x, y, pretension).shaper
    shaped = ShapedTrajectory(reference, shaper)
    end = float(reference.duration) + float(shaper.duration) + HOLD
    time = float(controller.period) * np.arange(round(end / float(controller.period)) + 1)
    commanded = jax.vmap(shaped.position)(jnp.asarray(time))
    run = _run(robot, controller, commanded)
    return run, np.asarray(commanded)


@eqx.filter_jit
def _run(
    robot: Robot, controller: Controller, commanded: Float[Array, "samples 2"]
) -> ClosedLoop:
    x, y = commanded[0]
    return closed_loop(robot, rest(robot, x, x, y), controller, reference=commanded)


def table(run: ClosedLoop, commanded: Float[np.ndarray, "samples 2"]) -> str:
    """A run as CSV, units in the header; the last row repeats the last command.

    Args:
        run: The run.
        commanded: The reference that the controller was given [m].

    Returns:
        The table.
    """
    voltage = np.asarray(run.voltage)
    q = np.asarray(run.states.position)
    columns = np.column_stack(
        [
            np.asarray(run.time),
            np.concatenate([voltage, voltage[-1:]]),
            commanded,
            q[:, [0, 4, 1, 2, 3]],
        ]
    )
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_HEADER)
    writer.writerows([[f"{number:.9g}" for number in row] for row in columns])
    return text.getvalue()
