r"""Which experiment next: the voltages that sharpen what is known most, by gradient.

A pattern of voltages is a level for each motor in each of some equal segments: steps,
staircases and square waves all are. Fisher's information about the quantities' logarithms
follows from the simulated Jacobian, and a criterion of it is minimised over the levels, within
the voltage limit, the stroke and the speed.
"""

import dataclasses
from collections.abc import Callable, Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
import optax
from jaxtyping import Array, Float

from identification.campaign.types import Sensors
from identification.unknowns import DEFAULT_FREE
from scdpr_jax.closed_loop import pulley_angles
from scdpr_jax.dynamics import rest
from scdpr_jax.parameters import Robot, replace, value
from scdpr_jax.stepping import Inputs, simulate

STEP = 1e-2
"""Step of the simulation [s]."""

FRAMES = 3
"""Steps from one camera frame to the next: 33 frames a second."""

MARGIN = 0.1
"""How far the end-effector stays clear of the frame beyond its own size [m]."""

SOFTNESS = 0.01
"""Excursion beyond a limit that costs as much as a unit of the criterion [m, or m/s]."""

Criterion = Callable[[Float[Array, "n n"]], Float[Array, ""]]
"""What is minimised, of the information about the quantities' logarithms."""


def d_optimal(information: Float[Array, "n n"]) -> Float[Array, ""]:
    """Logarithm of the confidence ellipsoid's volume, up to a constant.

    Args:
        information: Fisher's information.

    Returns:
        The criterion [1].
    """
    return -jnp.linalg.slogdet(information)[1] / 2


def a_optimal(information: Float[Array, "n n"]) -> Float[Array, ""]:
    """Logarithm of the quantities' mean relative variance.

    Args:
        information: Fisher's information.

    Returns:
        The criterion [1].
    """
    return jnp.log(jnp.trace(jnp.linalg.inv(information))) / 2


def sharpest(index: int) -> Criterion:
    """The criterion that minds a single quantity: its standard error's logarithm.

    Args:
        index: Number of the quantity.

    Returns:
        The criterion.
    """
    return lambda information: jnp.log(jnp.linalg.inv(information)[index, index]) / 2


@dataclasses.dataclass(frozen=True, eq=False)
class Excitation:
    """A proposed experiment in open loop."""

    start: tuple[float, float]
    """Pose of the end-effector to start from at rest [m]."""
    segment: float
    """Length of a segment [s]."""
    voltage: Float[np.ndarray, "segments 2"]
    """Levels of the two motors [V]."""
    sigma: dict[str, float]
    """Relative standard error of each quantity from this run and what was known [1]."""
    begun: dict[str, float]
    """The same from the best of the patterns that the search began at [1]."""
    reach: tuple[float, float]
    """Least and greatest horizontal position of the end-effector [m]."""


def propose(
    robot: Robot,
    *,
    start: tuple[float, float],
    duration: float,
    names: Sequence[str] = DEFAULT_FREE,
    criterion: Criterion = d_optimal,
    known: Float[np.ndarray, "n n"] | None = None,
    sensors: Sensors = Sensors(),  # noqa: B008 - frozen
    segments: int = 8,
    top_speed: float = 1.5,
    iterations: int = 60,
) -> Excitation:
    """The voltages that tell most about some quantities in a given time.

    Reference: A. C. Atkinson, A. N. Donev, R. D. Tobias, "Optimum experimental designs, with
    SAS", Oxford 2007: the criteria.

    Args:
        robot: The robot as far as it is known, with exact friction.
        start: Pose of the end-effector to start from [m].
        duration: Length of the run [s].
        names: The quantities, which must be positive.
        criterion: `d_optimal`, `a_optimal` or `sharpest(index)`.
        known: Information from earlier runs, None for next to nothing.
        sensors: The sensors' noise.
        segments: Segments of constant voltage.
        top_speed: Largest speed of the end-effector [m/s].
        iterations: Steps of the search.

    Returns:
        The experiment, within voltage, stroke and speed.

    Raises:
        ValueError: If the duration is shorter than its segments' steps.
    """
    rows = round(duration / segments / STEP)
    if rows < 1:
        raise ValueError(
            f"`duration` must be {segments * STEP} s or more for {segments} segments, got "
            f"{duration} s. Take fewer segments or a longer run."
        )
    names = tuple(names)
    earlier = 1e-2 * np.eye(len(names)) if known is None else np.asarray(known)
    limit = float(value(robot, "voltage_limit"))
    levels = jnp.asarray(np.arctanh(0.98 * _patterns(segments)))
    pose = jnp.asarray(start)

    @eqx.filter_jit
    def judged(shape: Float[Array, "segments 2"]) -> tuple[Array, tuple[Array, Array, Array]]:
        voltage = limit * jnp.tanh(shape)
        information, path, speed = _information(
            robot, names, jnp.repeat(voltage, rows, axis=0), pose, sensors
        )
        total = information + earlier
        cost = criterion(total) + _beyond(robot, path, speed, top_speed)
        return cost, (total, path[:, 0], voltage)

    gradient = eqx.filter_jit(jax.vmap(jax.value_and_grad(judged, has_aux=True)))
    optimiser = optax.adam(0.1)
    state = optimiser.init(levels)
    best, begun = None, None
    for _ in range(iterations):
        (cost, told), slope = gradient(levels)
        cost = np.where(np.isfinite(cost), np.asarray(cost), np.inf)
        at = int(np.argmin(cost))
        found = (cost[at], *(np.asarray(part[at]) for part in told))
        begun = found if begun is None else begun
        best = found if best is None or found[0] < best[0] else best
        slope = jnp.where(jnp.isfinite(slope), slope, 0.0)
        change, state = optimiser.update(slope, state)
        levels = optax.apply_updates(levels, change)
    _, information, across, voltage = best
    return Excitation(
        start=start,
        segment=rows * STEP,
        voltage=voltage,
        sigma=_relative(names, information),
        begun=_relative(names, begun[1]),
        reach=(float(across.min()), float(across.max())),
    )


