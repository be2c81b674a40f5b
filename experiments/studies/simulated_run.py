"""One manoeuvre of Table 3, simulated and written as a table."""

import csv
import io

import equinox as eqx
import jax.numpy as jnp
import numpy as np

from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.trajectory import Trajectory, table_3
from scdpr_jax.legs.command_law import CommandLaw
from scdpr_jax.legs.ensemble import single
from scdpr_jax.legs.leg import Leg, run_leg
from scdpr_jax.robot.parameters import Robot
from tuning.result.tuning import Tuning

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
) -> Leg:
    """A manoeuvre under the tuned controller and shaper, or under the PD of Eq. (25).

    Args:
        robot: The robot.
        reference: The manoeuvre.
        tuning: Gains and shapers; None for Eq. (25) without a shaper.
        pretension: Nominal pretension, which the shaper is chosen for [N].

    Returns:
        The run.
    """
    law = CommandLaw(reference, published_pd())
    if tuning is not None:
        x, y = (float(part) for part in reference.position(jnp.asarray(reference.duration)))
        law = CommandLaw(
            reference, tuning.controller, tuning.shaper_at(x, y, pretension).shaper
        )
    end = float(law.duration) + HOLD
    return _run(robot, law, round(end / float(law.controller.period)) + 1)


@eqx.filter_jit
def _run(robot: Robot, law: CommandLaw, samples: int) -> Leg:
    commands = law.commands(samples)
    return run_leg(robot, single(robot, commands.commanded[0]).start, commands)


def sentence(run: Leg) -> str:
    """What came of a run, in words.

    Args:
        run: The run.

    Returns:
        Sentences.
    """
    error, swing = run.measures.largest_error, run.measures.residual_vibration
    return (
        f"Largest error, Eq. (26): {1e3 * error:.1f} mm. Vibration after the arrival: "
        f"{1e3 * swing:.2f} mm peak to peak. Largest command: "
        f"{run.measures.largest_voltage:.2f} V."
    )


def table(run: Leg) -> str:
    """A run as CSV, units in the header; the last row repeats the last command.

    Args:
        run: The run.

    Returns:
        The table.
    """
    voltage = np.asarray(run.voltage)
    q = np.asarray(run.states.position)
    columns = np.column_stack(
        [
            np.asarray(run.time),
            np.concatenate([voltage, voltage[-1:]]),
            np.asarray(run.commanded),
            q[:, [0, 4, 1, 2, 3]],
        ]
    )
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(_HEADER)
    writer.writerows([[f"{number:.9g}" for number in row] for row in columns])
    return text.getvalue()
