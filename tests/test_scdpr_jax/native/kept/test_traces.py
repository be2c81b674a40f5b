"""A step that an earlier process traced runs without being traced again."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax.native import Runs, direct, traced
from scdpr_jax.native.kept.traces import kept_trace

_TRACED: list[str] = []


class Swing(NamedTuple):
    place: object
    speed: object


def swing(stiffness, state, push):
    _TRACED.append("swing")
    speed = state.speed - 0.1 * (stiffness * jnp.sin(state.place) - push)
    place = state.place + 0.1 * speed
    return Swing(place, speed), (Swing(place**2, speed), place)


def in_a_dictionary(_, state, push):
    _TRACED.append("in_a_dictionary")
    return state + push, {"state": state}


START, PUSH = Swing(np.zeros(3), np.ones(3)), np.ones((1, 5))


@pytest.fixture
def cache(tmp_path):
    """JAX's compilation cache in a folder that is forgotten afterwards."""
    before = jax.config.jax_compilation_cache_dir
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    forget()
    yield tmp_path / "native"
    forget()
    jax.config.update("jax_compilation_cache_dir", before)


def forget():
    """As in another process."""
    direct._traced.cache_clear()
    traced._memory.clear()
    _TRACED.clear()


def traces(folder):
    return sorted(file for file in folder.iterdir() if file.name.startswith("trace_"))


def run():
    return Runs(swing, np.ones(1))(START, PUSH)


def same(one, other):
    assert jax.tree.structure(one) == jax.tree.structure(other)
    jax.tree.map(np.testing.assert_array_equal, one, other)


def test_a_step_that_is_kept_runs_without_being_traced(cache):
    first = run()
    assert len(traces(cache)) == 1
    assert _TRACED
    forget()
    same(run(), first)
    assert not _TRACED


def test_its_equations_are_traced_where_they_are_asked_for(cache):
    like = jax.ShapeDtypeStruct((), float)
    shapes = (like, Swing(like, like), like)
    first = kept_trace(swing, *shapes)
    forget()
    again = kept_trace(swing, *shapes)
    assert again.step == first.step
    assert (again.step.arguments, again.step.results, again.outputs) == (
        first.step.arguments,
        first.step.results,
        first.outputs,
    )
    assert not _TRACED
    assert str(again.step.closed) == str(first.step.closed)
    assert _TRACED == ["swing"]


def test_a_damaged_trace_is_made_anew(cache):
    first = run()
    (file,) = traces(cache)
    file.write_bytes(file.read_bytes()[:-3])
    forget()
    same(run(), first)
    assert _TRACED


def test_outputs_that_have_no_name_are_traced_by_each_process(cache):
    for _ in range(2):
        forget()
        _, made = Runs(in_a_dictionary, ())(np.zeros(1), PUSH)
        np.testing.assert_array_equal(made["state"][0], np.arange(5.0))
        assert _TRACED
    assert not traces(cache)


def test_without_a_folder_it_runs_all_the_same(cache):
    jax.config.update("jax_compilation_cache_dir", None)
    end, _ = run()
    assert end.place.shape == (3,)
