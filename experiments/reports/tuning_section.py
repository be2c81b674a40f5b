"""What a report says of gains and shapers, before and after."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from experiments.figures.tuning.bode import bode, open_loop
from experiments.figures.tuning.margin_curves import margin_curves
from experiments.figures.tuning.residual_vibration_map import residual_vibration_map
from experiments.figures.tuning.shaper_response import NamedShaper, shaper_response
from experiments.figures.tuning.tracking import tracking
from experiments.page.number_text import capitalised, percent, plain, short
from experiments.page.page import Picture, Pictures
from experiments.page.table import Table
from scdpr_jax.robot.drive import drive_gain, drive_pole
from scdpr_jax.robot.parameters import Robot
from tuning.loop.plant import MotorPlant
from tuning.loop.worst_margins import WorstMargin, margin_map
from tuning.regions.residual_map import ResidualMap, WorstResidual, residual_map
from tuning.regions.schedule import regions_at
from tuning.result.types import Metrics, RegionalShaper, Tuning

_TOGETHER = 4
"""Shapers in one figure: more lines can't be told apart."""

_MUCH = 0.5
"""Residual vibration from which a shaper does little against its mode [1]."""

_SAME = 0.01
"""Relative difference below which two shapers are drawn as one: a line's width."""

_NO_MORE = 0.01
"""Percentage points below which nothing is left beyond a promise."""

DELAY = 1
"""Samples from a measurement to its command that the margins are given for."""


class TuningSection(NamedTuple):
    """The part of a report that is about a tuning."""

    sentences: tuple[str, ...]
    """What it comes to, in plain words."""
    tables: tuple[Table, ...]
    """Gains, shapers and predictions."""
    pictures: tuple[Picture, ...]
    """Its figures."""


def tuning_section(tuning: Tuning, *, robot: Robot, picture: Pictures) -> TuningSection:
    """The part of a report that is about a tuning.

    Args:
        tuning: The tuning.
        robot: The robot that it is for.
        picture: The page's figures.

    Returns:
        Sentences, tables and figures.
    """
    maps = tuple(residual_map(tuning, known.pretension) for known in tuning.robots)
    between = (between_the_cells_sentence(maps),) if maps else ()
    return TuningSection(
        sentences=(*tuning_sentences(tuning), *between),
        tables=tuning_tables(tuning),
        pictures=tuple(_pictures(tuning, robot, maps, picture)),
    )


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
        f"PD gains {short(float(controller.proportional_gain), 5)} V/rad and "
        f"{short(float(controller.derivative_gain), 5)} V s/rad, with {margin}° of phase "
        "margin of a bare drive as sampled.",
    ]
    if tuning.worst_margins:
        sentences.append(worst_margins_sentence(tuning.worst_margins))
    for one in tuning.predicted:
        before, after = one.before.residual_vibration, one.after.residual_vibration
        sentences.append(
            f"{capitalised(one.name)}: vibration after the arrival {plain(1e3 * before)} mm "
            f"before, {plain(1e3 * after)} mm after, peak to peak; largest error "
            f"{plain(1e3 * one.before.largest_error)} mm before, "
            f"{plain(1e3 * one.after.largest_error)} mm after (simulated)."
        )
    ringing = [one for one in tuning.shapers if one.residual_vibration.nominal > _MUCH]
    if ringing:
        sentences.append(
            f"In {len(ringing)} of {len(tuning.shapers)} regions the shaper leaves more than "
            "half of a vibration at its frequency: don't count on the shaper alone there."
        )
    return (*sentences, *(capitalised(note) for note in tuning.notes))


def worst_margins_sentence(worst: Sequence[WorstMargin]) -> str:
    """The worst margins of the flexible robot's loops, in one line.

    Args:
        worst: The worst margins, at least one.

    Returns:
        The sentence, with where they are.
    """
    by_name = {one.measure: one for one in worst}
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


def _place(one: WorstMargin) -> str:
    return f"({one.loop}, y {1e3 * one.height:.0f} mm, {one.pretension:g} N)"


