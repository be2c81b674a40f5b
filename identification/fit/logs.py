"""A campaign's runs as arrays: on the logs' own grid, and on a coarser one to fit on.

A Jacobian costs some twenty simulations, and a step of a tenth of the fastest vibration errs
by a micrometre. So a fit's steps are made on the coarser grid, and what that errs by is taken
off the measurements afterwards (`identification.fit.correction`). Jacobians on the logs' own
grid would take ten times as long for the same answer.
"""

import dataclasses

import numpy as np

from identification.campaign.types import Campaign, Run, Sensors
from identification.data.record import (
    MotorRecord,
    Reading,
    Record,
    coarse,
    motor_record,
    stacked,
)
from identification.data.start import Clock, clocks
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import value

COARSE_STEP = 1e-2
"""Step that Jacobians are made at [s]: a tenth of the fastest vibration, where the engine's
own error is some 1 µm."""


@dataclasses.dataclass(frozen=True, eq=False)
class Logs:
    """A campaign's runs as arrays; `rough` is what is fitted, `records` is exact."""

    runs: tuple[Run, ...]
    """All runs."""
    cabled: tuple[int, ...]
    """Numbers of the runs with the cable on, in the order of `records`."""
    clocks: tuple[Clock, ...]
    """What is known of the camera's clock in each of those."""
    records: Record | None
    """The runs with the cable on, on the logs' own grid; None without any."""
    rough: Record | None
    """The same on a grid of about `COARSE_STEP`."""
    factor: int
    """How many intervals of `records` are one of `rough`."""
    motors: tuple[int, ...]
    """Numbers of the runs of the bare drives."""
    motor_records: MotorRecord | None
    """Those runs; None without any."""
    sensors: Sensors
    """The sensors' noise."""
    accepted: tuple[str, ...]
    """Contradictions of the sensors that the fit goes on with, in words."""

    @classmethod
    def of(cls, campaign: Campaign, robot: Robot, *, clock_drifts: bool) -> "Logs":
        """The runs of a campaign.

        Args:
            campaign: The campaign.
            robot: What is known of the robot: its pulleys' radius and its frame's height.
            clock_drifts: Whether the cameras' clocks may drift.

        Returns:
            The runs as arrays.

        Raises:
            ValueError: If nothing tells where a run started.
        """
        runs, sensors = campaign.runs, campaign.sensors
        motors = tuple(i for i, run in enumerate(runs) if run.kind == "motor_step")
        cabled = tuple(i for i in range(len(runs)) if i not in motors)
        with_cable = [runs[i] for i in cabled]
        radius = float(value(robot, "effective_radius"))
        known_clocks = clocks(with_cable, sensors, radius)
        records, rough, factor = None, None, 1
        if cabled:
            records = stacked(
                with_cable,
                known_clocks,
                sensors,
                Reading(
                    height=float(value(robot, "frame_height")),
                    radius=radius,
                    clock_drifts=clock_drifts,
                    in_motion=any(run.in_motion for run in runs),
                    sharing=2 * sum(sensors.height_offset(run) > 0 for run in with_cable),
                ),
            )
            duration = np.asarray(records.inputs.duration)
            factor = max(1, round(COARSE_STEP / float(np.median(duration[duration > 0]))))
            rough = coarse(records, factor)
        return cls(
            runs=runs,
            cabled=cabled,
            clocks=known_clocks,
            records=records,
            rough=rough,
            factor=factor,
            motors=motors,
            motor_records=motor_record([runs[i] for i in motors], sensors) if motors else None,
            sensors=sensors,
            accepted=campaign.accepted,
        )

    def of_drives(self) -> "Logs":
        """The same without the runs with the cable on, numbered as before."""
        return dataclasses.replace(self, cabled=(), clocks=(), records=None, rough=None)

    def measurements(self, run: int) -> float:
        """How many independent measurements a run holds.

        Args:
            run: Its number.

        Returns:
            The encoders' readings and the camera's coordinates [1].
        """
        if run in self.motors:
            return float(np.sum(np.asarray(self.motor_records.share)[self.motors.index(run)]))
        row = self.cabled.index(run)
        angles = float(np.sum(np.asarray(self.rough.angle_share)[row]))
        return angles + float(np.sum(np.asarray(self.rough.frame_weight)[row] > 0))
