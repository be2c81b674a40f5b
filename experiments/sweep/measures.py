"""What a sweep computes of every point."""

from collections.abc import Callable
from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from experiments.sweep.axes import Axis, Variable
from scdpr_jax.closed_loop import closed_loop
from scdpr_jax.controller import PD, published_pd
from scdpr_jax.dynamics import rest
from scdpr_jax.four_cables import needed_tension
from scdpr_jax.modes import CONDITIONS, natural_frequencies
from scdpr_jax.parameters import QUANTITIES, Robot, value
from scdpr_jax.trajectory import rest_to_rest
from scdpr_jax.workspace import geometric_region, static_workspace

Values = dict[str, Float[Array, ""]]
Results = tuple[Array, ...]


class Output(NamedTuple):
    """One variable of a sweep's dataset."""

    name: str
    unit: str
    meaning: str
    dimensions: tuple[str, ...] = ()
    """Dimensions beyond the sweep's axes."""


class Measure(NamedTuple):
    """What is computed of every point, and what it can be swept over."""

    variables: tuple[Variable, ...]
    """What it takes beside the robot's quantities."""
    outputs: tuple[Output, ...]
    """What it computes."""
    coordinates: dict[str, tuple[str | int, ...]]
    """Labels of the outputs' own dimensions."""
    function: Callable[[tuple[Axis, ...]], Callable[[Robot, Values], Results]]
    """From a sweep's axes to what computes a point's outputs."""
    chunk: int
    """Points that a device computes at a time."""
    part: int
    """Points of a part, which is what a sweep that was stopped doesn't do again."""

    def variables_of(self, robot: Robot) -> dict[str, Variable]:
        """Everything that it can be swept over, by name.

        Args:
            robot: The robot.

        Returns:
            Its own variables, with their defaults at this robot, and the robot's quantities.
        """
        frame = {
            "x": float(robot.frame.width) / 2,
            "y": float(robot.frame.height) / 2,
        }
        own = (v._replace(default=frame.get(v.name, v.default)) for v in self.variables)
        robots = (Variable(q.name, q.unit, q.meaning, None, q.positive) for q in QUANTITIES)
        return {variable.name: variable for variable in (*own, *robots)}


_X = Variable("x", "m", "position of the end-effector along the frame", None, positive=False)
_Y = Variable("y", "m", "height of the end-effector", None, positive=False)


def _name(condition: object) -> str:
    return f"lower {condition.lower.value}, upper {condition.upper.value}"


_MODES = max(condition.modes for condition in CONDITIONS)


def _frequency(_: tuple[Axis, ...]) -> Callable[[Robot, Values], Results]:
    def compute(robot: Robot, at: Values) -> Results:
        found = [natural_frequencies(robot, at["y"], condition) for condition in CONDITIONS]
        padded = [
            jnp.concatenate([f, jnp.full(_MODES - f.size, jnp.nan, f.dtype)]) for f in found
        ]
        return (jnp.stack(padded),)

    return compute


FREQUENCY = Measure(
    variables=(_Y,),
    outputs=(
        Output(
            "frequency", "Hz", "natural frequency, undamped; nan: no such mode",
            ("condition", "mode"),
        ),
    ),
    coordinates={
        "condition": tuple(map(_name, CONDITIONS)),
        "mode": tuple(range(1, _MODES + 1)),
    },
    function=_frequency,
    chunk=4096,
    part=65536,
)  # fmt: skip
"""Natural frequencies of an aligned pose, under every condition of the carriages."""


def _workspace(_: tuple[Axis, ...]) -> Callable[[Robot, Values], Results]:
    def compute(robot: Robot, at: Values) -> Results:
        position = jnp.stack([at["x"], at["y"]])
        region = geometric_region(robot, end_effector_width=at["end_effector_width"])
        needed = [
            needed_tension(
                robot,
                position,
                end_effector_width=at["end_effector_width"],
                minimum_tension=at["minimum_tension"],
                gravity=at["gravity"],
                crossed=crossed,
            )
            for crossed in (False, True)
        ]
        return (
            region.contains(position),
            static_workspace(robot).contains(position),
            jnp.stack(needed),
            jnp.stack(needed) <= at["maximum_tension"],
        )

    return compute


