import dataclasses

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from identification.many.lanes import Lanes, Task
from identification.many.short_runs import (
    NAMES,
    ShortRuns,
    _judged,
    encoded,
    estimate_many,
)
from identification.many.starts import balanced
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace, value

INTERVAL, INTERVALS = 5e-3, 200
SIGMA = np.array([6.8e-5, 6.8e-5, 1.9e-4, 2e-3, 1.9e-4, 1.9e-4])
COUNT = 2 * np.pi / 26624


def lanes(*, cost=900.0, promised=1e-5, information=None):
    information = 1e6 * np.eye(4) if information is None else information
    point = encoded(np.array([[0.01, 0.013, 0.2, 85.0]]))
    about = np.array([cost]), np.zeros((1, 4)), information[None], np.array([promised])
    return Lanes(point, *about, np.array([4]))


def judged(**spoilt):
    return _judged(lanes(**spoilt), np.array([1000]))


def test_a_lane_at_its_minimum_has_no_failure_and_its_own_values():
    found = judged()
    assert found.failure == ("",)
    np.testing.assert_allclose(found.values, [[0.01, 0.013, 0.2, 85.0]], rtol=1e-12)
    # The coefficient is the force over the pretension: both of their errors are in it.
    np.testing.assert_allclose(found.sigma / found.values, [[2**0.5 * 1e-3, *[1e-3] * 3]])


@pytest.mark.parametrize(
    ("spoilt", "reason"),
    [
        ({"cost": np.inf}, "isn't finite"),
        ({"promised": 50.0}, "used up its steps"),
        ({"cost": 4000.0}, "came to rest 4 times as far"),
        (
            {"information": np.diag([1e6, 1e6, 1e6, 0.0])},
            "nothing that was measured depends on effective_pretension",
        ),
    ],
)
def test_a_lane_that_failed_is_a_row_with_its_reason(spoilt, reason):
    found = judged(**spoilt)
    assert reason in found.failure[0]
    assert not found.converged[0]


def test_a_start_that_is_not_positive_is_refused():
    measured = np.zeros((1, 3, 6))
    runs = ShortRuns(
        np.zeros((1, 3)), np.zeros((1, 2, 2)), np.zeros((1, 2)), measured, measured
    )
    start = np.array([[1.0, 1.0, -1.0, 1.0]])
    with pytest.raises(ValueError, match="`starts` must be positive, got -1"):
        estimate_many(consistent(), runs, start, interval=INTERVAL)


def drawn(count, drive_friction=0.0):
    """Runs of drawn robots, their truths, and starts twice too large or too small."""
    robot, random = exact(consistent()), np.random.default_rng(0)
    robot = replace(robot, {"drive_friction": drive_friction})
    base = np.array([float(value(robot, name)) for name in NAMES])
    pretension = np.exp(random.uniform(np.log(60), np.log(200), count))
    force = np.exp(random.uniform(np.log(2), np.log(10), count))
    drives = base[1:3] * random.uniform(0.7, 1.3, (count, 2))
    truth = np.column_stack([force / (4 * pretension), drives, pretension])
    voltage = np.zeros((count, INTERVALS, 2))
    voltage[:, 10:60], voltage[:, 60:100] = 8.0, -5.0
    start = np.full((count, 3), 0.5)
    weight = np.tile(1 / SIGMA, (count, INTERVALS + 1, 1))
    weight[:, np.arange(INTERVALS + 1) % 7 != 0, 2:] = 0.0
    empty = ShortRuns(
        start,
        voltage,
        np.zeros((count, INTERVALS)),
        np.zeros_like(weight),
        np.ones_like(weight),
    )

    @jax.jit
    @jax.vmap
    def simulated(point, run):
        interval, rubs = jnp.asarray(INTERVAL), drive_friction > 0
        return -Task(robot, interval, run, rubs).residuals(point)

    clean = np.asarray(simulated(jnp.asarray(encoded(truth)), empty))
    noisy = clean + SIGMA * random.normal(size=clean.shape)
    shift = random.uniform(0, COUNT, (count, 1, 2))
    noisy[:, :, :2] = np.round((clean[:, :, :2] + shift) / COUNT) * COUNT
    runs = ShortRuns(start, voltage, empty.knock, noisy, weight)
    return robot, runs, truth, truth * 2.0 ** random.choice([-1, 1], size=(count, 4))


@pytest.mark.slow
@pytest.mark.parametrize("drive_friction", [0.0, 0.2])
def test_the_momentum_puts_the_drives_of_a_start_right(drive_friction):
    robot, runs, truth, starts = drawn(16, drive_friction)

    @jax.jit
    @jax.vmap
    def begun(run, start):
        return balanced((Task(robot, jnp.asarray(INTERVAL), run, False), start))

    found = np.exp(np.asarray(begun(runs, jnp.asarray(encoded(starts)))))
    # The upper carriage doesn't slide exactly as the lower one does: a start, no estimate.
    off = np.abs(np.log(found[:, 1:3] / truth[:, 1:3]))
    assert np.median(off) < 0.1
    assert np.max(off) < np.log(2)
    np.testing.assert_allclose(found[:, 3], starts[:, 3], rtol=1e-14)


@pytest.mark.slow
def test_a_run_that_tells_nothing_leaves_its_start_alone():
    robot, runs, _, starts = drawn(1)
    still = jax.tree.map(lambda leaf: leaf[0], runs)
    still = dataclasses.replace(still, voltage=0 * still.voltage, measured=0 * still.measured)
    start = jnp.asarray(encoded(starts)[0])
    found = balanced((Task(robot, jnp.asarray(INTERVAL), still, False), start))
    np.testing.assert_allclose(found, start, rtol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("drive_friction", [0.0, 0.2])
def test_fits_converge_from_starts_twice_off(drive_friction):
    robot, runs, truth, starts = drawn(256, drive_friction)
    found = estimate_many(robot, runs, starts, interval=INTERVAL)
    assert np.mean(found.converged) >= 0.999
    assert np.all(np.abs(found.values / truth - 1)[found.converged] < 0.02)
