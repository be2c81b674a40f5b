import multiprocessing
import pathlib
import time

import jax
import pytest

from experiments.studies import rehearsal
from identification.result.fitted_robot import FittedRobot
from scdpr_jax.native.kept import store
from scdpr_jax.numerics.files.private_folder import private_folder
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from tuning.gains.optimise import Effort
from tuning.gains.tune import tune


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """The command line's cache in a folder that is forgotten, here and for its processes."""
    before = jax.config.jax_compilation_cache_dir
    folder = private_folder(tmp_path / "scdpr-jax")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("JAX_COMPILATION_CACHE_DIR", str(folder))
    jax.config.update("jax_compilation_cache_dir", str(folder))
    yield folder
    jax.config.update("jax_compilation_cache_dir", before)


def instead(monkeypatch, function):
    monkeypatch.setattr(rehearsal, "_rehearse", function)


def kept_at_once(name, leg_times):
    store.keep(name, b"")


def asleep(name, leg_times):
    time.sleep(600)


def failing(name, leg_times):
    rehearsal.tune = None
    _REHEARSE(name, leg_times)


_REHEARSE = rehearsal._rehearse


def test_what_was_rehearsed_is_not_rehearsed_again(cache, monkeypatch):
    instead(monkeypatch, kept_at_once)
    with rehearsal.rehearsed() as wait:
        assert multiprocessing.active_children()
        wait()
    with rehearsal.rehearsed() as wait:
        assert not multiprocessing.active_children()
        wait()
    with rehearsal.rehearsed((1.0,)):
        assert multiprocessing.active_children()


def test_without_a_place_to_keep_programs_nothing_is_rehearsed(cache):
    jax.config.update("jax_compilation_cache_dir", None)
    with rehearsal.rehearsed() as wait:
        assert not multiprocessing.active_children()
        wait()


def test_who_does_not_wait_leaves_no_rehearsal_behind(cache, monkeypatch):
    instead(monkeypatch, asleep)
    with rehearsal.rehearsed():
        assert multiprocessing.active_children()
    assert not multiprocessing.active_children()


def test_one_that_fails_says_nothing_and_counts_for_none(cache, monkeypatch, capfd):
    instead(monkeypatch, failing)
    with rehearsal.rehearsed() as wait:
        wait()
    assert capfd.readouterr() == ("", "")
    with rehearsal.rehearsed():
        assert multiprocessing.active_children()


def programs(cache: pathlib.Path) -> set[str]:
    return {path.name for path in (cache / "native").iterdir()}


@pytest.mark.slow
def test_a_tuning_after_its_rehearsal_makes_no_program(cache):
    with rehearsal.rehearsed((2.3,)) as wait:
        wait()
    made = programs(cache)
    robot = replace(consistent(), {"effective_pretension": 85.0, "drive_damping": 0.2})
    little = Effort(legs=3, generations=2, planned=1)
    tune(FittedRobot(robot, (), None), None, leg_times=(2.3,), effort=little)
    assert programs(cache) == made
