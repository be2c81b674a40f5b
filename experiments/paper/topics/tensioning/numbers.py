"""The loop's cable: path, elasticity, creep, and the modified scheme of Fig. 21."""

import functools
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from experiments.paper.topics.knocks.numbers import effective_share
from identification.knocks.spectrum import natural_frequency
from scdpr_jax.engines.stepping import Inputs
from scdpr_jax.engines.tensioned_loop import (
    TensionedRun,
    Tensioner,
    held_tension,
    logarithmic_creep,
    simulate_tensioned,
)
from scdpr_jax.robot.loop_elasticity import (
    CableSection,
    consistent_section,
    lengthening,
    loop_length,
    loop_stiffness,
    published_section,
)
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.state import rest

SETPOINT = 85.0
"""Effective pretension that is held [N]."""

STRAINS = (3e-6, 1e-5, 3e-5)
"""Creep strains per decade of time [1]; the paper names creep and gives no number."""

ONSET, HOURS = 3600.0, 1000.0
"""Time from which on creep counts [s], and how long it is followed [h]."""

TOP_SPEED = 0.1
"""Speed of the linear actuator [m/s]; a brisk one of its kind."""

TIME_CONSTANTS = {"no actuator": np.inf, "maintenance, 60 s": 60.0, "fast, 20 ms": 20e-3}
"""Time in which the actuator takes up an error of the tension [s]."""

_PERIOD, _INTERVALS, _ON = 0.5e-3, 5000, 2000


def tensioner(name: str) -> Tensioner:
    """The loop of Table 1's steel with an actuator.

    Args:
        name: A name of `TIME_CONSTANTS`.

    Returns:
        The loop and its actuator.
    """
    stiff = float(loop_stiffness(consistent(), consistent_section()))
    return Tensioner(stiff, SETPOINT, 1 / (stiff * TIME_CONSTANTS[name]), TOP_SPEED)


class Creep(NamedTuple):
    """Pretension over a thousand hours."""

    hours: Float[np.ndarray, " samples"]
    """Time under load [h]."""
    bare: dict[float, Float[np.ndarray, " samples"]]
    """Tension without an actuator, by creep strain per decade [N]."""
    printed: Float[np.ndarray, " samples"]
    """The same with the printed modulus and the largest strain [N]."""
    held: Float[np.ndarray, " samples"]
    """The same with steel, the largest strain and the maintenance actuator [N]."""


@functools.cache
def creep() -> Creep:
    """A resting robot's pretension while its cable creeps.

    Returns:
        Tensions.
    """
    seconds = jnp.concatenate([jnp.zeros(1), jnp.geomspace(60.0, 3600 * HOURS, 200)])
    robot = consistent()

    def history(section: CableSection, strain: float, gain: float) -> Float[np.ndarray, " _"]:
        crept = logarithmic_creep(
            seconds,
            strain_per_decade=jnp.asarray(strain),
            onset=jnp.asarray(ONSET),
            length=loop_length(robot),
        )
        stiff = loop_stiffness(robot, section)
        held = Tensioner(stiff, 350.0, gain, TOP_SPEED)
        return np.asarray(held_tension(held, times=seconds, creep=crept))

    steel = consistent_section()
    return Creep(
        np.asarray(seconds) / 3600,
        {strain: history(steel, strain, 0.0) for strain in STRAINS},
        history(published_section(), STRAINS[-1], 0.0),
        history(steel, STRAINS[-1], float(tensioner("maintenance, 60 s").gain)),
    )


class Runs(NamedTuple):
    """Experiment 1 of Table 2 and a knock on an elastic loop, by actuator."""

    time: Float[np.ndarray, " samples"]
    """Time [s]."""
    tension: dict[str, Float[np.ndarray, " samples"]]
    """Tension in experiment 1 [N]."""
    travel: dict[str, Float[np.ndarray, " samples"]]
    """Travel of the actuator in experiment 1 [m]."""
    end: dict[str, float]
    """Where the end-effector is after experiment 1 [m]."""
    frequency: dict[str, float]
    """Frequency of a knock of 10 N in the middle of the frame [Hz]."""
    constant: float
    """The same with constant tension [Hz]."""
    path: float
    """Largest lengthening of the path in experiment 1 with constant tension [m]."""


@functools.cache
def runs() -> Runs:
    """Experiment 1 and a knock, simulated on the elastic loop.

    Returns:
        The runs.
    """
    names = tuple(TIME_CONSTANTS)
    push = np.where(np.arange(_INTERVALS) < _ON, 10.0, 0.0)
    nothing = np.zeros(_INTERVALS)
    knock = np.where(np.arange(_INTERVALS) < 60, 10.0, 0.0)
    # Constant tension: a loop that a path's lengthening doesn't stretch.
    soft = eqx.tree_at(lambda t: t.loop_stiffness, tensioner(names[0]), jnp.asarray(0.0))
    loops = [*(tensioner(name) for name in names), soft]
    batch = jax.tree.map(lambda *leaves: jnp.stack(leaves * 2), *loops)
    count = len(loops)
    poses = np.repeat([(0.173, 0.3), (1.1, 0.55)], count, axis=0)
    inputs = Inputs(
        np.full((2 * count, _INTERVALS), _PERIOD),
        np.repeat([np.stack([push, push], 1), np.zeros((_INTERVALS, 2))], count, axis=0),
        np.repeat([nothing, knock], count, axis=0),
    )
    simulated = _simulated(batch, consistent(), jnp.asarray(poses), inputs)
    position = np.asarray(simulated.states.position)
    frequency = [_frequency(run[:, 0]) for run in position[count:]]
    return Runs(
        _PERIOD * np.arange(_INTERVALS + 1),
        dict(zip(names, np.asarray(simulated.tension), strict=False)),
        dict(zip(names, np.asarray(simulated.travel), strict=False)),
        dict(zip(names, position[:, -1, 0].tolist(), strict=False)),
        dict(zip(names, frequency, strict=False)),
        frequency[-1],
        float(_longest(jnp.asarray(position[count - 1]))),
    )


def _frequency(x: Float[np.ndarray, " samples"]) -> float:
    # The camera's frames after the knock.
    seen = x[90::66]
    return natural_frequency(66 * _PERIOD * np.arange(seen.size), seen).frequency


@eqx.filter_jit
def _longest(position: Float[Array, "samples 5"]) -> Float[Array, ""]:
    return jnp.max(jax.vmap(lambda q: lengthening(consistent(), q))(position))


@eqx.filter_jit
def _simulated(
    loops: Tensioner, robot: Robot, poses: Float[Array, "runs 2"], inputs: Inputs
) -> TensionedRun:
    def run(loop: Tensioner, pose: Float[Array, "2"], held: Inputs) -> TensionedRun:
        start = rest(robot, pose[0], pose[0], pose[1])
        none = jnp.zeros(_INTERVALS + 1)
        return simulate_tensioned(loop, robot, start, held, creep=none)

    return jax.vmap(run)(loops, poses, inputs)


def lost_frequency(share: float) -> float:
    """Frequency that is left when a share of the tension is.

    Args:
        share: Tension over that at first [1].

    Returns:
        Frequency over that at first [1].
    """
    return share**0.5


def strain_of_the_pretension() -> float:
    """Strain that the nominal 350 N are, in steel.

    Returns:
        Strain [1].
    """
    return SETPOINT / effective_share() / float(consistent_section().axial_stiffness)
