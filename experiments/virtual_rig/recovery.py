"""Campaigns of drawn robots, and how often their truth is found and covered.

Short runs at a coarse rate, so that a hundred campaigns are a matter of minutes: two torque
steps, a knock and a step of the bare drives at 200 Hz, encoders rounded to counts, camera at
30 fps. The rig steps five times as fine as it logs. Everything else, from the starts to the
intervals, is what `scdpr identify` does.

Run it with `python -m experiments.virtual_rig --campaigns 100 --out recovery.csv`.
"""

from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from experiments.virtual_rig.rig import Truth
from experiments.virtual_rig.simulated import COUNTS_PER_REV
from identification.axis.motion import AxisParameters, axis_positions
from identification.campaign import CameraStream, Campaign, DriveStream, Knock, Run
from identification.campaign.types import default_sensors, encoder_resolution
from identification.result.estimation import estimate
from scdpr_jax.engines.closed_loop import pulley_angles
from scdpr_jax.engines.stepping import Inputs, interpolate, simulate
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace, value
from scdpr_jax.robot.state import rest

PERIOD, SUBSTEPS, ROWS = 5e-3, 5, 361
"""Sample period of the logs [s], steps of the rig in it, and samples of a run."""

SETTING = "350 N"
"""Nominal pretension of every run."""

DRAWN = ("friction_coefficient", "drive_inertia", "drive_damping", "effective_pretension")
"""What is drawn; everything else is as in the prototype, whose drives have no dry friction."""

RUNS = (
    ((0.30, 0.40), (9.0, 8.6), 0.0),
    ((1.90, 0.75), (-8.2, -8.8), 0.0),
    ((1.10, 0.55), (0.0, 0.0), 45.0),
)
"""Start pose [m], voltages [V] for half a second and knock [N] of the runs with the cable."""

MOTOR_VOLTAGE = 6.0
"""Step of the bare drives [V]."""


def draw(seed: int) -> Truth:
    """A robot anywhere in the range in which it has to be found.

    Args:
        seed: Seed of the draw.

    Returns:
        Friction from 0.003 to 0.03, pretension from 40 to 300 N, drives ± 40 %.
    """
    random = np.random.default_rng(seed)
    prototype = consistent()
    values = {
        "friction_coefficient": float(np.exp(random.uniform(np.log(0.003), np.log(0.03)))),
        "drive_inertia": float(value(prototype, "drive_inertia")) * random.uniform(0.6, 1.4),
        "drive_damping": float(value(prototype, "drive_damping")) * random.uniform(0.6, 1.4),
        "effective_pretension": float(np.exp(random.uniform(np.log(40), np.log(300)))),
    }
    return Truth(replace(prototype, values), values)


def campaign(truth: Truth, seed: int) -> Campaign:
    """The logs of a drawn robot.

    Args:
        truth: The robot.
        seed: Seed of start poses, camera times and noise.

    Returns:
        Its campaign.
    """
    random = np.random.default_rng([seed, 1])
    sensors = default_sensors(COUNTS_PER_REV)
    count = encoder_resolution(COUNTS_PER_REV)
    sigma = np.full(5, sensors.camera_position_sigma)
    sigma[1] = sensors.camera_angle_sigma
    time = PERIOD * np.arange(ROWS)
    runs = []
    for number, ((x, y), volts, force) in enumerate(RUNS, start=1):
        slope = random.uniform(-0.8, 0.8) * truth.values["friction_coefficient"]
        lower, height = np.array([x + slope * y, y]) + random.normal(0, 5e-4, 2)
        upper = lower - slope * float(truth.robot.frame.height)
        on = ((time >= 0.1) & (time < 0.6))[:, None]
        pushed = np.where((time[:-1] > 0.299) & (time[:-1] < 0.329), force, 0.0)
        stamps = random.uniform(2e-3, 30e-3) + np.arange(int(time[-1] * 30)) / 30
        angle, frame = simulated(
            truth.robot,
            jnp.array([lower, upper, height]),
            jnp.asarray(on[:-1] * np.array(volts)),
            jnp.asarray(pushed),
            jnp.asarray(stamps),
        )
        kind = "pseudo_impulse" if force else "torque_step"
        runs.append(
            Run(
                name=f"{number:04d}-{kind.replace('_', '-')}",
                kind=kind,
                pretension=350.0,
                pretension_label=SETTING,
                drive=DriveStream(
                    time=time, voltage=on * np.array(volts), angle=_rounded(angle, count)
                ),
                camera=CameraStream(
                    time=stamps,
                    position=np.asarray(frame) + sigma * random.normal(size=(len(stamps), 5)),
                ),
                knock=Knock(start=0.3, duration=0.03) if force else None,
            )
        )
    turned = _bare(truth.robot, jnp.asarray(np.where(time[:-1] >= 0.1, MOTOR_VOLTAGE, 0.0)))
    shifted = np.asarray(turned) + random.uniform(0, count, 2)
    both = np.repeat(np.where(time >= 0.1, MOTOR_VOLTAGE, 0.0)[:, None], 2, axis=1)
    runs.append(
        Run(
            name="0004-motor-step",
            kind="motor_step",
            pretension=350.0,
            pretension_label=SETTING,
            drive=DriveStream(time=time, voltage=both, angle=_rounded(shifted, count)),
        )
    )
    known = {"effective_radius": float(value(truth.robot, "effective_radius"))}
    return Campaign(
        name=f"drawn robot {seed}",
        runs=tuple(runs),
        counts_per_rev=COUNTS_PER_REV,
        robot=known,
        sensors=sensors,
    )


