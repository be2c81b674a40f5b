"""One logged run as arrays of fixed shape: what is simulated, and what it is compared with.

Runs of different length are padded, so that one compiled function serves all of them:
intervals of length zero, and samples of weight zero.
"""

import dataclasses
from collections.abc import Iterable, Sequence
from typing import TypeVar

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float, Int

from identification.campaign.types import Run, Sensors
from identification.data.beginning import start_in_motion
from identification.data.circumstances import Prior, prior
from identification.data.start import CLOCK_MARGIN, Clock, Start, start_pose
from scdpr_jax.engines.stepping import Inputs
from scdpr_jax.robot.fields import real, si
from scdpr_jax.robot.state import HEIGHT


class Record(eqx.Module):
    """A run with the cable on: inputs, measurements and their weights."""

    inputs: Inputs
    """Commands; the knock is 1 N while the end-effector is knocked, else 0."""
    angle: Float[Array, "... rows 2"] = eqx.field(converter=real, metadata=si("rad"))
    """Encoder angles at the ends of the intervals [rad]."""
    angle_weight: Float[Array, "... rows 2"] = eqx.field(converter=real, metadata=si("1/rad"))
    """Inverse standard deviation of the angles, see `readings` [1/rad]; 0 for none."""
    angle_share: Float[Array, "... rows 2"] = eqx.field(converter=real, metadata=si("1"))
    """How much of a measurement of its own each angle is, up to 1 [1]."""
    frame_time: Float[Array, "... frames"] = eqx.field(converter=real, metadata=si("s"))
    """Camera stamps on the drive's clock, since its first row [s]."""
    frame: Float[Array, "... frames 5"] = eqx.field(converter=real, metadata=si("m, rad"))
    """Camera positions; 0 where a marker was lost [m, rad, m, m, m]."""
    frame_weight: Float[Array, "... frames 5"] = eqx.field(converter=real, metadata=si("1/m"))
    """Inverse standard deviations of the positions; 0 where there is none [1/m, 1/rad]."""
    prior: Prior
    """What is known of the run's circumstances before any fit; the clock's offset is beyond
    what the stamps were put right by."""

    @property
    def length(self) -> Float[Array, ""]:
        """Length of the run [s]."""
        return jnp.sum(self.inputs.duration)

    @property
    def readings(self) -> Float[Array, "2"]:
        """Independent measurements of each encoder [1]."""
        return jnp.sum(self.angle_share, axis=0)

    @property
    def frames(self) -> Int[Array, "5"]:
        """Frames in which each of the camera's coordinates was measured [1]."""
        return jnp.sum(self.frame_weight > 0, axis=0)


class MotorRecord(eqx.Module):
    """A step of the bare drives, the cable off their pulleys, padded like `Record`."""

    duration: Float[Array, "... intervals"] = eqx.field(converter=real, metadata=si("s"))
    """Lengths of the intervals [s]."""
    voltage: Float[Array, "... intervals 2"] = eqx.field(converter=real, metadata=si("V"))
    """Commands [V]."""
    angle: Float[Array, "... rows 2"] = eqx.field(converter=real, metadata=si("rad"))
    """Encoder angles [rad]."""
    weight: Float[Array, "... rows 2"] = eqx.field(converter=real, metadata=si("1/rad"))
    """Inverse standard deviation of the angles, see `readings` [1/rad]; 0 for none."""
    share: Float[Array, "... rows 2"] = eqx.field(converter=real, metadata=si("1"))
    """How much of a measurement of its own each angle is, up to 1 [1]."""


AnyRecord = TypeVar("AnyRecord", Record, MotorRecord)


def readings(angle: Float[np.ndarray, "rows 2"]) -> Float[np.ndarray, "rows 2"]:
    """How much of an independent measurement each encoder sample is.

    A rounded encoder reads the same count for as long as the drive moves by less, and all
    these samples have one rounding error, not one each. So the `k` samples that read the
    same count in a row are one measurement, and a `k`-th of it each.

    Args:
        angle: Angles as they were read [rad].

    Returns:
        Shares, up to 1 [1].
    """
    shares = np.empty(angle.shape)
    for axis, read in enumerate(angle.T):
        begins = np.concatenate([[0], np.flatnonzero(np.diff(read) != 0) + 1])
        lengths = np.diff(np.append(begins, read.size))
        shares[:, axis] = np.repeat(1 / lengths, lengths)
    return shares


