"""A cluster gives the bytes of one process, whoever of it dies, and knows who may ask it."""

import contextlib
import os
import pathlib
import random
import signal
import subprocess
import sys
import threading
import time

import pytest
from unreadable_campaigns import job_of

from experiments.runtime.executors.chosen import CERTIFICATES, chosen
from experiments.runtime.executors.here import ThisProcess
from experiments.sweep.axes import parse_axes
from experiments.sweep.move import CLOSED_LOOP
from experiments.sweep.run import sweep
from scdpr_jax.robot.prototype import consistent

distributed = pytest.importorskip("distributed")
cluster_module = pytest.importorskip("experiments.runtime.executors.cluster")


@pytest.fixture
def broken(tmp_path):
    return job_of(tmp_path)


def outcomes(executor, broken):
    job = broken(executor.installation)
    return dict(executor.outcomes(job, range(job.count)))


@pytest.fixture
def threads(monkeypatch):
    """A cluster of threads of this process."""
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    monkeypatch.setattr("experiments.runtime.executors.worker.set_up", lambda: None)
    for cached in ("installation.installation", "executors.worker.ready"):
        module, _, name = f"experiments.runtime.{cached}".rpartition(".")
        getattr(sys.modules[module], name).cache_clear()
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=False, dashboard_address="127.0.0.1:0"
    ) as local:
        executor = cluster_module.Cluster(
            lambda: distributed.Client(local, set_as_default=False), "here"
        )
        yield executor
        executor.close()


def test_a_cluster_gives_the_bytes_of_this_process(threads, broken):
    assert outcomes(threads, broken) == outcomes(ThisProcess(), broken)


def test_a_worker_of_another_installation_is_refused_by_name(threads, monkeypatch):
    monkeypatch.setattr(
        cluster_module, "installation", lambda: {"jax": "0.0.1", "processor": "mine"}
    )
    with pytest.raises(ValueError, match=r"another installation: jax .* for 0\.0\.1"):
        _ = threads.installation


def test_workers_that_share_out_sums_are_refused(threads, monkeypatch):
    shared = lambda: {"system": "", "processor": "one", "OPENBLAS_NUM_THREADS": "2"}  # noqa: E731
    monkeypatch.setattr("experiments.runtime.executors.worker.installation", shared)
    monkeypatch.setattr(cluster_module, "installation", shared)
    with pytest.raises(ValueError, match="share out sums"):
        _ = threads.installation


# With processes of its own

needs_proc = pytest.mark.skipif(not os.path.isdir("/proc/self"), reason="there is no /proc")
GRID = ("y=0.2..0.9:32 m", "x=0.2..1.3:64 m")
ENVIRONMENT = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}


def dask(*arguments):
    return subprocess.Popen(
        [sys.executable, "-m", "dask", *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=ENVIRONMENT,
    )


def free_port():
    import socket

    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return str(one.getsockname()[1])


def children(process):
    found = []
    for entry in pathlib.Path("/proc").iterdir():
        with contextlib.suppress(OSError, IndexError, ValueError):
            parent = int((entry / "stat").read_text().rpartition(")")[2].split()[1])
            if parent == process and b"tracker" not in (entry / "cmdline").read_bytes():
                found.append(int(entry.name))
    return found


class Rack:
    """A scheduler and workers, all of which begin anew when they die."""

    def __init__(self, folder, *, kind="tcp", options=()):
        self.port, self.options = free_port(), options
        self.address, self.folder = f"{kind}://127.0.0.1:{self.port}", folder
        self.scheduler = self._scheduler()
        self.workers = [self._worker() for _ in range(2)]

    def _scheduler(self):
        place = ("--host", self.address.rpartition(":")[0], "--port", self.port)
        return dask("scheduler", *place, "--no-dashboard", *self.options)

    def _worker(self):
        one = ("--nthreads", "1", "--nworkers", "1", "--no-dashboard")
        local = ("--local-directory", str(self.folder / "dask"))
        return dask("worker", self.address, *one, *local, *self.options)

    def kill_a_worker(self):
        for process in children(random.choice(self.workers).pid):
            with contextlib.suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)

    def kill_the_scheduler(self):
        self.scheduler.kill()
        self.scheduler.wait()
        self.scheduler = self._scheduler()

    def look_after(self):
        self.workers = [own if own.poll() is None else self._worker() for own in self.workers]

    def end(self):
        for process in [*self.workers, self.scheduler]:
            for child in children(process.pid):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(child, signal.SIGKILL)
            process.kill()
            process.wait()


