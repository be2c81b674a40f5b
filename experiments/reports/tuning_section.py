"""What a report shows of gains and shapers, before and after: tables and figures."""

from collections.abc import Iterator

import numpy as np
from markupsafe import Markup

from experiments.figures.robot_film import Track, robot_film
from experiments.figures.tuning.bode import bode
from experiments.figures.tuning.legs_outcome import legs_outcome
from experiments.figures.tuning.margin_curves import margin_curves
from experiments.figures.tuning.path_in_space import path_in_space
from experiments.figures.tuning.residual_vibration_map import residual_vibration_map
from experiments.figures.tuning.shaper_response import shaper_response
from experiments.figures.tuning.tracking import tracking
from experiments.page.number_text import capitalised, percent, plain, short
from experiments.page.page import Picture, Pictures
from experiments.page.table import Table, table_of
from experiments.reports.calibration.first_screen import exported_sides
from experiments.studies.findings.responses import open_loop
from experiments.studies.findings.tuning import (
    TuningFindings,
    region_name,
    worst_margins_sentence,
)
from experiments.studies.legs.in_space import in_space
from scdpr_jax.legs.leg import Leg
from scdpr_jax.robot.drive import drive_gain, drive_pole
from scdpr_jax.robot.parameters import Robot
from tuning.loop.plant import MotorPlant
from tuning.regions.schedule import regions_at
from tuning.result.prediction import Metrics, Prediction
from tuning.result.regional_shaper import RegionalShaper
from tuning.result.tuning import Tuning

_SPARE = (("band [Hz]",), ("kind",), ("left, nominal", "worst"), ("from",), ("left of legs",))
"""What of a shaper a narrow terminal can do without: a file and a figure have it."""
_TOGETHER = 4
"""Shapers in one figure: more lines can't be told apart."""

_NAMES = ("before: Eq. (25), plain", "after: gains and shaper")
"""What is compared in space."""

DELAY = 1
"""Samples from a measurement to its command that the margins are given for."""


def tuning_pictures(
    findings: TuningFindings, *, robot: Robot, picture: Pictures
) -> tuple[Picture, ...]:
    """The figures of a tuning.

    Args:
        findings: What it comes to.
        robot: The robot that it is for.
        picture: The page's figures.

    Returns:
        Bode plot, margins, shapers, residual vibration, and the predicted manoeuvres.
    """
    return tuple(_pictures(findings, robot, picture))


def tuning_film(tuning: Tuning, robot: Robot, *, name: str) -> tuple[Markup, str] | None:
    """The robot on a predicted manoeuvre, with the tuned law.

    Args:
        tuning: The tuning.
        robot: The robot.
        name: What the drawing's identifiers begin with.

    Returns:
        The film and its caption; None where no manoeuvre has its runs.
    """
    runs = [m for m in tuning.predicted if m.run_before is not None and m.run_after is not None]
    if not runs:
        return None
    shown = runs[0]
    before, after = (
        Track(side, np.asarray(run.time), np.asarray(run.states.position))
        for side, run in (("before", shown.run_before), ("after", shown.run_after))
    )
    track = Track(f"{shown.name}, with the tuned gains and shaper", after.time, after.position)
    return (
        robot_film(robot, track, name=name, ghost=before),
        f"{capitalised(shown.name)}, simulated with the fitted robot, to scale and in real "
        "time: with the tuned gains and shaper, and dashed the end-effector as it goes before, "
        "with Eq. (25) and the plain reference. Red: its path.",
    )


def tuning_tables(tuning: Tuning) -> tuple[Table, ...]:
    """A tuning's gains, shapers and predictions.

    Args:
        tuning: The tuning.

    Returns:
        The tables that aren't empty.
    """
    shapers = map(_shaper, tuning.shapers)
    tables = (
        _gains(tuning),
        table_of("Shapers, for legs that end in the region", shapers, spare=_SPARE),
        _legs(tuning),
        _predicted(tuning),
    )
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


