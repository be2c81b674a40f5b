"""A run under every transformation of JAX is the scan of the same step."""

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from share import share

from scdpr_jax import native
from scdpr_jax.native import primitive, reverse
from scdpr_jax.numerics.lean_scan import lean_scan

STEPS, ROBOTS = 40, 11
RANDOM = np.random.default_rng(5)
ROUNDINGS = 1e-13
"""Forty steps of numbers around one, in another order of operations."""


def step(parameters, carry, row):
    """A step with a nested carry, truth values, counters and a queue."""
    state, counter, up, (queue,) = carry
    push = jnp.sin(state) * parameters["gain"] + parameters["matrix"] @ state + row["push"]
    following = jnp.where(up, push, 0.9 * push) - jnp.clip(state, -1.0, parameters["gain"])
    following = jax.lax.cond(
        following[0] > 0, jnp.tanh, lambda own: own * jnp.exp(-own * own), following
    )
    following = following.at[1].add(jnp.maximum(following[0], following[2]))
    queue = jnp.concatenate([queue[1:], following[None, :1]])
    carry = (following, counter + 1, following[1] > 0, (queue,))
    return carry, (following[:2], queue[0, 0], counter, up)


PARAMETERS = {
    "gain": jnp.array(0.8),
    "matrix": jnp.asarray(RANDOM.uniform(-0.5, 0.5, (3, 3))),
}
START = (
    jnp.asarray(RANDOM.normal(size=3)),
    jnp.array(0),
    jnp.array(True),
    (jnp.zeros((4, 1)),),
)
INPUTS = {"push": jnp.asarray(0.3 * RANDOM.normal(size=(STEPS, 3)))}
GAINS = jnp.linspace(0.5, 1.0, ROBOTS)


def scan(step, parameters, start, inputs):
    return lean_scan(lambda carry, row: step(parameters, carry, row), start, inputs)


def real(run):
    """All real results, as a function of a gain and the inputs."""

    def function(gain, push):
        parameters = {**PARAMETERS, "gain": gain}
        (state, _, _, queue), (rows, first, _, _) = run(step, parameters, START, {"push": push})
        return state, queue, rows, first

    return function


def squares(run):
    def total(gain, push):
        return sum(jnp.sum(jnp.square(own)) for own in jax.tree.leaves(real(run)(gain, push)))

    return total


def assert_same(found, expected):
    assert jax.tree.structure(found) == jax.tree.structure(expected)
    for own, other in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        assert (own.shape, own.dtype) == (other.shape, other.dtype)
        if own.dtype == float:
            np.testing.assert_allclose(own, other, rtol=ROUNDINGS, atol=ROUNDINGS)
        else:
            np.testing.assert_array_equal(own, other)


CHANGES = {
    "as it is": lambda f: f(GAINS[0], INPUTS["push"]),
    "jit": lambda f: jax.jit(f)(GAINS[0], INPUTS["push"]),
    "vmap": lambda f: jax.vmap(f, (0, None))(GAINS, INPUTS["push"]),
    "vmap of inputs, steps first": lambda f: jax.vmap(f, (None, 1))(
        GAINS[0], jnp.stack([INPUTS["push"]] * 3, 1)
    ),
    "vmap of vmap": lambda f: jax.vmap(jax.vmap(f, (0, None)), (None, 0))(
        GAINS, jnp.stack([INPUTS["push"], 1.1 * INPUTS["push"]])
    ),
    "vmap of one": lambda f: jax.vmap(f, (0, None))(GAINS[:1], INPUTS["push"]),
    "jvp": lambda f: jax.jvp(f, (GAINS[0], INPUTS["push"]), (1.0, INPUTS["push"])),
    "jacfwd": lambda f: jax.jacfwd(f)(GAINS[0], INPUTS["push"]),
    "jacfwd by 25 numbers": lambda f: jax.jacfwd(f, (0, 1))(GAINS[0], INPUTS["push"][:8]),
    "vmap of jacfwd": lambda f: jax.vmap(jax.jacfwd(f), (0, None))(GAINS, INPUTS["push"]),
    "jacfwd of vmap": lambda f: jax.jacfwd(jax.vmap(f, (0, None)))(GAINS, INPUTS["push"]),
    "jit of vmap of jacfwd of vmap": lambda f: jax.jit(
        jax.vmap(jax.jacfwd(jax.vmap(f, (0, None))), (None, 0))
    )(GAINS[:3], jnp.stack([INPUTS["push"], 1.1 * INPUTS["push"]])),
    "linearize": lambda f: jax.linearize(f, GAINS[0], INPUTS["push"])[1](0.5, INPUTS["push"]),
    "checkpoint": lambda f: jax.checkpoint(f)(GAINS[0], INPUTS["push"]),
    "scan": lambda f: jax.lax.scan(lambda _, k: (0, f(k, INPUTS["push"])), 0, GAINS[:3])[1],
}


@pytest.mark.parametrize("name", share(CHANGES, 8))
def test_a_run_is_the_scan_of_its_step_under(name):
    assert_same(CHANGES[name](real(native.run)), CHANGES[name](real(scan)))