def between_the_cells_sentence(maps: Sequence[ResidualMap]) -> str:
    """What the shapers leave between the cells' points, and how much more than at them.

    Args:
        maps: Residual vibration over the workspace, one map at least.

    Returns:
        The sentence, with the places.
    """
    worst = max(maps, key=lambda one: one.worst.value)
    further = max(maps, key=lambda one: one.beyond.value)
    more = 100 * further.beyond.value
    compared = (
        "nowhere more than its cell promises"
        if more < _NO_MORE
        else f"up to {plain(more, 3)} percentage points more than its cell promises "
        f"{_pose(further.beyond, further)}"
    )
    return (
        "Wherever a leg ends, the shapers, blended between the regions, leave at most "
        f"{percent(worst.worst.value, 3)} of a vibration of the held mode "
        f"{_pose(worst.worst, worst)}; {compared}."
    )


def _pose(place: WorstResidual, of: ResidualMap) -> str:
    return f"(x {1e3 * place.x:.0f}, y {1e3 * place.y:.0f} mm, {of.pretension:g} N)"


def tuning_tables(tuning: Tuning) -> tuple[Table, ...]:
    """A tuning's gains, shapers and predictions.

    Args:
        tuning: The tuning.

    Returns:
        The tables that aren't empty.
    """
    tables = (_gains(tuning), _shapers(tuning), _predicted(tuning))
    return tuple(table for table in tables if table.rows)


def _gains(tuning: Tuning) -> Table:
    controller, margins = tuning.controller, tuning.margins
    gain_margin = float(margins.gain_margin)
    return Table(
        "Controller of both drives",
        ("quantity", "value", "unit"),
        (
            ("proportional gain", short(float(controller.proportional_gain)), "V/rad"),
            ("derivative gain", short(float(controller.derivative_gain)), "V s/rad"),
            ("derivative filter", short(1e3 * float(controller.filter_time), 4), "ms"),
            ("sample period", short(1e3 * float(controller.period), 4), "ms"),
            ("gain crossover", short(float(margins.gain_crossover), 4), "rad/s"),
            ("phase margin", short(float(np.degrees(margins.phase_margin)), 4), "°"),
            ("delay margin", short(1e3 * float(margins.delay_margin), 4), "ms"),
            ("gain margin", short(20 * float(np.log10(gain_margin)), 4), "dB"),
            ("peak sensitivity", short(float(margins.peak_sensitivity), 4), "1"),
        ),
    )


def _shapers(tuning: Tuning) -> Table:
    return Table(
        "Shapers, for legs that end in the region",
        (
            "region",
            "frequency [Hz]",
            "band [Hz]",
            "from",
            "times [ms]",
            "amplitudes [1]",
            "left, nominal",
            "worst",
        ),
        tuple(_shaper(one) for one in tuning.shapers),
    )


def _shaper(one: RegionalShaper) -> tuple[str, ...]:
    times = np.atleast_1d(np.asarray(one.shaper.times))
    amplitudes = np.atleast_1d(np.asarray(one.shaper.amplitudes))
    return (
        region_name(one),
        short(one.frequency, 4),
        f"{short(one.band[0], 4)} … {short(one.band[1], 4)}",
        "knock" if one.measured else "model",
        ", ".join(short(1e3 * float(time), 3) for time in times),
        ", ".join(short(float(amplitude), 3) for amplitude in amplitudes),
        percent(one.residual_vibration.nominal),
        percent(one.residual_vibration.worst),
    )


def region_name(one: RegionalShaper) -> str:
    """A region in one line.

    Args:
        one: The regional shaper.

    Returns:
        Its ranges [mm, N].
    """
    x, y = ([f"{1e3 * end:.0f}" for end in pair] for pair in (one.region.x, one.region.y))
    low, high = one.region.pretension
    tension = f"{low:g} N" if low == high else f"{low:g}–{high:g} N"
    return f"x {x[0]}–{x[1]}, y {y[0]}–{y[1]} mm, {tension}"


_COMPARED = (
    ("vibration after arrival [mm]", 1e3, "residual_vibration"),
    ("resting error [mm]", 1e3, "resting_error"),
    ("largest error, commanded [mm]", 1e3, "largest_error"),
    ("largest error, unshaped [mm]", 1e3, "largest_original_error"),
    ("largest command [V]", 1.0, "largest_voltage"),
    ("saturated [%]", 100.0, "saturation"),
)


