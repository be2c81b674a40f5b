"""What an entry point sets up."""

import os
import subprocess
import sys

import pytest

SET_UP = """
import jax
from experiments.runtime import set_up
set_up()
print(jax.config.jax_enable_x64, jax.config.jax_compilation_cache_dir)
"""


def set_up(**environment):
    """What is set up in a process of its own: float64, the cache's folder, complaints."""
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", SET_UP],
        env={**os.environ, "JAX_COMPILATION_CACHE_DIR": "", **environment},
        capture_output=True,
        text=True,
        check=True,
    )
    double, folder = done.stdout.rstrip("\n").split(" ", 1)
    return double, folder, done.stderr


def test_programs_are_kept_in_a_folder_of_the_users_own(tmp_path):
    double, folder, complaint = set_up(XDG_CACHE_HOME=str(tmp_path))
    assert double == "True"
    assert folder == str(tmp_path / "scdpr-jax")
    assert (tmp_path / "scdpr-jax").stat().st_mode & 0o777 == 0o700
    assert complaint == ""


@pytest.mark.parametrize("place", ["relative", "open"])
def test_without_a_folder_to_trust_nothing_is_kept_and_one_line_says_so(tmp_path, place):
    (tmp_path / "scdpr-jax").mkdir()
    (tmp_path / "scdpr-jax").chmod(0o777)
    cache = "relative/cache" if place == "relative" else str(tmp_path)
    double, folder, complaint = set_up(XDG_CACHE_HOME=cache)
    assert (double, folder) == ("True", "")
    assert len(complaint.splitlines()) == 1
    assert "compiled programs aren't kept" in complaint
