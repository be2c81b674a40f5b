"""How fast a leg is: its time, and how even the pace of its plain profile."""

import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.legs.ensemble import single
from scdpr_jax.native import kept_jit
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from tuning.plan.feedforward import inverse_dynamics
from tuning.plan.profile import plain_motion

LEG_TIME = 2.0
"""Time of a leg that is not asked for otherwise, if the drives can [s]."""
ORDERS = (2, 4, 6, 8, 10)
"""Orders of the plain profile's `pace` to choose from, the paper's first [1]."""
_PLAIN_SHARE = 0.92
"""Share of the voltage limit that the plain profile may ask for [1]: the PD answers a count of
the encoders with some 0.6 V, and a saturated drive doesn't follow."""


@dataclasses.dataclass(frozen=True)
class Pace:
    """How fast a leg is, but for what the plan adds."""

    leg_time: float = dataclasses.field(metadata=si("s"))
    """Time of the leg [s]."""
    order: int
    """Order of its plain profile, `tuning.plan.profile.pace`."""


def chosen_pace(
    robot: Robot,
    start: Float[np.ndarray, "2"],
    end: Float[np.ndarray, "2"],
    leg_time: float | None,
) -> Pace:
    """The first plain profile of `ORDERS` that the drives can follow in a leg's time.

    Args:
        robot: The robot.
        start: First position [m].
        end: Last position [m].
        leg_time: Time of the leg [s]; None for `LEG_TIME`, or as many tenths more as the
            drives need.

    Returns:
        Time and profile; where none can be followed in the time that was asked for, the one
        that asks the least of the drives.
    """
    most = _PLAIN_SHARE * float(robot.drive.voltage_limit)
    time = LEG_TIME if leg_time is None else leg_time
    while True:
        volts = np.asarray(_plain_voltages(robot, start, end, np.asarray(time)))
        if min(volts) <= most or leg_time is not None:
            first = next((k for k, v in enumerate(volts) if v <= most), int(np.argmin(volts)))
            return Pace(time, ORDERS[first])
        time = round(time + 0.1, 1)


@kept_jit
def _plain_voltages(
    robot: Robot, start: Float[Array, "2"], end: Float[Array, "2"], leg_time: Float[Array, ""]
) -> Float[Array, " orders"]:
    """Largest commands of the plain profiles of `ORDERS`, the robot in line [V]."""
    time = jnp.linspace(0.0, leg_time, 41)[:-1]
    state = single(robot, start).start

    def largest(order: int) -> Float[Array, ""]:
        motion = plain_motion(start, end, leg_time=leg_time, time=time, order=order)
        volts = jax.vmap(lambda moment: inverse_dynamics(robot, state, moment))(motion)
        return jnp.max(jnp.abs(volts))

    return jnp.stack([largest(order) for order in ORDERS])
