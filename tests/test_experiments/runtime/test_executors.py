"""Whoever computes, the bytes are the same, and nobody who dies takes a unit along.

Campaigns that can't be read are units that compute nothing: what is left is the way there.
"""

import contextlib
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import pytest
from unreadable_campaigns import NAMES, job_of

from experiments.runtime.computation import COMPUTATIONS, Outcome, compute
from experiments.runtime.executors.chosen import chosen, require_cluster
from experiments.runtime.executors.here import ThisProcess
from experiments.runtime.executors.processes import Processes
from experiments.runtime.installation import different, installation
from experiments.studies.campaigns.unit import answer_of


@pytest.fixture
def broken(tmp_path):
    return job_of(tmp_path)


def outcomes(executor, broken):
    job = broken(executor.installation)
    found = list(executor.outcomes(job, range(job.count)))
    assert sorted(number for number, _ in found) == list(range(job.count))
    return dict(found)


def test_every_computation_has_its_module():
    import importlib

    for module in COMPUTATIONS.values():
        assert callable(importlib.import_module(module).begin)


def children():
    """Processes of this machine that compute units for this one."""
    found = []
    for entry in pathlib.Path("/proc").iterdir():
        with contextlib.suppress(OSError, IndexError):
            if not entry.name.isdecimal():
                continue
            parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            if parent == os.getpid() and b"executors.child" in (entry / "cmdline").read_bytes():
                found.append(int(entry.name))
    return found


needs_proc = pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="there is no /proc")


@needs_proc
def test_processes_give_the_bytes_of_this_one_though_one_is_killed(broken):
    killed = []

    def kill():
        while not killed:
            for child in children()[:1]:
                os.kill(child, signal.SIGKILL)
                killed.append(child)
            time.sleep(0.01)

    here = outcomes(ThisProcess(), broken)
    killer = threading.Thread(target=kill)
    killer.start()
    found = outcomes(Processes(2), broken)
    killer.join()
    assert found == here
    assert not children()
    for number, outcome in found.items():
        assert (outcome.failure, outcome.foreign) == ("", "")
        assert f"campaign {NAMES[number]}: 2 faults" in answer_of(outcome.content).reason


PARENT = """
import sys
from experiments.runtime.executors.processes import Processes
from experiments.runtime.job import Job
from experiments.runtime.parcel import Parcel
facts = {"names": ["a"] * 9, "question": {}, "accept": [], "skip_bad_runs": False}
executor = Processes(1)
job = Job("identify", Parcel(facts), 9, executor.installation, lambda number: b"")
for number, outcome in executor.outcomes(job, range(9)):
    print(number, flush=True)
    sys.stdin.read()
"""


@pytest.mark.slow
@needs_proc
def test_a_parent_that_is_killed_leaves_no_process_behind():
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    )
    parent.stdout.readline()
    own = [
        int(entry.name)
        for entry in pathlib.Path("/proc").iterdir()
        if entry.name.isdecimal()
        and (entry / "stat").read_text().rpartition(")")[2].split()[1] == str(parent.pid)
    ]
    assert own
    parent.kill()
    parent.wait()
    parent.stdin.close()
    parent.stdout.close()
    deadline = time.monotonic() + 30
    while any(alive(process) for process in own) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert not any(alive(process) for process in own)


def alive(process):
    try:
        status = pathlib.Path(f"/proc/{process}/stat").read_text()
        return status.rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def test_whoever_has_another_installation_computes_nothing():
    expected = {**installation(), "jax": "0.0.1"}
    outcome = Outcome.unpacked(compute("identify", b"", 0, b"", expected))
    assert (outcome.content, outcome.failure) == (b"", "")
    assert outcome.foreign == f"jax {installation()['jax']} for 0.0.1"
    assert different(installation(), installation()) == ""


def test_a_failure_is_an_outcome_with_its_reason():
    outcome = Outcome.unpacked(compute("identify", b"no parcel", 0, b"", installation()))
    assert outcome.failure.startswith("ValueError: no parcel")


@pytest.mark.parametrize(
    ("cluster", "certificates", "cores", "said"),
    [
        ("udp://here:1", None, None, "expected tcp://HOST:PORT"),
        ("local:0", None, None, "expected tcp://HOST:PORT"),
        ("local:two", None, None, "expected tcp://HOST:PORT"),
        ("tcp://here", None, None, "expected tcp://HOST:PORT"),
        ("tls://here:1", None, None, "expected a folder with ca.pem"),
        ("tcp://here:1", "folder", None, "for tls:// and for nothing else"),
        ("tls://here:1", "folder", None, "has no ca.pem, cert.pem, key.pem"),
        (None, "folder", None, "belong to `--cluster"),
        ("local:2", None, 2, "beside `--cluster`"),
        (None, None, 0, "1 or more"),
    ],
)
def test_what_is_no_cluster_is_refused_before_anything_begins(
    cluster, certificates, cores, said, tmp_path
):
    folder = None if certificates is None else tmp_path
    with pytest.raises(ValueError, match=said):
        require_cluster(cluster, folder, cores)


def test_a_cluster_that_is_not_there_is_said_to_be(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("experiments.runtime.executors.chosen.ANSWERS_WITHIN", 0.5)
    with (
        pytest.raises(ValueError, match=r"127\.0\.0\.1:9 doesn't answer"),
        chosen("tcp://127.0.0.1:9", None, 1),
    ):
        raise AssertionError
