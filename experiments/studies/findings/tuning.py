"""What gains and shapers come to over the workspace, in numbers and in words."""

import dataclasses
from collections.abc import Sequence

import numpy as np

from experiments.page.number_text import capitalised, percent, plain, short
from experiments.studies.findings.responses import NamedShaper
from tuning.loop.worst_margins import MarginMap, WorstMargin, margin_map
from tuning.regions.residual_map import ResidualMap, WorstResidual, residual_map
from tuning.result.prediction import LegsOutcome
from tuning.result.regional_shaper import RegionalShaper
from tuning.result.tuning import Tuning

_MUCH = 0.5
"""Residual vibration from which a shaper does little against its mode [1]."""

_SAME = 0.01
"""Relative difference below which two shapers are drawn as one: a line's width."""

_NO_MORE = 0.01
"""Percentage points below which nothing is left beyond a promise."""


@dataclasses.dataclass(frozen=True, eq=False)
class TuningFindings:
    """What a tuning comes to over the workspace."""

    tuning: Tuning
    """Gains and shapers."""
    residual_maps: tuple[ResidualMap, ...]
    """Residual vibration over the workspace at each tuned setting."""
    margins: MarginMap | None
    """Margins of the flexible robot's loops; None without a fitted robot."""
    shapers: tuple[NamedShaper, ...]
    """The shapers, those that are the same to the eye as one."""
    sentences: tuple[str, ...]
    """What it comes to, in words."""

    @property
    def between_the_cells(self) -> tuple[str, ...]:
        """What the shapers leave between the cells' points, in words; nothing without maps."""
        maps = self.residual_maps
        return (between_the_cells_sentence(maps),) if maps else ()


def tuning_findings(tuning: Tuning) -> TuningFindings:
    """What a tuning comes to over the workspace.

    Args:
        tuning: The tuning.

    Returns:
        Maps, margins, shapers and words.
    """
    robots = tuning.robots
    return TuningFindings(
        tuning=tuning,
        residual_maps=tuple(residual_map(tuning, fitted.pretension) for fitted in robots),
        margins=margin_map(robots, tuning.controller) if robots else None,
        shapers=distinct_shapers(tuning),
        sentences=tuning_sentences(tuning),
    )


def distinct_shapers(tuning: Tuning) -> tuple[NamedShaper, ...]:
    """A tuning's shapers, those that are the same to the eye as one.

    Args:
        tuning: The tuning.

    Returns:
        Shapers, named by the first region and how many more there are, with the band of
        all of them.
    """
    groups: list[list[RegionalShaper]] = []
    for regional in tuning.shapers:
        alike = next((group for group in groups if _alike(regional, group[0])), None)
        if alike is None:
            groups.append([regional])
        else:
            alike.append(regional)
    return tuple(
        NamedShaper(
            region_name(group[0]) + (f" and {len(group) - 1} more" if len(group) > 1 else ""),
            group[0].shaper,
            group[0].damping_ratio,
            (min(r.band[0] for r in group), max(r.band[1] for r in group)),
        )
        for group in groups
    )


def _alike(first: RegionalShaper, second: RegionalShaper) -> bool:
    pairs = (
        (first.shaper.times, second.shaper.times),
        (first.shaper.amplitudes, second.shaper.amplitudes),
        (first.frequency, second.frequency),
    )
    return all(
        np.shape(a) == np.shape(b) and np.allclose(a, b, rtol=_SAME, atol=0) for a, b in pairs
    )


def region_name(regional: RegionalShaper) -> str:
    """A region in one line.

    Args:
        regional: The regional shaper.

    Returns:
        Its ranges [mm, N].
    """
    region = regional.region
    x, y = ([f"{1e3 * end:.0f}" for end in pair] for pair in (region.x, region.y))
    low, high = region.pretension
    tension = f"{low:g} N" if low == high else f"{low:g}–{high:g} N"
    return f"x {x[0]}–{x[1]}, y {y[0]}–{y[1]} mm, {tension}"


def _legs_sentences(tuning: Tuning) -> list[str]:
    """What random legs leave before, with gains and shapers, and as planned."""
    legs = tuning.legs
    if legs is None:
        return []
    sides = [("under Eq. (25)", legs.before), ("with gains and shapers", legs.after)]
    if legs.planned is not None:
        count = len(legs.planned.vibration)
        sides.append((f"as planned (the first {count} of them)", legs.planned))

    def typical(outcome: LegsOutcome) -> str:
        median, worst = np.median(outcome.vibration), np.max(outcome.vibration)
        rest = np.median(outcome.resting_error)
        lengths = [plain(1e3 * float(length), 2) for length in (median, worst, rest)]
        return "vibrates by {} mm ({} mm at worst) and rests {} mm off".format(*lengths)

    parts = [f"{name} it {typical(outcome)}" for name, outcome in sides]
    return [
        f"After {len(legs)} random legs over the workspace, on robots as they might be, the "
        f"end-effector's median: {'; '.join(parts)} (simulated). Plans are made by `scdpr "
        "plan` and, in the controller, by `export/onboard/`."
    ]


