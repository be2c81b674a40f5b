"""What tuning gives: gains, a shaper for each region, and what they are predicted to do."""

import dataclasses

from scdpr_jax.command.controller import PD
from scdpr_jax.provenance import UNKNOWN, Provenance
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from tuning.loop.margins import Margins
from tuning.loop.worst_margins import WorstMargin
from tuning.result.prediction import PredictedLegs, Prediction
from tuning.result.regional_shaper import RegionalShaper, nearest_setting

CAUTION = (
    "CAUTION: the model doesn't fit the runs that this was made from. It is for a robot that "
    "isn't the one on the rig: don't run it there."
)
"""What is written on everything that is made from a fit that has failed."""


@dataclasses.dataclass(frozen=True, eq=False)
class FittedSetting:
    """The fitted robot at one nominal pretension."""

    pretension: float = dataclasses.field(metadata=si("N", "T"))
    """Nominal setting of the cable loop [N]."""
    robot: Robot
    """The robot, with exact friction."""


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
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
    legs: PredictedLegs | None = None
    """Random legs simulated before and after; None if unknown."""
    caution: str = ""
    """`CAUTION` where the fit that it is made from has failed, else empty."""
    provenance: Provenance = UNKNOWN
    """Where it comes from."""

    def __repr__(self) -> str:
        controller = self.controller
        settings = ", ".join(f"{fitted.pretension:g} N" for fitted in self.robots) or "unknown"
        measured = sum(shaper.measured for shaper in self.shapers)
        lines = [
            f"Tuning: PD of {float(controller.proportional_gain):.4g} V/rad and "
            f"{float(controller.derivative_gain):.4g} V s/rad at "
            f"{1 / float(controller.period):.4g} Hz",
            f"  shapers for {len(self.shapers)} regions, {measured} of them measured; "
            f"settings: {settings}",
        ]
        lines += [
            f"  {prediction.name}: vibration "
            f"{1e3 * prediction.before.residual_vibration:.3g} mm before, "
            f"{1e3 * prediction.after.residual_vibration:.3g} mm after"
            for prediction in self.predicted
        ]
        if self.legs is not None:
            left = f"{100 * self.legs.share:.3g} % of the vibration left"
            lines.append(f"  {len(self.legs)} random legs: {left}, predicted")
            if self.legs.planned is not None:
                planned = 100 * self.legs.planned_share
                lines.append(f"  {planned:.3g} % where they are planned, predicted")
        lines += [f"  {note}" for note in (self.caution, *self.notes) if note]
        return "\n".join(lines)

    def robot_at(self, pretension: float | None = None) -> FittedSetting:
        """The fitted robot at a nominal pretension.

        Args:
            pretension: The setting [N], as exact as a controller reads it; None for the
                first.

        Returns:
            The robot with its setting.

        Raises:
            ValueError: If the tuning has no robot at that setting.
        """
        if pretension is None and self.robots:
            return self.robots[0]
        if pretension is not None:
            spans = ((fitted.pretension, fitted.pretension) for fitted in self.robots)
            near = nearest_setting(spans, pretension)
            for fitted in self.robots:
                if near is not None and fitted.pretension == near[0]:
                    return fitted
        settings = ", ".join(f"{fitted.pretension:g} N" for fitted in self.robots) or "none"
        where = "" if pretension is None else f" at {pretension:g} N"
        raise ValueError(
            f"the tuning has no fitted robot{where}, got: {settings}. Name a setting that "
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
        # None at what was read: the setting that it is a reading of.
        near = nearest_setting((own.region.pretension for own in self.shapers), pretension)
        for shaper in self.shapers:
            region = shaper.region
            if region.pretension == near and region.contains(x, y, near[0]):
                return shaper
        raise ValueError(
            f"`tuning` has no shaper for x = {x:.4g} m, y = {y:.4g} m at {pretension:.4g} N, "
            "expected a pose inside the frame at a tuned setting. Tune with knocks there."
        )
