"""The benchmark's answer held to the event-by-event reference."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from event_by_event import Linear, Nonlinear, simulate
from robot_numbers import numbers_of

from experiments.benchmarks.peers.engines import LinearEngine, NonlinearEngine
from experiments.benchmarks.problem import (
    HEIGHT,
    LOG,
    PARTS,
    REFINED,
    ROWS,
    TORQUE_STEP,
    drawn,
    error,
    robot_of,
    start_of,
)

MODELS = {
    "linear": (LinearEngine, lambda numbers: Linear(numbers, HEIGHT)),
    "nonlinear": (NonlinearEngine, Nonlinear),
}


# The linear engine takes a minute to compile: `test_linear_stepping` is its quick share.
@pytest.mark.slow
@pytest.mark.parametrize("model", [pytest.param("linear", marks=pytest.mark.slow), "nonlinear"])
@pytest.mark.parametrize(
    "run", [0, *(pytest.param(r, marks=pytest.mark.slow) for r in range(1, 8))]
)
def test_answer_at_a_twentieth_of_the_step_is_the_references(model, run):
    engine, system = MODELS[model]
    values = jnp.asarray(drawn(run + 1)[run])
    start = start_of(robot_of(values))
    reference = simulate(
        system(numbers_of(robot_of(values))),
        np.concatenate([start.position, start.velocity]),
        np.full(ROWS, LOG),
        TORQUE_STEP,
        np.zeros(ROWS),
    )
    found = np.asarray(jax.jit(lambda v: engine(REFINED * PARTS)(v))(values))
    # A hundredth of what the engines err by at 200 Hz, which it is to judge.
    assert error(found, reference.positions) <= 5e-9
    assert 0 < reference.sticks.mean() < 1