def tuning_sentences(tuning: Tuning) -> tuple[str, ...]:
    """What a tuning comes to, in plain words.

    Args:
        tuning: The tuning.

    Returns:
        Sentences.
    """
    margin = plain(float(np.degrees(tuning.margins.phase_margin)), 3)
    controller = tuning.controller
    sentences = [
        *filter(None, [tuning.caution]),
        *_legs_sentences(tuning),
        f"PD gains {short(float(controller.proportional_gain), 5)} V/rad and "
        f"{short(float(controller.derivative_gain), 5)} V s/rad, with {margin}° of phase "
        "margin of a bare drive as sampled.",
    ]
    if tuning.worst_margins:
        sentences.append(worst_margins_sentence(tuning.worst_margins))
    for manoeuvre in tuning.predicted:
        before, after = manoeuvre.before, manoeuvre.after
        sentences.append(
            f"{capitalised(manoeuvre.name)}: vibration after the arrival "
            f"{plain(1e3 * before.residual_vibration)} mm before, "
            f"{plain(1e3 * after.residual_vibration)} mm after, peak to peak; largest error "
            f"{plain(1e3 * before.largest_error)} mm before, "
            f"{plain(1e3 * after.largest_error)} mm after (simulated)."
        )
    ringing = [r for r in tuning.shapers if r.residual_vibration.nominal > _MUCH]
    if ringing:
        sentences.append(_ringing_sentence(ringing, len(tuning.shapers)))
    return (*sentences, *(capitalised(note) for note in tuning.notes))


def _ringing_sentence(ringing: Sequence[RegionalShaper], count: int) -> str:
    """What it means that shapers leave much of the mode that friction holds."""
    where = f"In {len(ringing)} of {count} regions the shaper leaves more than half of a "
    if any(regional.share is None for regional in ringing):
        return where + "vibration at its frequency: don't count on the shaper alone there."
    return where + (
        "vibration of the held mode alone: it is made for legs with friction, on which the "
        "mode is slower while the carriages slide. Judge it by the random legs."
    )


def worst_margins_sentence(worst: Sequence[WorstMargin]) -> str:
    """The worst margins of the flexible robot's loops, in one line.

    Args:
        worst: The worst margins, at least one.

    Returns:
        The sentence, with where they are.
    """
    by_name = {margin.measure: margin for margin in worst}
    if "spectral_radius" in by_name:
        least = by_name["spectral_radius"]
        return (
            f"With these gains the flexible robot is UNSTABLE {_place(least)}: its closed "
            f"loop's largest pole has modulus {plain(least.value, 5)}. Lower the gains."
        )
    phase, delay, peak = (
        by_name[name] for name in ("phase_margin", "delay_margin", "peak_sensitivity")
    )
    return (
        "The flexible robot's loops, worst over the workspace: phase margin "
        f"{plain(float(np.degrees(phase.value)), 3)}° {_place(phase)}; peak sensitivity "
        f"{plain(peak.value, 3)} {_place(peak)}; delay margin {plain(1e3 * delay.value, 3)} ms "
        f"{_place(delay)}."
    )


def _place(margin: WorstMargin) -> str:
    return f"({margin.loop}, y {1e3 * margin.height:.0f} mm, {margin.pretension:g} N)"


def between_the_cells_sentence(maps: Sequence[ResidualMap]) -> str:
    """What the shapers leave between the cells' points, and how much more than at them.

    Args:
        maps: Residual vibration over the workspace, one map at least.

    Returns:
        The sentence, with the places.
    """
    worst = max(maps, key=lambda each: each.worst.value)
    further = max(maps, key=lambda each: each.beyond.value)
    more = 100 * further.beyond.value
    compared = (
        "nowhere more than stated for the region"
        if more < _NO_MORE
        else f"up to {plain(more, 3)} % of it more than stated for the region "
        f"{_pose(further.beyond, further)}"
    )
    return (
        "Wherever a leg ends, the shapers, blended between the regions, leave at most "
        f"{percent(worst.worst.value, 3)} of a vibration of the held mode "
        f"{_pose(worst.worst, worst)}; {compared}."
    )


def _pose(place: WorstResidual, of: ResidualMap) -> str:
    return f"(x {1e3 * place.x:.0f}, y {1e3 * place.y:.0f} mm, {of.pretension:g} N)"
