"""What smoothed friction does to what is identified: bias of a fit, its gradient, its cost.

The truth is the exact engine's: both drives pull for half a second, then the robot coasts
until both carriages are held, from Table 2's poses with its first torques. A camera without
noise sees it. The robot with smoothed friction is fitted to that, so that what is left is
the smoothing's bias alone.
"""

import functools
from collections.abc import Callable
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from experiments.paper.topics.open_loop.numbers import POSES, TORQUES
from scdpr_jax.command.sensors import Camera
from scdpr_jax.engines.adaptive import smooth_sensitivities
from scdpr_jax.engines.stepping import Inputs, simulate
from scdpr_jax.numerics.levenberg_marquardt import Stopping, minimise
from scdpr_jax.numerics.merit import SumOfSquares
from scdpr_jax.robot.parameters import SMOOTHING_WIDTH, Robot, smoothed
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace, value
from scdpr_jax.robot.state import State, rest

UNKNOWNS = ("friction_coefficient", "effective_pretension", "drive_inertia", "drive_damping")
"""What is fitted; the derivative that is looked at is the first one's."""

SYMBOLS = ("μ", "T", "J", "b")
"""Their symbols."""

_DEFAULT = 3
WIDTHS = tuple((SMOOTHING_WIDTH * 10 ** ((np.arange(10) - _DEFAULT) / 3)).tolist())
"""Widths of the smoothed friction, three a decade, with the default among them [m/s]."""

WANTED = 1e-3
"""Relative error of the friction coefficient that a fit on good logs is to reach [1]."""

AT_TRUTH = np.zeros(len(UNKNOWNS))
"""Logarithms of the unknowns over the truth, there."""

BEGIN = (2.0, 0.8, 1.25, 0.8)
"""Where fits begin, over the truth [1]."""

STEPS = (1e-3, 5e-3)
"""Steps of the exact engine [s]: of the truth, and as long as the adaptive solver's accuracy
needs."""

_FRAME = 1e-2
_SIDEWAYS = np.array([0, 2, 3])
_DIFFERENCE = 1e-4


class Pulls(NamedTuple):
    """Runs in which both drives pull alike, then nothing."""

    pose: Float[np.ndarray, "runs 2"]
    """Where the end-effector starts, the carriages above and below it [m]."""
    voltage: Float[np.ndarray, " runs"]
    """Commands to both drives [V]."""
    pulled: float
    """How long they pull [s]."""
    length: float
    """How long a run is [s]."""

    @property
    def frames(self) -> Float[np.ndarray, " frames"]:
        """When the camera looks [s]."""
        return _FRAME * np.arange(round(self.length / _FRAME) + 1)


def pulls() -> Pulls:
    """Table 2's poses and first torques, half as long: none of the runs meets the frame.

    Returns:
        The four runs.
    """
    torque = np.array(TORQUES)[:, 0]
    voltage = torque / float(consistent().drive.torque_per_volt)
    return Pulls(np.array(POSES), voltage, pulled=0.5, length=1.25)


class Motion(NamedTuple):
    """What a model says of some runs at the camera's frames."""

    position: Float[np.ndarray, "runs frames 5"]
    r"""$[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m]."""
    derivative: Float[np.ndarray, "runs frames 5 unknowns"]
    """Derivatives by the unknowns' logarithms [m, rad, m, m, m]."""
    steps: float
    """Steps that a run took, on average."""


Model = Callable[[Float[np.ndarray, " unknowns"]], Motion]
"""From the unknowns' logarithms, 0 at the truth, to the motion."""


def exact_model(runs: Pulls, *, step: float) -> Model:
    """The engine with exact friction.

    Args:
        runs: The runs.
        step: Length of its steps, a whole part of the camera's period [s].

    Returns:
        The model.
    """

    def motion(logs: Float[np.ndarray, " unknowns"]) -> Motion:
        position, derivative = map(np.asarray, _exact(runs, jnp.asarray(logs), step))
        return Motion(position, derivative, runs.length / step)

    return motion


