r"""How much the cables between the drives and the lower carriage give, from both sensors.

The model takes them for rigid, $q_3 = r(\alpha_1 + \alpha_2)/2$. A camera that sees the
carriage sees what is missing,

$$ q_3 - r\,(\alpha_1 + \alpha_2)/2 = -c\,F + a\,\Delta q + \text{const}, $$

with the force $F$ that the drives put on the carriage: what the motors give and their own
inertia, damping and friction don't take. An error of the radius goes with the way $\Delta q$,
a pretension or a friction that is wrong with neither, so that the regression needs nothing of
the fit but the drives. As a part of the fit it would cost every simulation two states.
"""

import dataclasses
from collections.abc import Iterator, Mapping

import numpy as np

from identification.campaign.types import Campaign, Run
from identification.data.circumstances import Circumstances
from identification.judge.uncertainty import ParameterEstimate
from identification.result.estimate import Estimate
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import replace

NAME = "drive_compliance"
"""The quantity's name."""
_WINDOW = 0.1
"""Time over which velocity and acceleration are taken from encoders [s]."""
_SURE = 5.0
"""Standard errors from zero below which cables count as rigid [1]."""
_LEAST = 2e-6
"""Least that is worth allowing for [m/N]: 0.1 mm under 50 N."""
_KINDS = ("torque_step", "manoeuvre", "pseudo_impulse")
"""Kinds of runs in which the drives move the cables."""


def with_compliance(found: Estimate, campaign: Campaign) -> Estimate:
    """An estimate with the cables' give, where the logs show any.

    Args:
        found: The estimate.
        campaign: The campaign that it is from.

    Returns:
        The estimate; with another row and another robot if they give.
    """
    measured = compliance(campaign, found.robot, found.circumstances)
    if measured is None:
        return found
    value, sigma = measured
    row = ParameterEstimate(
        name=NAME,
        setting=None,
        value=value,
        unit="m/N",
        sigma=sigma,
        interval95=(value - 1.96 * sigma, value + 1.96 * sigma),
        status="fixed",
    )
    fitted = dataclasses.replace(
        found.fitted,
        robot=replace(found.fitted.robot, {NAME: value}),
        parameters=(*found.fitted.parameters, row),
    )
    return dataclasses.replace(found, fitted=fitted)


def compliance(
    campaign: Campaign, robot: Robot, circumstances: Mapping[str, Circumstances]
) -> tuple[float, float] | None:
    """The cables' give and its standard error.

    Args:
        campaign: The campaign.
        robot: The fitted robot.
        circumstances: Of each run that was fitted, for its camera's clock.

    Returns:
        Both [m/N]; None where cables count as rigid or nothing tells.
    """
    runs = [run for run in campaign.runs if run.kind in _KINDS and run.name in circumstances]
    parts = [_normal(run, robot, circumstances[run.name]) for run in runs]
    parts = [part for part in parts if part is not None]
    if not parts:
        return None
    normal = sum(matrix for matrix, _, _, _ in parts)
    right = sum(vector for _, vector, _, _ in parts)
    if np.linalg.cond(normal) > 1e12:
        return None
    slopes = np.linalg.solve(normal, right)
    rows = sum(count for _, _, _, count in parts)
    squares = sum(square for _, _, square, _ in parts) - slopes @ right
    # What friction and windows leave lasts for a few frames: three tell as much as one.
    spread = 3 * max(squares, 0.0) / max(rows - 2 - len(parts), 1)
    value, sigma = -slopes[0], np.sqrt(spread * np.linalg.inv(normal)[0, 0])
    if not (value > _SURE * sigma and value > _LEAST):
        return None
    return float(value), float(sigma)


def _normal(
    run: Run, robot: Robot, clock: Circumstances
) -> tuple[np.ndarray, np.ndarray, float, int] | None:
    """Normal equations of a run by force and way, its own constant taken off."""
    if run.camera is None:
        return None
    rows = list(_frames(run, robot, clock))
    if len(rows) < 20:
        return None
    missing, force, way = np.array(rows).T
    columns = np.stack([force, way], axis=1)
    columns = columns - np.mean(columns, axis=0)
    missing = missing - np.mean(missing)
    # Frames that don't belong there: another marker, or none.
    good = np.abs(missing - np.median(missing)) < 10e-3
    columns, missing = columns[good], missing[good]
    return columns.T @ columns, columns.T @ missing, float(missing @ missing), len(missing)


def _frames(
    run: Run, robot: Robot, clock: Circumstances
) -> Iterator[tuple[float, float, float]]:
    """What is missing at the carriage, the force on it and its way, frame by frame."""
    drive, own = run.drive, robot.drive
    radius, inertia, damping = map(float, (own.effective_radius, own.inertia, own.damping))
    offset = (run.clock_offset or 0.0) + float(clock.clock_offset)
    begin, end = drive.time[0], drive.time[-1]
    seen = run.camera.time - offset - float(clock.clock_drift) * (run.camera.time - begin)
    way = radius * (drive.angle[:, 0] + drive.angle[:, 1]) / 2
    limit = 2 * float(own.voltage_limit)
    volts = np.clip(np.sum(drive.voltage, axis=1), -limit, limit)
    turning = np.tanh(np.gradient(drive.angle, drive.time, axis=0) / 0.05)
    torque = float(own.torque_per_volt) * volts - turning @ np.asarray(own.frictions)
    inside = (seen - begin >= _WINDOW / 2) & (end - seen >= _WINDOW / 2)
    good = inside & np.isfinite(run.camera.position[:, 2])
    edges = np.searchsorted(drive.time, [seen - _WINDOW / 2, seen + _WINDOW / 2])
    for frame in np.flatnonzero(good):
        near = slice(*edges[:, frame])
        # In units of half the window, in which a parabola's terms are of one size.
        share = 2 * (drive.time[near] - seen[frame]) / _WINDOW
        if share.size < 8:
            continue
        terms = np.stack([np.ones_like(share), share, share**2])
        place, slope, curve = np.linalg.solve(terms @ terms.T, terms @ way[near])
        speed, acceleration = 2 * slope / _WINDOW, 8 * curve / _WINDOW**2
        force = np.mean(torque[near]) / radius - 2 / radius**2 * (
            inertia * acceleration + damping * speed
        )
        yield run.camera.position[frame, 2] - place, force, place
