"""A run beside its simulation, channel by channel."""

import dataclasses

import equinox as eqx
import jax
import numpy as np
from jaxtyping import Array, Float, Int

from identification.campaign.types import Run, Sensors
from identification.data.record import MotorRecord, Record
from identification.fit.accumulate import motor_angles
from identification.fit.residuals import Circumstances, drive_time, frames, move
from identification.fit.unknowns.unknowns import apply
from scdpr_jax.robot.parameters import Robot

ENCODERS = ("alpha_1", "alpha_2")
CAMERA = ("x_e", "delta_e", "q_3", "q_4", "y_e")

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


Predicted = tuple[
    Float[Array | np.ndarray, "runs rows 5"],
    Float[Array | np.ndarray, "runs rows 2"],
    Float[Array | np.ndarray, "runs frames 5"],
]
"""Positions at the drive's rows, encoder angles, and positions at the camera's stamps."""


@eqx.filter_jit
def predictions(
    robot: Robot,
    free: tuple[str, ...],
    unknowns: Float[Array, "lanes n"],
    run: Int[Array, " lanes"],
    records: Record,
) -> Predicted:
    """Runs with the cable on as the robot would do them.

    Args:
        robot: The robot with its fixed quantities.
        free: Names of the free quantities.
        unknowns: For each lane its run's free quantities and its circumstances.
        run: Which of the runs each lane is.
        records: The runs.

    Returns:
        Positions at the drive's rows, encoder angles there, and positions at the camera's
        stamps [m, rad, m, m, m].
    """

    def one(
        unknown: Float[Array, " n"], number: Int[Array, ""]
    ) -> tuple[Float[Array, "rows 5"], Float[Array, "rows 2"], Float[Array, "frames 5"]]:
        record = jax.tree.map(lambda leaf: leaf[number], records)
        fitted = apply(robot, free, unknown[: len(free)])
        own = Circumstances(*unknown[len(free) :])
        motion = move(fitted, own, record)
        return motion.states.position, motion.angle, frames(motion, own, record)

    return jax.vmap(one)(unknowns, run)


def compare(
    predicted: Predicted,
    clocks: Float[np.ndarray, "runs 2"],
    records: Record,
    *,
    runs: tuple[Run, ...],
    sensors: Sensors,
    held_out: frozenset[str],
) -> tuple[Comparison, ...]:
    """Runs with the cable on beside their simulations.

    Args:
        predicted: What `predictions` gives for them.
        clocks: Their cameras' clocks, beside what was known of them before: offset [s] and
            drift [1].
        records: The runs' records.
        runs: The runs, in the same order.
        sensors: The sensors' noise.
        held_out: Names of the runs that were held out.

    Returns:
        A comparison for each run.

    Raises:
        FloatingPointError: If the simulation of a run isn't finite.
    """
    seen, frame, frame_time = (
        np.asarray(part) for part in (records.frame_weight, records.frame, records.frame_time)
    )
    found = []
    for number, run in enumerate(runs):
        path, angle, frames = (part[number] for part in predicted)
        rows = run.drive.time.size
        count = 0 if run.camera is None else run.camera.time.size
        if not (np.all(np.isfinite(path[:rows])) and np.all(np.isfinite(frames[:count]))):
            raise FloatingPointError(
                f"run {run.name!r}: the simulation isn't finite at the fitted values. "
                "Look at the run with `scdpr check`, or leave it out."
            )
        used = seen[number, :count] > 0
        measured = np.where(used, frame[number, :count], np.nan)
        since = drive_time(frame_time[number, :count], *map(float, clocks[number]))
        stamps = since + run.drive.time[0]
        found.append(
            _comparison(
                run,
                run.name in held_out,
                simulated_angle=angle[:rows],
                camera=(stamps, measured, frames[:count]),
                path=path[:rows],
                sensors=sensors,
            )
        )
    return tuple(found)


@eqx.filter_jit
def _motor_predictions(
    robot: Robot, free: tuple[str, ...], unknowns: Float[Array, "runs n"], records: MotorRecord
) -> Float[Array, "runs rows 2"]:
    return jax.vmap(lambda u, r: motor_angles(apply(robot, free, u).drive, r))(
        unknowns, records
    )


def compare_motors(
    robot: Robot,
    free: tuple[str, ...],
    unknowns: Float[Array, "runs n"],
    records: MotorRecord,
    *,
    runs: tuple[Run, ...],
    sensors: Sensors,
    held_out: frozenset[str],
) -> tuple[Comparison, ...]:
    """Steps of the bare drives beside their simulations; see `compare`."""
    angles = np.asarray(_motor_predictions(robot, free, unknowns, records))
    nothing = (np.zeros(0), np.zeros((0, 5)), np.zeros((0, 5)))
    return tuple(
        _comparison(
            run,
            run.name in held_out,
            simulated_angle=angles[number][: run.drive.time.size],
            camera=nothing,
            path=np.zeros((0, 5)),
            sensors=sensors,
        )
        for number, run in enumerate(runs)
    )


def _comparison(run, held_out, *, simulated_angle, camera, path, sensors) -> Comparison:
    stamps, measured, simulated = camera
    measured_angle = run.drive.angle - run.drive.angle[0]
    zero = np.mean(measured_angle - simulated_angle, axis=0)
    simulated_angle = simulated_angle + zero
    channels = [
        _channel(name, "rad", sensors.encoder_sigma, run.drive.time, difference)
        for name, difference in zip(ENCODERS, (measured_angle - simulated_angle).T, strict=True)
    ]
    for index, name in enumerate(CAMERA):
        difference = measured[:, index] - simulated[:, index]
        seen = np.isfinite(difference)
        if np.any(seen):
            angular = name == "delta_e"
            sigma = sensors.camera_angle_sigma if angular else sensors.camera_position_sigma
            unit = "rad" if angular else "m"
            channels.append(_channel(name, unit, sigma, stamps[seen], difference[seen]))
    return Comparison(
        name=run.name,
        kind=run.kind,
        held_out=held_out,
        time=run.drive.time,
        voltage=run.drive.voltage,
        measured_angle=measured_angle,
        simulated_angle=simulated_angle,
        frame_time=stamps,
        measured=measured,
        simulated=simulated,
        path=path,
        channels=tuple(channels),
    )


def _channel(name, unit, sigma, time, difference) -> Channel:
    return Channel(
        name=name,
        unit=unit,
        rms=float(np.sqrt(np.mean(np.square(difference)))),
        sigma=sigma,
        worst_time=float(time[np.argmax(np.abs(difference))]),
        count=difference.size,
    )
