r"""Stability margins of the joint loop, continuous and as the controller samples it."""

import functools
from collections.abc import Callable

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Complex, Float

from scdpr_jax.command.controller import PD
from scdpr_jax.native import kept_jit
from scdpr_jax.robot.fields import si
from tuning.loop.plant import MotorPlant
from tuning.loop.responses import continuous_loop, sampled_loop

_POINTS = 512
"""Grid points; a resonance narrower than 2 % of its frequency could slip between them."""
DECADES = 3.0
"""Decades scanned below, and in the continuous loop above, the crossover's scale."""
HALVINGS = 26
"""Halvings of a grid interval: half of a double's digits, and Newton's step doubles them."""
SECTIONS = 40
"""Golden sections of two grid intervals: the least distance errs by the square of the place."""


class Margins(eqx.Module):
    """How far a loop is from instability."""

    gain_crossover: Float[Array | np.ndarray, "..."] = eqx.field(
        metadata=si("rad/s", r"\omega_c")
    )
    r"""Where $|L| = 1$ with the least phase margin [rad/s]; NaN if nowhere."""
    phase_margin: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("rad", r"\varphi_m"))
    r"""Angle of $-L$ at the gain crossover [rad]; negative in an unstable loop."""
    delay_margin: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("s", r"\tau_m"))
    r"""Further delay that the loop bears, $\varphi_m / \omega_c$ [s]."""
    phase_crossover: Float[Array | np.ndarray, "..."] = eqx.field(
        metadata=si("rad/s", r"\omega_\pi")
    )
    """Where $L$ is real and negative with the least gain margin [rad/s]; NaN if nowhere."""
    gain_margin: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("1", "g_m"))
    r"""Factor on the gain that brings $L$ to $-1$ [1]; infinite without a phase crossover."""
    peak_sensitivity: Float[Array | np.ndarray, "..."] = eqx.field(metadata=si("1", "M_s"))
    r"""Largest $1 / |1 + L|$ [1]; of no meaning in an unstable loop."""


class Response(eqx.Module):
    """The frequency response of an open loop: a pytree, so that it can be held constant."""

    loop: Callable[..., Complex[Array, ""]] = eqx.field(static=True)
    """From plant, controller and angular frequency to the open loop."""
    plant: MotorPlant
    """The drive."""
    controller: PD
    """The controller."""

    def __call__(self, angular_frequency: Float[Array, ""]) -> Complex[Array, ""]:
        """The open loop at an angular frequency [rad/s]."""
        return self.loop(self.plant, self.controller, angular_frequency)


Measure = Callable[[Response, Float[Array, ""]], Float[Array, ""]]


@jax.jit
def continuous_margins(plant: MotorPlant, controller: PD) -> Margins:
    """Margins of the loop that Eq. (25) was designed on: no sampling, no delay.

    Its phase never reaches -180°: the gain margin is infinite.

    Args:
        plant: The drive.
        controller: The controller, its sampling disregarded.

    Returns:
        The margins, differentiable in the plant and the controller.
    """
    scale = _scale(plant, controller)
    exponents = jnp.linspace(-DECADES, DECADES, _POINTS, dtype=scale.dtype)
    response = Response(continuous_loop, plant, controller)
    return _margins(response, scale * 10**exponents, at_nyquist=False)


def sampled_margins(plant: MotorPlant, controller: PD, *, delay: int = 1) -> Margins:
    """Margins of the loop as it runs: hold, backward difference and computing time.

    Args:
        plant: The drive, behind a zero-order hold.
        controller: The controller at its sample period.
        delay: Samples from a measurement to its command.

    Returns:
        The margins, differentiable in the plant and the controller.

    Raises:
        ValueError: If the delay is negative.
    """
    if delay < 0:
        raise ValueError(
            f"`delay` must not be negative [samples], got {delay}: a command that is out "
            "before the next sample has 0, one that waits for it has 1."
        )
    return Margins(*_sampled_margins(plant, controller, delay=delay))


@kept_jit
def _sampled_margins(plant: MotorPlant, controller: PD, *, delay: int) -> tuple[Array, ...]:
    # A rate that is fitted or optimised moves the Nyquist frequency with it.
    nyquist = jnp.pi / controller.period
    lowest = 10**-DECADES * jnp.minimum(_scale(plant, controller), nyquist)
    share = jnp.linspace(0.0, 1.0, _POINTS, dtype=lowest.dtype)
    response = Response(functools.partial(sampled_loop, delay=delay), plant, controller)
    made = _margins(response, lowest * (nyquist / lowest) ** share, at_nyquist=True)
    return tuple(jax.tree.leaves(made))