def smooth_model(runs: Pulls, *, width: float) -> Model:
    """The adaptive solver with smoothed friction.

    Args:
        runs: The runs.
        width: Velocity over which the friction turns round [m/s].

    Returns:
        The model.
    """
    robot = smoothed(consistent(), width=width)

    def motion(logs: Float[np.ndarray, " unknowns"]) -> Motion:
        position, derivative, steps = map(np.asarray, _smooth(robot, runs, jnp.asarray(logs)))
        return Motion(position, np.moveaxis(derivative, 2, -1), float(steps.mean()))

    return motion


def bias(
    model: Model, seen: Float[np.ndarray, "runs frames 5"]
) -> Float[np.ndarray, " unknowns"]:
    """By how much a model's fit to the true motion misses the true unknowns.

    Args:
        model: What is fitted.
        seen: The true positions [m, rad, m, m, m].

    Returns:
        Estimates over the truth, minus one [1]; NaN if the fit doesn't converge.
    """
    camera = Camera()
    sigma = np.full(5, float(camera.position_sigma))
    sigma[1] = float(camera.angle_sigma)

    def evaluate(logs: Float[np.ndarray, " unknowns"]) -> SumOfSquares:
        motion = model(logs)
        residual = ((motion.position - seen) / sigma).ravel()
        jacobian = (motion.derivative / sigma[:, None]).reshape(-1, len(UNKNOWNS))
        return SumOfSquares(residual, jacobian)

    minimum = minimise(
        evaluate,
        np.log(BEGIN),
        # A ten-thousandth of the noise that the camera would have in one frame.
        stopping=Stopping(evaluations=50, decrement=1e-8),
    )
    return (
        np.expm1(minimum.point)
        if minimum.ended == "converged"
        else np.full_like(AT_TRUTH, np.nan)
    )


def gradient_error(motion: Motion, truth: Motion, *, frame: int) -> float:
    """Error of the derivative of where the robot is by the logarithm of μ.

    Args:
        motion: What a model says at the truth.
        truth: What the exact engine says.
        frame: Which of the camera's frames.

    Returns:
        Over all runs, end-effector and both carriages, sideways: size of the error over
        that of the derivative [1].
    """
    ours, true = (part.derivative[:, frame, _SIDEWAYS, 0] for part in (motion, truth))
    return float(np.linalg.norm(ours - true) / np.linalg.norm(true))


def difference_error(model: Model) -> float:
    """Largest error of a model's derivatives at the truth against central differences.

    Args:
        model: The model.

    Returns:
        The error over the largest derivative by the same unknown [1].
    """
    shifts = _DIFFERENCE * np.eye(len(UNKNOWNS))
    differences = np.stack(
        [(model(s).position - model(-s).position) / (2 * _DIFFERENCE) for s in shifts], axis=-1
    )
    derivative = model(AT_TRUTH).derivative
    error, largest = (
        np.abs(part).max(axis=(0, 1, 2)) for part in (differences - derivative, derivative)
    )
    return float((error / largest).max())


class Errors(NamedTuple):
    """What a model makes of the true runs."""

    bias: Float[np.ndarray, " unknowns"]
    """Estimates over the truth, minus one [1]."""
    sliding: float
    """Error of the derivative by μ as the drives stop pulling [1]."""
    held: float
    """The same at the end of the runs, where friction holds both carriages [1]."""
    steps: float
    """Steps of a run with its derivatives."""


def errors(model: Model, truth: Motion, runs: Pulls) -> Errors:
    """A model against the truth.

    Args:
        model: The model.
        truth: The true motion.
        runs: The runs.

    Returns:
        Its errors.
    """
    motion = model(AT_TRUTH)
    let_go = round(runs.pulled / _FRAME)
    return Errors(
        bias(model, truth.position),
        gradient_error(motion, truth, frame=let_go),
        gradient_error(motion, truth, frame=-1),
        motion.steps,
    )


