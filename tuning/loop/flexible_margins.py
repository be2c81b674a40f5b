r"""Margins of the flexible robot's joint loops over its workspace, as the controller samples.

The horizontal position doesn't matter, so that the workspace is heights by pretensions.
"""

import functools

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Complex, Float, Int

from scdpr_jax.command.controller import PD
from scdpr_jax.native import kept_jit
from scdpr_jax.robot.drive import drive_gain, drive_pole
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from tuning.loop.flexible_loop import (
    Motion,
    PlantOfPoles,
    closed_loop_matrix,
    flexible_loop,
    flexible_plant,
    motions,
    resonances,
)
from tuning.loop.margins import (
    Margins,
    Response,
    crossover_scale,
    peak_sensitivity,
    root,
    with_nyquist,
)
from tuning.loop.plant import MotorPlant

_EVEN_POINTS = 256
"""Grid points that lie evenly over the logarithm of the frequency."""
_DECADES = 3.0
"""Decades scanned below the bare drive's crossover."""
_NEAR = tuple(10 ** -(power / 2) for power in range(1, 14))
"""Relative distances of grid points from a resonance: damping ratios down to 1e-6 show."""


class FlexibleMargins(eqx.Module):
    """How far a joint loop of the flexible robot is from instability."""

    margins: Margins
    r"""The least margins over all crossings; not numbers in an unstable loop. The phase
    margin is the angle to $-1$ in either direction, the delay margin the least of all
    crossings' lag over frequency."""
    spectral_radius: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("1", r"\rho"))
    r"""Largest modulus of the closed loop's poles $\rho$ [1]; the loop is stable below 1."""


def flexible_margins(
    robot: Robot, height: Float[Array, ""], controller: PD, *, motion: Motion, delay: int = 1
) -> FlexibleMargins:
    r"""Margins of a joint loop at an aligned pose: hold, PD and computing time as they run.

    Poles of the closed loop decide whether it is stable. The
    frequencies are searched between the grid's points, which crowd around every resonance of
    the plant and every pole of the closed loop.

    Args:
        robot: The robot; of its friction laws only the viscous part counts.
        height: Height $y_e$ of the end-effector [m].
        controller: The controller of both drives.
        motion: What moves.
        delay: Samples from a measurement to its command.

    Returns:
        The margins.

    Raises:
        ValueError: If the delay is negative.
    """
    if delay < 0:
        raise ValueError(
            f"`delay` must not be negative [samples], got {delay}: a command that is out "
            "before the next sample has 0, one that waits for it has 1."
        )
    plant = flexible_plant(robot, height, motion, period=controller.period)
    poles = jnp.linalg.eigvals(closed_loop_matrix(plant, controller, delay=delay))
    radius = jnp.max(jnp.abs(poles))
    special = jnp.concatenate(
        [resonances(robot, height), jnp.abs(jnp.angle(poles)) / controller.period]
    )
    response = Response(functools.partial(flexible_loop, delay=delay), plant, controller)
    gain = controller.proportional_gain + controller.derivative_gain / controller.period
    still = Response(response.loop, PlantOfPoles.of(plant, gain), controller)
    grid = _grid(robot, controller, special)
    # |L| = 1 and Im L = 0 are polynomials in cos(omega h) of no higher degree.
    most = plant.input.size + delay + 2
    margins = _least_margins(response, jax.lax.stop_gradient(still), grid, most=most)
    stable = radius < 1
    return FlexibleMargins(
        margins=jax.tree.map(lambda leaf: jnp.where(stable, leaf, jnp.nan), margins),
        spectral_radius=radius,
    )


def margins_over_workspace(
    robots: Robot,
    heights: Float[Array | np.ndarray, " heights"],
    controller: PD,
    *,
    delay: int = 1,
) -> FlexibleMargins:
    """Margins of every joint loop at every height of every robot.

    Args:
        robots: Robots, stacked leaf by leaf, such as one for each pretension.
        heights: Heights of the end-effector [m].
        controller: The controller of both drives.
        delay: Samples from a measurement to its command.

    Returns:
        Margins by loop (those of `JOINT_LOOPS`), robot and height, as NumPy arrays.
    """
    # The last height again where some are missing: one compiled function serves any number.
    count = len(heights)
    rows = np.minimum(np.arange(count + -count % _HEIGHTS), count - 1).reshape(-1, _HEIGHTS)
    height = np.asarray(heights)

    def of_robot(number: int) -> list[Float[np.ndarray, "loops heights"]]:
        robot = jax.tree.map(lambda leaf: np.asarray(leaf)[number], robots)
        parts = [_at_heights(robot, height[few], controller, delay) for few in rows]
        return [np.concatenate(leaf, axis=-1)[:, :count] for leaf in zip(*parts, strict=True)]

    each = map(of_robot, range(len(jax.tree.leaves(robots)[0])))
    *margins, radius = (np.stack(leaf, axis=1) for leaf in zip(*each, strict=True))
    return FlexibleMargins(Margins(*margins), radius)


