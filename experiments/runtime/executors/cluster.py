"""Units shared among the workers of a dask cluster.

A worker that dies costs what it was at; the scheduler gives that to another one. A scheduler
that dies takes all that it knew with it: what wasn't received is asked for anew, as soon as one
answers at the same address.
"""

import contextlib
import dataclasses
import math
import queue
import time
from collections.abc import Callable, Iterable, Iterator

from distributed import Client, Future, KilledWorker
from distributed.client import FutureCancelledError
from distributed.comm import CommClosedError

from experiments.runtime.computation import Outcome
from experiments.runtime.executors import worker
from experiments.runtime.executors.executor import ATTEMPTS, Executor, fallen
from experiments.runtime.installation import Installation, different, installation
from experiments.runtime.job import Job

PATIENCE = 120.0
"""How long a cluster may be away, or without a worker [s]: a service is begun anew by then."""
AHEAD = 2
"""Units that wait for each thread, so that none waits for the client."""
WORKERS_OWN = ("system", "processor", "OPENBLAS_NUM_THREADS")
"""What workers have of their own: the client computes nothing."""
_LOOK = 2.0
"""How often it is looked how many workers there are [s]."""
_DEATHS = 4
"""Workers that dask lets a unit bring down before it gives it back."""
_LOST = (CommClosedError, FutureCancelledError, OSError, TimeoutError)
"""What a cluster that goes away, or a part of it, is seen by."""


@dataclasses.dataclass
class _Asked:
    """A unit that the cluster was asked for."""

    number: int
    payload: bytes
    rounds: int = 0
    deaths: int = 0
    future: Future | None = None