class Smoothing(NamedTuple):
    """What smoothing costs."""

    by_width: tuple[Errors, ...]
    """Smoothed friction, for each of `WIDTHS`."""
    exact: tuple[Errors, ...]
    """Exact friction, for each of `STEPS`."""
    difference: float
    """Error of the exact engine's derivatives against central differences [1]."""

    @property
    def bias(self) -> Float[np.ndarray, "widths unknowns"]:
        """Estimates with smoothed friction over the truth, minus one [1]."""
        return np.stack([one.bias for one in self.by_width])

    @property
    def default(self) -> Errors:
        """Smoothed friction of the default width."""
        return self.by_width[_DEFAULT]

    @property
    def order(self) -> float:
        """Power of the width that the bias of μ goes with, up to the default width [1]."""
        narrow = slice(_DEFAULT + 1)
        biases = np.log(np.abs(self.bias[narrow, 0]))
        return float(np.polyfit(np.log(WIDTHS[narrow]), biases, 1)[0])

    @property
    def width_for_wanted(self) -> float:
        """Width at which μ is biased by what is just wanted [m/s]."""
        biases = np.log(np.abs(self.bias[:, 0]))
        return float(np.exp(np.interp(np.log(WANTED), biases, np.log(WIDTHS))))


@functools.cache
def smoothing() -> Smoothing:
    """Smoothed friction of every width, and exact friction, against the truth.

    Returns:
        Their errors.
    """
    runs = pulls()
    exact = [exact_model(runs, step=step) for step in STEPS]
    truth = exact[0](AT_TRUTH)
    smooth = [smooth_model(runs, width=width) for width in WIDTHS]
    return Smoothing(
        tuple(errors(model, truth, runs) for model in smooth),
        tuple(errors(model, truth, runs) for model in exact),
        difference_error(exact[0]),
    )


def _robot_of(robot: Robot, logs: Float[Array, " unknowns"]) -> Robot:
    """A robot whose unknowns are the prototype's, times the logarithms' exponentials."""
    nominal = jnp.stack([value(consistent(), name) for name in UNKNOWNS])
    return replace(robot, dict(zip(UNKNOWNS, nominal * jnp.exp(logs), strict=True)))


def _start(pose: Float[Array, "2"]) -> State:
    return rest(consistent(), pose[0], pose[0], pose[1])


@eqx.filter_jit
def _exact(
    runs: Pulls, logs: Float[Array, " unknowns"], step: float
) -> tuple[Float[Array, "runs frames 5"], Float[Array, "runs frames 5 unknowns"]]:
    count = round(runs.length / step)
    pulling = (jnp.arange(count) < round(runs.pulled / step))[:, None]

    def positions(
        logs: Float[Array, " unknowns"], pose: Float[Array, "2"], volts: Float[Array, ""]
    ) -> tuple[Float[Array, "frames 5"], Float[Array, "frames 5"]]:
        command = jnp.where(pulling, volts, jnp.zeros((count, 2)))
        inputs = Inputs(jnp.full(count, step), command, jnp.zeros(count))
        states = simulate(_robot_of(consistent(), logs), _start(pose), inputs)
        seen = states.position[:: round(_FRAME / step)]
        return seen, seen

    def run(
        pose: Float[Array, "2"], volts: Float[Array, ""]
    ) -> tuple[Float[Array, "frames 5"], Float[Array, "frames 5 unknowns"]]:
        derivative, position = jax.jacfwd(positions, has_aux=True)(logs, pose, volts)
        return position, derivative

    return jax.vmap(run)(jnp.asarray(runs.pose), jnp.asarray(runs.voltage))


@eqx.filter_jit
def _smooth(
    robot: Robot, runs: Pulls, logs: Float[Array, " unknowns"]
) -> tuple[
    Float[Array, "runs frames 5"], Float[Array, "runs frames unknowns 5"], Int[Array, " runs"]
]:
    def run(
        pose: Float[Array, "2"], volts: Float[Array, ""]
    ) -> tuple[Float[Array, "frames 5"], Float[Array, "frames unknowns 5"], Int[Array, ""]]:
        run = smooth_sensitivities(
            lambda unknowns: _robot_of(robot, unknowns),
            _start(pose),
            unknowns=logs,
            voltage=volts * jnp.array([[1.0, 1.0], [0.0, 0.0]]),
            times=jnp.array([0.0, runs.pulled, runs.length]),
            save_at=jnp.asarray(runs.frames),
        )
        return run.states.position, run.derivatives.position, run.steps

    return jax.vmap(run)(jnp.asarray(runs.pose), jnp.asarray(runs.voltage))
