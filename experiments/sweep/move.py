"""Sweeps of the closed loop: one move under the sampled PD, exact friction and all."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array

from experiments.sweep.axes import Axis, Variable
from experiments.sweep.measure import Measure, Output, Values, X, Y, only_if
from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.command.trajectory import rest_to_rest
from scdpr_jax.legs.command_law import CommandLaw
from scdpr_jax.legs.ensemble import single
from scdpr_jax.legs.leg import run_leg
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.statics.workspace import static_workspace

PERIOD = 1e-3
"""Sample period of the loop, section 6 [s]."""
HOLD = 1000
"""Samples after the arrival that count as rest: a second."""
LEG_TIME = 1.5
"""Time of the move where it isn't swept [s]."""


class _Move(eqx.Module):
    """One move, simulated until the slowest one of the sweep has come to rest."""

    samples: int = eqx.field(static=True)

    def __call__(self, robot: Robot, at: Values) -> tuple[Array, ...]:
        start = jnp.stack([at["x"], at["y"]])
        target = start + jnp.stack([at["distance"], at["rise"]])
        law = CommandLaw(
            rest_to_rest(start, target, duration=at["leg_time"]),
            PD(at["proportional_gain"], at["derivative_gain"], period=PERIOD),
        )
        begin = single(robot, start).start
        leg = run_leg(robot, begin, law.commands(self.samples, judged=HOLD)).measures
        outputs = (
            leg.largest_error,
            leg.residual_vibration,
            leg.resting_error,
            leg.largest_tilt,
            leg.largest_voltage,
        )
        region = static_workspace(robot)
        reachable = region.contains(start) & region.contains(target)
        return (reachable, *(only_if(reachable, output) for output in outputs))


def _longest(axes: tuple[Axis, ...]) -> _Move:
    legs = {axis.variable.name: float(axis.values.max()) for axis in axes}
    return _Move(samples=round(legs.get("leg_time", LEG_TIME) / PERIOD) + HOLD + 2)


CLOSED_LOOP = Measure(
    name="closed-loop",
    variables=(
        X._replace(meaning="where the move starts along the frame"),
        Y._replace(meaning="height at which the move starts"),
        Variable("distance", "m", "way along the frame", lambda robot: 0.4, None),
        Variable("rise", "m", "way upwards", lambda robot: 0.0, None),
        Variable("leg_time", "s", "time of the move", lambda robot: LEG_TIME),
        Variable(
            "proportional_gain",
            "V/rad",
            "proportional gain of the PD; by default Eq. (25)'s",
            lambda robot: published_pd().proportional_gain,
        ),
        Variable(
            "derivative_gain",
            "V s/rad",
            "derivative gain of the PD; by default Eq. (25)'s",
            lambda robot: published_pd().derivative_gain,
            False,
        ),
    ),
    outputs=(
        Output("reachable", "1", "start and target lie in the static workspace, Eq. (1)"),
        Output("largest_error", "m", "largest distance from the reference, Eq. (26)"),
        Output("vibration", "m", "peak to peak of x_e in the second after the arrival"),
        Output("resting_error", "m", "distance from the target to where it comes to rest"),
        Output("largest_tilt", "rad", "largest rotation of the end-effector"),
        Output("largest_command", "V", "largest command to a drive"),
    ),
    labels={},
    compute=_longest,
    chunk=64,
    unit=512,
    most=4096,
)
"""A move under the sampled PD, exact Coulomb friction on both carriages."""
