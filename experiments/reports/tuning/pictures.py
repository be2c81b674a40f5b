"""What a report shows of gains and shapers, before and after, in figures."""

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
from experiments.page.number_text import capitalised, plain
from experiments.page.page import Picture, Pictures
from experiments.reports.calibration.first_screen import exported_sides
from experiments.studies.findings.responses import open_loop
from experiments.studies.findings.tuning import (
    TuningFindings,
    worst_margins_sentence,
)
from experiments.studies.legs.in_space import in_space
from scdpr_jax.robot.drive import drive_gain, drive_pole
from scdpr_jax.robot.parameters import Robot
from tuning.loop.plant import MotorPlant
from tuning.regions.schedule import regions_at
from tuning.result.prediction import Prediction
from tuning.result.tuning import Tuning

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
            "vibration is close to zero inside it; dotted: 5 %. The last panel: the impulses.",
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
                f"{capitalised(manoeuvre.name)} in space. The path: the reference and both "
                "ways, the height enlarged where it hardly changes. The deviation: by how much "
                "they are off in every direction, lag taken off; the smaller the cloud, the "
                "truer the way.",
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
