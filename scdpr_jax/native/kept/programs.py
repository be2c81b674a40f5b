"""Compiled functions whose traced programs are kept on disk between processes.

JAX's compilation cache keeps what XLA makes of a program, but the program itself is traced
anew by every process, in half a second for the Jacobian of a run. What is kept here is the
program, named by all that tracing depends on: the function, the shapes, what is no array, the
sources of the packages that they come from, and versions. A kept program may call machine
code (`machine`), which is kept beside it.
"""

import functools
import json
import re
import threading
from collections.abc import Callable, Hashable, Sequence
from typing import Any, Generic, ParamSpec, TypeVar

import equinox as eqx
import jax
import numpy as np
from jaxtyping import PyTree

from scdpr_jax.native import machine
from scdpr_jax.native.kept import store
from scdpr_jax.native.kept.names import lasting_name

Given = ParamSpec("Given")
Result = TypeVar("Result")
Leaf = jax.Array | np.ndarray | np.generic
Program = Callable[..., Any]
"""From arrays to a tree of arrays."""

_ANY_CALL = jax.export.DisabledSafetyCheck.custom_call("ALL")
"""A program is read by the versions that wrote it, so no call needs to be stable."""
_HANDLERS = re.compile(rf"\b{machine.HANDLER}[0-9a-f]{{40}}\b")


def kept_jit(function: Callable[Given, Result]) -> "KeptJit[Given, Result]":
    """`equinox.filter_jit`, with programs that are kept between processes.

    A program is kept if a folder for it can be trusted (see `store`) and all that it depends
    on has a name that lasts, which a function inside of another one hasn't; else it is traced
    by each process. A function calls what is in its own package and in this one: the sources
    of others aren't looked at. Under another transformation it is the function itself.

    Args:
        function: From trees of arrays, and of what is no array, to a tree of arrays: tuples,
            lists, dictionaries, and named tuples that `jax.export` was told of.

    Returns:
        The function, compiled.
    """
    return functools.wraps(function)(KeptJit(function))


class KeptJit(Generic[Given, Result]):
    """A function with its programs, one for each kind of arguments."""

    def __init__(self, function: Callable[Given, Result]):
        """Nothing is traced until it is called.

        Args:
            function: The function.
        """
        self._function = function
        self._programs: dict[Hashable, Program] = {}
        self._locks: dict[Hashable, threading.Lock] = {}
        self._one_at_a_time = threading.Lock()

    def __call__(self, *args: Given.args, **kwargs: Given.kwargs) -> Result:
        """The function's result."""
        arrays, static = eqx.partition((args, kwargs), _is_array)
        leaves, structure = jax.tree.flatten(arrays)
        if any(isinstance(leaf, jax.core.Tracer) for leaf in leaves):
            return self._function(*args, **kwargs)
        return self._program(leaves, structure, static)(*leaves)

    def _program(
        self, leaves: Sequence[Leaf], structure: jax.tree_util.PyTreeDef, static: PyTree
    ) -> Program:
        others, whole = jax.tree.flatten(static)
        shapes = tuple((leaf.shape, leaf.dtype) for leaf in leaves)
        kind = (structure, shapes, tuple(others), whole, jax.config.jax_enable_x64)
        with self._one_at_a_time:
            own = self._locks.setdefault(kind, threading.Lock())
        with own:
            # Whoever else asks for it meanwhile waits.
            if kind not in self._programs:
                about = repr((kind[1:], str(structure)))
                file = lasting_name("program", [self._function, *others], about)
                flat = self._flat(structure, static)
                self._programs[kind] = _compiled(flat, leaves, file)
        return self._programs[kind]

    def _flat(self, structure: jax.tree_util.PyTreeDef, static: PyTree) -> jax.stages.Wrapped:
        """The function of the arrays alone."""

        def flat(*leaves: jax.Array) -> Result:
            args, kwargs = eqx.combine(jax.tree.unflatten(structure, leaves), static)
            return self._function(*args, **kwargs)

        return jax.jit(flat)


def _is_array(leaf: Any) -> bool:
    return isinstance(leaf, Leaf)


def _compiled(flat: jax.stages.Wrapped, leaves: Sequence[Leaf], file: str) -> Program:
    """A function's program: kept from an earlier process, or kept now, or only compiled."""
    if not file or store.folder() is None:
        return flat.lower(*leaves).compile()
    exported = _loaded(store.kept(file))
    if exported is None:
        exported = jax.export.export(flat, disabled_checks=[_ANY_CALL])(*leaves)
        handlers = sorted(set(_HANDLERS.findall(exported.mlir_module())))
        store.keep(file, json.dumps(handlers).encode() + b"\n" + exported.serialize())
    return jax.jit(exported.call).lower(*leaves).compile()


def _loaded(code: bytes | None) -> jax.export.Exported | None:
    """A kept program; none without it, or without the machine code that it calls."""
    if code is None:
        return None
    handlers, program = code.split(b"\n", 1)
    if not all(map(machine.register_kept, json.loads(handlers))):
        return None
    return jax.export.deserialize(bytearray(program))