def _rounded(angle: Array | np.ndarray, count: float) -> Float[np.ndarray, "rows 2"]:
    return np.round(np.asarray(angle) / count) * count


@eqx.filter_jit
def simulated(
    robot: Robot,
    start: Float[Array, "3"],
    voltage: Float[Array, "intervals 2"],
    knock: Float[Array, " intervals"],
    stamps: Float[Array, " frames"],
    *,
    period: float = PERIOD,
    substeps: int = SUBSTEPS,
) -> tuple[Float[Array, "rows 2"], Float[Array, "frames 5"]]:
    """What encoders and camera would see of a run without noise.

    Args:
        robot: The robot.
        start: Lower carriage, upper carriage and height at rest [m].
        voltage: Commands through each sample period [V].
        knock: Force on the end-effector through each sample period [N].
        stamps: The camera's, on the drives' clock [s].
        period: Sample period of the log [s].
        substeps: Steps of the rig in it.

    Returns:
        Angles at the log's rows [rad] and positions at the camera's stamps [m, rad].
    """
    begun = rest(robot, *start)
    step = period / substeps
    fine = Inputs(
        jnp.full(voltage.shape[0] * substeps, step),
        jnp.repeat(voltage, substeps, axis=0),
        jnp.repeat(knock, substeps),
    )
    states = simulate(robot, begun, fine)
    rows = jax.tree.map(lambda leaf: leaf[::substeps], states)
    angle = jax.vmap(lambda state: pulley_angles(robot, state, begun))(rows)
    interval = (stamps / step).astype(int)
    frame = interpolate(
        states, fine, interval=interval, fraction=stamps / step - interval.astype(float)
    )
    return angle, frame


@jax.jit
def _bare(robot: Robot, voltage: Float[Array, " intervals"]) -> Float[Array, "rows 2"]:
    drive, steps = robot.drive, jnp.full(voltage.shape, PERIOD)
    torque, start = motor_torque(drive, voltage), jnp.zeros(())

    def turned(friction: Float[Array, ""]) -> Float[Array, " rows"]:
        axis = AxisParameters(drive.inertia, drive.damping, friction, 0.0)
        return axis_positions(axis, torque, steps=steps, start=start)

    return jax.vmap(turned, out_axes=1)(drive.frictions)


class Outcome(NamedTuple):
    """How one campaign went."""

    seed: int
    """Its seed."""
    ended: str
    """How the fit ended."""
    truth: dict[str, float]
    """True values [SI]."""
    error: dict[str, float]
    """Estimate over truth, minus 1 [1]."""
    deviation: dict[str, float]
    """Error in standard errors [1]."""
    covered: dict[str, bool]
    """Whether the 95 % interval holds the truth."""

    @property
    def right(self) -> bool:
        """Whether it ended in the right minimum: within 2 % of the true pretension."""
        return abs(self.error["effective_pretension"]) < 0.02


def recovered(seed: int) -> Outcome:
    """A drawn robot, estimated from default starts.

    Args:
        seed: Its seed.

    Returns:
        How it went.
    """
    truth = draw(seed)
    found = estimate(campaign(truth, seed))
    estimated = {p.name: p for p in found.parameters if p.name in DRAWN}
    true = truth.values
    return Outcome(
        seed,
        found.fit.ended,
        true,
        {n: p.value / true[n] - 1 for n, p in estimated.items()},
        {n: (p.value - true[n]) / p.sigma for n, p in estimated.items()},
        {n: p.interval95[0] <= true[n] <= p.interval95[1] for n, p in estimated.items()},
    )
