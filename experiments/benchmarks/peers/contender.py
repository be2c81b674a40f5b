"""What takes part in a benchmark."""

import abc

import equinox as eqx
from jaxtyping import Array, Float


class Contender(eqx.Module):
    """A way to simulate the problem's run; equal ones are compiled once."""

    @abc.abstractmethod
    def __call__(self, values: Float[Array, "4"]) -> Float[Array, "rows 5"]:
        """Positions at the log's instants.

        Args:
            values: Values of `experiments.benchmarks.problem.FREE`.

        Returns:
            Positions [m, rad, m, m, m], the start first.
        """
