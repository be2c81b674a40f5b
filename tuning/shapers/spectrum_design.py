"""A shaper for a measured spectrum, beside every shaper of the catalogue."""

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from scdpr_jax.command.shaper import Shaper
from scdpr_jax.numerics.progress import SILENT, Progress, listening
from tuning.shapers.catalogue import CATALOGUE
from tuning.shapers.comparison import FREE, Fitted, fitted, pick
from tuning.shapers.design import Design, fewest_impulses, least_duration, least_residual
from tuning.shapers.design.criterion import Criterion
from tuning.shapers.design.positive import NOTHING_LEFT
from tuning.shapers.design.refine import IMPULSES
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
    """Designs of which none is beaten by another that isn't longer, has no more impulses and
    leaves no more; the shortest first."""


def design_for_spectrum(
    spectrum: Spectrum,
    *,
    damping_ratio: float = 0.1,
    damping_ratios: tuple[float, ...] = DAMPING_RATIOS,
    max_duration: float | None = None,
    max_vibration: float | None = None,
    impulses: int = IMPULSES,
    progress: Progress | bool = SILENT,
) -> SpectrumDesign:
    """The best shapers of positive impulses for a measured spectrum.

    Unless a duration or a vibration is asked for, what leaves least in the duration of the
    shaper to take from the catalogue (`comparison.pick`) is recommended; where nothing need
    be left, the shortest such. So it is never longer than that one nor leaves more. All
    designs have as few impulses as leave `FREE` more than the least.

    Args:
        spectrum: The spectrum.
        damping_ratio: Damping ratio to design the catalogue's shapers for [1].
        damping_ratios: Damping ratios to judge every shaper at [1].
        max_duration: The longest that the shaper may be [s].
        max_vibration: The most that it may leave [1]; the shortest such is recommended. If
            it has to be longer than `max_duration`, what leaves least in that time is.
        impulses: The most impulses that a design may have, two at least.
        progress: Told what is being done and which share of it is done;
            True shows it in a notebook.

    Returns:
        The design.

    Raises:
        ValueError: If no shaper leaves as little as is asked for, or there are to be fewer
            impulses than two.
    """
    progress = listening(progress)
    if impulses < 2:
        raise ValueError(
            f"`impulses` of a shaper must be 2 or more, got {impulses}: one impulse is no "
            f"shaper. Leave it out for {IMPULSES} at most."
        )
    criterion = vibration_left(spectrum, damping_ratios=damping_ratios)
    fits = []
    for number, entry in enumerate(CATALOGUE):
        progress(f"best frequency of {entry.name}", 0.3 * number / len(CATALOGUE))
        fits.append(fitted(entry, criterion, damping_ratio=damping_ratio))
    progress("shortest that leaves nothing", 0.3)
    search = _search(criterion, fits, impulses)
    compared = []
    for number, fit in enumerate(fits):
        progress(f"instead of {fit.entry.name}", 0.4 + 0.35 * number / len(fits))
        compared.append(search.instead_of(fit))
    near = [comparison.same_duration.shaper for comparison in compared]
    front = search.front(near, progress.part(0.75, 0.95, "duration against vibration"))
    progress("the recommended one", 0.95)
    picked = pick([fit for fit in fits if fit.shaper.times.size <= max(impulses, 3)])
    recommended = next(one for one in compared if one.fit is picked).same_duration
    if max_vibration is not None:
        recommended = search.within(max_vibration, near)
    if max_duration is not None and (
        max_vibration is None or float(recommended.shaper.duration) > max_duration
    ):
        recommended = search.in_duration(max_duration, near)
    return SpectrumDesign(
        spectrum,
        damping_ratio,
        tuple(damping_ratios),
        recommended,
        tuple(compared),
        picked,
        front,
    )


@dataclasses.dataclass(frozen=True, eq=False)
class _Search:
    """Searches for one spectrum, which start from the catalogue's shapers."""

    criterion: Criterion
    starts: tuple[Shaper, ...]
    nothing: Design
    """The shortest design that leaves nothing, of any number of impulses."""
    impulses: int

    @property
    def enough(self) -> float:
        """Duration of the shortest design that leaves nothing [s]."""
        return float(self.nothing.shaper.duration)

    def in_duration(
        self, duration: float, near: Sequence[Shaper], *, bound: float | None = None
    ) -> Design:
        """What leaves least in a duration, or hardly more with fewer impulses."""
        least = self.nothing
        if duration < self.enough:
            near = (*self.starts, *near)
            least = least_residual(self.criterion, duration=duration, starts=near)
        worth = least.residual + FREE
        return self._few(least, worth if bound is None else min(worth, bound))

    def within(self, bound: float, near: Sequence[Shaper]) -> Design:
        """What is shortest and leaves no more than a bound; longer with as few impulses."""
        near = [*self.starts, *near]
        design = least_duration(self.criterion, bound=bound, starts=near, longest=self.enough)
        few = self._few(design, bound)
        for stretch in _LONGER:
            if few.residual <= bound:
                break
            duration = stretch * float(design.shaper.duration)
            longer = least_residual(self.criterion, duration=duration, starts=near)
            few = self._few(longer, bound)
        return few

    def instead_of(self, fit: Fitted) -> Compared:
        """What can be had instead of a shaper of the catalogue."""
        near, duration = [self.nothing.shaper], float(fit.shaper.duration)
        same = self.in_duration(duration, near, bound=fit.residual)
        return Compared(fit, same, self.within(fit.residual, [same.shaper]))

    def front(self, near: Sequence[Shaper], progress: Progress) -> tuple[Design, ...]:
        """Designs from the shortest shaper of the catalogue to what leaves nothing."""
        shortest = min(float(shaper.duration) for shaper in self.starts)
        designs = []
        for number, duration in enumerate(np.geomspace(shortest, self.enough, _FRONT)[:-1]):
            progress("", number / _FRONT)
            designs.append(self.in_duration(float(duration), near))
        return unbeaten([*designs, self._few(self.nothing, NOTHING_LEFT)])

    def _few(self, design: Design, bound: float) -> Design:
        return fewest_impulses(self.criterion, design, bound=bound, most=self.impulses)


_LONGER = tuple(np.geomspace(1.05, 4.0, 8).tolist())
"""Stretches of a shortest duration in which few impulses are tried [1]."""


def _search(criterion: Criterion, fits: Sequence[Fitted], impulses: int) -> _Search:
    starts = tuple(fit.shaper for fit in fits)
    nothing = least_duration(criterion, bound=NOTHING_LEFT, starts=starts)
    return _Search(criterion, starts, nothing, impulses)


def unbeaten(designs: Sequence[Design]) -> tuple[Design, ...]:
    """The designs that none of the others beats, the shortest first.

    A design is beaten by one that isn't longer, has no more impulses and leaves no more.
    So what is kept leaves less the longer it is or the more impulses it has.

    Args:
        designs: The designs.

    Returns:
        Those that are kept.
    """
    kept: list[Design] = []
    ordered = sorted(
        designs, key=lambda d: (float(d.shaper.duration), d.residual, d.shaper.times.size)
    )
    for design in ordered:
        beaten = any(
            one.residual <= design.residual
            and one.shaper.times.size <= design.shaper.times.size
            for one in kept
        )
        if not beaten:
            kept.append(design)
    return tuple(kept)
