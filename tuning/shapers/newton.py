"""Roots of equations, differentiable in what the equations depend on."""

from collections.abc import Callable

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

_STAGES = 12
"""Parameters on the way to the one asked for."""
_STEPS = 6
"""Newton's steps at each: from so near a start four reach rounding."""

_Function = Callable[[Float[Array, " n"]], Float[Array, " n"]]
_Family = Callable[[Float[Array, " n"], Float[Array, ""]], Float[Array, " n"]]


def continued_root(
    equations: _Family, start: Float[Array, " n"], *, parameter: Float[Array, ""]
) -> Float[Array, " n"]:
    """Where some equations vanish, followed from a known root as a parameter grows.

    Newton's method at a dozen parameters between 0 and the one asked for, each starting
    from the last one's root. The derivative is that of the implicit function, whatever
    the number of steps.

    Args:
        equations: As many as there are unknowns, over the unknowns and the parameter;
            other numbers that they close over may be differentiated, too.
        start: The root, or a point near it, at a parameter of 0.
        parameter: The parameter.

    Returns:
        The root; not finite, or no root, where the method lost it: check it.
    """

    def stage(number: Int[Array, ""], x: Float[Array, " n"]) -> Float[Array, " n"]:
        share = (1 + number // _STEPS).astype(x.dtype) / _STAGES

        def function(x: Float[Array, " n"]) -> Float[Array, " n"]:
            return equations(x, share * parameter)

        return x - jnp.linalg.solve(jax.jacfwd(function)(x), function(x))

    def solve_linear(function: _Function, y: Float[Array, " n"]) -> Float[Array, " n"]:
        return jnp.linalg.solve(jax.jacfwd(function)(y), y)

    solution = jax.lax.stop_gradient(jax.lax.fori_loop(0, _STAGES * _STEPS, stage, start))
    # Solved already: this only tells how the root moves with what the equations hold.
    return jax.lax.custom_root(
        lambda x: equations(x, parameter), solution, lambda _, x: x, solve_linear
    )
