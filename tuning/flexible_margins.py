r"""Margins of the flexible robot's joint loops over its workspace, as the controller samples.

The horizontal position doesn't matter, so that the workspace is heights by pretensions.
"""

import functools
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Complex, Float

from scdpr_jax.controller import PD
from scdpr_jax.drive import drive_gain, drive_pole
from scdpr_jax.fields import si
from scdpr_jax.parameters import Robot
from tuning.flexible_loop import (
    FlexiblePlant,
    JointLoop,
    closed_loop_matrix,
    flexible_loop,
    flexible_plant,
    resonances,
)
from tuning.margins import (
    Margins,
    Measure,
    Response,
    crossover_scale,
    log_gain,
    peak_sensitivity,
    phase_over_half_turn,
    root,
    with_nyquist,
)
from tuning.plant import MotorPlant

_EVEN_POINTS = 256
"""Grid points that lie evenly over the logarithm of the frequency."""
_DECADES = 3.0
"""Decades scanned below the bare drive's crossover."""
_NEAR = 10.0 ** -jnp.arange(0.5, 6.6, 0.5)
"""Relative distances of grid points from a resonance: damping ratios down to 1e-6 show."""


class FlexibleMargins(eqx.Module):
    """How far a joint loop of the flexible robot is from instability."""

    margins: Margins
    r"""The least margins over all crossings; not numbers in an unstable loop. The phase
    margin is the angle to $-1$ in either direction, the delay margin the least of all
    crossings' lag over frequency."""
    spectral_radius: Float[Array, "..."] = eqx.field(metadata=si("1", r"\rho"))
    r"""Largest modulus of the closed loop's poles $\rho$ [1]; the loop is stable below 1."""


def flexible_margins(
    robot: Robot, height: Float[Array, ""], controller: PD, *, loop: JointLoop, delay: int = 1
) -> FlexibleMargins:
    r"""Margins of a joint loop at an aligned pose: hold, PD and computing time as they run.

    Whether the loop is stable is decided by the poles of its closed form in $z$. The
    frequencies are searched between the grid's points, which crowd around every resonance of
    the plant and every pole of the closed loop.

    Args:
        robot: The robot; of its friction laws only the viscous part counts.
        height: Height $y_e$ of the end-effector [m].
        controller: The controller of both drives.
        loop: Which loop.
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
    plant = flexible_plant(robot, height, loop, period=controller.period)
    poles = jnp.linalg.eigvals(closed_loop_matrix(plant, controller, delay=delay))
    radius = jnp.max(jnp.abs(poles))
    special = jnp.concatenate(
        [resonances(robot, height, loop), jnp.abs(jnp.angle(poles)) / controller.period]
    )
    response = Response(functools.partial(flexible_loop, delay=delay), plant, controller)
    grid = _grid(robot, controller, special)
    # |L| = 1 and Im L = 0 are polynomials in cos(omega h) of no higher degree.
    found = _least_margins(response, grid, most=plant.input.size + delay + 2)
    stable = radius < 1
    return FlexibleMargins(
        margins=jax.tree.map(lambda leaf: jnp.where(stable, leaf, jnp.nan), found),
        spectral_radius=radius,
    )


@functools.partial(jax.jit, static_argnames=("loop", "delay"))
def margins_over_workspace(
    robots: Robot,
    heights: Float[Array, " heights"],
    controller: PD,
    *,
    loop: JointLoop,
    delay: int = 1,
) -> FlexibleMargins:
    """Margins of a joint loop at every height of every robot.

    Args:
        robots: Robots, stacked leaf by leaf, such as one for each pretension.
        heights: Heights of the end-effector [m].
        controller: The controller of both drives.
        loop: Which loop.
        delay: Samples from a measurement to its command.

    Returns:
        Margins with a row for each robot and a column for each height.
    """

    def at(robot: Robot, height: Float[Array, ""]) -> FlexibleMargins:
        return flexible_margins(robot, height, controller, loop=loop, delay=delay)

    return jax.vmap(jax.vmap(at, in_axes=(None, 0)), in_axes=(0, None))(robots, heights)


def _grid(
    robot: Robot, controller: PD, special: Float[Array, " k"]
) -> Float[Array, " points"]:
    nyquist = jnp.pi / controller.period
    drive = MotorPlant(gain=drive_gain(robot.drive), pole=drive_pole(robot.drive))
    lowest = 10**-_DECADES * jnp.minimum(crossover_scale(drive, controller), nyquist)
    share = jnp.linspace(0.0, 1.0, _EVEN_POINTS, dtype=lowest.dtype)
    even = lowest * (nyquist / lowest) ** share
    near = _NEAR.astype(special.dtype)
    around = special[:, None] * jnp.concatenate([1 / (1 + near), 1 + near])
    return jnp.sort(jnp.concatenate([even, jnp.clip(around.ravel(), lowest, nyquist)]))


def _least_margins(
    response: Response, grid: Float[Array, " points"], *, most: int
) -> Margins:
    values = jax.vmap(response)(grid)
    at_gain = _gain_crossovers(response, grid, values, most=most)
    lags = jax.vmap(functools.partial(phase_over_half_turn, response))(at_gain)
    narrowest = jnp.argmin(jnp.where(jnp.isnan(at_gain), jnp.inf, jnp.abs(lags)))
    delays = jnp.mod(lags, 2 * jnp.pi) / at_gain

    at_phase = _phase_crossovers(response, grid, values, most=most)
    gains = jnp.exp(-jax.vmap(functools.partial(log_gain, response))(at_phase))
    nearest = jnp.argmin(jnp.where(jnp.isnan(at_phase), jnp.inf, jnp.abs(jnp.log(gains))))
    phase_crossover, gain_margin = with_nyquist(
        response,
        grid[-1],
        at_phase[nearest],
        jnp.where(jnp.isnan(at_phase[nearest]), jnp.inf, gains[nearest]),
    )
    return Margins(
        gain_crossover=at_gain[narrowest],
        phase_margin=jnp.abs(lags[narrowest]),
        delay_margin=jnp.nanmin(delays),
        phase_crossover=phase_crossover,
        gain_margin=gain_margin,
        peak_sensitivity=peak_sensitivity(response, grid, values),
    )


def _gain_crossovers(
    response: Response,
    grid: Float[Array, " points"],
    values: Complex[Array, " points"],
    *,
    most: int,
) -> Float[Array, " most"]:
    above = jnp.abs(values) > 1
    return _roots(log_gain, response, grid, above[:-1] != above[1:], most=most)


def _phase_crossovers(
    response: Response,
    grid: Float[Array, " points"],
    values: Complex[Array, " points"],
    *,
    most: int,
) -> Float[Array, " most"]:
    negative = jnp.real(values) < 0
    above = jnp.imag(values) > 0
    crosses = (above[:-1] != above[1:]) & negative[:-1] & negative[1:]
    return _roots(phase_over_half_turn, response, grid, crosses, most=most)


def _roots(
    measure: Measure,
    response: Response,
    grid: Float[Array, " points"],
    crosses: Array,
    *,
    most: int,
) -> Float[Array, " most"]:
    """Frequencies of the crossings, NaN where there are fewer than `most`."""
    (index,) = jnp.nonzero(crosses, size=most, fill_value=0)
    found = jax.vmap(functools.partial(root, measure, response))(grid[index], grid[index + 1])
    return jnp.where(jnp.arange(most) < jnp.sum(crosses), found, jnp.nan)
