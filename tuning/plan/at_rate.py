"""A motion at the controller's period: references, and commands by dynamics inversion."""

import numpy as np
from jaxtyping import Float

from scdpr_jax.engines.led_stepping import Lead, thirds
from scdpr_jax.robot.parameters import Robot
from tuning.plan.led.following import Leader
from tuning.plan.leg import Leg, led
from tuning.plan.plan import Plan
from tuning.plan.profile import Moment
from tuning.plan.search.scenarios import FITTED, scenarios, starts


def planned(
    robot: Robot, leg: Leg, coefficients: Float[np.ndarray, " splines"], *, period: float
) -> Plan:
    """A motion as the controller is told it.

    A command is held until the next sample, so it is that of the interval's middle.

    Args:
        robot: The fitted robot.
        leg: The leg.
        coefficients: Of its splines [m].
        period: The controller's [s].

    Returns:
        The plan, from the leg's begin to the first sample after its end. Where cables give, the
        drives are led ahead of the lower carriage by what they do.
    """
    samples = int(np.ceil(leg.time / period - 1e-9))
    motion = led(leg, coefficients, period / 4 * np.arange(4 * samples + 1))
    lead = Lead(*(thirds(own)[None] for own in motion.value.T))
    alone = scenarios(robot, FITTED)
    fitted = Leader(alone.robot)
    begins = motion.slope[None, :-1:2, 0]
    halves = fitted.steps(period / 2)
    end, (positions, _) = halves(starts(alone, leg), (lead, begins))
    middles = Moment(*(own[None, 2::4] for own in motion))
    volts = fitted.commands(positions[:, 1::2], middles)
    x = np.append(positions[0, ::2, 0], leg.end[0])
    radius = np.asarray(robot.drive.effective_radius)
    way = motion.value[::4] - motion.value[0]
    angle = np.stack([way[:, 0] + way[:, 1], way[:, 0] - way[:, 1]], axis=1) / radius
    if float(robot.drive.compliance):
        sampled_at = np.concatenate([positions[:, ::2], end.position[:, None]], axis=1)
        sampled = Moment(*(own[None, ::4] for own in motion))
        ahead = fitted.stretches(sampled_at, sampled)
        # The angles count from the begin, at which nothing has moved yet.
        ahead[0] = 0.0
        angle += ahead[:, None] / radius
    return Plan(
        time=period * np.arange(samples + 1),
        position=np.stack([x, motion.value[::4, 1]], axis=1),
        angle=angle,
        feedforward=np.concatenate([volts, np.zeros((1, 2))]),
    )
