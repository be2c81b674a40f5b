"""The one search on problems with known minima, and its step in NumPy and compiled."""

import dataclasses
import itertools
import math

import hypothesis
import hypothesis.strategies as st
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.numerics.levenberg_marquardt import (
    Damping,
    Stopping,
    damped_step,
    free_unknowns,
    minimise,
    minimise_together,
    settled,
)
from scdpr_jax.numerics.merit import Merit, Normal, SumOfSquares
from scdpr_jax.numerics.progress import Progress


def rosenbrock(point):
    x, y = point
    residual = np.array([10 * (y - x**2), 1 - x])
    return SumOfSquares(residual, np.array([[-20 * x, 10.0], [-1.0, 0.0]]))


def test_it_walks_down_a_curved_valley_to_the_minimum():
    found = minimise(
        rosenbrock, np.array([-1.2, 1.0]), stopping=Stopping(evaluations=60, decrement=1e-16)
    )
    # The stopping rule allows a decrement of 1e-16; the slope of the valley is 1e-2 at most.
    np.testing.assert_allclose(found.point, [1.0, 1.0], atol=1e-6)
    assert found.ended == "converged"


def test_a_linear_problem_is_solved_at_once():
    matrix = np.array([[2.0, 1.0], [0.0, 3.0], [1.0, 1.0]])
    target = np.array([1.0, -2.0, 0.5])
    found = minimise(
        lambda x: SumOfSquares(matrix @ x - target, matrix),
        np.zeros(2),
        stopping=Stopping(evaluations=10, decrement=1e-12),
    )
    expected = np.linalg.lstsq(matrix, target, rcond=None)[0]
    # It may stop a millionth of the cost above the minimum, in a valley of curvature >= 1.
    np.testing.assert_allclose(found.point, expected, atol=np.sqrt(1e-6 * found.normal.cost))


def test_what_is_left_is_gone_after_the_last_step_where_the_model_is_right():
    matrix = np.array([[2.0, 1.0], [0.0, 3.0], [1.0, 1.0]])
    target = np.array([1.0, -2.0, 0.5])
    found = minimise(
        lambda x: SumOfSquares(matrix @ x - target, matrix),
        np.array([5.0, 5.0]),
        stopping=Stopping(evaluations=10, decrement=1.0),
    )
    expected = np.linalg.lstsq(matrix, target, rcond=None)[0]
    assert np.abs(found.point - expected).max() > 1e-6
    lower = np.full(2, -np.inf)
    np.testing.assert_allclose(settled(found, lower).point, expected, atol=1e-8)
    # A bound that the last step would cross holds it.
    lower = np.where(expected < found.point, found.point, -np.inf)
    assert (settled(found, lower).point >= lower).all()


def test_a_search_that_ended_otherwise_stays_where_it_was():
    stopped = minimise(rosenbrock, np.array([-1.2, 1.0]), stopping=Stopping(evaluations=3))
    assert settled(stopped, np.full(2, -np.inf)) is stopped


def test_what_hardly_acts_goes_no_further_than_it_may():
    slope = np.array([[1.0, 0.0], [0.0, 1e-9]])

    def faint(point):
        return SumOfSquares(slope @ point - 1.0, slope)

    longest, stopping = np.array([np.inf, 3.0]), Stopping(evaluations=2, share=0.0)
    far = minimise(faint, np.zeros(2), stopping=stopping)
    near = minimise(faint, np.zeros(2), longest=longest, stopping=stopping)
    assert far.point[1] > 1e8
    np.testing.assert_allclose(near.point, [far.point[0], 3.0])
    converged = dataclasses.replace(near, ended="converged")
    assert settled(converged, np.full(2, -np.inf)).point[1] > 1e8
    assert settled(converged, np.full(2, -np.inf), longest).point[1] == 6.0


def test_a_bound_holds_what_would_cross_it():
    found = minimise(
        lambda x: SumOfSquares(x - np.array([-1.0, 2.0]), np.eye(2)),
        np.array([1.0, 1.0]),
        lower=np.array([0.0, -np.inf]),
        stopping=Stopping(evaluations=30, decrement=1e-12),
    )
    assert found.point[0] == 0.0
    # A millionth of the cost, 1, is left over at most.
    np.testing.assert_allclose(found.point[1], 2.0, atol=1e-3)
    free = free_unknowns(found.normal, found.point, np.array([0.0, -np.inf]))
    np.testing.assert_array_equal(free, [False, True])


