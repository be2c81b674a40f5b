"""Machine code is kept for later processes, and only where it can be trusted."""

import stat
import subprocess
import sys

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from scdpr_jax import native
from scdpr_jax.native.kept import names, store

INPUTS = jnp.linspace(0.0, 1.0, 20)


@pytest.fixture
def cache(tmp_path):
    """JAX's compilation cache in a folder that is forgotten afterwards."""
    before = jax.config.jax_compilation_cache_dir
    jax.config.update("jax_compilation_cache_dir", str(tmp_path))
    yield tmp_path
    jax.config.update("jax_compilation_cache_dir", before)


def test_what_is_kept_is_found(cache):
    assert store.kept("name") is None
    store.keep("name", b"code")
    assert store.kept("name") == b"code"
    assert stat.S_IMODE((cache / "native").stat().st_mode) == 0o700
    assert stat.S_IMODE((cache / "native" / "name").stat().st_mode) == 0o600


@pytest.mark.parametrize("damage", [slice(0, 20), slice(0, -1), slice(1, None), slice(0, 0)])
def test_a_damaged_file_counts_as_none(cache, damage):
    store.keep("name", b"code")
    file = cache / "native" / "name"
    file.write_bytes(file.read_bytes()[damage])
    assert store.kept("name") is None


def test_a_foreign_file_counts_as_none(cache):
    store.keep("name", b"code")
    (cache / "native" / "name").rename(cache / "native" / "other")
    assert store.kept("other") is None


def test_a_folder_that_others_can_write_is_refused(cache):
    (cache / "native").mkdir(mode=0o700)
    (cache / "native").chmod(0o770)
    with pytest.warns(RuntimeWarning, match="others can write"):
        store.keep("name", b"code")
    assert not [*(cache / "native").iterdir()]


def test_without_jax_cache_nothing_is_kept(cache):
    jax.config.update("jax_compilation_cache_dir", None)
    store.keep("name", b"code")
    assert store.kept("name") is None


LATER = """
import sys
import jax
import jax.numpy as jnp
from scdpr_jax import native
from scdpr_jax.native import machine

jax.config.update("jax_enable_x64", True)
jax.config.update("jax_compilation_cache_dir", sys.argv[1])
made, kernel = [], machine.kernel
machine.kernel = lambda *step, **about: made.append(step) or kernel(*step, **about)

def step(gain, carry, row):
    return jnp.sin(carry) * gain + 0.1875 * row, carry

end, _ = native.run(step, jnp.array(0.7), jnp.array(0.5), jnp.linspace(0.0, 1.0, 20))
print(float(end).hex(), len(made))
"""


def in_a_process(cache):
    """The end of a run in a process of its own, and how many kernels it made."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", LATER, str(cache)],
        capture_output=True,
        text=True,
        check=True,
    )
    end, kernels = done.stdout.split()
    return end, int(kernels)


def test_a_later_process_compiles_nothing_and_a_damaged_object_is_made_anew(tmp_path):
    first, kernels = in_a_process(tmp_path)
    assert kernels == 1
    [file] = (tmp_path / "native").iterdir()
    made = file.read_bytes()

    assert in_a_process(tmp_path) == (first, 0)

    file.write_bytes(made[:-100] + bytes(100))
    assert in_a_process(tmp_path) == (first, 1)
    assert file.read_bytes() == made


def test_a_name_depends_on_all_that_code_depends_on(monkeypatch):
    def name(gain, **change):
        def step(k, carry, row):
            return gain * k * carry + row, carry

        traced = native.running._traced(step, jnp.array(1.0), jnp.array(1.0), INPUTS)
        return traced.step.name

    assert name(2.0) == name(2.0)
    assert name(2.0) != name(np.nextafter(2.0, 3.0))
    before = names.fingerprint()
    names.fingerprint.cache_clear()
    monkeypatch.setattr(names, "header", lambda: "another")
    assert names.fingerprint() != before
    names.fingerprint.cache_clear()
