"""A planned leg, and the same leg as the paper runs it, simulated side by side."""

import dataclasses
import math

import jax
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD, published_pd
from scdpr_jax.legs.command_law import Commands
from scdpr_jax.legs.ensemble import Ensemble, Variation, varied
from scdpr_jax.legs.leg import Leg as Run
from scdpr_jax.legs.leg import leg_of, run_leg
from scdpr_jax.legs.starts import held_slope
from scdpr_jax.native import kept_jit
from scdpr_jax.robot.parameters import Robot
from tuning.plan.expectation import ROBOTS
from tuning.plan.planning import Planned, plain_plan

AFTERWARDS = 1.5
"""Time that is looked at after the leg [s]."""
SIDES = ("plain profile, Eq. (25)", "planned")
"""Names of what is compared, for tables and legends."""


@dataclasses.dataclass(frozen=True, eq=False)
class Compared:
    """A leg as the paper runs it and as planned, on the robots that it was planned for."""

    names: tuple[str, ...]
    """What is different about each robot, the fitted one first."""
    plain: tuple[Run, ...]
    """The plain profile under the PD of Eq. (25)."""
    planned: tuple[Run, ...]
    """The plan."""


def compare(robot: Robot, controller: PD, planned: Planned) -> Compared:
    """The leg as the paper runs it, and as planned, on the robots of `ROBOTS`.

    Args:
        robot: The fitted robot.
        controller: The PD controller of the plan.
        planned: The plan.

    Returns:
        Both on every robot, in the time of the plan.
    """
    leg, plan = planned.leg, planned.simulated
    share = leg.slope / float(held_slope(robot)) if leg.slope else 0.0
    robots = dataclasses.replace(
        varied(robot, ROBOTS, np.asarray(leg.start)),
        out_of_line=np.array([own.out_of_line for own in ROBOTS]) + share,
    )
    period, radius = float(controller.period), float(robot.drive.effective_radius)
    # In the plan's time, which may be longer than what was asked for.
    plain = plain_plan(
        dataclasses.replace(leg, time=float(plan.time[-1])), controller, radius=radius
    )
    # One length of runs for a second of leg times: fewer programs.
    whole = math.ceil(plan.time[-1] + AFTERWARDS)
    rest = period * (round(whole / period) - plan.time.size + 1)
    return Compared(
        tuple(map(_words, ROBOTS)),
        _legs(robots, plain.commands(robot, published_pd(), rest=rest)),
        _legs(robots, plan.commands(robot, controller, rest=rest)),
    )


def _words(variation: Variation) -> str:
    """What is different about a robot."""
    shares = (("pretension", variation.tension), ("friction", variation.friction))
    parts = [
        f"{name} {100 * (share - 1):+.0f} %".replace("-", "−")
        for name, share in shares
        if share != 1
    ]
    if variation.out_of_line:
        side = "ahead" if variation.out_of_line > 0 else "behind"
        share = f"{abs(variation.out_of_line):g} of what friction holds"
        parts.append(f"lower carriage {side} by {share}")
    return ", ".join(parts) or "as fitted"


def _legs(robots: Ensemble, commands: Commands) -> tuple[Run, ...]:
    legs = jax.tree.map(np.asarray, leg_of(_run(robots, commands)))
    return tuple(
        jax.tree.map(lambda leaf, row=row: leaf[row], legs) for row in range(len(robots))
    )


@kept_jit
def _run(robots: Ensemble, commands: Commands) -> list[Float[Array, "robots ..."]]:
    """The arrays of a leg for each robot."""
    return jax.tree.leaves(
        jax.vmap(lambda each: run_leg(each.robot, each.start, commands))(robots)
    )
