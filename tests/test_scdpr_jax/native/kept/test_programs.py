"""Programs that are kept between processes: the same numbers, and never a stale one."""

import os
import pathlib
import subprocess
import sys
import textwrap
import threading

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax import native
from scdpr_jax.native.kept import names, store

_TRACED: list[str] = []
"""A word for every time that a function was traced."""


def oscillate(parameters, state, force):
    position, velocity = state
    velocity = velocity + 0.01 * (force - parameters["stiffness"] * position)
    position = position + 0.01 * velocity
    return (position, velocity), position


def driven(parameters, forces, sign):
    _TRACED.append("driven")
    start = (jnp.zeros(()), jnp.zeros(()))
    _, positions = native.run(oscillate, parameters, start, sign * forces)
    return {"positions": positions, "last": (positions[-1],)}


FORCES = jnp.sin(jnp.linspace(0.0, 5.0, 200))
PARAMETERS = {"stiffness": jnp.asarray(30.0)}


@pytest.fixture
def cache(tmp_path):
    """JAX's compilation cache in a folder that is forgotten afterwards."""
    before = jax.config.jax_compilation_cache_dir
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    _TRACED.clear()
    yield tmp_path / "native"
    jax.config.update("jax_compilation_cache_dir", before)


def programs(folder: pathlib.Path) -> list[pathlib.Path]:
    return [file for file in folder.iterdir() if file.name.startswith("program_")]


def same(one, other):
    jax.tree.map(np.testing.assert_array_equal, one, other)


def test_a_kept_program_does_what_the_function_does_and_traces_nothing(cache):
    expected = native.kept_jit(driven)(PARAMETERS, FORCES, 1.0)
    assert len(programs(cache)) == 1
    _TRACED.clear()
    same(native.kept_jit(driven)(PARAMETERS, FORCES, 1.0), expected)
    assert not _TRACED
    same(expected, jax.jit(driven)(PARAMETERS, FORCES, 1.0))


def test_what_is_no_array_and_every_shape_have_programs_of_their_own(cache):
    compiled = native.kept_jit(driven)
    forwards = compiled(PARAMETERS, FORCES, 1.0)["positions"]
    backwards = compiled(PARAMETERS, FORCES, -1.0)["positions"]
    np.testing.assert_allclose(backwards, -forwards, atol=1e-15)
    assert compiled(PARAMETERS, FORCES[:7], 1.0)["positions"].shape == (7,)
    assert len(programs(cache)) == 3


def test_without_a_folder_it_is_compiled_all_the_same(cache):
    jax.config.update("jax_compilation_cache_dir", None)
    same(
        native.kept_jit(driven)(PARAMETERS, FORCES, 1.0),
        jax.jit(driven)(PARAMETERS, FORCES, 1.0),
    )


def test_a_damaged_program_is_made_anew(cache):
    expected = native.kept_jit(driven)(PARAMETERS, FORCES, 1.0)
    (file,) = programs(cache)
    file.write_bytes(file.read_bytes()[:-9])
    same(native.kept_jit(driven)(PARAMETERS, FORCES, 1.0), expected)
    assert store.kept(file.name) is not None


def test_a_program_whose_machine_code_is_gone_is_made_anew(cache, tmp_path):
    script = tmp_path / "once.py"
    script.write_text(
        textwrap.dedent("""\
        import sys
        import jax
        jax.config.update("jax_enable_x64", True)
        jax.config.update("jax_compilation_cache_dir", sys.argv[1])
        from tests.test_scdpr_jax.native.kept import test_programs as own
        print(own.native.kept_jit(own.driven)(own.PARAMETERS, own.FORCES, 1.0)["last"][0])
        print(len(own._TRACED))
        """)
    )

    def told():
        root = pathlib.Path(names.__file__).parents[3]
        call = [sys.executable, script, str(cache.parent)]
        run = subprocess.run(
            call,
            capture_output=True,
            text=True,
            check=True,
            cwd=root,
            env=os.environ | {"PYTHONPATH": str(root)},
        )
        return run.stdout.split()

    first, traced = told()
    assert traced != "0"
    assert told() == [first, "0"]
    for file in cache.glob("run_*.o"):
        file.unlink()
    again, traced = told()
    assert again == first
    assert traced != "0"


def test_a_function_inside_of_another_is_not_kept(cache):
    native.kept_jit(lambda x: 2 * x)(FORCES)
    assert not cache.exists() or not programs(cache)


def test_another_source_is_another_program(cache, monkeypatch):
    native.kept_jit(driven)(PARAMETERS, FORCES, 1.0)
    monkeypatch.setattr(names, "sources", lambda package: b"edited")
    native.kept_jit(driven)(PARAMETERS, FORCES, 1.0)
    assert len(programs(cache)) == 2


def test_under_transformations_it_is_the_function(cache):
    compiled = native.kept_jit(driven)

    def last(stiffness):
        return compiled({"stiffness": stiffness}, FORCES, 1.0)["last"][0]

    slope = jax.jacfwd(last)(PARAMETERS["stiffness"])
    h = 1e-4
    differences = (last(jnp.asarray(30.0 + h)) - last(jnp.asarray(30.0 - h))) / (2 * h)
    np.testing.assert_allclose(slope, differences, rtol=1e-6)


def test_threads_that_ask_for_one_program_compile_it_once(cache):
    compiled = native.kept_jit(driven)
    together = threading.Barrier(4)

    def ask():
        together.wait()
        compiled(PARAMETERS, FORCES, 1.0)

    threads = [threading.Thread(target=ask) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    # Once to see what it calls, and once to be kept; a trace in between is JAX's own.
    assert len(programs(cache)) == 1
    assert len(_TRACED) <= 2
