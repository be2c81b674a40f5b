"""Input shapers: impulse sequences that a reference is convolved with."""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.command.trajectory import Trajectory
from scdpr_jax.robot.fields import concrete, real, refuse, si


def _ordered_times(value: Any) -> Float[Array, "..."]:
    times = real(value)
    numbers = concrete(times)
    disordered = (numbers[..., 1:] < numbers[..., :-1]).any() | ~(numbers >= 0).all()
    message = (
        "`times` of a shaper must not be negative nor decrease [s], got some that do: "
        "sort the impulses and count time from the first one."
    )
    return refuse(times, disordered, message)


def _unit_sum(value: Any) -> Float[Array, "..."]:
    amplitudes = real(value)
    numbers = concrete(amplitudes)
    # Amplitudes written down with seven digits pass, a forgotten impulse doesn't.
    tolerance = 1e-6 * abs(numbers).sum(axis=-1)
    message = (
        "`amplitudes` of a shaper must sum to 1 [1], got another sum: divide them by it, "
        "or the shaped reference ends elsewhere."
    )
    return refuse(amplitudes, ~(abs(numbers.sum(axis=-1) - 1) <= tolerance), message)


class Shaper(eqx.Module):
    """A sequence of impulses whose amplitudes sum to one."""

    times: Float[Array, "... impulses"] = eqx.field(
        converter=_ordered_times, metadata=si("s", "t_i")
    )
    """Times $t_i$ of the impulses [s], not negative and not decreasing."""
    amplitudes: Float[Array, "... impulses"] = eqx.field(
        converter=_unit_sum, metadata=si("1", "A_i")
    )
    """Amplitudes $A_i$ [1], of sum 1; negative ones are allowed."""

    def __check_init__(self):
        if self.times.ndim == 0 or self.times.shape != self.amplitudes.shape:
            raise ValueError(
                "`times` [s] and `amplitudes` [1] of a shaper must be lists of one length, "
                f"got shapes {self.times.shape} and {self.amplitudes.shape}: give each impulse "
                "both."
            )

    @property
    def duration(self) -> Float[Array, "..."]:
        """Time from 0 to the last impulse [s]: how much later a shaped move ends."""
        return self.times[..., -1]


class ShapedTrajectory(Trajectory):
    r"""A trajectory convolved with a shaper, exactly.

    $$ p_s(t) = \sum_i A_i\, p(t - t_i) $$
    """

    trajectory: Trajectory
    """The reference to shape."""
    shaper: Shaper
    """The impulses."""

    @property
    def duration(self) -> Float[Array, "..."]:
        return self.trajectory.duration + self.shaper.duration

    def position(self, time: Float[Array, ""]) -> Float[Array, "2"]:
        delayed = jax.vmap(self.trajectory.position)(time - self.shaper.times)
        return self.shaper.amplitudes @ delayed


def shape_samples(
    shaper: Shaper, samples: Float[Array, " time *axes"], *, period: Float[Array, ""]
) -> Float[Array, " time *axes"]:
    """A sampled reference convolved with a shaper.

    Exact for a reference that is straight between its samples; its first value is held
    before the record. The result has the record's length, so hold the last value at its end
    for the shaper's duration. Where the formula of the reference is known, shape that:
    `ShapedTrajectory`.

    Args:
        shaper: The impulses.
        samples: Reference at a constant rate [any unit].
        period: Sample period [s].

    Returns:
        Shaped reference at the same instants [the reference's unit].
    """
    length = samples.shape[0]
    instants = jnp.arange(length, dtype=samples.dtype)

    def delayed(time: Float[Array, ""]) -> Float[Array, " time *axes"]:
        place = jnp.clip(instants - time / period, 0)
        before = jnp.floor(place)
        share = (place - before).reshape((length,) + (1,) * (samples.ndim - 1))
        index = before.astype(int)
        after = jnp.minimum(index + 1, length - 1)
        return (1 - share) * samples[index] + share * samples[after]

    return jnp.tensordot(shaper.amplitudes, jax.vmap(delayed)(shaper.times), axes=1)


def convolve(first: Shaper, second: Shaper) -> Shaper:
    """The shaper that does what two do one after the other, for two modes say.

    Args:
        first: A shaper of n impulses.
        second: A shaper of m impulses.

    Returns:
        A shaper of n·m impulses.
    """
    times = (first.times[:, None] + second.times[None, :]).ravel()
    amplitudes = (first.amplitudes[:, None] * second.amplitudes[None, :]).ravel()
    order = jnp.argsort(times)
    return Shaper(times[order], amplitudes[order])


