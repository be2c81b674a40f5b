"""What all executors are: something that computes a job's units, in whatever order."""

import abc
from collections.abc import Iterable, Iterator

from experiments.runtime.computation import Outcome
from experiments.runtime.installation import Installation
from experiments.runtime.job import Job

ATTEMPTS = 8
"""How often a unit may bring down who computes it; others may be to blame for some of them."""


def fallen(attempts: int, cause: str) -> Outcome:
    """What becomes of a unit whose worker has died again and again.

    Args:
        attempts: How often it was tried.
        cause: What was seen of it.

    Returns:
        The outcome.
    """
    return Outcome(b"", f"its worker died {attempts} times over it: {cause}")


class Executor(abc.ABC):
    """Who computes units."""

    @property
    @abc.abstractmethod
    def installation(self) -> Installation:
        """What its results come from.

        Raises:
            ValueError: If it has several that differ.
        """

    @abc.abstractmethod
    def outcomes(self, job: Job, numbers: Iterable[int]) -> Iterator[tuple[int, Outcome]]:
        """Units' outcomes, as they come.

        Args:
            job: The job.
            numbers: The units to compute, each once.

        Yields:
            A unit's number, and what became of it.
        """
