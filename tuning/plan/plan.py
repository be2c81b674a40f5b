"""A planned leg, as the controller reads it."""

import dataclasses

import numpy as np
from jaxtyping import Float

from scdpr_jax.command.controller import PD
from scdpr_jax.legs.command_law import Commands
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.kinematics import forward_kinematics
from scdpr_jax.robot.parameters import Robot


@dataclasses.dataclass(frozen=True, eq=False, repr=False)
class Plan:
    """A planned leg from its begin to its end inclusive; the last row is held."""

    time: Float[np.ndarray, " samples"] = dataclasses.field(metadata=si("s", "t"))
    """Times from the leg's begin [s]."""
    position: Float[np.ndarray, "samples 2"] = dataclasses.field(metadata=si("m"))
    """Where the end-effector is to be, $[x_e, y_e]$ [m]."""
    angle: Float[np.ndarray, "samples 2"] = dataclasses.field(metadata=si("rad"))
    """Angles of the driver pulleys from those at the leg's begin [rad]."""
    feedforward: Float[np.ndarray, "samples 2"] = dataclasses.field(metadata=si("V"))
    """Commands to add to the PD's, held until the next sample [V]."""

    def __repr__(self) -> str:
        begin, end = (f"({x:.3g} m, {y:.3g} m)" for x, y in self.position[[0, -1]])
        return (
            f"Plan: {begin} to {end} in {self.time[-1]:.4g} s\n"
            f"  {self.time.size} samples, every {1e3 * (self.time[1] - self.time[0]):.4g} ms\n"
            f"  feed-forward up to {np.max(np.abs(self.feedforward)):.3g} V"
        )

    def driven(self, robot: Robot) -> Float[np.ndarray, "samples 2"]:
        """Where lower carriage and height are to be, which end in line with the end-effector.

        Args:
            robot: The robot.

        Returns:
            $[q_3, y_e]$ [m].
        """
        way = forward_kinematics(self.angle, np.asarray(robot.drive.effective_radius))
        return self.position[-1] + way - way[-1]

    def commands(self, robot: Robot, controller: PD, *, rest: float) -> Commands:
        """The plan as a robot is told it.

        Args:
            robot: The robot.
            controller: The PD controller beside it, at the plan's period.
            rest: Time that the last row is held for [s].

        Returns:
            The commands.
        """
        more = ((0, round(rest / float(controller.period))), (0, 0))
        reference, driven, feedforward = (
            np.pad(part, more, mode="edge")
            for part in (self.position, self.driven(robot), self.feedforward)
        )
        return Commands(
            controller=controller,
            reference=reference,
            commanded=driven,
            afterwards=np.arange(len(reference)) >= self.time.size - 1,
            feedforward=feedforward,
        )