def test_what_no_residual_depends_on_stays_where_it_was():
    found = minimise(
        lambda x: SumOfSquares(np.array([x[0] - 3.0]), np.array([[1.0, 0.0]])),
        np.array([0.0, 7.0]),
        stopping=Stopping(evaluations=20, decrement=1e-12),
    )
    assert found.point[1] == 7.0


def test_a_simulation_that_diverges_is_not_accepted():
    def evaluate(point):
        if point[0] > 1.5:
            return Normal(float("nan"), np.zeros(1), np.eye(1))
        return SumOfSquares(np.array([point[0] - 2.0]), np.eye(1))

    found = minimise(
        evaluate,
        np.array([0.0]),
        lower=np.array([-np.inf]),
        stopping=Stopping(evaluations=60, decrement=1e-9),
    )
    assert found.point[0] <= 1.5
    assert np.isfinite(found.normal.cost)
    assert found.ended == "stalled"


@pytest.mark.parametrize("iterations", [1, 3])
def test_running_out_of_iterations_is_said(iterations):
    found = minimise(
        rosenbrock,
        np.array([-1.2, 1.0]),
        stopping=Stopping(evaluations=iterations, decrement=1e-9),
    )
    assert found.ended == "unfinished"


def test_starts_that_go_together_end_where_each_would_alone():
    starts = [np.array([-1.2, 1.0]), np.array([2.0, -1.0]), np.array([0.0, 0.0])]
    options = {"stopping": Stopping(evaluations=60, decrement=1e-16)}
    together = minimise_together(
        lambda points: [rosenbrock(point) for point in points], starts, **options
    )
    for start, found in zip(starts, together, strict=True):
        alone = minimise(rosenbrock, start, **options)
        np.testing.assert_array_equal(found.point, alone.point)
        assert (found.iterations, found.ended) == (alone.iterations, alone.ended)


SCHEDULES = {
    "fit": Damping(again=1e-3),
    "axis": Damping(rise=2.0, growth=2.0, least=0.0, most=1e8),
    "plan": Damping(fall=5.0, rise=4.0, floor=1e-9),
    "co-design": Damping(first=1e-2, fall=4.0, rise=6.0, least=1e-6, floor=1e-6),
}


@pytest.mark.parametrize("damping", SCHEDULES.values(), ids=SCHEDULES)
@pytest.mark.parametrize("start", [(-1.2, 1.0), (2.0, -2.0), (0.0, 0.0)])
def test_every_schedule_follows_the_valley_to_its_end(damping, start):
    stopping = Stopping(steps=100, rejections=20, share=0.0, saving=1e-12)
    found = minimise(rosenbrock, np.array(start), stopping=stopping, damping=damping)
    np.testing.assert_allclose(found.point, 1.0, atol=1e-6)


def test_the_merit_never_rises():
    stopping = Stopping(evaluations=12)
    history = minimise(rosenbrock, np.array([-1.2, 1.0]), stopping=stopping).history
    assert len(history) > 4
    assert all(later < before for before, later in itertools.pairwise(history))


def test_only_so_many_steps_are_taken():
    found = minimise(rosenbrock, np.array([-1.2, 1.0]), stopping=Stopping(steps=3))
    assert len(found.history) == 4
    assert found.ended == "unfinished"


def test_a_step_that_saves_too_little_is_the_last():
    stopping = Stopping(share=0.0, saving=0.9)
    found = minimise(rosenbrock, np.array([-1.2, 1.0]), stopping=stopping)
    assert found.ended == "converged"
    assert found.history[-2] - found.history[-1] < 0.9 * found.history[-1]


def deceptive(point):
    """Derivatives that promise a way down where there is none."""
    return SumOfSquares(np.abs(point) + 1.0, np.ones((1, 1)))


def test_steps_in_a_row_that_do_not_help_end_it():
    stopping = Stopping(rejections=5, share=0.0)
    found = minimise(deceptive, np.array([0.0]), stopping=stopping)
    assert (found.ended, found.iterations) == ("stalled", 6)


def test_a_damping_beyond_the_largest_ends_it():
    damping = Damping(first=1.0, rise=2.0, growth=2.0, most=100.0)
    found = minimise(deceptive, np.array([0.0]), stopping=Stopping(share=0.0), damping=damping)
    # Factors of 2, 4, 8 and 16 make 1024; three of them 64.
    assert (found.ended, found.iterations) == ("stalled", 5)


