"""Logged runs as legs that a robot is refined by."""

import pathlib
from collections.abc import Sequence

from identification.campaign.read import read_campaign
from identification.campaign.types import Run, Sensors
from identification.data.start import clocks, rest_until, start_pose
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import TILT, UPPER, X
from tuning.refinement.logged_leg import LoggedLeg

SEEN = [X, TILT, UPPER]
"""Columns of the camera that no drive leads."""


def read_runs(
    folders: Sequence[pathlib.Path], *, option: str = "--run"
) -> tuple[list[Run], Sensors]:
    """Runs by their folders, and the noise of their sensors.

    Args:
        folders: Folders of runs, of one campaign.
        option: The option that names them, for messages.

    Returns:
        The runs in this order, and the sensors.

    Raises:
        ValueError: If a folder is no run without faults, has no camera, or they differ in
            campaign or setting.
    """
    homes = {folder.resolve().parent for folder in folders}
    if len(homes) != 1:
        raise ValueError(
            f"`{option}`: got runs of {len(homes)} campaigns, expected one: "
            f"{', '.join(map(str, folders)) or 'none'}. Put the legs into one folder."
        )
    campaign = read_campaign(homes.pop(), skip_bad_runs=True)
    faults = dict(campaign.skipped)
    runs = []
    for folder in folders:
        name = folder.resolve().name
        if name in faults:
            raise ValueError(f"{folder}: {faults[name][0]}")
        if name not in {own.name for own in campaign.runs}:
            raise ValueError(
                f"`{option}`: got {folder}, expected a run's folder, with run.toml, drive.csv "
                "and camera.csv, in a campaign."
            )
        run = campaign.run(name)
        if run.camera is None:
            raise ValueError(
                f"`{option}`: {folder} has no camera.csv, expected one: encoders don't see how "
                "the carriages lie. Log it with the camera."
            )
        runs.append(run)
    if len({own.pretension for own in runs}) > 1:
        raise ValueError(
            f"`{option}`: the runs have the settings "
            f"{', '.join(sorted({own.pretension_label for own in runs}))}, expected one: "
            "tensions differ. Refine one setting after the other."
        )
    return runs, campaign.sensors


def logged_legs(robot: Robot, runs: Sequence[Run], sensors: Sensors) -> list[LoggedLeg]:
    """Runs as legs.

    Args:
        robot: The fitted robot.
        runs: The runs, each with a camera.
        sensors: Their noise.

    Returns:
        The legs.

    Raises:
        ValueError: If one doesn't move, or nothing tells where it started.
    """
    radius, height = float(robot.drive.effective_radius), float(robot.frame.height)
    legs = []
    for run, clock in zip(runs, clocks(runs, sensors, radius), strict=True):
        if rest_until(run) >= run.drive.time[-1]:
            raise ValueError(
                f"run {run.name!r} doesn't move, expected a leg: there is nothing to learn "
                "from it. Leave it out."
            )
        lower, upper, y = start_pose(run, clock.offset, sensors, height).position
        slope = float((lower - upper) / height)
        legs.append(
            LoggedLeg(
                name=run.name,
                time=run.drive.time,
                angle=run.drive.angle,
                voltage=run.drive.voltage,
                seen_time=run.camera.time - clock.offset,
                seen=run.camera.position[:, SEEN],
                place=(float(lower - slope * y), float(y)),
                slope=slope,
                noise=tuple(sensors.of_camera(run)[:2].tolist()),
            )
        )
    return legs
