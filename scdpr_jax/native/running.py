"""A run of many steps, as machine code where there can be any."""

import functools
from collections.abc import Callable
from typing import Any, TypeVar

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import PyTree

from scdpr_jax.native import primitive
from scdpr_jax.native.traced import Step, Traced, trace
from scdpr_jax.numerics.lean_scan import lean_scan

Parameters = TypeVar("Parameters")
Carry = TypeVar("Carry")
Inputs = TypeVar("Inputs")
Outputs = TypeVar("Outputs")

_KINDS = frozenset(map(np.dtype, (np.float64, np.int32, np.int64, np.bool_)))
"""What machine code knows; integers only count there."""


def run(
    step: Callable[[Parameters, Carry, Inputs], tuple[Carry, Outputs]],
    parameters: Parameters,
    start: Carry,
    inputs: Inputs,
) -> tuple[Carry, Outputs]:
    """Many steps one after the other: `jax.lax.scan` as machine code of the step's equations.

    On a processor in float64 it takes a tenth to a fiftieth of XLA's time, and what compiles
    in a minute there compiles in a second. `jit`, `vmap`, `jvp`, `jacfwd` and `linearize` keep
    that, and so does `grad` by up to 256 numbers; by more, in float32 and on other devices it
    is the XLA program of the same step, as it is, with a `RuntimeWarning`, where the step does
    something that machine code has no rule for. Derivatives are those of `jax.jvp`.

    A step is traced again by each call that passes another function, so pass one that lasts:
    what it needs goes through `parameters`, though it may close over arrays.

    Args:
        step: A step, from parameters, what is carried and a row of inputs to what is carried on
            and outputs.
        parameters: What is the same in all steps.
        start: What is carried into the first step.
        inputs: Inputs of the steps, along the first axis of every array.

    Returns:
        What the last step carries on, and the outputs along the first axis.
    """
    given = jax.tree.map(jnp.asarray, (parameters, start, inputs))
    traced = _traced(step, *given)
    if traced is None:
        return scan(step, *given)
    operands = (*traced.constants, *jax.tree.leaves(given))
    made = _whole(*operands, step=traced.step)
    own, structure = jax.tree.flatten(traced.outputs)
    kinds = zip(made, own, strict=True)
    return jax.tree.unflatten(structure, [x.astype(like.dtype) for x, like in kinds])


def scan(
    step: Callable[[Parameters, Carry, Inputs], tuple[Carry, Outputs]],
    parameters: Parameters,
    start: Carry,
    inputs: Inputs,
) -> tuple[Carry, Outputs]:
    """What `run` does, as an XLA program: for steps that machine code has no rules for.

    Args:
        step: A step, from parameters, what is carried and a row of inputs to what is carried on
            and outputs.
        parameters: What is the same in all steps.
        start: What is carried into the first step.
        inputs: Inputs of the steps, along the first axis of every array.

    Returns:
        What the last step carries on, and the outputs along the first axis.
    """
    return lean_scan(functools.partial(step, parameters), start, inputs)


def _traced(step: Callable, parameters: PyTree, start: PyTree, inputs: PyTree) -> Traced | None:
    """A step that machine code can do, as far as its arrays are concerned."""
    leaves, rows = jax.tree.leaves((parameters, start, inputs)), jax.tree.leaves(inputs)
    lengths = {own.shape[:1] for own in rows}
    if not _are_known(leaves) or len(lengths) != 1 or lengths & {(), (0,)}:
        return None
    likes = jax.tree.map(_like, (parameters, start))
    row = jax.tree.map(lambda own: _like(own, own.shape[1:]), inputs)
    traced = trace(step, *likes, row)
    results = jax.tree.leaves(traced.outputs)
    carried = jax.tree.map(lambda own: (own.shape, own.dtype), start)
    following = jax.tree.map(lambda own: (own.shape, own.dtype), traced.outputs[0])
    fits = carried == following and _are_known([*results, *traced.constants])
    return traced if fits else None


def _are_known(arrays: list[Any]) -> bool:
    return all(own.dtype in _KINDS for own in arrays)


def _like(own: jax.Array, shape: tuple[int, ...] | None = None) -> jax.ShapeDtypeStruct:
    return jax.ShapeDtypeStruct(own.shape if shape is None else shape, own.dtype)


@functools.partial(jax.jit, static_argnames="step", inline=True)
def _whole(*operands: jax.Array, step: Step) -> list[jax.Array]:
    """All results of a single robot."""
    rows = [own.astype(jnp.float64)[None] for own in operands]
    # A sum over one keeps mapped axes where they are; an index would move them to the front.
    return [jnp.sum(own, 0) for own in primitive.results(rows, step=step)]
