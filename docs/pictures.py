"""The documentation's pictures: the figures of a calibration's report and of a plan.

    python docs/pictures.py FOLDER

They are the product's own figures of a virtual rig, made anew wherever the site is built. The
search for gains is a short one, so that the pictures take seconds.
"""

import pathlib
import sys
from collections.abc import Iterator

import matplotlib
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from experiments.figures.identification.frequency_map import (
    frequency_map,
    frequency_over_height,
)
from experiments.figures.identification.intervals import intervals
from experiments.figures.identification.residuals import residuals
from experiments.figures.identification.ring_down import ring_down_figure
from experiments.figures.identification.run_comparison import run_comparison
from experiments.figures.robot_view import robot_view, shown_instants
from experiments.figures.tuning.bode import bode
from experiments.figures.tuning.leg import leg
from experiments.figures.tuning.legs_outcome import legs_outcome
from experiments.figures.tuning.margin_curves import margin_curves
from experiments.figures.tuning.path_in_space import path_in_space
from experiments.figures.tuning.residual_vibration_map import residual_vibration_map
from experiments.figures.tuning.shaper_response import shaper_response
from experiments.figures.tuning.tracking import tracking
from experiments.reports.calibration.first_screen import exported_sides
from experiments.runtime import set_up
from experiments.studies.findings.findings import Findings
from experiments.studies.findings.parameters import estimated
from experiments.studies.findings.responses import open_loop
from experiments.studies.legs.in_space import in_space
from experiments.studies.legs.planned_leg import compare
from experiments.studies.pipeline import calibrate
from experiments.virtual_rig import rig
from scdpr_jax.robot.drive import drive_gain, drive_pole
from scdpr_jax.robot.quantities import value
from tuning import Effort, MotorPlant, plan_leg
from tuning.regions.schedule import regions_at

SEED = 1
"""Of the virtual rig: that of `scdpr demo`."""
EFFORT = Effort(legs=16, population=8, generations=2, planned=4)
"""Of the search for gains."""
START, END = (0.3, 0.55), (1.9, 0.55)
"""The leg that is planned [m]."""

Named = tuple[str, Figure]


def main(folder: pathlib.Path) -> None:
    """Write all pictures.

    Args:
        folder: Where they are to be; made where there is none.
    """
    set_up()
    folder.mkdir(parents=True, exist_ok=True)
    truth = rig.draw_truth(SEED)
    made = rig.campaign(truth, SEED)
    found = calibrate(made.with_runs(rig.DEMONSTRATED), leg_times=(2.0,), effort=EFFORT)
    for named in (_fit(found, truth.values), _frequencies(found), _tuning(found), _plan(found)):
        for name, figure in named:
            _write(figure, folder / f"{name}.svg")


def _write(figure: Figure, path: pathlib.Path) -> None:
    # Text as text, and identifiers that don't change from one run to the next.
    with matplotlib.rc_context({"svg.fonttype": "none", "svg.hashsalt": path.stem}):
        FigureCanvasSVG(figure).print_svg(path, metadata={"Date": None})


def _fit(found: Findings, truth: dict[str, float]) -> Iterator[Named]:
    """How sure, how well explained."""
    yield "intervals", intervals(estimated(found.estimate), truth=truth)
    shown = next(run for run in found.estimate.comparisons if run.held_out)
    yield "run", run_comparison(shown)
    yield "residuals", residuals(shown)
    instants = shown_instants(shown.time)[:2]
    yield (
        "robot",
        robot_view(found.estimate.robot, time=shown.time, path=shown.path, instants=instants),
    )


def _frequencies(found: Findings) -> Iterator[Named]:
    """Knocks, and what the model says of them."""
    robot, measured = found.estimate.robot, found.frequencies
    frame = tuple(float(value(robot, f"frame_{side}")) for side in ("width", "height"))
    settings = sorted(set(measured.pretension.tolist()))
    yield (
        "frequency-map",
        frequency_map(measured, found.model_curves, size=frame, settings=settings),
    )
    yield "frequency-over-height", frequency_over_height(measured, found.model_curves)
    yield "ring-down", ring_down_figure(found.decays[0])


def _tuning(found: Findings) -> Iterator[Named]:
    """Gains and shapers, and what they leave."""
    tuned, robot = found.tuning, found.estimate.robot
    tuning = tuned.tuning
    yield "legs", legs_outcome(exported_sides(tuning.legs))
    shown = tuning.predicted[0]
    limit = float(value(robot, "voltage_limit"))
    yield "tracking", tracking(shown.run_before, shown.run_after, voltage_limit=limit)
    before, after = in_space(shown.run_before), in_space(shown.run_after)
    yield "path", path_in_space(before, after, names=("before", "after"))
    plant = MotorPlant(gain=drive_gain(robot.drive), pole=drive_pole(robot.drive))
    crossover = float(tuning.margins.gain_crossover)
    loop = open_loop(plant, tuning.controller, delay=1, crossover=crossover)
    yield "bode", bode(loop, tuning.margins)
    regions = [
        [own.region for own in regions_at(tuning.shapers, each.pretension)]
        for each in tuned.residual_maps
    ]
    yield "residual-vibration", residual_vibration_map(tuned.residual_maps, regions)
    yield "margins", margin_curves(tuned.margins)
    yield "shapers", shaper_response(tuned.shapers[:4])


def _plan(found: Findings) -> Iterator[Named]:
    """A planned leg beside the plain one."""
    tuning = found.tuning.tuning
    robot = tuning.robots[0].robot
    planned = plan_leg(robot, tuning.controller, START, END)
    compared = compare(robot, tuning.controller, planned)
    limit = float(value(robot, "voltage_limit"))
    yield "plan", leg(compared, leg_time=float(planned.plan.time[-1]), voltage_limit=limit)


if __name__ == "__main__":
    main(pathlib.Path(sys.argv[1]))
