"""What a manoeuvre under control is judged by, differentiable."""

import equinox as eqx
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.engines.closed_loop import ClosedLoop
from scdpr_jax.robot.dynamics import rest
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot

_POWER = 8
"""Order of the mean that stands for a maximum: 16 % below a sinusoid's amplitude."""


class Scores(eqx.Module):
    """The metrics of a run as arrays; `tuning.result.types.Metrics` says what each is."""

    residual_vibration: Float[Array, "..."] = eqx.field(metadata=si("m"))
    """Peak to peak of $x_e$ once the commanded reference has ended [m]."""
    smooth_vibration: Float[Array, "..."] = eqx.field(metadata=si("m"))
    """Its smooth surrogate [m], see `smooth_peak_to_peak`."""
    resting_error: Float[Array, "..."] = eqx.field(metadata=si("m"))
    """Distance from the last commanded position to where it rests [m]."""
    largest_error: Float[Array, "..."] = eqx.field(metadata=si("m"))
    """Largest error against the commanded reference [m]."""
    rms_error: Float[Array, "..."] = eqx.field(metadata=si("m"))
    """Root mean square of it until the reference ends [m]."""
    largest_original_error: Float[Array, "..."] = eqx.field(metadata=si("m"))
    """Largest error against the reference before shaping [m]."""
    largest_voltage: Float[Array, "..."] = eqx.field(metadata=si("V"))
    """Largest command [V]."""
    saturation: Float[Array, "..."] = eqx.field(metadata=si("1"))
    """Share of the samples at which a drive is saturated [1]."""


def tracking_error(
    position: Float[Array, "samples 2"], reference: Float[Array, "samples 2"]
) -> Float[Array, " samples"]:
    r"""Distance of the end-effector from its reference, Eq. (26).

    $$ \varepsilon_e = \sqrt{(x_e^* - x_e)^2 + (y_e^* - y_e)^2} $$

    Where the error vanishes, the root has a kink and its derivative is taken as 0.

    Args:
        position: Positions [m].
        reference: References [m].

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


def score(
    robot: Robot,
    run: ClosedLoop,
    *,
    commanded: Float[Array, "samples 2"],
    reference: Float[Array, "samples 2"],
    end: Float[Array, ""],
) -> Scores:
    """Metrics of a run.

    The end-effector rests on the straight line between its carriages, `rest`: with no
    damping of its own it may swing about it for long.

    Args:
        robot: The robot.
        run: Its run under control.
        commanded: Reference that the controller was given [m].
        reference: The same before shaping [m].
        end: When the commanded reference ends [s], before the run's last sample.

    Returns:
        The metrics.
    """
    position = run.states.position
    pose = jnp.stack([position[:, 0], position[:, 4]], axis=1)
    error = tracking_error(pose, commanded)
    after = (run.time >= end).astype(error.dtype)
    last = position[-1]
    rested = rest(robot, last[2], last[3], last[4]).position
    resting = jnp.hypot(rested[0] - commanded[-1, 0], last[4] - commanded[-1, 1])
    moving = 1 - after
    size = jnp.abs(run.voltage)
    full = jnp.any(size >= robot.drive.voltage_limit, axis=1).astype(error.dtype)
    return Scores(
        residual_vibration=peak_to_peak(position[:, 0], after),
        smooth_vibration=smooth_peak_to_peak(position[:, 0], after),
        resting_error=resting,
        largest_error=jnp.max(error),
        rms_error=jnp.sqrt(jnp.sum(moving * jnp.square(error)) / jnp.sum(moving)),
        largest_original_error=jnp.max(tracking_error(pose, reference)),
        largest_voltage=jnp.max(size),
        saturation=jnp.mean(full),
    )


def loss(found: Scores, baseline: Scores, *, target: float = 0.35) -> Float[Array, ""]:
    r"""How far a run is from what is wanted of it, each metric over its baseline's.

    The vibration counts throughout, and four times above the target share; the resting error
    and that of Eq. (26) count where they come near the baseline's or exceed it, a millimetre
    further from the target as much as one and a half of vibration.

    Args:
        found: Metrics of the run.
        baseline: Metrics of the same manoeuvre with the PD of Eq. (25) alone.
        target: Share of the baseline's vibration that is to be left at most [1].

    Returns:
        Loss [1].
    """
    # A capped share keeps one bad leg from hiding what another does.
    capped = 3 * jnp.tanh(found.smooth_vibration / baseline.smooth_vibration / 3)
    # Where friction leaves the robot is a matter of luck, and the baseline may have had it: its
    # resting error is no measure of its own growth.
    size = jnp.maximum(baseline.smooth_vibration, 1e-3)
    further = (found.resting_error - 0.93 * baseline.resting_error) / size
    tracking = found.largest_error / baseline.largest_error
    return (
        capped
        + 3 * _above(capped, target)
        + 6 * _above(further, 0.0)
        + 8 * _above(tracking, 0.97)
    )


def _above(share: Float[Array, ""], limit: float) -> Float[Array, ""]:
    return jnp.maximum(share - limit, 0.0)
