"""A shaper for a measured spectrum, beside every shaper of the catalogue."""

import dataclasses
from typing import NamedTuple

import numpy as np

from scdpr_jax.command.shaper import Shaper
from scdpr_jax.numerics.progress import SILENT, Progress
from tuning.shapers.catalogue import CATALOGUE
from tuning.shapers.comparison import Fitted, fitted, pick
from tuning.shapers.design import Design, least_duration, least_residual
from tuning.shapers.design.positive import NOTHING_LEFT
from tuning.shapers.spectrum import DAMPING_RATIOS, Spectrum, vibration_left

_FRONT = 10
"""Designs between the catalogue's shortest shaper and the shortest that leaves nothing."""


class Compared(NamedTuple):
    """A shaper of the catalogue, and what can be had instead of it."""

    fit: Fitted
    """The shaper at its best frequency."""
    same_duration: Design
    """What leaves least in its duration."""
    same_vibration: Design
    """What is shortest and leaves no more."""


@dataclasses.dataclass(frozen=True, eq=False)
class SpectrumDesign:
    """Shapers for a measured spectrum."""

    spectrum: Spectrum
    """The spectrum."""
    damping_ratio: float
    """Damping ratio that the catalogue's shapers are designed for [1]."""
    damping_ratios: tuple[float, ...]
    """Damping ratios that every shaper is judged at, the worst counting [1]."""
    recommended: Design
    """The shaper to use."""
    compared: tuple[Compared, ...]
    """The catalogue, the shortest first."""
    picked: Fitted
    """What one would take from the catalogue."""
    front: tuple[Design, ...]
    """Least vibration over duration, from the shortest to what leaves nothing."""


def design_for_spectrum(
    spectrum: Spectrum,
    *,
    damping_ratio: float = 0.1,
    damping_ratios: tuple[float, ...] = DAMPING_RATIOS,
    max_duration: float | None = None,
    max_vibration: float | None = None,
    progress: Progress = SILENT,
) -> SpectrumDesign:
    """The best shapers of positive impulses for a measured spectrum.

    Unless a duration or a vibration is asked for, what leaves least in the duration of the
    shaper to take from the catalogue (`comparison.pick`) is recommended; where nothing need
    be left, the shortest such. So it is never longer than that one nor leaves more.

    Args:
        spectrum: The spectrum.
        damping_ratio: Damping ratio to design the catalogue's shapers for [1].
        damping_ratios: Damping ratios to judge every shaper at [1].
        max_duration: The longest that the shaper may be [s].
        max_vibration: The most that it may leave [1]; the shortest such is recommended. If
            it has to be longer than `max_duration`, what leaves least in that time is.
        progress: Told what is being done and which share of it is done.

    Returns:
        The design.

    Raises:
        ValueError: If no shaper leaves as little as is asked for.
    """
    criterion = vibration_left(spectrum, damping_ratios=damping_ratios)
    fits = []
    for number, entry in enumerate(CATALOGUE):
        progress(f"best frequency of {entry.name}", 0.3 * number / len(CATALOGUE))
        fits.append(fitted(entry, criterion, damping_ratio=damping_ratio))
    starts = [fit.shaper for fit in fits]
    progress("shortest that leaves nothing", 0.3)
    nothing = least_duration(criterion, bound=NOTHING_LEFT, starts=starts)
    enough = float(nothing.shaper.duration)

    def in_duration(duration: float, near: list[Shaper]) -> Design:
        if duration >= enough:
            return nothing
        return least_residual(criterion, duration=duration, starts=near)

    def within(bound: float, near: list[Shaper]) -> Design:
        return least_duration(criterion, bound=bound, starts=near, longest=enough)

    compared = []
    for number, fit in enumerate(fits):
        progress(f"instead of {fit.entry.name}", 0.4 + 0.35 * number / len(fits))
        same = in_duration(float(fit.shaper.duration), [*starts, nothing.shaper])
        shorter = within(fit.residual, [*starts, same.shaper])
        compared.append(Compared(fit, same, shorter))
    near = [shaper for comparison in compared for shaper in (comparison.same_duration.shaper,)]
    front = []
    shortest = min(float(shaper.duration) for shaper in starts)
    for number, duration in enumerate(np.geomspace(shortest, enough, _FRONT)[:-1]):
        progress("duration against vibration", 0.75 + 0.2 * number / _FRONT)
        front.append(in_duration(float(duration), near))
    progress("the recommended one", 0.95)
    picked = pick(fits)
    chosen = next(comparison for comparison in compared if comparison.fit is picked)
    if max_vibration is not None:
        recommended = within(max_vibration, [*starts, *near])
        if max_duration is not None and float(recommended.shaper.duration) > max_duration:
            recommended = in_duration(max_duration, [*starts, *near])
    elif max_duration is not None:
        recommended = in_duration(max_duration, [*starts, *near])
    else:
        recommended = chosen.same_duration
    return SpectrumDesign(
        spectrum,
        damping_ratio,
        tuple(damping_ratios),
        recommended,
        tuple(compared),
        picked,
        (*front, nothing),
    )
