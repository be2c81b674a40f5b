"""What a process of `Processes` runs: units from its standard input to its standard output.

Run as `python -P -m experiments.runtime.executors.child`. It ends as soon as its input does, in
the middle of a unit as well: a parent that is killed leaves nobody behind.
"""

import os
import queue
import signal
import sys
import threading
from typing import IO

from experiments.runtime.computation import compute
from experiments.runtime.executors.pipe import received, send
from experiments.runtime.executors.worker import ready
from experiments.runtime.parcel import unpacked


def main() -> None:
    """Compute what is asked for until nothing more is."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Its parent decides what a key means.
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # What libraries print is no answer.
    asked: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(sys.stdin.buffer, asked), daemon=True).start()
    ready()
    shared: dict[str, bytes] = {}
    while True:
        facts, arrays = unpacked(asked.get())
        if "shared" in arrays:
            shared = {"shared": arrays["shared"].tobytes()}
        given = (facts["number"], arrays["payload"].tobytes(), facts["installation"])
        send(answers, compute(facts["computation"], shared["shared"], *given))


def _listen(pipe: IO[bytes], asked: "queue.SimpleQueue[bytes]") -> None:
    """Take in messages until there is nobody to send any."""
    while (message := received(pipe)) is not None:
        asked.put(message)
    os._exit(0)


if __name__ == "__main__":
    main()
