"""A campaign as the doctor holds it: what is known of the rig, and each run's signals."""

import dataclasses
import functools
import math
from collections.abc import Callable, Collection, Iterable

import numpy as np
from jaxtyping import Bool, Float64

from identification.campaign.notes.drive import GAP
from identification.campaign.notes.note import rig_value
from identification.campaign.types import Campaign, Initial, Knock, Run, encoder_resolution

X, D, Q3, Q4, Y = range(5)
"""Columns of the camera's positions: x_e, delta_e, q_3, q_4, y_e."""

CAMERA_COLUMNS = ("x_e", "delta_e", "q_3", "q_4", "y_e")
"""Their names."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Rig:
    """What is known of the rig before anything is fitted [SI]."""

    radius: float
    """Effective radius of the driver pulleys [m]."""
    width: float
    """Width of the frame [m]."""
    height: float
    """Height of the frame [m]."""
    lower_offset: float
    """Attachment point of the lower cables below the end-effector's centre of mass [m]."""
    upper_offset: float
    """Attachment point of the upper cables above it [m]."""
    inertia: float
    """Inertia of one drive at its pulley [kg m²], the nameplate's."""
    damping: float
    """Viscous damping of one drive [N m s]."""
    torque_per_volt: float
    """Torque of one drive at a volt [N m/V]."""
    voltage_limit: float
    """Largest command that the amplifiers take [V]."""
    end_effector_mass: float
    """Mass of the end-effector [kg]."""
    moved_mass: float
    """Mass of the end-effector and both carriages [kg]."""
    count: float
    """Angle of one encoder count at the pulley [rad]."""
    position_sigma: float
    """Noise of a position from the camera [m]."""


def rig_of(campaign: Campaign) -> Rig:
    """What a campaign states of its rig, and the paper's rig where it states nothing.

    Args:
        campaign: The campaign.

    Returns:
        The rig.
    """
    mass, lower, upper = (
        rig_value(name, campaign)
        for name in ("end_effector_mass", "lower_carriage_mass", "upper_carriage_mass")
    )
    count = campaign.sensors.encoder_sigma * math.sqrt(12)
    if campaign.counts_per_rev is not None:
        count = encoder_resolution(campaign.counts_per_rev)
    return Rig(
        radius=rig_value("effective_radius", campaign),
        width=rig_value("frame_width", campaign),
        height=rig_value("frame_height", campaign),
        lower_offset=rig_value("lower_offset", campaign),
        upper_offset=rig_value("upper_offset", campaign),
        inertia=rig_value("drive_inertia", campaign),
        damping=rig_value("drive_damping", campaign),
        torque_per_volt=rig_value("torque_per_volt", campaign),
        voltage_limit=rig_value("voltage_limit", campaign),
        end_effector_mass=mass,
        moved_mass=mass + lower + upper,
        count=count,
        position_sigma=campaign.sensors.camera_position_sigma,
    )


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Record:
    """One run's signals, as logged or as put right so far."""

    run: Run
    """The run as it was read."""
    kind: str
    """What it is, as its file says or as it turned out."""
    time: Float64[np.ndarray, " rows"]
    """Time of the drive's samples [s]."""
    voltage: Float64[np.ndarray, "rows 2"]
    """Commands [V]."""
    angle: Float64[np.ndarray, "rows 2"]
    """Angles of the driver pulleys [rad]."""
    trusted: Bool[np.ndarray, " rows"]
    """Whether the drive's sample counts."""
    commanded: bool = True
    """Whether its commands count."""
    frame_time: Float64[np.ndarray, " frames"] | None = None
    """Time of the camera's frames on its own clock [s], None without a camera."""
    position: Float64[np.ndarray, "frames 5"] | None = None
    """The camera's positions [m, rad], NaN where a marker was lost or doesn't count."""
    offset: float = 0.0
    """Camera time minus drive time [s], stated or estimated."""
    settled: bool = True
    """Whether the offset is stated, or has been estimated."""
    initial: Initial | None = None
    """Where the operator says that the run begins."""
    knock: Knock | None = None
    """Moment of the knock."""

    @property
    def name(self) -> str:
        """Name of the run."""
        return self.run.name

    @property
    def filmed(self) -> bool:
        """Whether there is a camera."""
        return self.position is not None

    @property
    def offset_known(self) -> bool:
        """Whether the log states the camera's clock."""
        return self.run.clock_offset is not None

    @functools.cached_property
    def period(self) -> float:
        """Sample period of the drive [s]."""
        return float(np.median(np.diff(self.time)))

    @functools.cached_property
    def gaps(self) -> tuple[tuple[float, float], ...]:
        """Start and end of the drive's gaps [s]."""
        rows = np.flatnonzero(np.diff(self.time) > GAP * self.period)
        return tuple((float(self.time[row]), float(self.time[row + 1])) for row in rows)


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Case:
    """The rig and its records."""

    rig: Rig
    """What is known of the rig."""
    records: tuple[Record, ...]
    """The runs."""

    @property
    def filmed(self) -> tuple[Record, ...]:
        """The runs with a camera."""
        return tuple(record for record in self.records if record.filmed)

    def only(self, names: Collection[str]) -> "Case":
        """The case with some of its runs.

        Args:
            names: Names of the runs to keep.

        Returns:
            The smaller case.
        """
        kept = tuple(record for record in self.records if record.name in names)
        return dataclasses.replace(self, records=kept)

    def updated(self, records: Iterable[Record]) -> "Case":
        """The case with some runs replaced by others of their names.

        Args:
            records: The new runs.

        Returns:
            The case with the same runs in the same order.
        """
        new = {record.name: record for record in records}
        records = tuple(new.get(record.name, record) for record in self.records)
        return dataclasses.replace(self, records=records)

    def map(self, change: Callable[[Record], Record]) -> "Case":
        """The case with every run changed.

        Args:
            change: What is done to a run.

        Returns:
            The changed case.
        """
        return dataclasses.replace(self, records=tuple(map(change, self.records)))


FEWEST_FRAMES = 8
"""Fewer frames than this tell nothing of a motion: the run counts as not filmed."""


def case_of(campaign: Campaign) -> Case:
    """A campaign as the doctor begins with it.

    Args:
        campaign: The campaign.

    Returns:
        The case, nothing put right yet.
    """
    return Case(rig=rig_of(campaign), records=tuple(map(record_of, campaign.runs)))


def record_of(run: Run) -> Record:
    """A run as the doctor begins with it.

    Args:
        run: The run.

    Returns:
        Its record; a camera of a few frames doesn't count.
    """
    record = Record(
        run=run,
        kind=run.kind,
        time=run.drive.time,
        voltage=run.drive.voltage,
        angle=run.drive.angle,
        trusted=np.ones(len(run.drive.time), dtype=bool),
        initial=run.initial,
        knock=run.knock,
    )
    if run.camera is None or len(run.camera.time) < FEWEST_FRAMES:
        return record
    return dataclasses.replace(
        record,
        frame_time=run.camera.time,
        position=run.camera.position,
        offset=run.clock_offset or 0.0,
        settled=run.clock_offset is not None,
    )