def padded(shaper: Shaper, count: int) -> Shaper:
    """The same shaper with idle impulses at its end, so that shapers can be stacked.

    Args:
        shaper: The impulses.
        count: How many there shall be, at least as many as there are.

    Returns:
        A shaper of so many impulses.
    """
    if shaper.times.size == count:
        return shaper
    idle = (0, count - shaper.times.size)
    xp = concrete(shaper.times).__array_namespace__()
    return Shaper(
        xp.pad(concrete(shaper.times), idle, mode="edge"),
        xp.pad(concrete(shaper.amplitudes), idle),
    )


@jax.jit
def impulse_phasors(
    times: Float[Array, " impulses"],
    *,
    end: Float[Array, ""],
    frequency: Float[Array, ""],
    damping_ratio: Float[Array, ""],
) -> Float[Array, "2 impulses"]:
    r"""Cosine and sine part of what each of some unit impulses leaves in a mode.

    $$ e^{-\zeta\omega (t - t_i)} [\cos \omega_d t_i, \sin \omega_d t_i], \qquad
       \omega_d = \omega \sqrt{1 - \zeta^2} $$

    Args:
        times: Instants $t_i$ of the impulses [s].
        end: Instant $t$ at which the vibration is measured [s].
        frequency: Undamped natural frequency $\omega / 2\pi$ of the mode [Hz].
        damping_ratio: Damping ratio $\zeta$ of the mode [1], below 1.

    Returns:
        The two parts [1], as shares of the vibration of an impulse at that instant.
    """
    omega = 2 * jnp.pi * frequency
    # Counted back from an end after the impulses the exponent is never positive: no overflow.
    decay = jnp.exp(-damping_ratio * omega * (end - times))
    angle = omega * jnp.sqrt(1 - jnp.square(damping_ratio)) * times
    return jnp.stack([decay * jnp.cos(angle), decay * jnp.sin(angle)])


@jax.jit
def residual_phasor(
    shaper: Shaper, *, frequency: Float[Array, ""], damping_ratio: Float[Array, ""]
) -> Float[Array, "2"]:
    r"""Cosine and sine part of what the impulses leave in a mode.

    $$ [C, S] = \sum_i A_i\, e^{-\zeta\omega (t_n - t_i)}
       [\cos \omega_d t_i, \sin \omega_d t_i], \qquad \omega_d = \omega \sqrt{1 - \zeta^2} $$

    Smooth everywhere, also where the vibration vanishes: the one to differentiate for
    conditions such as ZVD's.

    Args:
        shaper: The impulses.
        frequency: Undamped natural frequency $\omega / 2\pi$ of the mode [Hz].
        damping_ratio: Damping ratio $\zeta$ of the mode [1], below 1.

    Returns:
        The two parts [1], as shares of a single unit impulse's vibration.
    """
    phasors = impulse_phasors(
        shaper.times, end=shaper.times[-1], frequency=frequency, damping_ratio=damping_ratio
    )
    return phasors @ shaper.amplitudes


@jax.jit
def residual_vibration(
    shaper: Shaper, *, frequency: Float[Array, ""], damping_ratio: Float[Array, ""]
) -> Float[Array, ""]:
    r"""Share of a mode's vibration that a shaper leaves after its last impulse.

    $$ V = \sqrt{C^2 + S^2} $$

    with the parts of `residual_phasor`. At V = 0, where the root has a kink, its derivative
    is taken as 0.

    Args:
        shaper: The impulses.
        frequency: Undamped natural frequency of the mode [Hz].
        damping_ratio: Damping ratio $\zeta$ of the mode [1], below 1.

    Returns:
        Residual vibration [1]: 0 for none, 1 for as much as without a shaper.

    Reference: N. C. Singer, W. P. Seering, "Preshaping command inputs to reduce system
    vibration", ASME J. Dyn. Syst. Meas. Control 112(1), 1990, doi:10.1115/1.2894142.
    """
    phasor = residual_phasor(shaper, frequency=frequency, damping_ratio=damping_ratio)
    square = jnp.sum(jnp.square(phasor))
    vanished = square == 0
    return jnp.where(vanished, 0.0, jnp.sqrt(jnp.where(vanished, 1.0, square)))