def compile_margins(robot: Robot, controller: PD, *, delay: int = 1) -> None:
    """Compiles what `margins_over_workspace` needs.

    Args:
        robot: Any robot.
        controller: Any controller.
        delay: Samples from a measurement to its command.
    """
    _at_heights.compile(robot, np.zeros(_HEIGHTS), controller, delay)


_HEIGHTS = 3
"""Heights that are looked at in one call: what a search looks at."""


@kept_jit
def _at_heights(
    robot: Robot, heights: Float[Array, " heights"], controller: PD, delay: int
) -> list[Float[Array, "loops heights"]]:
    """The fields of `FlexibleMargins`, those of `Margins` first."""

    def of_height(height: Float[Array, ""]) -> FlexibleMargins:
        def at(motion: Motion) -> FlexibleMargins:
            return flexible_margins(robot, height, controller, motion=motion, delay=delay)

        return jax.vmap(at)(motions())

    # Height by height, as all responses at once take gigabytes.
    margins = jax.tree.leaves(jax.lax.map(of_height, heights))
    return [jnp.moveaxis(leaf, 0, -1) for leaf in margins]


def _grid(robot: Robot, controller: PD, special: Float[Array, " k"]) -> Float[Array, " points"]:
    nyquist = jnp.pi / controller.period
    drive = MotorPlant(gain=drive_gain(robot.drive), pole=drive_pole(robot.drive))
    lowest = 10**-_DECADES * jnp.minimum(crossover_scale(drive, controller), nyquist)
    share = jnp.linspace(0.0, 1.0, _EVEN_POINTS, dtype=lowest.dtype)
    even = lowest * (nyquist / lowest) ** share
    near = jnp.asarray(_NEAR, special.dtype)
    around = jnp.outer(special, jnp.concatenate([1 / (1 + near), 1 + near]))
    return jnp.sort(jnp.concatenate([even, jnp.clip(around.ravel(), lowest, nyquist)]))


def _least_margins(
    response: Response, still: Response, grid: Float[Array, " points"], *, most: int
) -> Margins:
    values = jax.vmap(still)(jax.lax.stop_gradient(grid))
    of_gain = jnp.arange(2 * most) < most
    marks = (_gain_crosses(values), _phase_crosses(values))
    index, crosses = map(
        jnp.concatenate, zip(*(_first(mark, most=most) for mark in marks), strict=True)
    )
    at = jax.vmap(functools.partial(_crossing, response, still))(
        of_gain, grid[index], grid[index + 1]
    )
    there = jax.vmap(response)(at)

    lags = jnp.where(crosses & of_gain, jnp.angle(-there), jnp.nan)
    narrowest = _least(jnp.abs(lags))
    gains = jnp.where(crosses & ~of_gain, 1 / jnp.abs(there), jnp.inf)
    nearest = _least(jnp.abs(jnp.log(gains)))
    phase_crossover, gain_margin = with_nyquist(
        response,
        grid[-1],
        jnp.where(jnp.isinf(gains[nearest]), jnp.nan, at[nearest]),
        gains[nearest],
    )
    return Margins(
        gain_crossover=jnp.where(jnp.isnan(lags[narrowest]), jnp.nan, at[narrowest]),
        phase_margin=jnp.abs(lags[narrowest]),
        delay_margin=jnp.nanmin(jnp.mod(lags, 2 * jnp.pi) / at),
        phase_crossover=phase_crossover,
        gain_margin=gain_margin,
        peak_sensitivity=peak_sensitivity(response, grid, values, still=still),
    )


def _least(values: Float[Array, " n"]) -> Int[Array, ""]:
    return jnp.argmin(jnp.where(jnp.isnan(values), jnp.inf, values))


def _gain_crosses(values: Complex[Array, " points"]) -> Bool[Array, " points-1"]:
    above = jnp.abs(values) > 1
    return above[:-1] != above[1:]


def _phase_crosses(values: Complex[Array, " points"]) -> Bool[Array, " points-1"]:
    negative, above = jnp.real(values) < 0, jnp.imag(values) > 0
    return (above[:-1] != above[1:]) & negative[:-1] & negative[1:]


def _first(
    marks: Bool[Array, " n"], *, most: int
) -> tuple[Int[Array, " most"], Bool[Array, " most"]]:
    """Indices of the first `most` marks, and which of them there are."""
    (index,) = jnp.nonzero(marks, size=most, fill_value=0)
    return index, jnp.arange(most) < jnp.sum(marks)


def _crossing(
    response: Response,
    still: Response,
    of_gain: Bool[Array, ""],
    low: Float[Array, ""],
    high: Float[Array, ""],
) -> Float[Array, ""]:
    """Where the gain is one or the phase half a turn; one search, so that it compiles once."""

    def measure(response: Response, angular_frequency: Float[Array, ""]) -> Float[Array, ""]:
        value = response(angular_frequency)
        return jnp.where(of_gain, jnp.log(jnp.abs(value)), jnp.angle(-value))

    return root(measure, response, low, high, still=still)
