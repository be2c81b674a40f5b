"""What a campaign is once it is read: frozen data in SI units and radians."""

import collections
import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from jaxtyping import Float64, Shaped

from identification.campaign.faults import Fault
from scdpr_jax.robot.stated.units import si

CAMERA_COORDINATES: tuple[str, ...] = ("x_e", "delta_e", "q_3", "q_4", "y_e")
"""Columns of a camera's stream, in the order of the model's coordinates."""
HEIGHT_OFFSET = "y_e_offset"
"""Key beside these of a run's own camera: what is the same in all frames of `y_e`."""
KINDS: tuple[str, ...] = (
    "torque_step",
    "breakaway",
    "motor_step",
    "pseudo_impulse",
    "manoeuvre",
    "free",
)
"""The kinds of runs."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class DriveStream:
    """The controller's stream: commands and encoders, on the drive's clock."""

    time: Float64[np.ndarray, " rows"] = dataclasses.field(metadata=si("s", "t"))
    """Time [s], strictly increasing."""
    voltage: Float64[np.ndarray, "rows 2"] = dataclasses.field(metadata=si("V", "V"))
    """Commands to both servo-amplifiers [V], each held until the next row."""
    angle: Float64[np.ndarray, "rows 2"] = dataclasses.field(
        metadata=si("rad", r"\alpha_1, \alpha_2")
    )
    """Angles of both driver pulleys [rad], from an arbitrary zero."""
    current: Float64[np.ndarray, "rows 2"] | None = dataclasses.field(
        default=None, metadata=si("A", "i")
    )
    """Measured motor currents [A]."""
    tension: Float64[np.ndarray, " rows"] | None = dataclasses.field(
        default=None, metadata=si("N", "T")
    )
    """Measured tension of the cable [N]."""
    reference: Float64[np.ndarray, "rows 2"] | None = dataclasses.field(
        default=None, metadata=si("m", r"x_e, y_e")
    )
    """Commanded position of the end-effector, $[x_e, y_e]$ [m]."""
    extra: dict[str, Shaped[np.ndarray, " rows"]] = dataclasses.field(default_factory=dict)
    """Columns that the format doesn't know, by header, in their own units; text as text."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class CameraStream:
    """The vision system's stream: pose and carriages, on the camera's clock."""

    time: Float64[np.ndarray, " rows"] = dataclasses.field(metadata=si("s", "t"))
    """Time [s], strictly increasing."""
    position: Float64[np.ndarray, "rows 5"] = dataclasses.field(
        metadata=si("m, rad, m, m, m", "q")
    )
    r"""The model's coordinates $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m]; NaN
    where the marker was lost."""
    extra: dict[str, Shaped[np.ndarray, " rows"]] = dataclasses.field(default_factory=dict)
    """Columns that the format doesn't know, by header, in their own units; text as text."""

    @property
    def pose(self) -> Float64[np.ndarray, "rows 2"]:
        """The end-effector's place $[x_e, y_e]$ [m]."""
        return self.position[:, [0, 4]]


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class AccelerometerStream:
    """The stream of an accelerometer on the end-effector, on its own clock."""

    time: Float64[np.ndarray, " rows"] = dataclasses.field(metadata=si("s", "t"))
    """Time [s], strictly increasing."""
    along: Float64[np.ndarray, " rows"] = dataclasses.field(metadata=si("m/s^2", "a_x"))
    """Acceleration along the guides [m/s²], from any zero: gravity may be in it."""
    upwards: Float64[np.ndarray, " rows"] | None = dataclasses.field(
        default=None, metadata=si("m/s^2", "a_y")
    )
    """Acceleration upwards [m/s²]."""
    across: Float64[np.ndarray, " rows"] | None = dataclasses.field(
        default=None, metadata=si("m/s^2", "a_z")
    )
    """Acceleration towards the camera [m/s²]."""
    extra: dict[str, Shaped[np.ndarray, " rows"]] = dataclasses.field(default_factory=dict)
    """Columns that the format doesn't know, by header, in their own units; text as text."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Initial:
    """Where the operator put the end-effector before the run."""

    x_e: float = dataclasses.field(metadata=si("m", "x_e"))
    """Horizontal position [m]."""
    y_e: float = dataclasses.field(metadata=si("m", "y_e"))
    """Vertical position [m]."""
    placement_sigma: float = dataclasses.field(default=1e-3, metadata=si("m", r"\sigma_p"))
    """Standard deviation of the placement, of each coordinate [m]."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Knock:
    """When the end-effector was knocked; the force isn't known."""

    start: float = dataclasses.field(metadata=si("s", "t_k"))
    """Start on the drive's clock [s]."""
    duration: float = dataclasses.field(metadata=si("s", r"\tau_k"))
    """Duration [s]."""


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False)
class Run:
    """One logged run."""

    name: str
    """Name of its folder."""
    kind: str
    """One of `KINDS`."""
    pretension: float = dataclasses.field(metadata=si("N", "T"))
    """Nominal setting of the cable loop [N]."""
    pretension_label: str
    """The setting with its unit, equal for equal settings: "350 N"."""
    drive: DriveStream
    """The controller's stream."""
    camera: CameraStream | None = None
    """The vision system's stream, None without one."""
    accelerometer: AccelerometerStream | None = None
    """The accelerometer's stream, None without one."""
    notes: str = ""
    """The operator's notes."""
    initial: Initial | None = None
    """Nominal start, None if it wasn't noted."""
    knock: Knock | None = None
    """Moment of the knock, of a pseudo-impulse."""
    clock_offset: float | None = dataclasses.field(default=0.0, metadata=si("s", r"\Delta t"))
    """Camera time minus drive time [s], None if it is unknown and to be estimated."""
    in_motion: bool = False
    """Whether it begins in motion, so that its start velocities are estimated."""
    camera_sigma: dict[str, float] = dataclasses.field(default_factory=dict)
    """Standard deviations of its camera's columns that aren't the campaign's [m, rad]; under
    `HEIGHT_OFFSET` the part of y_e's that is the same in all frames [m]."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Sensors:
    """Standard deviations of the measurement noise."""

    encoder_sigma: float = dataclasses.field(default=1e-4, metadata=si("rad", r"\sigma_\alpha"))
    """Of an encoder's angle, at the driver pulley [rad]."""
    camera_position_sigma: float = dataclasses.field(
        default=1.9e-4, metadata=si("m", r"\sigma_x")
    )
    """Of a position from the camera [m]."""
    camera_angle_sigma: float = dataclasses.field(
        default=2e-3, metadata=si("rad", r"\sigma_\delta")
    )
    """Of the end-effector's rotation from the camera [rad]."""

    def of_camera(self, run: Run) -> Float64[np.ndarray, " 5"]:
        r"""Standard deviations of a run's camera, in the model's coordinates.

        Args:
            run: The run, which may state its own.

        Returns:
            Of $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m].
        """
        usual = dict.fromkeys(CAMERA_COORDINATES, self.camera_position_sigma)
        usual["delta_e"] = self.camera_angle_sigma
        own = usual | run.camera_sigma
        return np.array([own[name] for name in CAMERA_COORDINATES])

    @staticmethod
    def height_offset(run: Run) -> float:
        """What a run's camera may have every height off by alike.

        Args:
            run: The run.

        Returns:
            Its standard deviation [m]; 0 where the run states none.
        """
        return run.camera_sigma.get(HEIGHT_OFFSET, 0.0)


