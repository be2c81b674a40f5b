"""Units shared among processes of this machine.

`concurrent.futures` has such a pool, and gives up all work when one of its processes dies; its
processes outlive a parent that is killed; and it sends pickles.
"""

import contextlib
import os
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Iterable, Iterator
from typing import IO

import numpy as np

from experiments.runtime.computation import Outcome
from experiments.runtime.executors.executor import ATTEMPTS, Executor, fallen
from experiments.runtime.executors.pipe import received, send
from experiments.runtime.installation import Installation, installation
from experiments.runtime.job import Job
from experiments.runtime.parcel import Parcel, packed

_COMMAND = (sys.executable, "-P", "-m", "experiments.runtime.executors.child")
_ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1"}
"""Sums that threads share out come out otherwise on another number of cores."""


class Processes(Executor):
    """Processes of this machine, which begin with the first unit and end with the last."""

    def __init__(self, number: int) -> None:
        """Nothing begins yet.

        Args:
            number: How many processes.
        """
        self._number = number

    @property
    def installation(self) -> Installation:
        return {**installation(), **_ONE_THREAD}

    def outcomes(self, job: Job, numbers: Iterable[int]) -> Iterator[tuple[int, Outcome]]:
        """Units' outcomes, as they come; see `Executor.outcomes`."""
        waiting = iter(numbers)
        found: queue.SimpleQueue[tuple[int, Outcome]] = queue.SimpleQueue()
        hands = [_Hand(job, found) for _ in range(self._number)]
        busy = 0
        try:
            for hand, number in zip(hands, waiting, strict=False):
                hand.take(number, job.payload(number))
                busy += 1
            while busy:
                number, outcome = found.get()
                hand = next(each for each in hands if each.number == number)
                following = next(waiting, None)
                if following is None:
                    busy -= 1
                else:
                    hand.take(following, job.payload(following))
                yield number, outcome
        finally:
            for hand in hands:
                hand.end()


class _Hand:
    """One process, begun anew when it dies, and the thread that waits for it."""

    def __init__(self, job: Job, found: "queue.SimpleQueue[tuple[int, Outcome]]") -> None:
        self.number = -1
        self._job, self._found = job, found
        self._process: subprocess.Popen[bytes] | None = None
        self._knows = False
        self._ended = False
        self._asked: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._work, daemon=True)

    def take(self, number: int, payload: bytes) -> None:
        """Compute a unit, once the one before is done."""
        if self.number < 0:
            self._thread.start()
        self.number = number
        self._asked.put(payload)

    def end(self) -> None:
        """End the process, whatever it is doing."""
        self._ended = True
        self._asked.put(None)
        if self._process is not None:
            self._process.kill()
        if self.number >= 0:
            self._thread.join()

    def _work(self) -> None:
        while (payload := self._asked.get()) is not None:
            number, cause = self.number, ""
            for _ in range(ATTEMPTS):
                answer = self._answer(number, payload)
                if self._ended:
                    return
                if answer is not None:
                    self._found.put((number, Outcome.unpacked(answer)))
                    break
                cause = self._buried()
            else:
                self._found.put((number, fallen(ATTEMPTS, cause)))
        self._buried()

    def _answer(self, number: int, payload: bytes) -> bytes | None:
        """The process's answer; None if it has died."""
        if self._process is None:
            environment = {**os.environ, **_ONE_THREAD, "MKL_NUM_THREADS": "1"}
            self._process = subprocess.Popen(
                _COMMAND, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment
            )
            self._knows = False
        if self._ended:  # Between its beginning and here.
            self._process.kill()
        facts = {
            "computation": self._job.computation,
            "number": number,
            "installation": dict(self._job.installation),
        }
        given = {"payload": payload, **({} if self._knows else {"shared": self._job.shared})}
        arrays = {name: np.frombuffer(part, np.uint8) for name, part in given.items()}
        try:
            send(_pipe(self._process.stdin), packed(Parcel(facts, arrays)))
        except OSError:
            return None
        self._knows = True
        return received(_pipe(self._process.stdout))

    def _buried(self) -> str:
        """What a process that has died died of, in words; the next begins anew."""
        process, self._process = self._process, None
        if process is None:
            return ""
        process.kill()
        status = process.wait()
        for pipe in (process.stdin, process.stdout):
            with contextlib.suppress(OSError):  # What it hadn't read any more.
                _pipe(pipe).close()
        if status < 0:
            return f"signal {-status}, {signal.strsignal(-status) or 'unknown'}"
        return f"exit status {status}"


def _pipe(pipe: IO[bytes] | None) -> IO[bytes]:
    assert pipe is not None  # As the process was begun with it.
    return pipe