@dataclasses.dataclass(frozen=True)
class Reading:
    """How the runs of a campaign are read."""

    height: float
    """Height of the frame [m]."""
    radius: float
    """Effective radius of the driver pulleys [m]."""
    clock_drifts: bool = False
    """Whether the cameras' clocks may drift."""
    in_motion: bool = False
    """Whether any of the runs begins in motion."""
    sharing: int = 2
    """How many sums of frames may have their heights off by the same: the start's and the
    motion's of each run that states so."""


def record(run: Run, clock: Clock, sensors: Sensors, reading: Reading) -> Record:
    r"""The run as arrays.

    What a camera has all heights off by alike, $b$, is no noise: were the $n$ frames' heights
    taken for independent, they would tell the height $\sqrt n$ times too well, and with it the
    stiffness. What else heights tell, the encoders tell better, so each frame's variance is
    grown by $n b^2$, and they tell the height as well together as one frame does. Where $k$
    such sums are off by the same, as of runs before one camera, each is taken to be off by
    $\sqrt k b$ by itself, which is never too little.

    Args:
        run: A run with the cable on.
        clock: What is known of the camera's clock.
        sensors: The sensors' noise.
        reading: How the campaign's runs are read.

    Returns:
        The run's arrays. Camera frames from before anything moves tell the start; those
        and frames from outside the drive's stream aren't compared a second time.

    Raises:
        ValueError: If nothing tells where the run started.
    """
    time = run.drive.time - run.drive.time[0]
    share = readings(run.drive.angle)
    stamps, frame = _camera(run, clock.offset)
    margin = CLOCK_MARGIN if run.clock_offset is None or reading.clock_drifts else 0.0
    shared = np.sqrt(reading.sharing) * sensors.height_offset(run)
    start = _start(run, clock.offset, sensors, reading, height_offset=shared)
    inside = (stamps > start.until) & (stamps <= time[-1] - margin)
    seen = np.isfinite(frame) & inside[:, None]
    sigma = sensors.of_camera(run)
    sigma[HEIGHT] = np.hypot(sigma[HEIGHT], np.sqrt(seen[:, HEIGHT].sum()) * shared)
    return Record(
        inputs=Inputs(np.diff(time), run.drive.voltage[:-1], _knocked(run, time)),
        angle=run.drive.angle - run.drive.angle[0],
        angle_weight=np.sqrt(share) / sensors.encoder_sigma,
        angle_share=share,
        frame_time=stamps,
        frame=np.where(seen, frame, 0.0),
        frame_weight=seen / sigma,
        prior=prior(
            run,
            start,
            clock,
            clock_drifts=reading.clock_drifts,
            in_motion=reading.in_motion,
        ),
    )


def _start(
    run: Run, offset: float, sensors: Sensors, reading: Reading, *, height_offset: float
) -> Start:
    height, radius = reading.height, reading.radius
    if run.in_motion:
        return start_in_motion(run, offset, sensors, height=height, radius=radius)
    return start_pose(run, offset, sensors, height, height_offset=height_offset)


def stacked(
    runs: Sequence[Run], clocks: Sequence[Clock], sensors: Sensors, reading: Reading
) -> Record:
    """Runs with the cable on, padded to the longest and stacked.

    Args:
        runs: The runs.
        clocks: What is known of the camera's clock in each.
        sensors: The sensors' noise.
        reading: How the campaign's runs are read.

    Returns:
        Their records, with a leading axis over the runs.
    """
    return _padded(
        record(run, clock, sensors, reading) for run, clock in zip(runs, clocks, strict=True)
    )


def motor_record(runs: Sequence[Run], sensors: Sensors) -> MotorRecord:
    """Steps of the bare drives, padded to the longest and stacked.

    Args:
        runs: The runs, without the cable.
        sensors: The sensors' noise.

    Returns:
        Their records, with a leading axis over the runs.
    """
    shares = [readings(run.drive.angle) for run in runs]
    return _padded(
        MotorRecord(
            duration=np.diff(run.drive.time),
            voltage=run.drive.voltage[:-1],
            angle=run.drive.angle - run.drive.angle[0],
            weight=np.sqrt(share) / sensors.encoder_sigma,
            share=share,
        )
        for run, share in zip(runs, shares, strict=True)
    )


