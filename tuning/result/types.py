"""What tuning gives: gains, a shaper for each region, and what they are predicted to do."""

import dataclasses

import numpy as np
from jaxtyping import Float

from scdpr_jax.command.controller import PD
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from tuning.loop.margins import Margins
from tuning.loop.worst_margins import WorstMargin

Range = tuple[float, float]
"""Lower and upper end."""


@dataclasses.dataclass(frozen=True)
class Region:
    """A part of the workspace at some pretension settings."""

    x: Range = dataclasses.field(metadata=si("m", "x_e"))
    """Horizontal positions of the end-effector [m]."""
    y: Range = dataclasses.field(metadata=si("m", "y_e"))
    """Heights of the end-effector [m]."""
    pretension: Range = dataclasses.field(metadata=si("N", "T"))
    """Nominal settings of the cable loop [N]."""

    def contains(self, x: float, y: float, pretension: float) -> bool:
        """Whether a pose at a setting lies in the region, its edges included.

        Args:
            x: Horizontal position of the end-effector [m].
            y: Its height [m].
            pretension: Nominal setting [N].

        Returns:
            Whether it does.
        """
        pairs = ((x, self.x), (y, self.y), (pretension, self.pretension))
        return all(low <= number <= high for number, (low, high) in pairs)


@dataclasses.dataclass(frozen=True)
class ResidualVibration:
    """Share of a linear mode's vibration that a shaper leaves, see `residual_vibration`."""

    nominal: float = dataclasses.field(metadata=si("1", "V"))
    """At the cell's frequency [1]."""
    worst: float = dataclasses.field(metadata=si("1", "V"))
    """Largest over the frequency's band of two standard errors [1]."""


@dataclasses.dataclass(frozen=True, eq=False)
class RegionalShaper:
    """The shaper of a region, for legs that end in it."""

    region: Region
    """Where it holds."""
    height: float = dataclasses.field(metadata=si("m", "y_e"))
    """Height at which its frequency holds [m]."""
    shaper: Shaper
    """The impulses."""
    frequency: float = dataclasses.field(metadata=si("Hz", "f_n"))
    """Natural frequency with both carriages held by friction [Hz]."""
    band: Range = dataclasses.field(metadata=si("Hz"))
    """That frequency less and plus two standard errors [Hz]."""
    damping_ratio: float = dataclasses.field(metadata=si("1", r"\zeta"))
    """Damping ratio at that frequency [1]."""
    measured: bool
    """Whether the frequency was measured in the region; otherwise it is the model's."""
    residual_vibration: ResidualVibration
    """What the shaper leaves of the linear mode that is held by friction."""


@dataclasses.dataclass(frozen=True)
class Metrics:
    """What a manoeuvre under control comes to."""

    residual_vibration: float = dataclasses.field(metadata=si("m"))
    """Peak to peak of $x_e$ once the commanded reference has ended [m]."""
    resting_error: float = dataclasses.field(metadata=si("m"))
    """Distance from the last commanded position to where the end-effector rests [m]."""
    largest_error: float = dataclasses.field(metadata=si("m", r"\varepsilon_e"))
    """Largest error against the commanded (shaped) reference, Eq. (26) [m]."""
    rms_error: float = dataclasses.field(metadata=si("m", r"\varepsilon_e"))
    """Root mean square of it until the reference ends [m]."""
    largest_original_error: float = dataclasses.field(metadata=si("m", r"\varepsilon_e"))
    """Largest error against the reference before shaping, Eq. (26) [m]."""
    largest_voltage: float = dataclasses.field(metadata=si("V", "V"))
    """Largest command of either drive [V]."""
    saturation: float = dataclasses.field(metadata=si("1"))
    """Share of the samples at which a drive is saturated [1]."""


