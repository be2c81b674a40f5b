r"""How a run begins that doesn't begin at rest, by its first samples.

Encoders and camera are followed back to the run's first row by polynomials through the samples
that come first (`identification.doctor.samples.begin`). The fit has the same samples as
measurements, so this is where it starts from, and as a prior it counts for little: a direction
that no sample tells is kept from running off, and nothing is known twice.
"""

import numpy as np
from jaxtyping import Float

from identification.campaign.types import Run, Sensors
from identification.data.start import CLOCK_MARGIN, Known, Start
from identification.doctor.samples.begin import at_begin
from scdpr_jax.robot.state import HEIGHT, LOWER, TILT, UPPER, X

TURNED = 0.04
"""Time over which the encoders are followed back [s]."""

SEEN = 0.2
"""Time over which the camera's frames are [s]."""

DRIVEN = 12
"""Frames that tell where what goes with the drives began."""

WIDE = 5.0
"""The prior's standard deviation over the error of the first samples [1]: they count again in
the fit, and as a prior for a twenty-fifth."""

LEAST = np.array([2e-3, 2e-2, 2e-2, 0.2, 2e-2, 0.1, 0.1])
"""Least standard deviations of the prior, in the order of `BEGINNING` [SI]."""


def start_in_motion(
    run: Run, offset: float, sensors: Sensors, *, height: float, radius: float
) -> Start:
    """Start of a run that begins in motion.

    Args:
        run: A run with the cable on.
        offset: Camera time minus drive time, as far as it is known [s].
        sensors: The sensors' noise.
        height: Height of the frame [m].
        radius: Effective radius of the driver pulleys [m].

    Returns:
        Start and its standard deviations; every frame of the run is left to the fit.

    Raises:
        ValueError: If the camera doesn't see how the run begins.
    """
    stamps, frames = _frames(run, offset)
    speeds = drive_speeds(run, sensors)
    sigma, turn = sensors.camera_position_sigma, sensors.camera_angle_sigma
    aside, tilt, upper = (
        at_begin(stamps, frames[:, column], SEEN, noise)
        for column, noise in ((X, sigma), (TILT, turn), (UPPER, sigma))
    )
    lower, y = (_driven(run, stamps, frames, radius, column) for column in (LOWER, HEIGHT))
    position = np.array([lower, upper.value, y])
    slope = (position[0] - position[1]) / height
    value = [
        aside.value - (position[0] - slope * position[2]),
        tilt.value - np.arctan(slope),
        aside.slope,
        tilt.slope,
        upper.slope,
        *speeds.value,
    ]
    error = [aside.error, tilt.error, aside.slope_error, tilt.slope_error, upper.slope_error]
    known = Known(np.array(value), np.maximum(WIDE * np.append(error, speeds.sigma), LEAST))
    near = np.array([sigma, max(sigma, upper.error), sigma])
    margin = CLOCK_MARGIN if run.clock_offset is None else 0.0
    return Start(position, WIDE * near, margin, known)


def drive_speeds(run: Run, sensors: Sensors) -> Known:
    """Angular velocities that the drives begin a run with.

    Args:
        run: The run.
        sensors: The sensors' noise.

    Returns:
        Both, with their standard deviations [rad/s].
    """
    time = run.drive.time - run.drive.time[0]
    both = [at_begin(time, angle, TURNED, sensors.encoder_sigma) for angle in run.drive.angle.T]
    return Known(np.array([b.slope for b in both]), np.array([b.slope_error for b in both]))


def _frames(run: Run, offset: float) -> tuple[np.ndarray, np.ndarray]:
    """The camera's frames from the first row on, on the drive's clock."""
    if run.camera is None:
        raise ValueError(
            f"run {run.name!r}: it begins in motion and has no camera.csv, expected frames "
            "that show how it begins [m]. Log from standstill on, or leave the run out."
        )
    stamps = run.camera.time - offset - run.drive.time[0]
    inside = stamps >= 0
    return stamps[inside], run.camera.position[inside]


def _driven(
    run: Run,
    stamps: Float[np.ndarray, " frames"],
    frames: Float[np.ndarray, "frames 5"],
    radius: float,
    column: int,
) -> float:
    """Where what goes with the drives began [m]: frames, less the way by the encoders."""
    sign = 1.0 if column == LOWER else -1.0
    turned = run.drive.angle - run.drive.angle[0]
    way = radius * (turned[:, 0] + sign * turned[:, 1]) / 2
    rows = np.flatnonzero(np.isfinite(frames[:, column]))[:DRIVEN]
    time = run.drive.time - run.drive.time[0]
    return float(np.mean(frames[rows, column] - np.interp(stamps[rows], time, way)))
