r"""Whether a fit has failed: what no model that was tried explains, and what follows.

A standard error says how far the noise, or a misfit that comes and goes, moves a value within
a model. Where a camera's residuals are tens of its noise, the model is another rig's, and the
value is off by what the model is off, which nothing in the fit tells: then no error is better
than one of a ten-thousandth. Encoders resolve a fiftieth of what a camera sees, and
every real rig departs from its model by more than their counts: what an encoder leaves has to
be a share of its motion, too, and tens of what a camera would see at the pulley's rim. A knock
turns a drive by a few counts, and how it gives way within its friction no model knows.

Where a contradiction between the sensors was accepted, more than noise in any channel is its
doing until the contrary is shown.
"""

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from identification.fit.comparison import ENCODERS, Channel, Comparison
from identification.judge.uncertainty import (
    DOES_NOT_FIT,
    ParameterEstimate,
    interval95,
    judge,
)
from scdpr_jax.robot.quantities import quantity

TENS = 30.0
"""Residual over the noise from which a channel isn't explained [1]: rigs that bend, rub and
slacken otherwise than the model leave up to eighteen times the camera's."""

SHARE = 0.1
"""Residual over the motion that an encoder has to leave for that, too [1]."""


INERTIA_FACTOR = 2.0
"""Drive inertia over the nameplate's, or the reverse, from which it isn't plausible [1]: rotors
of drawn rigs differ by 1.4. Commands in another unit scale it."""


@dataclasses.dataclass(frozen=True)
class Unexplained:
    """A channel of a fitted run that the model doesn't explain."""

    run: str
    """Name of the run."""
    channel: str
    """Name of the column."""
    ratio: float
    """Root mean square of the residual over the noise's standard deviation [1]."""
    share: float
    """The same over the channel's motion; infinite for one that stands still [1]."""


def unexplained(
    comparisons: Iterable[Comparison], *, contradicted: bool, seen: float
) -> tuple[Unexplained, ...]:
    """Channels of the fitted runs that the model doesn't explain.

    Args:
        comparisons: The runs beside their simulations.
        contradicted: Whether a contradiction between the sensors was accepted.
        seen: Turn of a drive that moves its cable by the camera's noise [rad].

    Returns:
        The channels, by how far they exceed the noise.
    """
    channels = [
        Unexplained(run.name, channel.name, math.sqrt(channel.chi_square), _share(channel))
        for run in comparisons
        if not run.held_out
        for channel in run.channels
        if (not channel.is_noise if contradicted else _is_unexplained(channel, seen))
    ]
    return tuple(sorted(channels, key=lambda channel: -channel.ratio))


def is_doubtful(
    parameters: Sequence[ParameterEstimate],
    comparisons: Iterable[Comparison],
    *,
    nameplate: float,
) -> bool:
    """Whether a fit that leaves more than noise has an inertia that no rotor of the rig has.

    What scales the commands scales inertia, damping and friction with them, and where nothing
    else tells the scale, the fit is hardly the worse for it.

    Args:
        parameters: The quantities by their standard errors.
        comparisons: The runs beside their simulations.
        nameplate: Drive inertia that is known of the rig [kg m²].

    Returns:
        Whether it is so.
    """
    noise = all(c.is_noise for run in comparisons if not run.held_out for c in run.channels)
    return not noise and any(
        p.name == "drive_inertia"
        and p.status == "identified"
        and not 1 / INERTIA_FACTOR < p.value / nameplate < INERTIA_FACTOR
        for p in parameters
    )


def judged(
    parameters: Sequence[ParameterEstimate],
    *,
    failed: bool,
    contradicted: bool,
    open_by_rank: frozenset[tuple[str, str | None]] = frozenset(),
    left_open: Mapping[tuple[str, str | None], float] | None = None,
) -> tuple[ParameterEstimate, ...]:
    """The quantities as the verdict leaves them.

    Args:
        parameters: The quantities by their standard errors.
        failed: Whether the fit has failed: then no value has an error.
        contradicted: Whether a contradiction between the sensors was accepted, or the fit is
            doubtful: what rests on data that can't all be right is weakly identified at best.
        open_by_rank: Name and setting of the quantities that no smaller noise would tell.
        left_open: By how much that leaves each quantity open, as a fit holds it; None for not.

    Returns:
        The quantities; fixed ones as they are.
    """

    def of(parameter: ParameterEstimate) -> ParameterEstimate:
        parameter = _widened(parameter, left_open or {})
        by_rank = (parameter.name, parameter.setting) in open_by_rank
        if parameter.status == "fixed" or not (failed or contradicted or by_rank):
            return parameter
        if failed or by_rank:
            status = DOES_NOT_FIT if failed else "unidentifiable"
            return dataclasses.replace(
                parameter, sigma=np.inf, interval95=(-np.inf, np.inf), status=status
            )
        status = "weak" if parameter.status == "identified" else parameter.status
        return dataclasses.replace(parameter, status=status)

    return tuple(map(of, parameters))


def _widened(
    parameter: ParameterEstimate, left_open: Mapping[tuple[str, str | None], float]
) -> ParameterEstimate:
    """A quantity with what it may go along with one that no smaller noise would tell."""
    encoded = left_open.get((parameter.name, parameter.setting), 0.0)
    if parameter.status == "fixed" or encoded == 0.0 or not math.isfinite(parameter.sigma):
        return parameter
    size = abs(parameter.value) if quantity(parameter.name).positive else 1.0
    sigma = math.hypot(parameter.sigma, encoded * size)
    name, value, freedom = parameter.name, parameter.value, parameter.degrees_of_freedom
    return dataclasses.replace(
        parameter,
        sigma=sigma,
        interval95=interval95(name, value, sigma, freedom),
        status=judge(name, value, sigma, at_bound=parameter.status == "at_bound"),
    )


def _is_unexplained(channel: Channel, seen: float) -> bool:
    if channel.is_noise or channel.chi_square < TENS**2:
        return False
    if channel.name not in ENCODERS:
        return True
    return _share(channel) > SHARE and channel.rms > TENS * seen


def _share(channel: Channel) -> float:
    return channel.rms / channel.motion if channel.motion > 0 else math.inf
