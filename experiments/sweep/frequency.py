"""Sweeps of the natural frequency over heights and parameters."""

import jax.numpy as jnp
from jaxtyping import Array

from experiments.sweep.measure import Measure, Output, Values, X, Y, only_if
from scdpr_jax.linear.modes import CONDITIONS, Condition, natural_frequencies
from scdpr_jax.robot.parameters import Robot

_MODES = max(condition.modes for condition in CONDITIONS)


def _frequencies(robot: Robot, at: Values) -> tuple[Array, ...]:
    height, (low, high) = at["y"], robot.heights
    reachable = (height > low) & (height < high)
    # Beyond, a cable would have to point the other way; the middle keeps the numbers real.
    inside = jnp.where(reachable, height, robot.frame.height / 2)
    modes = [natural_frequencies(robot, inside, condition) for condition in CONDITIONS]
    padded = [jnp.pad(f, (0, _MODES - f.size), constant_values=jnp.nan) for f in modes]
    return (only_if(reachable, jnp.stack(padded)),)


def _label(condition: Condition) -> str:
    return f"lower {condition.lower.value}, upper {condition.upper.value}"


FREQUENCY = Measure(
    name="frequency",
    variables=(X, Y),
    outputs=(
        Output(
            "frequency",
            "Hz",
            "natural frequency of an aligned pose, undamped; nan: no such mode or pose",
            ("condition", "mode"),
        ),
    ),
    labels={
        "condition": tuple(map(_label, CONDITIONS)),
        "mode": tuple(range(1, _MODES + 1)),
    },
    compute=lambda axes: _frequencies,
    chunk=4096,
    unit=65_536,
    most=65_536,
)
"""Natural frequencies of an aligned pose, under every condition of the carriages.

They are the same all along the frame; `x` is there for maps over the workspace.
"""