def _padded(records: Iterable[AnyRecord]) -> AnyRecord:
    """Records as one of NumPy arrays, padded with zeros to somewhat more than the longest."""

    def together(path: tuple, *arrays: Float[Array, "..."]) -> Float[np.ndarray, "..."]:
        longest, field = max(len(array) for array in arrays), path[0].name
        if field != "prior":
            fewer = field in _INTERVALS
            longest = _roomy(longest + fewer) - fewer
        stack = np.zeros((len(arrays), longest, *arrays[0].shape[1:]))
        for row, array in zip(stack, arrays, strict=True):
            row[: len(array)] = array
        return stack

    return jax.tree_util.tree_map_with_path(together, *records)


_INTERVALS = ("inputs", "duration", "voltage")
"""Fields of the records that have one row fewer than there are samples."""


def _roomy(samples: int) -> int:
    """The least of 2, 3, 4, 6, 8, 12 ... that is enough.

    Logs are of any length. Rounded up they are of few, and what was compiled for a campaign
    serves most others.
    """
    octave = 1 << max(samples - 1, 1).bit_length()
    return octave * 3 // 4 if samples <= octave * 3 // 4 else octave


def _camera(run: Run, offset: float) -> tuple[np.ndarray, np.ndarray]:
    if run.camera is None:
        # A frame in which nothing was seen, so that no array is empty.
        return np.zeros(1), np.full((1, 5), np.nan)
    return run.camera.time - offset - run.drive.time[0], run.camera.position


def _knocked(run: Run, time: np.ndarray) -> np.ndarray:
    """Share of each interval during which the end-effector is knocked."""
    if run.knock is None:
        return np.zeros(time.size - 1)
    start = run.knock.start - run.drive.time[0]
    inside = np.clip(time, start, start + run.knock.duration)
    return np.diff(inside) / np.diff(time)


def coarse(records: Record, factor: int) -> Record:
    """The same runs on a coarser grid, which is what a fit's Jacobians are made on.

    Voltages and knocks become their means over the longer intervals, so that every
    impulse is kept. An angle becomes the mean of the samples about its instant, and knows
    as much as these did together.

    Args:
        records: Records with a leading axis over the runs.
        factor: How many intervals become one.

    Returns:
        The records on the coarser grid.
    """
    inputs = records.inputs
    count = -(-inputs.duration.shape[-1] // factor)
    missing = count * factor - inputs.duration.shape[-1]

    def grouped(array: Float[np.ndarray, "runs intervals *rest"]) -> Float[np.ndarray, "..."]:
        padded = np.pad(array, [(0, 0), (0, missing)] + [(0, 0)] * (array.ndim - 2))
        return padded.reshape(array.shape[0], count, factor, *array.shape[2:])

    duration = grouped(inputs.duration)
    total = np.sum(duration, axis=2)
    share = duration / np.where(total > 0, total, 1.0)[:, :, None]
    information = windowed(np.square(records.angle_weight), factor)
    weighted = windowed(np.square(records.angle_weight) * np.asarray(records.angle), factor)
    return eqx.tree_at(
        lambda r: (r.inputs, r.angle, r.angle_weight, r.angle_share),
        records,
        (
            Inputs(
                duration=total,
                voltage=np.sum(share[..., None] * grouped(inputs.voltage), axis=2),
                knock=np.sum(share * grouped(inputs.knock), axis=2),
            ),
            weighted / np.where(information > 0, information, 1.0),
            np.sqrt(information),
            np.minimum(windowed(records.angle_share, factor), 1.0),
        ),
    )


def windowed(
    samples: Float[Array | np.ndarray, "runs rows 2"], factor: int
) -> Float[np.ndarray, "runs instants 2"]:
    """Sums over the samples about each instant of a coarser grid.

    Args:
        samples: Something of each sample.
        factor: How many intervals of the samples are one of the coarser grid.

    Returns:
        The sums; the first and the last window have half of the width.
    """
    samples = np.asarray(samples)
    intervals = samples.shape[1] - 1
    before = factor // 2
    instants = -(-intervals // factor) + 1
    after = instants * factor - before - samples.shape[1]
    padded = np.pad(samples, [(0, 0), (before, max(after, 0)), (0, 0)])
    grouped = padded[:, : instants * factor].reshape(samples.shape[0], instants, factor, 2)
    return grouped.sum(axis=2)
