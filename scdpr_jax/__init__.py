"""The planar cable robot with a single cable loop: a differentiable model.

What a user calls is here, and `dir(scdpr_jax)` shows it. The adaptive solvers are the
exception, as they take a second to import: `scdpr_jax.engines.adaptive`.
"""

from types import ModuleType as _ModuleType

from scdpr_jax.command.controller import PD as PD
from scdpr_jax.command.controller import Controller as Controller
from scdpr_jax.command.controller import published_pd as published_pd
from scdpr_jax.command.sensors import Camera as Camera
from scdpr_jax.command.sensors import Encoder as Encoder
from scdpr_jax.command.shaper import ShapedTrajectory as ShapedTrajectory
from scdpr_jax.command.shaper import Shaper as Shaper
from scdpr_jax.command.shaper import residual_vibration as residual_vibration
from scdpr_jax.command.trajectory import BezierLeg as BezierLeg
from scdpr_jax.command.trajectory import Manoeuvre as Manoeuvre
from scdpr_jax.command.trajectory import Trajectory as Trajectory
from scdpr_jax.command.trajectory import rest_to_rest as rest_to_rest
from scdpr_jax.command.trajectory import table_3 as table_3
from scdpr_jax.engines.closed_loop import ClosedLoop as ClosedLoop
from scdpr_jax.engines.closed_loop import closed_loop as closed_loop
from scdpr_jax.engines.linear_stepping import simulate_linear as simulate_linear
from scdpr_jax.engines.stepping import Inputs as Inputs
from scdpr_jax.engines.stepping import interpolate as interpolate
from scdpr_jax.engines.stepping import simulate as simulate
from scdpr_jax.engines.stepping import step as step
from scdpr_jax.linear.model import StateSpace as StateSpace
from scdpr_jax.linear.model import linearise as linearise
from scdpr_jax.linear.model import mass_matrix as mass_matrix
from scdpr_jax.linear.model import stiffness as stiffness
from scdpr_jax.linear.model import stiffness_matrix as stiffness_matrix
from scdpr_jax.linear.modes import BOTH_HELD as BOTH_HELD
from scdpr_jax.linear.modes import DRIVEN as DRIVEN
from scdpr_jax.linear.modes import LOWER_HELD as LOWER_HELD
from scdpr_jax.linear.modes import PRINTED as PRINTED
from scdpr_jax.linear.modes import Condition as Condition
from scdpr_jax.linear.modes import Modes as Modes
from scdpr_jax.linear.modes import held_frequency as held_frequency
from scdpr_jax.linear.modes import modes as modes
from scdpr_jax.linear.modes import natural_frequencies as natural_frequencies
from scdpr_jax.linear.stiffness import horizontal_stiffness as horizontal_stiffness
from scdpr_jax.numerics.batches import in_chunks as in_chunks
from scdpr_jax.robot.cable import cable_angles as cable_angles
from scdpr_jax.robot.cable import loop_forces as loop_forces
from scdpr_jax.robot.cable import potential as potential
from scdpr_jax.robot.dynamics import accelerations as accelerations
from scdpr_jax.robot.dynamics import energy as energy
from scdpr_jax.robot.friction import Coulomb as Coulomb
from scdpr_jax.robot.friction import Friction as Friction
from scdpr_jax.robot.friction import SmoothCoulomb as SmoothCoulomb
from scdpr_jax.robot.kinematics import forward_kinematics as forward_kinematics
from scdpr_jax.robot.kinematics import inverse_kinematics as inverse_kinematics
from scdpr_jax.robot.parameters import Cable as Cable
from scdpr_jax.robot.parameters import Carriage as Carriage
from scdpr_jax.robot.parameters import Drive as Drive
from scdpr_jax.robot.parameters import EndEffector as EndEffector
from scdpr_jax.robot.parameters import Frame as Frame
from scdpr_jax.robot.parameters import Robot as Robot
from scdpr_jax.robot.parameters import exact as exact
from scdpr_jax.robot.parameters import smoothed as smoothed
from scdpr_jax.robot.parameters import with_friction as with_friction
from scdpr_jax.robot.prototype import PROVENANCE as PROVENANCE
from scdpr_jax.robot.prototype import consistent as consistent
from scdpr_jax.robot.prototype import published as published
from scdpr_jax.robot.quantities import QUANTITIES as QUANTITIES
from scdpr_jax.robot.quantities import Quantity as Quantity
from scdpr_jax.robot.quantities import replace as replace
from scdpr_jax.robot.quantities import value as value
from scdpr_jax.robot.state import State as State
from scdpr_jax.robot.state import carriages as carriages
from scdpr_jax.robot.state import driven as driven
from scdpr_jax.robot.state import pose as pose
from scdpr_jax.robot.state import rest as rest
from scdpr_jax.statics.workspace import static_workspace as static_workspace


def __dir__() -> list[str]:
    """What a user calls, without the wings that it lives in."""
    return sorted(
        name
        for name, value in globals().items()
        if not (name.startswith("_") or isinstance(value, _ModuleType))
    )
