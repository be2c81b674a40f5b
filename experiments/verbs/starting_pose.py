"""Where a planned leg begins: asked for, told, or as a run's camera saw it last."""

import pathlib
from typing import TYPE_CHECKING, NamedTuple

from experiments.verbs.places import parse_position

if TYPE_CHECKING:
    from scdpr_jax.robot.parameters import Robot

FRAMES = 10
"""Last frames of a run's camera that are averaged: a tenth of a milliradian of slope."""


class Begin(NamedTuple):
    """Where a leg begins."""

    place: tuple[float, float]
    """Where the end-effector rests, $[x_e, y_e]$ [m]."""
    slope: float | None
    """Slope of the line between the carriages [1]; None where it isn't told."""


def beginning(
    robot: "Robot", begin: str | None, start: str | None, run: pathlib.Path | None
) -> Begin:
    """Where a leg begins.

    Args:
        robot: The robot.
        begin: `--from`: a position.
        start: `--start`: a pose with the carriages.
        run: `--start-run`: a logged run.

    Returns:
        The place, and the slope where it is told.

    Raises:
        ValueError: If not exactly one of them is given, or it can't be read.
    """
    given = [own for own in (begin, start, run) if own is not None]
    if len(given) != 1:
        raise ValueError(
            f"a leg begins in one place, got {len(given)} of `--from`, `--start` and "
            "`--start-run`, expected one of them. Name where the end-effector rests, such as "
            '--from "0.3 m, 0.55 m".'
        )
    if begin is not None:
        return Begin(parse_position(begin, name="--from", robot=robot), None)
    from scdpr_jax.legs.starts import steepest_held_slope
    from tuning.plan.planning import UNSTEADY, resting_start

    pose = _stated(start) if start is not None else _last_frames(run)
    place, slope = resting_start(robot, pose)
    steepest = steepest_held_slope(robot)
    if abs(slope) > 2 * steepest + UNSTEADY:
        raise ValueError(
            f"{'`--start`' if start is not None else run}: the carriages' line has a slope of "
            f"{slope:.4f}, expected at most {steepest:.4f}, which friction holds at rest. Give "
            "a robot at rest: q_3 is the lower carriage's place and q_4 the upper one's."
        )
    text = f"{place[0]} m, {place[1]} m"
    return Begin(parse_position(text, name="the start", robot=robot), slope)


def _stated(text: str) -> list[float]:
    from identification.campaign.quantities import parse_quantity

    names = ("x_e", "y_e", "delta_e", "q_3", "q_4")
    units = ("m", "m", "rad", "m", "m")
    parts = text.split(",")
    if len(parts) != len(names):
        raise ValueError(
            f"`--start` isn't a pose, got {text!r}, expected five quantities: x_e, y_e, "
            'delta_e, q_3, q_4, such as "0.3 m, 0.55 m, 0 rad, 0.302 m, 0.298 m".'
        )
    x, y, tilt, lower, upper = (
        parse_quantity(part.strip(), unit=unit, name=f"--start ({name})")
        for part, unit, name in zip(parts, units, names, strict=True)
    )
    return [x, tilt, lower, upper, y]


def _last_frames(run: pathlib.Path) -> list[float]:
    import numpy as np

    from experiments.studies.legs.logged_legs import read_runs

    (found,), _ = read_runs([run], option="--start-run")
    seen = found.camera.position[np.all(np.isfinite(found.camera.position), axis=1)]
    if len(seen) == 0:
        raise ValueError(
            f"`--start-run`: {run / 'camera.csv'} has no row in which every marker is seen. "
            "Give the pose with `--start`."
        )
    return [float(number) for number in np.median(seen[-FRAMES:], axis=0)]
