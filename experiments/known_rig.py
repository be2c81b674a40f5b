"""What is known of a rig: from a campaign that is fitted, or from `parameters.json`."""

import pathlib
from collections.abc import Callable

import numpy as np

from experiments.next_run import Left, known_rig
from experiments.parameters_file import read_parameters
from identification.campaign import read_campaign
from identification.estimate import Estimate
from identification.next_experiment import Rig
from identification.selection import select
from identification.unknowns import PER_SETTING
from scdpr_jax.parameters import Robot


def rig_from(
    known: pathlib.Path,
    *,
    setting: str | None,
    top_speed: float,
    progress: Callable[[str, float], None],
) -> tuple[Rig, tuple[Left, ...]]:
    """What is known of a rig.

    Args:
        known: Folder of a campaign, or `parameters.json`.
        setting: Nominal pretension, "350 N"; None for the first one known.
        top_speed: Largest speed of the end-effector [m/s].
        progress: Told what is being done and which share of it is done.

    Returns:
        The rig, and what the fit leaves of each channel.

    Raises:
        ValueError: If the input can't be read, or doesn't know the setting.
    """
    if known.is_dir():
        campaign = read_campaign(known)
        found = select(campaign, progress=progress)
        rows = [p for p in found.parameters if p.status != "fixed"]
        of_setting, correlation = found.of_setting, found.correlation
        channels = left(found)
    else:
        read = read_parameters(known)
        rows = [row for row in read.parameters if row.status != "fixed"]
        if read.correlation is None or len(read.correlation.matrix) != len(rows):
            raise ValueError(
                f"{known}: has no correlation of its {len(rows)} estimated parameters, so "
                "nothing says what is known. Give a file that `scdpr identify` wrote."
            )
        of_setting, correlation = read.of_setting, np.array(read.correlation.matrix)
        channels = tuple(
            Left(one.channel, one.rms, one.noise_sigma, one.is_noise) for one in read.residuals
        )
    label = setting or next((row.setting for row in rows if row.name == PER_SETTING), None)
    rig = known_rig(
        of_setting(label or ""),
        rows,
        correlation,
        setting=label,
        channels=channels,
        top_speed=top_speed,
    )
    return rig, channels


def left(found: Estimate) -> tuple[Left, ...]:
    """What a fit leaves of each channel.

    Args:
        found: The estimate.

    Returns:
        One for each channel of each run.
    """
    return tuple(
        Left(one.name, one.rms, one.sigma, one.is_noise)
        for run in found.comparisons
        for one in run.channels
    )


def poses(robot: Robot) -> tuple[tuple[float, float], ...]:
    """Where a proposed run may start: left, and low and high in the middle.

    Args:
        robot: The robot.

    Returns:
        Poses of the end-effector [m].
    """
    width, height = float(robot.frame.width), float(robot.frame.height)
    return (
        (0.15 * width, 0.5 * height),
        (0.5 * width, 0.35 * height),
        (0.5 * width, 0.65 * height),
    )
