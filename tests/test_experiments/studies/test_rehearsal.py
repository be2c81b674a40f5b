import concurrent.futures
import os
import pathlib

import jax
import pytest

from experiments.runtime import processes_aside
from experiments.studies import rehearsal
from experiments.studies.rehearsal import rehearse
from identification.result.fitted_robot import FittedRobot
from scdpr_jax.numerics.files.private_folder import private_folder
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import replace
from tuning.gains.optimise import Effort
from tuning.gains.tune import tune

TIMES = (2.3,)


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """The command line's cache in a folder that is forgotten, here and for its processes."""
    before = jax.config.jax_compilation_cache_dir
    folder = private_folder(tmp_path / "scdpr-jax")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    jax.config.update("jax_compilation_cache_dir", str(folder))
    yield folder
    jax.config.update("jax_compilation_cache_dir", before)


class Here(concurrent.futures.Executor):
    """Does at once what it is asked for."""

    def submit(self, function, *args):
        done = concurrent.futures.Future()
        try:
            done.set_result(function(*args))
        except TypeError as fault:
            done.set_exception(fault)
        return done


@pytest.fixture
def little(monkeypatch):
    """A tuning that is made at once."""
    asked = []
    monkeypatch.setattr(rehearsal, "_tuned", lambda leg_times: asked.append(leg_times))
    return asked


def test_what_was_rehearsed_is_not_rehearsed_again(cache, little):
    for times in (TIMES, TIMES, (1.0,)):
        concurrent.futures.wait(rehearse(Here(), times))
    assert little == [TIMES, (1.0,)]


def test_without_a_place_to_keep_programs_nothing_is_rehearsed(cache, little):
    jax.config.update("jax_compilation_cache_dir", None)
    assert rehearse(Here(), TIMES) == []
    assert not little


def test_without_other_processes_nothing_is_rehearsed(cache, little):
    assert rehearse(None, TIMES) == []
    assert not little


def test_one_that_fails_says_nothing_and_counts_for_none(cache, monkeypatch, capfd):
    def failing(leg_times):
        os.write(1, b"said by a library\n")
        raise TypeError

    monkeypatch.setattr(rehearsal, "_tuned", failing)
    for _ in range(2):
        assert rehearse(Here(), TIMES)[0].exception() is not None
    print("said afterwards")
    assert capfd.readouterr() == ("said afterwards\n", "")


def files(cache: pathlib.Path) -> set[str]:
    return {path.name for path in (cache / "native").iterdir()}


@pytest.mark.slow
def test_a_tuning_after_its_rehearsal_makes_no_program(cache):
    with processes_aside(1) as processes:
        concurrent.futures.wait(rehearse(processes, TIMES))
    made = files(cache)
    assert len(made) > 20
    robot = replace(consistent(), {"effective_pretension": 85.0, "drive_damping": 0.2})
    little = Effort(legs=3, generations=2, planned=1)
    tune(FittedRobot(robot, (), None), None, leg_times=TIMES, effort=little)
    assert files(cache) == made