WORKSPACE = Measure(
    variables=(
        _X,
        _Y,
        Variable("minimum_tension", "N", "least tension of the four cables", 10.0, False),
        Variable("maximum_tension", "N", "largest tension of the four cables", 100.0),
        Variable("end_effector_width", "m", "width of the end-effector", 0.287),
        Variable("gravity", "m/s^2", "gravity on the four-cable robot", 9.81, False),
    ),
    outputs=(
        Output("inside_frame", "1", "the upright end-effector lies inside the frame"),
        Output("single_loop", "1", "pose of the single loop's static workspace, Eq. (1)"),
        Output(
            "needed_tension", "N", "least largest tension of the four-cable robot; inf: none",
            ("cables",),
        ),
        Output(
            "four_cables", "1", "pose of the four-cable robot's static workspace", ("cables",)
        ),
    ),
    coordinates={"cables": ("open", "crossed")},
    function=_workspace,
    chunk=4096,
    part=65536,
)  # fmt: skip
"""Static workspaces of the single loop and of the conventional robot of four cables."""

HOLD = 1.0
"""Time that is simulated after the slowest arrival [s]."""


def _closed_loop(axes: tuple[Axis, ...]) -> Callable[[Robot, Values], Results]:
    defaults = {v.name: v.default for v in CLOSED_LOOP.variables}
    swept = {axis.variable.name: axis.values.max() for axis in axes}
    period = float(published_pd().period)
    samples = round((swept.get("leg_time", defaults["leg_time"]) + HOLD) / period) + 1
    rest_samples = round(HOLD / period)

    def compute(robot: Robot, at: Values) -> Results:
        x, y, leg = at["x"], at["y"], at["leg_time"]
        start = jnp.stack([x, y])
        move = jnp.stack([at["distance"], at["rise"]])
        time = period * jnp.arange(samples, dtype=x.dtype)
        leg_of = rest_to_rest(start, start + move, duration=leg)
        reference = jax.vmap(leg_of.position)(time)
        gains = PD(at["proportional_gain"], at["derivative_gain"], period=period)
        run = closed_loop(robot, rest(robot, x, x, y), gains, reference=reference)
        q = run.states.position
        error = jnp.linalg.norm(q[:, jnp.asarray([0, 4])] - reference, axis=1)
        arrived = (time >= leg) & (time < leg + period * rest_samples)
        at_rest = q[:, 0]
        swing = jnp.max(jnp.where(arrived, at_rest, -jnp.inf)) - jnp.min(
            jnp.where(arrived, at_rest, jnp.inf)
        )
        return (
            jnp.max(error),
            swing,
            error[-1],
            jnp.max(jnp.abs(q[:, 1])),
            jnp.max(jnp.abs(run.voltage)),
        )

    return compute


CLOSED_LOOP = Measure(
    variables=(
        _X._replace(meaning="where the move starts along the frame"),
        _Y._replace(meaning="height at which the move starts"),
        Variable("distance", "m", "move along the frame", 0.4, positive=False),
        Variable("rise", "m", "move upwards", 0.0, positive=False),
        Variable("leg_time", "s", "time of the move", 1.5),
        Variable(
            "proportional_gain", "V/rad", "proportional gain of the PD",
            float(np.asarray(published_pd().proportional_gain)),
        ),
        Variable(
            "derivative_gain", "V s/rad", "derivative gain of the PD",
            float(np.asarray(published_pd().derivative_gain)), positive=False,
        ),
    ),
    outputs=(
        Output("largest_error", "m", "largest distance from the reference, Eq. (26)"),
        Output("vibration", "m", "peak to peak of x in the second after the arrival"),
        Output("final_error", "m", "distance from the target at the end"),
        Output("largest_tilt", "rad", "largest rotation of the end-effector"),
        Output("largest_command", "V", "largest command to a drive"),
    ),
    coordinates={},
    function=_closed_loop,
    chunk=64,
    part=1024,
)  # fmt: skip
"""A move under the sampled PD, exact Coulomb friction on both carriages."""

MEASURES = {"frequency": FREQUENCY, "workspace": WORKSPACE, "closed-loop": CLOSED_LOOP}
"""What can be swept."""


def defaults(measure: Measure, robot: Robot) -> dict[str, float]:
    """Values of everything that a measure takes, where it isn't swept.

    Args:
        measure: The measure.
        robot: The robot.

    Returns:
        Values by name [in the variables' units].
    """
    return {
        name: float(value(robot, name)) if variable.default is None else variable.default
        for name, variable in measure.variables_of(robot).items()
    }