@dataclasses.dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Campaign:
    """One rig's logged runs, and what is known of the rig."""

    name: str
    """Name of the campaign."""
    runs: tuple[Run, ...]
    """The runs, in the order of their names."""
    counts_per_rev: float | None = dataclasses.field(default=None, metadata=si("1", ""))
    """Encoder counts of one turn of a driver pulley [1], None if unknown."""
    robot: dict[str, float] = dataclasses.field(default_factory=dict)
    """What is known of the robot [SI], by the names of
    `scdpr_jax.robot.quantities.QUANTITIES`."""
    sensors: Sensors = dataclasses.field(default_factory=Sensors)
    """The sensors' noise."""
    skipped: tuple[tuple[str, tuple[Fault, ...]], ...] = ()
    """Names of the runs that were left out, each with its faults."""
    accepted: tuple[str, ...] = ()
    """Contradictions of its sensors that a user has accepted, in words: results carry them."""
    source: str = ""
    """Hash of its files, `scdpr_jax.provenance.hash_of`; empty where there are none."""

    def __repr__(self) -> str:
        seconds = sum(float(run.drive.time[-1] - run.drive.time[0]) for run in self.runs)
        kinds = collections.Counter(run.kind for run in self.runs)
        lines = [
            f"Campaign {self.name!r}: {len(self.runs)} runs, {seconds:.0f} s",
            "  " + ", ".join(f"{count} {kind}" for kind, count in kinds.items()),
            "  at " + ", ".join(dict.fromkeys(run.pretension_label for run in self.runs)),
        ]
        if self.robot:
            lines.append(f"  stated of the robot: {', '.join(self.robot)}")
        if self.skipped:
            lines.append(f"  left out: {', '.join(name for name, _ in self.skipped)}")
        return "\n".join(lines)

    def run(self, name: str) -> Run:
        """The run of a name.

        Args:
            name: Name of its folder.

        Returns:
            The run.

        Raises:
            ValueError: If there is none.
        """
        for run in self.runs:
            if run.name == name:
                return run
        names = ", ".join(run.name for run in self.runs)
        raise ValueError(f"campaign {self.name!r}: no run {name!r}, expected one of: {names}.")

    def with_runs(self, names: Sequence[str]) -> "Campaign":
        """The campaign with some of its runs only.

        Args:
            names: Names of the runs to keep.

        Returns:
            The campaign with these runs, in this order.

        Raises:
            ValueError: If there is no run of a name.
        """
        return dataclasses.replace(self, runs=tuple(self.run(name) for name in names))


def encoder_resolution(counts_per_rev: float) -> float:
    """Angle of one encoder count at the driver pulley.

    Args:
        counts_per_rev: Encoder counts of one turn of the pulley [1].

    Returns:
        The angle [rad].
    """
    return 2 * math.pi / counts_per_rev


def default_sensors(counts_per_rev: float | None) -> Sensors:
    """The sensors' noise where nobody has stated it: that of the paper's rig.

    Args:
        counts_per_rev: Encoder counts of one turn of the pulley [1], None if unknown.

    Returns:
        The camera's noise as the paper's rig has it; the encoder's rounding to whole
        counts, uniform over one count, or 0.1 mrad where the counts aren't known.
    """
    if counts_per_rev is None:
        return Sensors()
    return Sensors(encoder_sigma=encoder_resolution(counts_per_rev) / math.sqrt(12))
