"""The engines' derivatives held to differences of the event-by-event reference."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from event_by_event import Linear, Nonlinear, simulate
from robot_numbers import numbers_of
from share import share

from scdpr_jax.engines import stepping
from scdpr_jax.engines.linear_stepping import simulate_linear
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace, value
from scdpr_jax.robot.state import State

FREE = ("friction_coefficient", "drive_inertia", "drive_damping", "effective_pretension")
HELD = 25e-3
"""Interval of the inputs and of the places that are compared [s]."""
COUNT = 80
VOLTAGE = np.where(np.arange(COUNT)[:, None] < COUNT // 2, [6.0, 4.5], 0.0)
AT_REST = np.concatenate([[0.40, 0.0, 0.40, 0.40, 0.45], np.zeros(5)])
STARTS = 10
"""Unknowns after those of `FREE`: the start state's."""
WIDTH = 1e-5
"""Of the differences, in ln of a quantity and in SI units of a start state. Four points leave
its fourth power; the reference is good to 1e-13 m, which makes 1e-8."""


def robot_and_start(unknowns, nominal):
    """The robot and its start, from logarithms of `FREE` and displacements of the start."""
    values = dict(zip(FREE, nominal, strict=True))
    scaled = {
        name: values[name] * jnp.exp(log) for name, log in zip(FREE, unknowns[:4], strict=True)
    }
    return replace(consistent(), scaled), unknowns[4:] + drawn_start()


def drawn_start():
    """In motion: at rest on its guides, a start state has no two-sided derivative."""
    moved = np.array([0.004, 0.01, 0, 0, 0, 0.05, 0.1, 0.2, 0.3, 0.1])
    return jnp.asarray(AT_REST + moved)


def nonlinear(robot, start, parts):
    inputs = stepping.Inputs(
        np.full(parts * COUNT, HELD / parts),
        np.repeat(VOLTAGE, parts, axis=0),
        np.zeros(parts * COUNT),
    )
    states = stepping.simulate(robot, State(start[:5], start[5:]), inputs)
    return states.position[::parts]


def linear(robot, start, parts):
    return simulate_linear(
        robot,
        State(start[:5], start[5:]),
        height=jnp.asarray(AT_REST[4]),
        interval=jnp.asarray(HELD),
        voltage=jnp.asarray(VOLTAGE),
        substeps=parts,
    ).position


MODELS = {
    "nonlinear": (nonlinear, Nonlinear),
    "linear": (linear, lambda numbers: Linear(numbers, AT_REST[4])),
}
BOUNDS = {5: 2e-3, 25: 1e-4}
"""Of the largest sensitivity of a run, by steps in an interval: 200 Hz and 1 kHz."""


def drawn(seed):
    """Nominal values within ±30 % of the prototype's, and the unknown that is varied."""
    random = np.random.default_rng(seed)
    prototype = np.array([float(value(consistent(), name)) for name in FREE])
    return prototype * random.uniform(0.7, 1.3, 4), seed % (len(FREE) + STARTS)


def by_differences(model, nominal, unknown):
    def places(shift):
        unknowns = jnp.zeros(len(FREE) + STARTS).at[unknown].set(shift)
        robot, start = robot_and_start(unknowns, nominal)
        system = MODELS[model][1](numbers_of(robot))
        return simulate(
            system, np.asarray(start), np.full(COUNT, HELD), VOLTAGE, np.zeros(COUNT)
        ).positions

    outer, inner = (places(2 * WIDTH) - places(-2 * WIDTH), places(WIDTH) - places(-WIDTH))
    return (8 * inner - outer) / (12 * WIDTH)


# The linear engine's take a minute to compile: `test_linear_stepping` is their quick share.
@pytest.fixture(
    scope="module", params=[pytest.param("linear", marks=pytest.mark.slow), "nonlinear"]
)
def derivative(request):
    """A function of nominal values, unknown and parts; compiled once for each of the parts."""
    engine = MODELS[request.param][0]

    def column(nominal, unknown, parts):
        direction = jnp.zeros(len(FREE) + STARTS).at[unknown].set(1.0)

        def places(unknowns):
            return engine(*robot_and_start(unknowns, nominal), parts)

        return jax.jvp(places, (jnp.zeros_like(direction),), (direction,))[1]

    return request.param, jax.jit(column, static_argnums=2)


@pytest.mark.parametrize("seed", share(range(200), 1))
def test_derivatives_are_the_references(derivative, seed):
    model, column = derivative
    nominal, unknown = drawn(seed)
    truth = by_differences(model, nominal, unknown)
    for parts, bound in BOUNDS.items():
        found = np.asarray(column(jnp.asarray(nominal), unknown, parts))
        assert np.all(np.isfinite(found))
        assert np.abs(found - truth).max() <= bound * np.abs(truth).max()
