"""MuJoCo as a contender: the robot from its published parts, friction as joint losses.

The loop's three moving parts are tendons of constant pull 2T, the drives the motors,
armature and damping of the lower carriage and of the height. MuJoCo's `frictionloss` is a
force that doesn't follow the cables' angles: 4Tμ on each carriage, as in the linear model,
set as hard as it goes, which comes five times nearer to dry friction than the default.
"""

import functools
import importlib.util

import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from experiments.benchmarks.problem import (
    HEIGHT,
    LOG,
    ROWS,
    TORQUE_STEP,
    X,
    robot_of,
)

STEP = 1e-3
NAME = "MuJoCo implicitfast, 1 kHz"

_MODEL = """
<mujoco>
  <option timestep="{step}" integrator="implicitfast" gravity="0 0 0"/>
  <worldbody>
    <body name="end_effector" pos="{x} 0 {y}">
      <joint name="x" type="slide" axis="1 0 0"/>
      <joint name="y" type="slide" axis="0 0 1" armature="{armature}" damping="{damping}"/>
      <joint name="tilt" type="hinge" axis="0 -1 0"/>
      <inertial pos="0 0 0" mass="{m_e}" diaginertia="{I_e} {I_e} {I_e}"/>
      <site name="below" pos="0 0 -{a}"/>
      <site name="above" pos="0 0 {b}"/>
    </body>
    <body name="lower" pos="{x} 0 0">
      <joint name="q_3" type="slide" axis="1 0 0" armature="{armature}" damping="{damping}"
        frictionloss="{friction}" solimpfriction="0.9999 0.9999 0.001"/>
      <inertial pos="0 0 0" mass="{m_3}" diaginertia="1 1 1"/>
      <site name="low"/>
    </body>
    <body name="upper" pos="{x} 0 {H}">
      <joint name="q_4" type="slide" axis="1 0 0" frictionloss="{friction}"
        solimpfriction="0.9999 0.9999 0.001"/>
      <inertial pos="0 0 0" mass="{m_4}" diaginertia="1 1 1"/>
      <site name="high"/>
    </body>
  </worldbody>
  <tendon>
    <spatial name="alpha"><site site="low"/><site site="below"/></spatial>
    <spatial name="beta"><site site="above"/><site site="high"/></spatial>
    <spatial name="gamma"><site site="low"/><site site="high"/></spatial>
  </tendon>
  <actuator>
    <motor joint="q_3"/><motor joint="y"/>
    <motor tendon="alpha"/><motor tendon="beta"/><motor tendon="gamma"/>
  </actuator>
</mujoco>
"""


def missing() -> str:
    """Why it can't take part.

    Returns:
        The reason; empty if it can.
    """
    if importlib.util.find_spec("mujoco") is None:
        return "mujoco isn't installed, see the extra of that name"
    return ""


def run(values: Float[np.ndarray, "4"]) -> Float[np.ndarray, "rows 5"]:
    """The problem's run.

    Args:
        values: Values of `experiments.benchmarks.problem.FREE`.

    Returns:
        Positions at the log's instants [m, rad, m, m, m].
    """
    import mujoco
    from mujoco import rollout

    model, controls = _model(tuple(values.tolist()))
    data = mujoco.MjData(model)
    full = mujoco.mjtState.mjSTATE_FULLPHYSICS
    begin = np.empty(mujoco.mj_stateSize(model, full))
    mujoco.mj_getState(model, data, begin, full)
    states, _ = rollout.rollout(model, data, begin[None], controls[None])
    # Time stands before the positions.
    moved = states[0][round(LOG / STEP) - 1 :: round(LOG / STEP), 1 : 1 + model.nq]
    x, y, tilt, lower, upper = np.concatenate([np.zeros((1, 5)), moved]).T
    return np.stack([X + x, tilt, X + lower, X + upper, HEIGHT + y], axis=1)


@functools.lru_cache(maxsize=1)
def _model(values: tuple[float, ...]) -> tuple[object, Float[np.ndarray, "steps 5"]]:
    import mujoco

    robot = robot_of(jnp.asarray(values))
    body, drive = robot.end_effector, robot.drive
    radius, pull = float(drive.effective_radius), 2 * float(robot.cable.effective_pretension)
    numbers = {
        "step": STEP,
        "x": X,
        "y": HEIGHT,
        "armature": 2 * drive.inertia / radius**2,
        "damping": 2 * drive.damping / radius**2,
        "m_e": body.mass,
        "I_e": body.inertia,
        "a": body.lower_offset,
        "b": body.upper_offset,
        "m_3": robot.lower_carriage.mass,
        "m_4": robot.upper_carriage.mass,
        "friction": 2 * pull * float(values[0]),
        "H": robot.frame.height,
    }
    text = _MODEL.format(**{name: repr(float(number)) for name, number in numbers.items()})
    torques = float(drive.torque_per_volt) * TORQUE_STEP
    drives = np.stack([torques.sum(axis=1), torques[:, 0] - torques[:, 1]], axis=1) / radius
    cables = np.full((ROWS, 3), -pull)
    controls = np.repeat(np.hstack([drives, cables]), round(LOG / STEP), axis=0)
    return mujoco.MjModel.from_xml_string(text), controls