def crossover_scale(
    gain: Float[Array | np.ndarray, "..."],
    pole: Float[Array | np.ndarray, "..."],
    controller: PD,
) -> Float[Array | np.ndarray, "..."]:
    r"""Gain crossover of the continuous loop without a filter, to place the grid.

    $\omega^4 + (p^2 - g^2 K_d^2) \omega^2 - g^2 K_p^2 = 0$ has one positive root.

    Args:
        gain: Of the plant, see `MotorPlant` [rad/s²/V].
        pole: Of the plant [1/s].
        controller: The controller, or several, whose arrays broadcast with the plant's.

    Returns:
        Angular frequencies [rad/s]: JAX's arrays of JAX's, NumPy's of NumPy's.
    """
    xp = gain.__array_namespace__()
    linear = (xp.square(pole) - xp.square(gain * controller.derivative_gain)) / 2
    constant = xp.square(gain * controller.proportional_gain)
    root = xp.hypot(linear, xp.sqrt(constant))
    # The form without a difference of equals, whichever sign the linear term has.
    square = xp.where(linear > 0, constant / (root + xp.abs(linear)), root - linear)
    return xp.sqrt(square)


def _scale(plant: MotorPlant, controller: PD) -> Float[Array, ""]:
    return jax.lax.stop_gradient(crossover_scale(plant.gain, plant.pole, controller))


def _margins(response: Response, grid: Float[Array, " points"], *, at_nyquist: bool) -> Margins:
    # The search itself needs no derivatives: only its results are evaluated with them.
    nyquist, grid, constant = grid[-1], *jax.lax.stop_gradient((grid, response))
    values = jax.vmap(constant)(grid)
    gain_crossover, phase_margin = _gain_crossover(response, grid, values)
    phase_crossover, gain_margin = _phase_crossover(response, grid, values)
    if at_nyquist:
        phase_crossover, gain_margin = with_nyquist(
            response, nyquist, phase_crossover, gain_margin
        )
    return Margins(
        gain_crossover=gain_crossover,
        phase_margin=phase_margin,
        delay_margin=phase_margin / gain_crossover,
        phase_crossover=phase_crossover,
        gain_margin=gain_margin,
        peak_sensitivity=peak_sensitivity(response, grid, values),
    )


def _log_gain(response: Response, angular_frequency: Float[Array, ""]) -> Float[Array, ""]:
    return jnp.log(jnp.abs(response(angular_frequency)))


def _phase_over_half_turn(
    response: Response, angular_frequency: Float[Array, ""]
) -> Float[Array, ""]:
    return jnp.angle(-response(angular_frequency))


def _distance(response: Response, angular_frequency: Float[Array, ""]) -> Float[Array, ""]:
    return jnp.abs(1 + response(angular_frequency))


