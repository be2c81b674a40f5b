"""Traced steps that are kept on disk between processes.

Machine code needs a step's name and its shapes, not its equations. Tracing finds both, in half
a second for a closed loop; so they are kept, named by all that tracing depends on, and the
equations are traced where the machine code isn't there, too.
"""

import json
import sys
from typing import Any

import jax
import numpy as np
from jaxtyping import PyTree

from scdpr_jax.native.kept import store
from scdpr_jax.native.kept.names import lasting_name
from scdpr_jax.native.traced import Step, StepFunction, Traced, trace


def kept_trace(
    function: StepFunction, parameters: PyTree, carry: PyTree, row: PyTree
) -> Traced:
    """What `trace` brings, or brought an earlier process.

    Args:
        function: The step.
        parameters: Shapes of its parameters.
        carry: Shapes of what it carries.
        row: Shapes of a row of inputs.

    Returns:
        The step and what it closes over.
    """
    shapes, structure = jax.tree.flatten((parameters, carry, row))
    about = repr((shapes, str(structure), jax.config.jax_enable_x64))
    file = lasting_name("trace", [function], about)
    if not file:
        return trace(function, parameters, carry, row)
    code = store.kept(file)
    if code is None:
        made = trace(function, parameters, carry, row)
        text = _written(made, carry)
        if text is not None:
            store.keep(file, text.encode())
        return made
    found = json.loads(code)
    step = Step(
        found["name"],
        found["parameters"],
        found["carried"],
        *(_shapes(found[own]) for own in ("arguments", "results")),
        lambda: trace(function, parameters, carry, row).step.closed,
    )
    return Traced(step, (), (carry, _tree(found["outputs"])))


def _written(made: Traced, carry: PyTree) -> str | None:
    """What is kept of a step; none if it closes over arrays, or its outputs have no name."""
    carried, outputs = made.outputs
    tree = _described(outputs)
    same = jax.tree.structure(carried) == jax.tree.structure(carry)
    if made.constants or tree is None or not same:
        return None
    step = made.step
    about = {name: getattr(step, name) for name in ("name", "parameters", "carried")}
    return json.dumps(
        about | {"arguments": step.arguments, "results": step.results, "outputs": tree}
    )


def _shapes(kept: dict[str, list[int]]) -> dict[str, tuple[int, ...]]:
    return {name: tuple(shape) for name, shape in kept.items()}


def _described(tree: PyTree) -> list | None:
    """A tree of tuples and named tuples as lists, each of what it is and what it holds."""
    if isinstance(tree, jax.ShapeDtypeStruct):
        return ["", [*tree.shape], str(tree.dtype)]
    if not isinstance(tree, tuple):
        return None
    parts = [_described(part) for part in tree]
    own = type(tree)
    return None if None in parts else [f"{own.__module__}:{own.__qualname__}", *parts]


def _tree(kept: list[Any]) -> PyTree:
    """The tree again. What a step returns is of classes that are there where the step is."""
    kind, *parts = kept
    if not kind:
        return jax.ShapeDtypeStruct(tuple(parts[0]), np.dtype(parts[1]))
    module, name = kind.split(":")
    made = map(_tree, parts)
    return tuple(made) if name == "tuple" else getattr(sys.modules[module], name)(*made)
