"""Runs between NumPy's arrays do what `native.run` does, whatever their shapes."""

import gc

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax import native
from scdpr_jax.native import Runs, Slopes, machine
from scdpr_jax.native.traced import trace

ROW = jax.ShapeDtypeStruct((3,), float)


def swing(stiffness, state, push):
    place, speed = state
    speed = speed - 0.1 * (stiffness * jnp.sin(place) - push)
    place = place + 0.1 * speed
    return (place, speed), jnp.stack([place, speed**2])


def drawn(robots, steps, seed=0):
    random = np.random.default_rng(seed)
    stiffness = random.uniform(1, 2, robots)
    start = (random.normal(size=robots), random.normal(size=robots))
    return stiffness, start, random.normal(size=(1, steps))


def expected(stiffness, start, push):
    run = jax.vmap(lambda k, own: native.run(swing, k, own, jnp.asarray(push[0])))
    return run(jnp.asarray(stiffness), jax.tree.map(jnp.asarray, start))


@pytest.fixture(params=[True, False], ids=["machine code", "XLA"])
def way(request, monkeypatch):
    if not request.param:
        monkeypatch.setattr(machine, "is_checked", lambda: False)
    return request.param


@pytest.mark.parametrize(("robots", "steps"), [(1, 3), (5, 7), (16, 2)])
def test_a_run_is_that_of_native_run(way, robots, steps):
    stiffness, start, push = drawn(robots, steps)
    made = Runs(swing, stiffness)(start, push)
    wanted = expected(stiffness, start, push)
    for own, other in zip(jax.tree.leaves(made), jax.tree.leaves(wanted), strict=True):
        # The same operations, but for sines of a vector and of a number.
        np.testing.assert_allclose(own, other, rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize(("robots", "tangents"), [(6, 1), (6, 23), (1, 1), (1, 16), (1, 43)])
def test_its_derivatives_are_those_of_jvp(way, robots, tangents):
    stiffness, start, push = drawn(robots, 4)
    random = np.random.default_rng(1)
    along = random.normal(size=(robots, tangents)), random.normal(size=(1, tangents, 4))
    runs = Runs(swing, stiffness)
    made, slopes = runs.linearised(
        start, push, along=Slopes((along[0], np.zeros((1, 1))), along[1])
    )
    wanted = runs(start, push)
    for own, other in zip(jax.tree.leaves(made), jax.tree.leaves(wanted), strict=True):
        np.testing.assert_allclose(own, other, rtol=1e-13, atol=1e-14)

    def one(k, place, speed, moved, pushed):
        def run(place, push):
            return native.run(swing, k, (place, speed), push)

        return jax.jvp(run, (place, jnp.asarray(push[0])), (moved, pushed))[1]

    for robot in range(robots):
        for tangent in range(tangents):
            given = (stiffness[robot], start[0][robot], start[1][robot])
            other = one(
                *map(jnp.asarray, given),
                jnp.asarray(along[0][robot, tangent]),
                jnp.asarray(along[1][0, tangent]),
            )
            own = jax.tree.map(lambda leaf, r=robot, t=tangent: leaf[r][..., t], tuple(slopes))
            for a, b in zip(jax.tree.leaves(own), jax.tree.leaves(other), strict=True):
                np.testing.assert_allclose(a, b, rtol=1e-11, atol=1e-12)


@pytest.mark.parametrize(("robots", "tangents"), [(5, 3), (5, 41), (1, 23), (1, 90)])
def test_tangents_that_have_not_begun_may_be_left_out(way, robots, tangents):
    stiffness, start, push = drawn(robots, 6)
    begun = np.array([0, 1, 1, 2, tangents - 1, tangents])
    waits = np.arange(tangents)[:, None] >= begun
    pushed = np.where(waits, 0.0, np.random.default_rng(2).normal(size=waits.shape))[None]
    along = Slopes((np.zeros((1, 1)), np.zeros((1, 1))), pushed)
    runs = Runs(swing, stiffness)
    made = runs.linearised(start, push, along=along, begun=begun)
    wanted = runs.linearised(start, push, along=along)
    for own, other in zip(jax.tree.leaves(made), jax.tree.leaves(wanted), strict=True):
        np.testing.assert_array_equal(own, other)


def test_a_held_run_is_of_what_its_arrays_hold_by_then(way):
    stiffness, start, push = drawn(5, 6)
    along = Slopes((np.ones((1, 2)), np.zeros((1, 2))), np.zeros((1, 2, 1)).repeat(6, 2))
    runs = Runs(swing, stiffness)
    held = runs.held(start, push, along=along)
    for seed in (1, 2):
        _, (place, speed), push[...] = drawn(5, 6, seed)
        start[0][...], start[1][...] = place, speed
        along.rows[...] = np.random.default_rng(seed).normal(size=(1, 2, 6))
        held()
        wanted = runs.linearised((place, speed), push.copy(), along=along)
        for own, other in zip(
            jax.tree.leaves((held.results, tuple(held.slopes))),
            jax.tree.leaves((wanted[0], tuple(wanted[1]))),
            strict=True,
        ):
            np.testing.assert_array_equal(own, other)


def test_a_held_run_outlives_what_it_was_made_from():
    stiffness, start, push = drawn(3, 4)
    wanted = Runs(swing, stiffness)(start, push)
    held = Runs(swing, stiffness.copy()).held(jax.tree.map(np.copy, start), push.copy())
    gc.collect()
    scratch = [np.full(12, np.nan) for _ in range(1000)]
    held()
    assert len(scratch) == 1000
    for own, other in zip(jax.tree.leaves(held.results), jax.tree.leaves(wanted), strict=True):
        np.testing.assert_array_equal(own, other)


def test_a_step_has_the_same_name_whenever_it_is_traced():
    def parted(size):
        def step(_, state, row):
            first, second = jnp.split(row, np.array([size]))
            return state + first[0], second

        return trace(step, (), jax.ShapeDtypeStruct((), float), ROW).step.name

    assert parted(1) == parted(1)
    assert parted(1) != parted(2)


def test_what_a_step_closes_over_is_refused():
    arm = jnp.arange(3.0)

    def step(_, state, push):
        return state + jnp.sum(arm) * push, state

    with pytest.raises(ValueError, match="closes over 1 arrays"):
        Runs(step, ())(np.zeros(1), np.zeros((1, 2)))
