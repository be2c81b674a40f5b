import concurrent.futures
import multiprocessing
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

import jax
import pytest

from experiments.runtime import processes_aside

DROPPED = (concurrent.futures.CancelledError, concurrent.futures.BrokenExecutor)


def asleep(seconds):
    time.sleep(seconds)
    return os.getpid()


def computes():
    return jax.config.jax_enable_x64, jax.config.jax_compilation_cache_dir


def loaded():
    import experiments.reports.report  # noqa: F401 - that it takes no time is what is tested

    backends = sys.modules["jax._src.xla_bridge"]._backends
    return time.process_time(), bool(backends)


def test_they_compute_as_the_command_line_does(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with processes_aside(1) as processes:
        double, cache = processes.submit(computes).result()
    assert double
    assert cache == str(tmp_path / "scdpr-jax")


def test_nobody_goes_on_working_afterwards():
    before = {process.pid for process in multiprocessing.active_children()}
    with processes_aside(2) as processes:
        first = [processes.submit(asleep, 0.2) for _ in range(2)]
        assert len({one.result() for one in first}) == 2
        long = [processes.submit(asleep, 600.0) for _ in range(5)]
        begun = time.monotonic()
    assert time.monotonic() - begun < 60
    for one in long:
        with pytest.raises(DROPPED):
            one.result(timeout=60)
    assert {process.pid for process in multiprocessing.active_children()} <= before


@pytest.mark.skipif(
    "forkserver" not in multiprocessing.get_all_start_methods(), reason="nothing forks here"
)
def test_what_a_process_needs_is_loaded_once_and_nothing_runs_in_it_before_it_forks():
    with processes_aside(1) as processes:
        took, runs = processes.submit(loaded).result()
    assert took < 1.0  # Loading takes two.
    assert not runs


LEAVES = """
import time
from experiments.runtime import processes_aside
from experiments.verbs.ending import leave

def main():
    with processes_aside(1) as processes:
        processes.submit(int).result()
        processes.submit(time.sleep, 600)

if __name__ == "__main__":
    main()
    leave(0)
"""


@pytest.mark.parametrize("name", ["short", "long" * 30], ids=["short", "long"])
def test_who_leaves_at_once_leaves_no_folder_behind(name, tmp_path):
    script = tmp_path / "leaves.py"
    script.write_text(LEAVES)
    with tempfile.TemporaryDirectory() as near:
        temporary = pathlib.Path(near, name)  # No socket has a name of 120 letters.
        temporary.mkdir()
        environment = {**os.environ, "TMPDIR": str(temporary)}
        call = [sys.executable, str(script)]
        ended = subprocess.run(
            call, env=environment, check=True, timeout=120, capture_output=True, text=True
        )
        assert (ended.stdout, ended.stderr) == ("", "")
        assert not any(temporary.iterdir())


HEARS = """
import signal
import time
from experiments.runtime import processes_aside
from experiments.verbs.ending import leave

def main():
    signal.signal(signal.SIGINT, signal.default_int_handler)
    with processes_aside(1) as processes:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        print("loads", flush=True)
        processes.submit(time.sleep, 0.5).result()

if __name__ == "__main__":
    main()
    leave(0)
"""


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such signals")
def test_nobody_who_loads_hears_ctrl_c(tmp_path):
    script = tmp_path / "hears.py"
    script.write_text(HEARS)
    pipe = subprocess.PIPE
    child = subprocess.Popen(
        [sys.executable, str(script)],
        stdout=pipe,
        stderr=pipe,
        text=True,
        start_new_session=True,
    )
    assert child.stdout.readline() == "loads\n"
    for _ in range(20):
        os.killpg(child.pid, signal.SIGINT)
        time.sleep(0.1)
    assert child.communicate(timeout=120) == ("", "")
    assert child.returncode == 0
