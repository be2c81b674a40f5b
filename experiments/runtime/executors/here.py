"""Units one after the other in this process."""

from collections.abc import Iterable, Iterator

from experiments.runtime.computation import Outcome, compute
from experiments.runtime.executors.executor import Executor
from experiments.runtime.installation import Installation, installation
from experiments.runtime.job import Job


class ThisProcess(Executor):
    """This process."""

    @property
    def installation(self) -> Installation:
        return installation()

    def outcomes(self, job: Job, numbers: Iterable[int]) -> Iterator[tuple[int, Outcome]]:
        for number in numbers:
            given = (job.shared, number, job.payload(number), job.installation)
            yield number, Outcome.unpacked(compute(job.computation, *given))