@dataclasses.dataclass(frozen=True, eq=False)
class TrackingRun:
    """Traces of a manoeuvre under control."""

    time: Float[np.ndarray, " samples"] = dataclasses.field(metadata=si("s", "t"))
    """Times of the samples [s]."""
    reference: Float[np.ndarray, "samples 2"] = dataclasses.field(metadata=si("m", "x^*, y^*"))
    """Reference before shaping [m]."""
    commanded: Float[np.ndarray, "samples 2"] = dataclasses.field(metadata=si("m"))
    """Reference that the controller was given [m]."""
    position: Float[np.ndarray, "samples 2"] = dataclasses.field(metadata=si("m", "x_e, y_e"))
    """Position of the end-effector [m]."""
    voltage: Float[np.ndarray, "samples-1 2"] = dataclasses.field(metadata=si("V", "V"))
    """Commands of the drives between the samples [V]."""


@dataclasses.dataclass(frozen=True, eq=False)
class Prediction:
    """A manoeuvre simulated before and after tuning."""

    name: str
    """The manoeuvre, for a table."""
    before: Metrics
    """With the PD of Eq. (25) alone."""
    after: Metrics
    """With the tuned gains and the shaper."""
    run_before: TrackingRun | None = None
    """Traces before; None in a tuning that was read from a file."""
    run_after: TrackingRun | None = None
    """Traces after; None in a tuning that was read from a file."""


@dataclasses.dataclass(frozen=True, eq=False)
class FittedSetting:
    """The fitted robot at one nominal pretension."""

    pretension: float = dataclasses.field(metadata=si("N", "T"))
    """Nominal setting of the cable loop [N]."""
    robot: Robot
    """The robot, with exact friction."""


@dataclasses.dataclass(frozen=True, eq=False)
class Tuning:
    """Gains for the robot and shapers for the regions of its workspace."""

    controller: PD
    """The PD controller of both drives."""
    margins: Margins
    """Margins of a bare drive's sampled loop with a computing time of one sample."""
    shapers: tuple[RegionalShaper, ...]
    """The shapers, which cover the workspace at every measured pretension."""
    predicted: tuple[Prediction, ...]
    """Manoeuvres simulated before and after."""
    robots: tuple[FittedSetting, ...] = ()
    """The fitted robot at every tuned pretension, which legs are planned for."""
    worst_margins: tuple[WorstMargin, ...] = ()
    """Worst margins of the flexible robot's loops over the workspace; empty if unknown."""
    notes: tuple[str, ...] = ()
    """What a reader should know, in whole sentences."""

    def robot_at(self, pretension: float | None = None) -> FittedSetting:
        """The fitted robot at a nominal pretension.

        Args:
            pretension: The setting [N]; None for the first.

        Returns:
            The robot with its setting.

        Raises:
            ValueError: If the tuning has no robot at that setting.
        """
        for known in self.robots:
            if pretension is None or known.pretension == pretension:
                return known
        settings = ", ".join(f"{known.pretension:g} N" for known in self.robots) or "none"
        wanted = "" if pretension is None else f" at {pretension:g} N"
        raise ValueError(
            f"the tuning has no fitted robot{wanted}, got: {settings}. Name a setting that "
            "was tuned, or write tuning.json anew with `scdpr tune` or `scdpr calibrate`."
        )

    def shaper_at(self, x: float, y: float, pretension: float) -> RegionalShaper:
        """The shaper for a leg that ends at a pose.

        Args:
            x: Horizontal position of the end-effector [m].
            y: Its height [m].
            pretension: Nominal setting of the cable loop [N].

        Returns:
            The first regional shaper whose region contains it.

        Raises:
            ValueError: If no region does.
        """
        for shaper in self.shapers:
            if shaper.region.contains(x, y, pretension):
                return shaper
        raise ValueError(
            f"`tuning` has no shaper for x = {x:.4g} m, y = {y:.4g} m at {pretension:.4g} N, "
            "expected a pose inside the frame at a tuned setting. Tune with knocks there."
        )
