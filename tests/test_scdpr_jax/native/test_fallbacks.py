"""Where there is no machine code a run is XLA's, and what is missing is said once."""

import sys
import warnings

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax import native
from scdpr_jax.native import machine, primitive
from scdpr_jax.native.kept import names
from scdpr_jax.native.xla import handler, interface

INPUTS = jnp.linspace(0.0, 1.0, 20)


@pytest.fixture(autouse=True)
def _nothing_known(monkeypatch):
    """What XLA knows stays known to it: other tests go on with the handlers that there were."""
    primitive._handler_name.cache_clear()
    monkeypatch.setattr(machine, "_handlers", {})
    yield
    primitive._handler_name.cache_clear()


def new_step(number):
    """A step that nobody compiled before."""

    def step(gain, carry, row):
        following = jnp.sin(carry) * gain + number * row
        return following, following

    return step


def last(step):
    return jax.jit(lambda gain: native.run(step, gain, jnp.array(0.5), INPUTS)[0])


def expected(number, gain):
    carry = 0.5
    for row in np.asarray(INPUTS):
        carry = np.sin(carry) * gain + number * row
    return carry


def assert_runs_by_xla_and_says(message, number):
    with pytest.warns(RuntimeWarning, match=message):
        found = last(new_step(number))(0.7)
    assert found == pytest.approx(expected(number, 0.7), abs=1e-14)
    # Once: not for the next program of the same step.
    with warnings.catch_warnings(action="error"):
        last(new_step(number))(0.6)
        assert "custom_call" not in last(new_step(number)).lower(0.6).as_text()


def test_a_primitive_without_a_rule_is_named():
    def step(_, carry, row):
        following = jnp.linalg.cholesky(carry + row * jnp.eye(2))
        return following, following

    start = 2 * jnp.eye(2)
    with pytest.warns(RuntimeWarning, match="There is no rule for `cholesky`"):
        found, _ = native.run(step, (), start, INPUTS)
    carry = np.asarray(start)
    for row in np.asarray(INPUTS):
        carry = np.linalg.cholesky(carry + row * np.eye(2))
    np.testing.assert_allclose(found, carry, atol=1e-13)


def test_in_tests_a_primitive_without_a_rule_is_a_failure():
    def step(_, carry, row):
        return jnp.linalg.cholesky(carry + row * jnp.eye(2)), row

    with pytest.raises(RuntimeWarning, match="cholesky"):
        native.run(step, (), 3 * jnp.eye(2), INPUTS)


def test_without_llvmlite(monkeypatch):
    monkeypatch.setitem(sys.modules, "llvmlite", None)
    monkeypatch.setitem(sys.modules, "llvmlite.binding", None)
    assert_runs_by_xla_and_says("llvmlite", 1.125)


def test_where_xla_has_no_header(monkeypatch, tmp_path):
    monkeypatch.setattr(jax.ffi, "include_dir", lambda: str(tmp_path))
    interface.header.cache_clear()
    names.fingerprint.cache_clear()
    assert_runs_by_xla_and_says("c_api.h", 1.25)
    interface.header.cache_clear()


@pytest.mark.parametrize(
    ("old", "new", "message", "number"),
    [
        ("int64_t rank;", "odd_t rank;", "unknown type: odd_t rank", 1.375),
        ("define XLA_FFI_API_MAJOR 0", "define XLA_FFI_API_MAJOR 7", "", 1.5),
        ("XLA_FFI_Args args;", "XLA_FFI_Args args; int64_t more;", "", 1.625),
    ],
)
def test_where_xla_speaks_another_version(monkeypatch, old, new, message, number):
    changed = interface.header().replace(old, new)
    assert changed != interface.header()
    for module in (names, handler):
        monkeypatch.setattr(module, "header", lambda: changed)
    names.fingerprint.cache_clear()
    assert_runs_by_xla_and_says(message, number)
    names.fingerprint.cache_clear()


def test_on_an_unchecked_system_nothing_is_said(monkeypatch):
    monkeypatch.setattr(machine, "CHECKED", ("plan9", "sparc"))
    assert last(new_step(1.75))(0.7) == pytest.approx(expected(1.75, 0.7), abs=1e-14)


def test_in_float32_it_is_the_ordinary_scan():
    start = jnp.array(0.5, jnp.float32)

    def step(gain, carry, row):
        return gain * carry + row, carry

    text = jax.jit(lambda k: native.run(step, k, start, INPUTS.astype(jnp.float32))).lower(
        jnp.array(0.5, jnp.float32)
    )
    assert "custom_call" not in text.as_text()


def test_for_other_devices_it_is_the_ordinary_program():
    traced = last(new_step(1.875)).trace(jnp.array(0.7))
    text = traced.lower(lowering_platforms=("cuda",)).as_text()
    assert "run_" not in text
    assert "while" in text


def test_a_step_with_too_many_numbers_is_refused_by_name():
    def step(table, carry, row):
        return carry + jnp.sum(table) * row, carry

    with pytest.warns(RuntimeWarning, match="5002 numbers|500. numbers"):
        native.run(step, jnp.ones(5000), jnp.array(0.0), INPUTS)