@pytest.fixture
def rack(tmp_path):
    own = Rack(tmp_path)
    yield own
    own.end()


def swept(out, executor):
    axes = parse_axes(GRID, CLOSED_LOOP.known)
    measure = CLOSED_LOOP._replace(unit=64)
    sweep(measure, axes, consistent(), out, executor=executor).close()
    return out.read_bytes()


@pytest.mark.slow
@needs_proc
def test_workers_and_the_scheduler_may_die_while_it_computes(rack, tmp_path, monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    over = threading.Event()

    def kill():
        for number in range(1, 9):
            if over.wait(3):
                return
            rack.kill_a_worker()
            if number == 3:
                rack.kill_the_scheduler()
            for _ in range(10):
                rack.look_after()
                time.sleep(0.1)

    killer = threading.Thread(target=kill)
    with chosen(rack.address, None, 1) as executor:
        killer.start()
        clustered = swept(tmp_path / "cluster.nc", executor)
    over.set()
    killer.join()
    assert clustered == swept(tmp_path / "here.nc", ThisProcess())


@pytest.mark.slow
def test_a_local_cluster_of_four_gives_the_bytes_of_one_process(tmp_path, monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    with chosen("local:4", None, 1) as executor:
        clustered = swept(tmp_path / "cluster.nc", executor)
    assert clustered == swept(tmp_path / "here.nc", ThisProcess())


def certificates(folder, authority=None):
    """A folder of `--certificates`, signed by another one's authority or by its own."""
    folder.mkdir()

    def openssl(*words):
        subprocess.run(["openssl", *words], check=True, capture_output=True, cwd=folder)

    if authority is None:
        subject = ("-subj", "/CN=scdpr test authority", "-days", "2")
        openssl("req", "-x509", "-newkey", "rsa:2048", "-nodes", *subject,
                "-keyout", "authority.key", "-out", "ca.pem")  # fmt: skip
        authority = folder
    (folder / "ca.pem").write_bytes((authority / "ca.pem").read_bytes())
    openssl("req", "-newkey", "rsa:2048", "-nodes", "-subj", "/CN=scdpr",
            "-keyout", "key.pem", "-out", "request.pem")  # fmt: skip
    openssl("x509", "-req", "-in", "request.pem", "-CA", str(authority / "ca.pem"),
            "-CAkey", str(authority / "authority.key"), "-CAcreateserial", "-days", "2",
            "-out", "cert.pem")  # fmt: skip
    return folder


@pytest.mark.slow
def test_a_client_without_a_certificate_of_the_clusters_authority_is_refused(
    tmp_path, broken, monkeypatch
):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    known = certificates(tmp_path / "known")
    mine = certificates(tmp_path / "mine", known)
    foreign = certificates(tmp_path / "foreign")
    authority, own, key = (str(known / name) for name in CERTIFICATES)
    options = ("--tls-ca-file", authority, "--tls-cert", own, "--tls-key", key)
    secured = Rack(tmp_path, kind="tls", options=options)
    try:
        with chosen(secured.address, mine, 1) as executor:
            asked = outcomes(executor, broken)
        assert asked == outcomes(ThisProcess(), broken)
        monkeypatch.setattr("experiments.runtime.executors.chosen.ANSWERS_WITHIN", 3.0)
        for address, folder in (
            (secured.address, foreign),
            (secured.address.replace("tls", "tcp"), None),
        ):
            with (
                pytest.raises(ValueError, match="doesn't answer"),
                chosen(address, folder, 1),
            ):
                raise AssertionError
    finally:
        secured.end()
