r"""What a leg under control is judged by, differentiable.

Two of the measures are no plain reading of a trace. The end-effector has no friction and next
to no damping, so where it is at the run's last sample is a matter of phase: where it *rests*
is the point at its height on the line between the carriages, which friction holds. The
resting error is that point's distance from the target, here and everywhere. And a peak to
peak hangs on two samples, whose derivative says little of the others: a search by gradient
takes the mean of eighth order instead.
"""

import equinox as eqx
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Float, Int

from scdpr_jax.engines.closed_loop import ClosedLoop
from scdpr_jax.legs.command_law import Commands
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import rest

SETTLED = 5e-3
"""Distance from the target within which a leg has settled [m]."""
_POWER = 8
"""Order of the mean that stands for a maximum: 16 % below a sinusoid's amplitude."""


class LegMeasures(eqx.Module):
    """What a leg comes to, in numbers."""

    residual_vibration: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("m"))
    """Peak to peak of $x_e$ once the commanded reference has ended [m]."""
    smooth_vibration: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("m"))
    """Its smooth surrogate [m], see `smooth_peak_to_peak`."""
    resting_error: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("m"))
    """Distance from the last commanded position to where the end-effector rests, on the line
    between the carriages as they are at the last judged sample [m]."""
    largest_error: Float[Array | np.ndarray, "..."] = eqx.field(
        metadata=si("m", r"\varepsilon_e")
    )
    """Largest error against the commanded (shaped) reference, Eq. (26) [m]."""
    rms_error: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("m", r"\varepsilon_e"))
    """Root mean square of it before the judged samples of rest [m]."""
    largest_original_error: Float[Array | np.ndarray, "..."] = eqx.field(
        metadata=si("m", r"\varepsilon_e")
    )
    """Largest error against the reference before shaping, Eq. (26) [m]."""
    largest_tilt: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("rad", r"\delta_e"))
    """Largest rotation of the end-effector of either sign [rad]."""
    settling_time: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("s"))
    """When the end-effector stays within `SETTLED` of the last commanded position [s]; NaN if
    it never does."""
    largest_voltage: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("V", "V"))
    """Largest command of either drive [V]."""
    saturation: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("1"))
    """Share of the samples at which a drive is saturated [1]."""


def measure(robot: Robot, run: ClosedLoop, commands: Commands) -> LegMeasures:
    """Measures of a run under commands.

    Args:
        robot: The robot.
        run: Its run.
        commands: What it was told; some sample of it is judged as rest.

    Returns:
        The measures.
    """
    pose, commanded = run.states.pose, commands.commanded
    error = tracking_error(pose, commanded)
    after = commands.afterwards.astype(error.dtype)
    before = 1 - after
    size = jnp.abs(run.voltage)
    saturated = jnp.any(size >= robot.drive.voltage_limit, axis=1).astype(error.dtype)
    target = commanded[-1]
    return LegMeasures(
        residual_vibration=peak_to_peak(pose[:, 0], after),
        smooth_vibration=smooth_peak_to_peak(pose[:, 0], after),
        resting_error=_resting_error(robot, run, target, _last(commands.afterwards)),
        largest_error=jnp.max(error),
        rms_error=jnp.sqrt(jnp.sum(before * jnp.square(error)) / jnp.sum(before)),
        largest_original_error=jnp.max(tracking_error(pose, commands.reference)),
        largest_tilt=jnp.max(jnp.abs(run.states.tilt)),
        settling_time=_settling_time(run.time, tracking_error(pose, target[None])),
        largest_voltage=jnp.max(size),
        saturation=jnp.mean(saturated),
    )


def tracking_error(
    position: Float[Array, "samples 2"], reference: Float[Array, "#samples 2"]
) -> Float[Array, " samples"]:
    r"""Distance of the end-effector from its reference, Eq. (26).

    $$ \varepsilon_e = \sqrt{(x_e^* - x_e)^2 + (y_e^* - y_e)^2} $$

    Where the error vanishes, the root has a kink and its derivative is taken as 0.

    Args:
        position: Positions [m].
        reference: References [m], one for each position or one for all.

    Returns:
        Errors [m].
    """
    square = jnp.sum(jnp.square(reference - position), axis=1)
    vanished = square == 0
    return jnp.where(vanished, 0.0, jnp.sqrt(jnp.where(vanished, 1.0, square)))


def peak_to_peak(
    signal: Float[Array, " samples"], window: Float[Array, " samples"]
) -> Float[Array, ""]:
    """Largest less smallest value of a signal within a window.

    Args:
        signal: The signal [any unit].
        window: 1 where it counts, else 0 [1]; somewhere 1.

    Returns:
        Peak to peak [the signal's unit].
    """
    inside = window > 0
    return jnp.max(jnp.where(inside, signal, -jnp.inf)) - jnp.min(
        jnp.where(inside, signal, jnp.inf)
    )


def smooth_peak_to_peak(
    signal: Float[Array, " samples"], window: Float[Array, " samples"]
) -> Float[Array, ""]:
    r"""Smooth surrogate of `peak_to_peak`, by every sample and not by two.

    $$ 2 \left(\frac{\sum_k w_k (s_k - \bar s)^8}{\sum_k w_k}\right)^{1/8} $$

    For a signal that doesn't move it is 0, and its derivative is taken as 0 there.

    Args:
        signal: The signal [any unit].
        window: Weight of each sample [1], somewhere above 0.

    Returns:
        Twice the mean of eighth order about the mean [the signal's unit].
    """
    total = jnp.sum(window)
    away = jnp.abs(signal - jnp.sum(window * signal) / total)
    distance = jnp.where(window > 0, away, 0.0)
    scale = jnp.max(distance)
    still = scale == 0
    # Scaled, so that the eighth power of a micrometre isn't lost.
    share = distance / jnp.where(still, 1.0, scale)
    mean = jnp.sum(window * share**_POWER) / total
    return jnp.where(still, 0.0, 2 * scale * jnp.where(still, 1.0, mean) ** (1 / _POWER))


def _last(afterwards: Bool[Array, " samples"]) -> Int[Array, ""]:
    """Number of the last judged sample."""
    return afterwards.shape[0] - 1 - jnp.argmax(afterwards[::-1])


def _resting_error(
    robot: Robot, run: ClosedLoop, target: Float[Array, "2"], sample: Int[Array, ""]
) -> Float[Array, ""]:
    _, _, lower, upper, height = jnp.unstack(run.states.position[sample])
    place = rest(robot, lower, upper, height).position
    return jnp.hypot(place[0] - target[0], height - target[1])


def _settling_time(
    time: Float[Array, " samples"], distance: Float[Array, " samples"]
) -> Float[Array, ""]:
    unsettled = distance > SETTLED
    first = time.shape[0] - jnp.argmax(unsettled[::-1])
    first = jnp.where(jnp.any(unsettled), first, 0)
    never = first == time.shape[0]
    return jnp.where(never, jnp.nan, time[jnp.where(never, 0, first)])