class Cluster(Executor):
    """A dask cluster, asked by a client that is made anew when it loses it."""

    def __init__(self, connect: Callable[[], Client], address: str) -> None:
        """Connects at once.

        Args:
            connect: Makes a client.
            address: Where the cluster is, for messages.

        Raises:
            ValueError: If it can't be reached.
        """
        self._connect, self._address = connect, address
        try:
            self._client = connect()
        except _LOST as error:
            raise self._unreachable(str(error)) from None

    def close(self) -> None:
        """Leave the cluster."""
        with contextlib.suppress(*_LOST):
            self._client.close(timeout=5)

    @property
    def installation(self) -> Installation:
        workers = self._installations()
        first = next(iter(workers.values()))
        own = {name: first[name] for name in WORKERS_OWN}
        expected = {**installation(), **own}
        for address, installed in workers.items():
            if words := different(installed, expected):
                raise _foreign(address, words)
        if first["OPENBLAS_NUM_THREADS"] != "1":
            raise ValueError(
                f"`--cluster`: workers of {self._address} share out sums among threads, got "
                f"OPENBLAS_NUM_THREADS {first['OPENBLAS_NUM_THREADS']}, expected 1: else the "
                "last bits depend on the number of cores. `dask worker` sets it where it has a "
                "nanny."
            )
        return expected

    def outcomes(self, job: Job, numbers: Iterable[int]) -> Iterator[tuple[int, Outcome]]:
        """Units' outcomes, as they come; see `Executor.outcomes`."""
        waiting = _Waiting(job, iter(numbers))
        asked: dict[int, _Asked] = {}
        ended: queue.SimpleQueue[tuple[int, Future]] = queue.SimpleQueue()
        room, looked = 0, -math.inf
        while waiting.more or asked:
            if time.monotonic() - looked > _LOOK:  # Workers come and go; asking takes a while.
                room, looked = AHEAD * self._threads() + 1, time.monotonic()
            for unit in waiting.taken(room - len(asked)):
                asked[unit.number] = unit
                self._ask(job, unit, ended)
            try:
                number, future = ended.get(timeout=1.0)
            except queue.Empty:
                if not self._is_there():
                    self._again(job, asked.values(), ended)
                continue
            if number not in asked or asked[number].future is not future:
                continue  # An earlier client's.
            outcome = self._outcome(asked[number], future)
            if outcome is None:
                if self._is_there():
                    self._ask(job, asked[number], ended)
                else:
                    self._again(job, asked.values(), ended)
                continue
            if outcome.foreign:
                raise _foreign(self._address, outcome.foreign)
            del asked[number]
            yield number, outcome

    def _installations(self) -> dict[str, Installation]:
        """Every worker's installation, by its address."""
        deadline = time.monotonic() + PATIENCE
        while True:
            try:
                self._client.wait_for_workers(1, timeout=PATIENCE)
                return self._client.run(worker.installed)
            except _LOST as error:
                if time.monotonic() > deadline:
                    raise self._unreachable(f"no worker there: {error}") from None
                self._connect_anew(deadline)
            except ImportError as error:
                raise self._cannot(error) from None

    def _connect_anew(self, deadline: float) -> None:
        """A new client, as soon as there is a scheduler with a worker."""
        self.close()
        while True:
            try:
                self._client = self._connect()
                self._client.wait_for_workers(1, timeout=max(deadline - time.monotonic(), 0.1))
                return
            except _LOST as error:
                if time.monotonic() > deadline:
                    raise self._unreachable(str(error)) from None
                time.sleep(0.5)

    def _is_there(self) -> bool:
        """Whether the scheduler is, and has a worker."""
        return self._client.status == "running" and bool(self._threads())

    def _threads(self) -> int:
        try:
            return sum(self._client.nthreads().values())
        except _LOST:
            return 0

    def _again(
        self,
        job: Job,
        asked: Iterable[_Asked],
        ended: "queue.SimpleQueue[tuple[int, Future]]",
    ) -> None:
        """Ask a cluster that has been away for all that it was asked for."""
        self._connect_anew(time.monotonic() + PATIENCE)
        for unit in asked:
            self._ask(job, unit, ended)

    def _ask(
        self, job: Job, unit: _Asked, ended: "queue.SimpleQueue[tuple[int, Future]]"
    ) -> None:
        """Ask for a unit; of one whose workers died, anew."""
        name = job.identity(unit.number, unit.payload).hex()[:32]
        unit.future = self._client.submit(
            worker.outcome,
            *(job.computation, job.shared, unit.number, unit.payload),
            dict(job.installation),
            key=f"scdpr-{name}-{unit.rounds}",
        )
        unit.future.add_done_callback(lambda own, number=unit.number: ended.put((number, own)))

    def _outcome(self, unit: _Asked, future: Future) -> Outcome | None:
        """What became of a unit; None where it has to be asked for anew."""
        try:
            return Outcome.unpacked(future.result(timeout=PATIENCE))
        except KilledWorker:
            unit.deaths += _DEATHS
            unit.rounds += 1
            if unit.deaths >= ATTEMPTS:
                return fallen(unit.deaths, "killed, or crashed")
            return None
        except _LOST:
            unit.rounds += 1  # Another name: the scheduler may still know the old one as lost.
            return None
        except ImportError as error:
            raise self._cannot(error) from None

    def _cannot(self, error: ImportError) -> ValueError:
        return ValueError(
            f"`--cluster`: a worker of {self._address} can't compute this, got {error}. "
            "Install scdpr-jax there, in the same version."
        )

    def _unreachable(self, seen: str) -> ValueError:
        return ValueError(
            f"`--cluster`: {self._address} doesn't answer, got {seen or 'nothing'}, expected a "
            "scheduler with a worker. What is done is kept: the same call goes on from here."
        )


class _Waiting:
    """Units that nobody was asked for yet."""

    def __init__(self, job: Job, numbers: Iterator[int]) -> None:
        self.more = True
        self._job, self._numbers = job, numbers

    def taken(self, most: int) -> Iterator[_Asked]:
        """The next of them."""
        for _ in range(most):
            number = next(self._numbers, None)
            if number is None:
                self.more = False
                return
            yield _Asked(number, self._job.payload(number))


def _foreign(address: str, words: str) -> ValueError:
    return ValueError(
        f"`--cluster`: a worker of {address} has another installation: {words}. Its bits may "
        "differ: install the same there, or take it out of the cluster."
    )