def test_an_undamped_promise_goes_on_where_a_damped_one_ends():
    damped, undamped = (
        minimise(
            deceptive,
            np.array([0.0]),
            stopping=Stopping(evaluations=20, share=1e-3, undamped=flag),
        )
        for flag in (False, True)
    )
    assert (damped.ended, undamped.ended) == ("stalled", "unfinished")


def test_a_start_without_a_finite_merit_is_infeasible():
    found = minimise(
        lambda x: SumOfSquares(x, np.eye(1)), np.array([np.nan]), stopping=Stopping()
    )
    assert (found.ended, found.iterations) == ("infeasible", 1)


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_sum_with_a_derivative_that_is_not_finite_is_infinite(bad):
    assert SumOfSquares(np.ones(1), np.array([[bad]])).cost == math.inf
    assert SumOfSquares(np.array([bad]), np.ones((1, 1))).cost == math.inf


@dataclasses.dataclass(frozen=True, eq=False)
class Lazy(Merit):
    """A parabola that notes where its derivatives are asked for."""

    at: np.ndarray
    asked: list

    @property
    def cost(self):
        return float(self.at @ self.at)

    @property
    def gradient(self):
        self.asked.append(float(self.at[0]))
        return self.at

    @property
    def matrix(self):
        return np.eye(1)


def test_derivatives_are_asked_for_only_where_a_step_begins():
    asked = []
    found = minimise(
        lambda x: Lazy(x, asked), np.array([2.0]), stopping=Stopping(steps=1, share=0.0)
    )
    assert set(asked) == {2.0}
    assert abs(found.point[0]) < 2.0


def test_progress_tells_the_share_of_what_is_allowed():
    told = []
    progress = Progress(lambda doing, share: told.append(share))
    stopping = Stopping(evaluations=5)
    minimise(rosenbrock, np.array([-1.2, 1.0]), stopping=stopping, progress=progress)
    np.testing.assert_allclose(told, [0.2, 0.4, 0.6, 0.8, 1.0])


numbers = st.integers(0, 2**31)


@hypothesis.given(numbers, st.floats(1e-6, 1e3), st.floats(0.0, 1e-3))
def test_the_step_solves_the_damped_equations(seed, damping, floor):
    random = np.random.default_rng(seed)
    jacobian = random.normal(size=(6, 3)) * np.array([1e3, 1.0, 1e-3])
    merit = SumOfSquares(random.normal(size=6), jacobian)
    diagonal = np.diag(merit.matrix) + floor * np.trace(merit.matrix)
    step = damped_step(merit.gradient, merit.matrix, damping, floor=floor)
    left = (merit.matrix + damping * np.diag(diagonal)) @ step + merit.gradient
    # Condition numbers of unit columns stay below 1e4 here, times a few ulp.
    scale = np.abs(merit.matrix) @ np.abs(step) + np.abs(merit.gradient)
    assert np.all(np.abs(left) <= 1e-9 * scale + 1e-300)


@hypothesis.given(numbers)
def test_unknowns_that_are_held_leave_the_step_of_the_others(seed):
    random = np.random.default_rng(seed)
    merit = SumOfSquares(random.normal(size=6), random.normal(size=(6, 4)))
    free = np.array([True, False, True, False])
    step = damped_step(merit.gradient, merit.matrix, 1e-3, free=free)
    alone = damped_step(merit.gradient[free], merit.matrix[np.ix_(free, free)], 1e-3)
    assert np.all(step[~free] == 0)
    np.testing.assert_allclose(step[free], alone, rtol=1e-9, atol=1e-12)


def test_lanes_of_a_compiled_program_take_the_same_steps():
    random = np.random.default_rng(0)
    merits = [SumOfSquares(random.normal(size=5), random.normal(size=(5, 3))) for _ in range(4)]
    gradients = np.stack([merit.gradient for merit in merits])
    matrices = np.stack([merit.matrix for merit in merits])
    gradients[0, 1] = matrices[0, 1] = matrices[0, :, 1] = 0.0
    lanes = jax.jit(jax.vmap(lambda g, m, d: damped_step(g, m, d)))
    steps = lanes(jnp.asarray(gradients), jnp.asarray(matrices), jnp.full(4, 1e-2))
    expected = [damped_step(g, m, 1e-2) for g, m in zip(gradients, matrices, strict=True)]
    assert steps[0, 1] == 0
    np.testing.assert_allclose(steps, expected, rtol=1e-9)