def _predicted(tuning: Tuning) -> Table:
    def line(name: str, metrics: Metrics) -> tuple[str, ...]:
        return (name, *(plain(f * getattr(metrics, field), 3) for _, f, field in _COMPARED))

    return Table(
        "Manoeuvres, simulated before and after",
        ("manoeuvre", *(name for name, _, _ in _COMPARED)),
        tuple(
            row
            for one in tuning.predicted
            for row in (
                line(f"{one.name}, before", one.before),
                line(f"{one.name}, after", one.after),
            )
        ),
    )


def _pictures(
    tuning: Tuning, robot: Robot, maps: Sequence[ResidualMap], picture: Pictures
) -> Iterator[Picture]:
    drive = robot.drive
    plant = MotorPlant(gain=drive_gain(drive), pole=drive_pole(drive))
    crossover = float(tuning.margins.gain_crossover)
    if np.isfinite(crossover):
        loop = open_loop(plant, tuning.controller, delay=DELAY, crossover=crossover)
        yield picture(
            bode(loop, tuning.margins),
            "Open loop of a drive as the controller runs it, sampled and one sample late. The "
            "thick bars are the margins; the further from zero, the safer.",
            narrow=True,
        )
    if tuning.robots:
        yield picture(
            margin_curves(margin_map(tuning.robots, tuning.controller)),
            "Margins of the flexible robot's loops over the height of the end-effector; the "
            "horizontal position doesn't matter. Sideways the cables' springs take away from "
            "the bare drive's phase, while the upper carriage slides (solid) and while "
            "friction holds it (dashed). Higher phase margins and lower peaks are safer; "
            "dotted: 30° and 2, short of which a loop rings. A gap is an unstable loop.",
        )
    named = distinct_shapers(tuning)
    for first in range(0, len(named), _TOGETHER):
        yield picture(
            shaper_response(named[first : first + _TOGETHER]),
            "What each shaper leaves of a vibration, over the vibration's frequency. Inside "
            "its shaded band, two standard errors to either side, a shaper that cancels the "
            "vibration is near zero. Right: the impulses. Dashed: 5 %.",
        )
    if maps:
        here = [regions_at(tuning.shapers, one.pretension) for one in maps]
        yield picture(
            residual_vibration_map(maps, [[one.region for one in known] for known in here]),
            "What is left of a vibration of the held mode after a leg that ends at a pose, by "
            "the shaper of that pose: the worst over two standard errors of the frequency, "
            "which is the model's over the height, corrected by the knocks. Without a shaper "
            "it is 100 % everywhere. About the dashed lines the regions' shapers are blended; "
            "the cross is the worst place. White is out of reach.",
        )
    limit = float(drive.voltage_limit)
    for one in tuning.predicted:
        if one.run_before is not None and one.run_after is not None:
            yield picture(
                tracking(one.run_before, one.run_after, voltage_limit=limit),
                f"{capitalised(one.name)}, simulated with the fitted robot: before with the "
                "published gains and the plain reference, after with the tuned gains and the "
                "shaped one. Look at the lower left: what still moves after the arrival.",
            )


def distinct_shapers(tuning: Tuning) -> list[NamedShaper]:
    """A tuning's shapers, those that are the same to the eye as one.

    Args:
        tuning: The tuning.

    Returns:
        Shapers, named by the first region and how many more there are, with the band of
        all of them.
    """
    groups: list[list[RegionalShaper]] = []
    for one in tuning.shapers:
        for group in groups:
            if _alike(one, group[0]):
                group.append(one)
                break
        else:
            groups.append([one])
    return [
        NamedShaper(
            region_name(group[0]) + (f" and {len(group) - 1} more" if len(group) > 1 else ""),
            group[0].shaper,
            group[0].damping_ratio,
            (min(one.band[0] for one in group), max(one.band[1] for one in group)),
        )
        for group in groups
    ]


def _alike(first: RegionalShaper, second: RegionalShaper) -> bool:
    pairs = (
        (first.shaper.times, second.shaper.times),
        (first.shaper.amplitudes, second.shaper.amplitudes),
        (first.frequency, second.frequency),
    )
    return all(
        np.shape(a) == np.shape(b) and np.allclose(a, b, rtol=_SAME, atol=0) for a, b in pairs
    )
