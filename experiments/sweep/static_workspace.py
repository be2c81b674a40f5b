"""Sweeps of the static workspace: the single loop's and the conventional robot's."""

import jax.numpy as jnp
from jaxtyping import Array

from experiments.sweep.axes import Variable
from experiments.sweep.measure import Measure, Output, Values, X, Y
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.statics.four_cables import needed_tension
from scdpr_jax.statics.workspace import geometric_region, static_workspace


def _workspaces(robot: Robot, at: Values) -> tuple[Array, ...]:
    position = jnp.stack([at["x"], at["y"]])
    width = at["end_effector_width"]
    needed = jnp.stack(
        [
            needed_tension(
                robot,
                position,
                end_effector_width=width,
                minimum_tension=at["minimum_tension"],
                gravity=at["gravity"],
                crossed=crossed,
            )
            for crossed in (False, True)
        ]
    )
    return (
        geometric_region(robot, end_effector_width=width).contains(position),
        static_workspace(robot).contains(position),
        needed,
        needed <= at["maximum_tension"],
    )


WORKSPACE = Measure(
    name="workspace",
    variables=(
        X,
        Y,
        Variable("minimum_tension", "N", "T_min of the four cables", lambda robot: 10.0, False),
        Variable(
            "maximum_tension",
            "N",
            "T_max of the four cables; by default what a drive of the robot can pull",
            lambda r: (
                r.drive.torque_per_volt * r.drive.voltage_limit / r.drive.effective_radius
            ),
        ),
        Variable("end_effector_width", "m", "width of the end-effector", lambda robot: 0.287),
        Variable(
            "gravity", "m/s^2", "gravity on the four-cable robot", lambda robot: 9.81, False
        ),
    ),
    outputs=(
        Output("inside_frame", "1", "the upright end-effector lies inside the frame"),
        Output("single_loop", "1", "pose of the single loop's static workspace, Eq. (1)"),
        Output(
            "needed_tension",
            "N",
            "least largest tension of the four-cable robot; inf: none holds it",
            ("cables",),
        ),
        Output(
            "four_cables",
            "1",
            "pose of the four-cable robot's static workspace, T_min to T_max",
            ("cables",),
        ),
    ),
    labels={"cables": ("open", "crossed")},
    compute=lambda axes: _workspaces,
    chunk=4096,
    unit=65_536,
    most=65_536,
)
"""Static workspaces of the single loop and of the conventional robot of four cables."""