def _patterns(segments: int) -> Float[np.ndarray, "patterns segments 2"]:
    """Patterns to begin at, in shares of the limit: to and fro, up and down, staircases."""
    number = np.arange(segments)
    fro = np.where(number % 4 < 2, 0.5, -0.5)
    quick = np.where(number % 2 == 0, 0.6, -0.6)
    stairs = 0.8 * (number / max(segments - 1, 1) * 2 - 1)
    both = np.stack([fro, fro], axis=1)
    apart = np.stack([quick, -quick], axis=1) * 0.4
    return np.stack(
        [both, apart, both + apart, np.stack([quick, quick], 1), np.stack([stairs, -fro], 1)]
    )


def _information(
    robot: Robot,
    names: tuple[str, ...],
    voltage: Float[Array, "intervals 2"],
    pose: Float[Array, "2"],
    sensors: Sensors,
) -> tuple[Float[Array, "n n"], Float[Array, "rows 5"], Float[Array, "rows 5"]]:
    """Information about the logarithms of the quantities, with the path and its speeds."""
    count = voltage.shape[0]
    inputs = Inputs(jnp.full(count, STEP), voltage, jnp.zeros(count))
    values = jnp.stack([value(robot, name) for name in names])
    noise = jnp.array([sensors.camera_position_sigma] * 5)
    noise = noise.at[1].set(sensors.camera_angle_sigma)

    def measured(change: Float[Array, " n"]) -> tuple[Array, tuple[Array, Array]]:
        changed = replace(robot, dict(zip(names, values * jnp.exp(change), strict=True)))
        begun = rest(changed, pose[0], pose[0], pose[1])
        states = simulate(changed, begun, inputs)
        angle = jax.vmap(lambda state: pulley_angles(changed, state, begun))(states)
        frame = states.position[::FRAMES] / noise
        both = [angle.ravel() / sensors.encoder_sigma, frame.ravel()]
        return jnp.concatenate(both), (states.position, states.velocity)

    nothing = jnp.zeros(len(names))
    jacobian, (path, speed) = jax.jacfwd(measured, has_aux=True)(nothing)
    return jacobian.T @ jacobian, path, speed


def _beyond(
    robot: Robot, path: Float[Array, "rows 5"], speed: Float[Array, "rows 5"], top_speed: float
) -> Float[Array, ""]:
    """What excursions beyond stroke and speed cost."""
    body, frame = robot.end_effector, robot.frame
    low = jnp.stack([jnp.asarray(MARGIN), body.lower_offset + MARGIN])
    high = jnp.stack([frame.width - MARGIN, frame.height - body.upper_offset - MARGIN])
    place, rate = path[:, jnp.array([0, 4])], speed[:, jnp.array([0, 4])]
    out = jnp.maximum(low[None] - place, 0.0) + jnp.maximum(place - high[None], 0.0)
    fast = jnp.maximum(jnp.abs(rate) - top_speed, 0.0)
    return (jnp.max(out) + jnp.max(fast)) / SOFTNESS


def _relative(names: tuple[str, ...], information: np.ndarray) -> dict[str, float]:
    spread = np.sqrt(np.diag(np.linalg.inv(information)))
    return dict(zip(names, (float(one) for one in spread), strict=True))