def _shaper(regional: RegionalShaper) -> dict[str, str]:
    times = np.atleast_1d(np.asarray(regional.shaper.times))
    amplitudes = np.atleast_1d(np.asarray(regional.shaper.amplitudes))
    return {
        "region": region_name(regional),
        "frequency [Hz]": short(regional.frequency, 4),
        "band [Hz]": _band(*regional.band),
        "from": "knock" if regional.measured else "model",
        "kind": regional.kind or "–",
        "left of legs": "–" if regional.share is None else percent(regional.share),
        "times [ms]": ", ".join(plain(1e3 * float(time), 3) for time in times),
        "amplitudes [1]": ", ".join(short(float(share), 3) for share in amplitudes),
        "left, nominal": percent(regional.residual_vibration.nominal),
        "worst": percent(regional.residual_vibration.worst),
    }


def _band(low: float, high: float) -> str:
    """A band with as many digits as tell its ends apart; the model's own frequency has none."""
    for digits in range(4, 8):
        ends = short(low, digits), short(high, digits)
        if ends[0] != ends[1]:
            return "–".join(ends)
    return short(low, 4)


def _legs(tuning: Tuning) -> Table:
    """Random legs before and after, leg for leg alike."""
    title = "Random legs over the workspace, on robots as they might be"
    if tuning.legs is None:
        return table_of(title, ())
    sides = [("Eq. (25), plain", tuning.legs.before), ("gains and shapers", tuning.legs.after)]
    if tuning.legs.planned is not None:
        count = len(tuning.legs.planned.vibration)
        sides.append((f"planned, the first {count}", tuning.legs.planned))
    return table_of(
        title,
        (
            {
                "command": name,
                **{
                    f"{what} [mm], {which}": plain(1e3 * float(np.quantile(values, at)), 3)
                    for what, values in (
                        ("vibration", outcome.vibration),
                        ("resting error", outcome.resting_error),
                    )
                    for which, at in (("median", 0.5), ("nine of ten", 0.9), ("worst", 1.0))
                },
            }
            for name, outcome in sides
        ),
    )


_COMPARED = (
    ("vibration after arrival [mm]", 1e3, "residual_vibration"),
    ("resting error [mm]", 1e3, "resting_error"),
    ("largest error, commanded [mm]", 1e3, "largest_error"),
    ("largest command [V]", 1.0, "largest_voltage"),
    ("saturated [%]", 100.0, "saturation"),
)


def _predicted(tuning: Tuning) -> Table:
    return table_of(
        "Manoeuvres, simulated before and after",
        (
            {"manoeuvre": f"{manoeuvre.name}, {side}", **_metrics(metrics), **_space(run)}
            for manoeuvre in tuning.predicted
            for side, metrics, run in (
                ("before", manoeuvre.before, manoeuvre.run_before),
                ("after", manoeuvre.after, manoeuvre.run_after),
            )
        ),
    )


def _metrics(metrics: Metrics) -> dict[str, str]:
    return {name: plain(f * getattr(metrics, field), 3) for name, f, field in _COMPARED}


def _space(run: Leg | None) -> dict[str, str]:
    """How far a run is behind its unshaped reference, and what is off besides."""
    placed = None if run is None else in_space(run)
    return {
        "behind the reference [s]": "–" if placed is None else plain(placed.lag),
        "largest error, lag taken off [mm]": (
            "–" if placed is None else plain(1e3 * float(placed.distance.max()), 3)
        ),
    }


def _pictures(findings: TuningFindings, robot: Robot, picture: Pictures) -> Iterator[Picture]:
    tuning, drive = findings.tuning, robot.drive
    yield from _legs_pictures(findings, picture)
    yield from _manoeuvre_pictures(tuning, robot, picture)
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
    yield from _residual_pictures(findings, picture)
    if findings.margins is not None:
        yield picture(
            margin_curves(findings.margins),
            "Margins of the flexible robot's loops over the height of the end-effector; the "
            "horizontal position doesn't matter. Sideways, the springs of the cables reduce "
            "the phase of the bare drive, while the upper carriage slides (solid) and while "
            "friction holds it (dashed). Higher phase margins and lower peaks are safer; "
            "below 30° or above 2 (dotted) a loop rings. A gap is an unstable loop.",
            seen=_margin_words(tuning),
        )
    for first in range(0, len(findings.shapers), _TOGETHER):
        yield picture(
            shaper_response(findings.shapers[first : first + _TOGETHER]),
            "Residual vibration of each shaper, over the frequency of the vibration. The "
            "shaded band is two standard errors wide on either side; a shaper that cancels the "
            "vibration is close to zero inside it. Right: the impulses. Dashed: 5 %.",
        )


