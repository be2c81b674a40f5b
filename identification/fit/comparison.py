"""A run beside its simulation, channel by channel."""

import dataclasses

import numpy as np
from jaxtyping import Float

from identification.campaign.types import CAMERA_COORDINATES
from identification.data.circumstances import CLOCK
from identification.fit.problem import Problem
from identification.fit.residuals import Predicted, drive_time
from identification.fit.run_sums import motor_angles

ENCODERS = ("alpha_1", "alpha_2")
CAMERA = CAMERA_COORDINATES

NOISE_LIMIT = {"encoder": 12.0, "camera": 1.75}
"""Mean squared residual up to which a channel may be noise [1].

12 is one whole count of an encoder: less it doesn't resolve while it stands. Fifty camera
frames of Gaussian noise stay below 1.75 but once in ten thousand.
"""


@dataclasses.dataclass(frozen=True)
class Channel:
    """How one measured quantity of a run fits its simulation."""

    name: str
    """Name of the column."""
    unit: str
    """SI unit."""
    rms: float
    """Root mean square of measurement minus simulation [unit]."""
    sigma: float
    """Standard deviation of the sensor's noise [unit]."""
    motion: float
    """Standard deviation of what was measured: how far the channel moves [unit]."""
    worst_time: float
    """Drive time of the largest residual [s]."""
    count: int
    """Number of measurements."""

    @property
    def chi_square(self) -> float:
        """Mean squared residual over the noise's variance [1]."""
        return (self.rms / self.sigma) ** 2

    @property
    def is_noise(self) -> bool:
        """Whether the residual may be the sensor's noise alone."""
        kind = "encoder" if self.name in ENCODERS else "camera"
        return self.chi_square <= NOISE_LIMIT[kind]


@dataclasses.dataclass(frozen=True, eq=False)
class Comparison:
    """A run beside its simulation."""

    name: str
    """Name of the run."""
    kind: str
    """Kind of the run."""
    held_out: bool
    """Whether the run said nothing about the shared quantities."""
    time: Float[np.ndarray, " rows"]
    """Drive time [s]."""
    voltage: Float[np.ndarray, "rows 2"]
    """Commands [V]."""
    measured_angle: Float[np.ndarray, "rows 2"]
    """Encoder angles from the start [rad]."""
    simulated_angle: Float[np.ndarray, "rows 2"]
    """Simulated angles; the encoders' arbitrary zero is matched [rad]."""
    frame_time: Float[np.ndarray, " frames"]
    """Camera stamps on the drive's clock [s]."""
    measured: Float[np.ndarray, "frames 5"]
    """Camera positions, NaN where nothing was seen or used [m, rad, m, m, m]."""
    simulated: Float[np.ndarray, "frames 5"]
    """Simulated positions at the camera's stamps [m, rad, m, m, m]."""
    path: Float[np.ndarray, "instants 5"]
    """Simulated positions at the drive's rows [m, rad, m, m, m]; empty without cable."""
    channels: tuple[Channel, ...]
    """How each channel fits."""


def comparisons(problem: Problem, point: Float[np.ndarray, " n"]) -> tuple[Comparison, ...]:
    """Every run beside its simulation, in the campaign's order.

    Args:
        problem: The problem.
        point: Vector of the fit.

    Returns:
        A comparison for each run.

    Raises:
        FloatingPointError: If the simulation of a run isn't finite.
    """
    logs, each = problem.logs, {}
    if logs.records is not None:
        predicted = problem.predictions(point)
        for row, run in enumerate(logs.cabled):
            each[run] = _cabled(problem, point, row, tuple(part[row] for part in predicted))
    if logs.motor_records is not None:
        angles = problem.of_motors(motor_angles, point)
        for run, angle in zip(logs.motors, angles, strict=True):
            rows = logs.runs[run].drive.time.size
            each[run] = _comparison(problem, run, simulated_angle=angle[:rows])
    return tuple(each[run] for run in range(len(logs.runs)))


def _cabled(
    problem: Problem, point: Float[np.ndarray, " n"], row: int, predicted: Predicted
) -> Comparison:
    """A run with the cable on beside what is predicted for it."""
    logs = problem.logs
    number, records, (path, angle, frames) = logs.cabled[row], logs.records, predicted
    run = logs.runs[number]
    rows = run.drive.time.size
    count = 0 if run.camera is None else run.camera.time.size
    if not (np.all(np.isfinite(path[:rows])) and np.all(np.isfinite(frames[:count]))):
        raise FloatingPointError(
            f"run {run.name!r}: the simulation isn't finite at the fitted values. "
            "Look at the run with `scdpr check`, or leave it out."
        )
    seen, frame, stamps = (
        np.asarray(part)[row, :count]
        for part in (records.frame_weight, records.frame, records.frame_time)
    )
    offset, drift = map(float, point[problem.unknowns.circumstances(number)][CLOCK])
    return _comparison(
        problem,
        number,
        simulated_angle=angle[:rows],
        frame_time=drive_time(stamps, offset, drift) + run.drive.time[0],
        measured=np.where(seen > 0, frame, np.nan),
        simulated=frames[:count],
        path=path[:rows],
    )


_UNSEEN = np.zeros((0, 5))
"""Positions of a run that no camera saw."""


def _comparison(
    problem: Problem,
    number: int,
    *,
    simulated_angle: Float[np.ndarray, "rows 2"],
    frame_time: Float[np.ndarray, " frames"] = _UNSEEN[:, 0],
    measured: Float[np.ndarray, "frames 5"] = _UNSEEN,
    simulated: Float[np.ndarray, "frames 5"] = _UNSEEN,
    path: Float[np.ndarray, "instants 5"] = _UNSEEN,
) -> Comparison:
    """A run beside its simulation; the encoders' arbitrary zero is matched."""
    run, sensors = problem.logs.runs[number], problem.logs.sensors
    measured_angle = run.drive.angle - run.drive.angle[0]
    zero = np.mean(measured_angle - simulated_angle, axis=0)
    simulated_angle = simulated_angle + zero
    channels = [
        _channel(
            name,
            "rad",
            sensors.encoder_sigma,
            time=run.drive.time,
            measured=measured_angle[:, number],
            simulated=simulated_angle[:, number],
        )
        for number, name in enumerate(ENCODERS)
    ]
    for index, name in enumerate(CAMERA):
        seen = np.isfinite(measured[:, index])
        if np.any(seen):
            unit = "rad" if name == "delta_e" else "m"
            channels.append(
                _channel(
                    name,
                    unit,
                    float(sensors.of_camera(run)[index]),
                    time=frame_time[seen],
                    measured=measured[seen, index],
                    simulated=simulated[seen, index],
                )
            )
    return Comparison(
        name=run.name,
        kind=run.kind,
        held_out=number in problem.held_out,
        time=run.drive.time,
        voltage=run.drive.voltage,
        measured_angle=measured_angle,
        simulated_angle=simulated_angle,
        frame_time=frame_time,
        measured=measured,
        simulated=simulated,
        path=path,
        channels=tuple(channels),
    )


def _channel(
    name: str,
    unit: str,
    sigma: float,
    *,
    time: Float[np.ndarray, " n"],
    measured: Float[np.ndarray, " n"],
    simulated: Float[np.ndarray, " n"],
) -> Channel:
    difference = measured - simulated
    return Channel(
        name=name,
        unit=unit,
        rms=float(np.sqrt(np.mean(np.square(difference)))),
        sigma=sigma,
        motion=float(np.std(measured)),
        worst_time=float(time[np.argmax(np.abs(difference))]),
        count=difference.size,
    )
