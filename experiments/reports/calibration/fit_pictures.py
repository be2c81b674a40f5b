"""The report's pictures of the fit: how sure, how well explained, run by run."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from markupsafe import Markup

from experiments.figures.identification.intervals import intervals, known_to, shown_name
from experiments.figures.identification.residuals import residuals
from experiments.figures.identification.run_comparison import run_comparison
from experiments.figures.robot_film import Track, robot_film
from experiments.page.coordinates import COORDINATES
from experiments.page.number_text import plain
from experiments.page.page import Picture, Pictures
from experiments.page.pictures.drawing import Draw, draw
from experiments.studies.findings.parameters import estimated
from identification.campaign.types import Campaign
from identification.fit.comparison import Comparison
from identification.judge.uncertainty import ParameterEstimate
from identification.result.estimate import Estimate

RUNS_DRAWN = 8
"""Runs that are drawn one by one: more would make the page heavy without telling more."""


class FitPictures:
    """The report's pictures of the fit, which are drawn while gains are still sought."""

    def __init__(
        self, campaign: Campaign, *, truth: dict[str, float] | None = None, draw: Draw = draw
    ) -> None:
        """A report without a picture.

        Args:
            campaign: The campaign.
            truth: True values by name [SI], where they are known.
            draw: What draws the report's figures.
        """
        self._campaign, self._truth = campaign, truth
        self.picture = Pictures(draw=draw)
        self.of_parameters: list[Picture] = []
        self.of_runs: list[dict[str, Any]] = []

    def begin(self, estimate: Estimate) -> None:
        """Have the pictures drawn.

        Args:
            estimate: The estimate that the report will be of.
        """
        drawn, _ = runs_to_draw(estimate.comparisons)
        self.of_runs = [_run(self._campaign, run, self.picture) for run in drawn]
        free = estimated(estimate)
        if free and estimate.fits:
            self.of_parameters = [_intervals(free, self._truth, self.picture)]


def runs_to_draw(
    comparisons: Sequence[Comparison],
) -> tuple[tuple[Comparison, ...], tuple[Comparison, ...]]:
    """The runs that the report draws one by one, and those that it doesn't.

    Args:
        comparisons: All runs.

    Returns:
        Held-out runs and those with the worst residuals, in the order that they have; and
        the rest.
    """

    def worst(comparison: Comparison) -> float:
        return max((channel.chi_square for channel in comparison.channels), default=0.0)

    ranked = sorted(comparisons, key=lambda one: (not one.held_out, -worst(one)))
    chosen = {one.name for one in ranked[:RUNS_DRAWN]}
    return (
        tuple(one for one in comparisons if one.name in chosen),
        tuple(one for one in comparisons if one.name not in chosen),
    )


def run_film(estimate: Estimate, *, name: str) -> tuple[Markup, str] | None:
    """The robot in the run that goes the furthest, a held-out one first.

    Args:
        estimate: The estimate.
        name: What the drawing's identifiers begin with.

    Returns:
        The film and its caption; None where no run has a path.
    """
    moved = [run for run in estimate.comparisons if run.path.size]
    if not moved:
        return None
    chosen = max(moved, key=lambda run: (run.held_out, float(np.ptp(run.path[:, 0]))))
    track = Track(f"simulated in run {chosen.name}", chosen.time, chosen.path)
    return (
        robot_film(estimate.robot, track, name=name),
        f"The fitted robot in run {chosen.name}, to scale and in real time: the end-effector's "
        "path in red, cables on the paths alpha (blue), beta (green) and gamma (purple), "
        "driver pulleys in the lower corners. Watch how far the carriages part and the "
        "end-effector tilts. Its width and the deflection pulleys aren't in the model.",
    )


def _intervals(
    free: Sequence[ParameterEstimate], truth: dict[str, float] | None, picture: Pictures
) -> Picture:
    told = [f"{shown_name(own)} {known_to(own)}" for own in free]
    return picture(
        intervals(free, truth=truth),
        "How well each parameter is known: the shorter the bar, the better. A bar that "
        "reaches the dashed lines is weakly identified or not at all. What may be zero is "
        "held against a tenth of its usual size where that is more than its value."
        + (
            " A cross left of its bar's end: the truth is inside the interval." if truth else ""
        ),
        seen=f"Bars of half of the 95 % intervals: {', '.join(told)}.",
        narrow=True,
    )


def _run(campaign: Campaign, comparison: Comparison, picture: Pictures) -> dict[str, Any]:
    run = campaign.run(comparison.name)
    return {
        "name": comparison.name,
        "kind": comparison.kind.replace("_", " "),
        "setting": run.pretension_label,
        "notes": run.notes,
        "held_out": comparison.held_out,
        "pictures": [
            picture(
                run_comparison(comparison),
                "Blue dots: camera. Thick blue line: encoder. Red: simulated, it should go "
                "through the dots and lie inside the thick line.",
                seen=f"Run {comparison.name}, measured and simulated over "
                f"{comparison.time[-1]:.1f} s. {_left(comparison)}",
            ),
            picture(
                residuals(comparison),
                "Residuals over the noise of the sensor, σ. A cloud inside the grey band is "
                "noise; a wave or a step is an effect that the model lacks.",
                seen=f"Residuals of run {comparison.name} over time. {_left(comparison)}",
            ),
        ],
    }


def _left(comparison: Comparison) -> str:
    """What a simulation leaves, channel by channel."""
    told = ", ".join(
        f"{COORDINATES[channel.name].symbol} {plain(channel.chi_square**0.5)}"
        for channel in comparison.channels
    )
    return f"Residuals over the noise: {told}."
