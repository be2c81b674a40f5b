"""The rig's sensors: the encoders of the drives and the camera."""

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, PRNGKeyArray

from scdpr_jax.robot.fields import real, si

_LARGEST_JITTER = 0.45
"""Share of the frame period; below a half, so that frames never change places."""


class Encoder(eqx.Module):
    """The incremental encoder of a drive, seen at the driver pulley."""

    counts_per_rev: Float[Array, "..."] = eqx.field(
        default=26624.0, converter=real, metadata=si("1", "N")
    )
    """Counts $N$ for one turn of the driver pulley [1]; the campaigns' rigs have 26624."""


@jax.custom_jvp
def _round(number: Float[Array, "*shape"]) -> Float[Array, "*shape"]:
    return jnp.round(number)


@_round.defjvp
def _round_jvp(primals, tangents):
    # Straight through: the staircase's own derivative is 0 and would tell a fit nothing.
    return _round(*primals), tangents[0]


def encoder_counts(encoder: Encoder, angles: Float[Array, "2"]) -> Float[Array, "2"]:
    r"""Counts that the encoders show, whole numbers.

    $$ n = \mathrm{round}(N \alpha / 2\pi) $$

    The derivative is that of the line through the staircase (straight through).

    Args:
        encoder: The encoder of both drives.
        angles: Angles of the driver pulleys [rad].

    Returns:
        Counts [1].
    """
    return _round(encoder.counts_per_rev * angles / (2 * jnp.pi))


def read_encoder(encoder: Encoder, angles: Float[Array, "2"]) -> Float[Array, "2"]:
    r"""Angles as the encoders show them.

    $$ \hat\alpha = 2\pi n / N $$

    within half a count of the angle; the derivative is the identity (straight through).

    Args:
        encoder: The encoder of both drives.
        angles: Angles of the driver pulleys [rad].

    Returns:
        Quantised angles [rad].
    """
    return encoder_counts(encoder, angles) * (2 * jnp.pi) / encoder.counts_per_rev


class Camera(eqx.Module):
    """The vision system of section 4.2: frames with jitter, noise and lost markers."""

    frame_rate: Float[Array, "..."] = eqx.field(
        default=30.0, converter=real, metadata=si("Hz", "f_c")
    )
    """Frames a second [Hz]."""
    jitter: Float[Array, "..."] = eqx.field(
        default=0.0, converter=real, metadata=si("s", r"\sigma_t")
    )
    """Standard deviation of a frame's time about the even grid [s]."""
    position_sigma: Float[Array, "..."] = eqx.field(
        default=0.19e-3, converter=real, metadata=si("m", r"\sigma_x")
    )
    """Standard deviation of a position [m]; the paper's reprojection error is 0.19 mm."""
    angle_sigma: Float[Array, "..."] = eqx.field(
        default=2e-3, converter=real, metadata=si("rad", r"\sigma_\delta")
    )
    """Standard deviation of the end-effector's rotation [rad]."""
    loss_probability: Float[Array, "..."] = eqx.field(
        default=0.0, converter=real, metadata=si("1", "p")
    )
    """Probability that one coordinate is lost in one frame [1]."""
    clock_offset: Float[Array, "..."] = eqx.field(
        default=0.0, converter=real, metadata=si("s", "t_c")
    )
    """What the camera's clock shows when the drives' shows zero [s]."""


def frame_times(
    camera: Camera, *, count: int, key: PRNGKeyArray, start: float = 0.0
) -> Float[Array, " frames"]:
    """When the frames are taken, on the drives' clock; what is stamped adds the offset.

    The jitter is Gaussian, cut at 45 % of the frame period: the times increase strictly.

    Args:
        camera: The camera.
        count: Number of frames.
        key: Random key.
        start: Nominal time of the first frame [s].

    Returns:
        Times [s].
    """
    period = 1 / camera.frame_rate
    draw = jax.random.normal(key, (count,), dtype=period.dtype)
    deviation = jnp.clip(
        camera.jitter * draw, -_LARGEST_JITTER * period, _LARGEST_JITTER * period
    )
    return start + period * jnp.arange(count, dtype=period.dtype) + deviation


def observe(
    camera: Camera, positions: Float[Array, "frames 5"], *, key: PRNGKeyArray
) -> Float[Array, "frames 5"]:
    r"""What the camera reports of the true positions.

    Args:
        camera: The camera.
        positions: $[x_e, \delta_e, q_3, q_4, y_e]$ at the frames' times [m, rad, m, m, m].
        key: Random key.

    Returns:
        The same with noise; NaN where a marker was lost, an empty cell in `camera.csv`.
    """
    noise_key, loss_key = jax.random.split(key)
    position, angle = camera.position_sigma, camera.angle_sigma
    sigma = jnp.stack([position, angle, position, position, position])
    noise = jax.random.normal(noise_key, positions.shape, dtype=positions.dtype)
    chance = jax.random.uniform(loss_key, positions.shape, dtype=positions.dtype)
    lost = chance < camera.loss_probability
    return jnp.where(lost, jnp.nan, positions + sigma[None] * noise)