def _gain_crossover(
    response: Response, grid: Float[Array, " points"], values: Complex[Array, " points"]
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    log_gain = jnp.log(jnp.abs(values))
    crosses = log_gain[:-1] * log_gain[1:] <= 0
    angles = jnp.unwrap(jnp.angle(-values))[:-1]
    index = jnp.argmin(jnp.where(crosses, jnp.abs(angles), jnp.inf))
    crossover = root(_log_gain, response, grid[index], grid[index + 1])
    margin = _phase_over_half_turn(response, crossover)
    # More than a turn of lag must not come back as a positive margin.
    turns = jax.lax.stop_gradient(jnp.round((angles[index] - margin) / (2 * jnp.pi)))
    is_crossed = crosses[index]
    return (
        jnp.where(is_crossed, crossover, jnp.nan),
        jnp.where(is_crossed, margin + 2 * jnp.pi * turns, jnp.nan),
    )


def _phase_crossover(
    response: Response, grid: Float[Array, " points"], values: Complex[Array, " points"]
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    negative = (jnp.real(values[:-1]) < 0) & (jnp.real(values[1:]) < 0)
    crosses = (jnp.imag(values[:-1]) * jnp.imag(values[1:]) < 0) & negative
    distance = jnp.abs(jnp.log(jnp.abs(values[:-1])))
    index = jnp.argmin(jnp.where(crosses, distance, jnp.inf))
    crossover = root(_phase_over_half_turn, response, grid[index], grid[index + 1])
    margin = jnp.exp(-_log_gain(response, crossover))
    is_crossed = crosses[index]
    return jnp.where(is_crossed, crossover, jnp.nan), jnp.where(is_crossed, margin, jnp.inf)


def with_nyquist(
    response: Response,
    nyquist: Float[Array, ""],
    phase_crossover: Float[Array, ""],
    gain_margin: Float[Array, ""],
) -> tuple[Float[Array, ""], Float[Array, ""]]:
    """The gain margin with the Nyquist frequency, where no sign change marks a real response.

    Args:
        response: The open loop, sampled.
        nyquist: The Nyquist frequency [rad/s].
        phase_crossover: Phase crossover with the least gain margin below it [rad/s].
        gain_margin: That margin [1].

    Returns:
        Phase crossover [rad/s] and gain margin [1] over all frequencies.
    """
    value = jnp.real(response(nyquist))
    margin = 1 / jnp.abs(value)
    nearer = (value < 0) & (jnp.abs(jnp.log(margin)) < jnp.abs(jnp.log(gain_margin)))
    return jnp.where(nearer, nyquist, phase_crossover), jnp.where(nearer, margin, gain_margin)


def peak_sensitivity(
    response: Response,
    grid: Float[Array, " points"],
    values: Complex[Array, " points"],
    *,
    still: Response | None = None,
) -> Float[Array, ""]:
    """Largest $1 / |1 + L|$, by golden section around the grid's nearest point to $-1$.

    Args:
        response: The open loop.
        grid: Angular frequencies, ascending [rad/s].
        values: The response there.
        still: The same without derivatives, to search with; None for the response itself.

    Returns:
        The peak [1].
    """
    nearest = jnp.argmin(jnp.abs(1 + values))
    low = grid[jnp.maximum(nearest - 1, 0)]
    high = grid[jnp.minimum(nearest + 1, grid.size - 1)]
    # At the minimum the derivative in the frequency vanishes: it may be held constant.
    return 1 / _distance(response, _minimum(_distance, still or response, low, high))


def root(
    measure: Measure,
    response: Response,
    low: Float[Array, ""],
    high: Float[Array, ""],
    *,
    still: Response | None = None,
) -> Float[Array, ""]:
    """Where a measure of the response vanishes, with the implicit function's derivative.

    Args:
        measure: From response and angular frequency to the number.
        response: The open loop.
        low: Lower end of a stretch in which the measure changes sign [rad/s].
        high: Its upper end [rad/s].
        still: The same response without derivatives, to search with; None for itself.

    Returns:
        Angular frequency [rad/s].
    """
    function = functools.partial(measure, jax.lax.stop_gradient(still or response))
    sign = jnp.sign(function(low))

    def halve(_, bounds):
        lower, upper = bounds
        middle = (lower + upper) / 2
        before = function(middle) * sign > 0
        return jnp.where(before, middle, lower), jnp.where(before, upper, middle)

    lower, upper = jax.lax.fori_loop(0, HALVINGS, halve, (low, high))
    root = (lower + upper) / 2
    slope = jax.jvp(function, (root,), (jnp.ones_like(root),))[1]
    flat = slope == 0
    # One Newton step of the live response carries the derivative -f_theta / f_omega.
    step = jnp.where(flat, 0.0, measure(response, root)) / jnp.where(flat, 1.0, slope)
    return root - step


def _minimum(
    measure: Measure, response: Response, low: Float[Array, ""], high: Float[Array, ""]
) -> Float[Array, ""]:
    """Where a measure of the response is least, by golden section, without derivative."""
    function = functools.partial(measure, jax.lax.stop_gradient(response))
    golden = (5.0**0.5 - 1) / 2

    def narrow(_, bounds):
        lower, upper = bounds
        left, right = upper - golden * (upper - lower), lower + golden * (upper - lower)
        at_left, at_right = jax.vmap(function)(jnp.stack([left, right]))
        go_left = at_left < at_right
        return jnp.where(go_left, lower, left), jnp.where(go_left, right, upper)

    lower, upper = jax.lax.fori_loop(0, SECTIONS, narrow, (low, high))
    return (lower + upper) / 2