REVERSE = {
    "grad": lambda f: jax.grad(f, (0, 1))(GAINS[0], INPUTS["push"]),
    "value and grad": lambda f: jax.value_and_grad(f)(GAINS[0], INPUTS["push"]),
    "vmap of grad": lambda f: jax.vmap(jax.grad(f, (0, 1)), (0, None))(
        GAINS[:3], INPUTS["push"]
    ),
    "grad of vmap": lambda f: jax.grad(
        lambda k: jnp.sum(jax.vmap(f, (0, None))(k, INPUTS["push"]))
    )(GAINS[:3]),
    "grad of checkpoint": lambda f: jax.grad(jax.checkpoint(f))(GAINS[0], INPUTS["push"]),
    "grad of scan of checkpoint": lambda f: jax.grad(
        lambda k: jax.lax.scan(
            lambda x, _: (jax.checkpoint(f)(x, INPUTS["push"]) / 1e3, None), k, length=2
        )[0]
    )(GAINS[0]),
    "vmap of jacfwd with values": lambda f: jax.vmap(
        jax.jacfwd(lambda k: (f(k, INPUTS["push"]),) * 2, has_aux=True)
    )(GAINS[:3]),
    "hessian": lambda f: jax.hessian(f)(GAINS[0], INPUTS["push"]),
    "forward over forward": lambda f: jax.jacfwd(jax.jacfwd(f))(GAINS[0], INPUTS["push"]),
}


@pytest.mark.parametrize("name", share(REVERSE, 1))
def test_reverse_and_second_derivatives_are_those_of_the_scan(name):
    found, expected = (REVERSE[name](squares(run)) for run in (native.run, scan))
    for own, other in zip(jax.tree.leaves(found), jax.tree.leaves(expected), strict=True):
        np.testing.assert_allclose(own, other, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("name", share(("grad", "vmap of grad", "grad of vmap"), 1))
def test_reverse_mode_is_the_same_by_many_numbers_and_by_few(name, monkeypatch):
    by_few = REVERSE[name](squares(native.run))
    monkeypatch.setattr(reverse, "MOST", 0)
    by_many = REVERSE[name](squares(native.run))
    for own, other in zip(jax.tree.leaves(by_few), jax.tree.leaves(by_many), strict=True):
        np.testing.assert_allclose(own, other, rtol=1e-11, atol=1e-11)


def test_a_gradient_by_a_parameter_is_machine_code(monkeypatch):
    monkeypatch.setattr(primitive, "results_by_xla", None)
    monkeypatch.setattr(primitive, "_slopes", None)
    gradient = jax.jit(jax.grad(squares(native.run)))
    text = gradient.lower(GAINS[0], INPUTS["push"]).as_text()
    assert text.count("custom_call @run_") == 2


def test_all_results_have_their_structure_and_types():
    found = native.run(step, PARAMETERS, START, INPUTS)
    assert_same(found, scan(step, PARAMETERS, START, INPUTS))


def test_a_step_may_close_over_what_is_differentiated_and_mapped():
    def closing(run, gain):
        def closed(_, carry, row):
            return step({**PARAMETERS, "gain": gain}, carry, row)

        return run(closed, (), START, INPUTS)[1][0]

    for change in (jax.jacfwd, jax.vmap, lambda f: jax.jit(jax.vmap(jax.jacfwd(f)))):
        gains = GAINS[0] if change is jax.jacfwd else GAINS
        found, expected = (
            change(lambda k, run=run: closing(run, k))(gains) for run in (native.run, scan)
        )
        np.testing.assert_allclose(found, expected, rtol=ROUNDINGS, atol=ROUNDINGS)


def test_it_is_one_call_of_machine_code(monkeypatch):
    # Whatever else runs would need the step in XLA.
    monkeypatch.setattr(primitive, "results_by_xla", None)
    monkeypatch.setattr(primitive, "_slopes", None)
    jacobian = jax.jit(jax.vmap(jax.jacfwd(real(native.run)), (0, None)))
    text = jacobian.lower(GAINS, INPUTS["push"]).as_text()
    assert text.count("custom_call @run_") == 1
    assert "while" not in text


def test_robots_have_the_same_bits_in_any_company():
    many = jax.vmap(real(native.run), (0, None))
    everyone = many(GAINS, INPUTS["push"])
    for i in range(1, ROBOTS - 1):
        some = many(GAINS[i : i + 2], INPUTS["push"])
        for own, other in zip(jax.tree.leaves(some), jax.tree.leaves(everyone), strict=True):
            np.testing.assert_array_equal(own, other[i : i + 2])


def test_another_function_that_does_the_same_compiles_nothing(monkeypatch):
    native.run(step, PARAMETERS, START, INPUTS)
    monkeypatch.setattr(primitive.machine, "kernel", None)
    found = native.run(lambda *given: step(*given), PARAMETERS, START, INPUTS)
    assert_same(found, native.run(step, PARAMETERS, START, INPUTS))


def test_inputs_of_different_lengths_are_refused():
    def of_two(_, carry, row):
        return carry + row[0] + row[1], carry

    with pytest.raises(ValueError, match="leading axis sizes"):
        native.run(of_two, (), jnp.array(0.0), (jnp.zeros(3), jnp.zeros(4)))


def test_a_step_that_carries_on_something_else_is_refused():
    with pytest.raises(TypeError, match="carry"):
        native.run(lambda _, c, x: ((c, c), x), (), jnp.array(0.0), jnp.zeros(3))


def test_one_jaxpr_with_other_roles_of_its_arrays_is_another_step():
    def equations(first, second, third, row):
        return first * third + row, second * row

    def one_carried(parameters, carry, row):
        return equations(*parameters, carry, row)

    def two_carried(parameter, carry, row):
        return equations(parameter, *carry, row), None

    first, second, third = jnp.array(0.5), jnp.array(2.0), jnp.array(0.25)
    rows = jnp.linspace(0.5, 1.0, 5)
    for step, given in (
        (one_carried, ((first, second), third)),
        (two_carried, (first, (second, third))),
    ):
        made = native.run(step, *given, rows)
        expected = native.scan(step, *given, rows)
        for ours, theirs in zip(jax.tree.leaves(made), jax.tree.leaves(expected), strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=1e-13)