def _margin_words(tuning: Tuning) -> str:
    words = "Phase margin and peak sensitivity over the height of the end-effector."
    return (
        f"{words} {worst_margins_sentence(tuning.worst_margins)}"
        if tuning.worst_margins
        else words
    )


def _legs_pictures(findings: TuningFindings, picture: Pictures) -> Iterator[Picture]:
    legs = findings.tuning.legs
    if legs is None:
        return
    sides = exported_sides(legs)
    told = "; ".join(
        f"{name}: half of the legs vibrate by less than "
        f"{plain(1e3 * float(np.median(outcome.vibration)))} mm, all by less than "
        f"{plain(1e3 * float(np.max(outcome.vibration)))} mm"
        for name, outcome in sides
    )
    yield picture(
        legs_outcome(sides),
        "Vibration and resting error of all legs, sorted: the share of the legs that have "
        "less. Further left is better, by a factor of ten at each tick; where two lines cross, "
        "some legs get worse.",
        seen=f"{capitalised(told)}.",
    )


def _residual_pictures(findings: TuningFindings, picture: Pictures) -> Iterator[Picture]:
    maps, shapers = findings.residual_maps, findings.tuning.shapers
    if maps:
        regions = [
            [regional.region for regional in regions_at(shapers, each.pretension)]
            for each in maps
        ]
        yield picture(
            residual_vibration_map(maps, regions),
            "Residual vibration of the held mode after a leg that ends at a pose, with the "
            "shaper of that pose: the worst over two standard errors of the frequency, which "
            "is the model's over the height, corrected by the knocks. Without a shaper it is "
            "100 % everywhere. Near the dashed lines the shapers of two regions are blended; "
            "the cross is the worst place. Places without colour are out of reach.",
            seen=f"Maps of the frame. {' '.join(findings.between_the_cells)}",
            narrow=len(maps) == 1,
        )


def _manoeuvre_pictures(tuning: Tuning, robot: Robot, picture: Pictures) -> Iterator[Picture]:
    limit = float(robot.drive.voltage_limit)
    for manoeuvre in tuning.predicted:
        if manoeuvre.run_before is not None and manoeuvre.run_after is not None:
            yield picture(
                tracking(manoeuvre.run_before, manoeuvre.run_after, voltage_limit=limit),
                f"{capitalised(manoeuvre.name)}, simulated with the fitted robot: before with "
                "the published gains and the plain reference, after with the tuned gains and "
                "the shaped one. A shaper delays: so each run is moved by the time that it is "
                "behind, and what is left is how far it is off in space. Look at what still "
                "moves after the arrival.",
                seen=_manoeuvre_words(manoeuvre),
            )
            yield picture(
                path_in_space(
                    in_space(manoeuvre.run_before), in_space(manoeuvre.run_after), names=_NAMES
                ),
                f"{capitalised(manoeuvre.name)} in space. Left the reference and both ways, "
                "the height enlarged where it hardly changes; right by how much they are off "
                "in every direction, lag taken off: the smaller the cloud, the truer the way.",
                seen=_manoeuvre_words(manoeuvre),
            )


def _manoeuvre_words(manoeuvre: Prediction) -> str:
    """What is to be seen of a manoeuvre before and after."""
    told = []
    for name, run in (("before", manoeuvre.run_before), ("after", manoeuvre.run_after)):
        placed = in_space(run)
        told.append(
            f"{name}, {plain(placed.lag)} s behind, at most "
            f"{plain(1e3 * float(placed.distance.max()))} mm off the reference"
        )
    return f"{capitalised(manoeuvre.name)}: {'; '.join(told)}."
