"""A step traced once: its jaxpr, which of its arrays are what, and a name for all of it."""

import enum
import functools
import hashlib
import types
import uuid
import warnings
import weakref
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import jax
import numpy as np
from jax.extend.core import ClosedJaxpr, Jaxpr, Literal, Var
from jaxtyping import PyTree

from scdpr_jax.native.scalar.reading import closed_jaxpr, derivative, is_real

StepFunction = Callable[[Any, Any, Any], tuple[Any, Any]]
"""From parameters, what is carried and a row of inputs to what is carried on and outputs."""


@dataclass(frozen=True, eq=False)
class Step:
    """A step as a jaxpr: equal to another one that does the same, in any process."""

    name: str
    """A hash of the jaxpr, and of which of its arrays are what."""
    parameters: int
    """How many arrays are the same in all steps."""
    carried: int
    """How many arrays are carried from step to step."""
    arguments: dict[str, tuple[int, ...]]
    """Names of all arguments, and their shapes: parameters, what is carried, inputs."""
    results: dict[str, tuple[int, ...]]
    """Names of all results, and their shapes: what is carried on, outputs."""
    equations: Callable[[], ClosedJaxpr]
    """Its jaxpr; traced when it is asked for, where the rest was kept."""

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Step) and self.name == other.name

    def __hash__(self) -> int:
        return hash(self.name)

    def __repr__(self) -> str:
        return f"Step({self.name})"

    @functools.cached_property
    def closed(self) -> ClosedJaxpr:
        """From parameters, carried arrays and inputs to carried arrays and outputs."""
        return self.equations()


class Traced(NamedTuple):
    """What tracing a function brings."""

    step: Step
    constants: tuple[Any, ...]
    """Arrays that the function closes over; they are the step's first parameters."""
    outputs: PyTree
    """Shapes of what is carried on and of the outputs."""


def trace(function: StepFunction, parameters: PyTree, carry: PyTree, row: PyTree) -> Traced:
    """A function traced, or what is known of it from an earlier time.

    Args:
        function: The step.
        parameters: Shapes of its parameters.
        carry: Shapes of what it carries.
        row: Shapes of a row of inputs.

    Returns:
        The step and what it closes over.
    """
    given, structure = jax.tree.flatten((parameters, carry, row))
    key = (structure, tuple((own.shape, own.dtype) for own in given))
    memory = _memory.setdefault(function, {}) if _is_kept(function) else {}
    if key not in memory:
        count = len(jax.tree.leaves(parameters)), len(jax.tree.leaves(carry))
        made = _traced(function, structure, given, count)
        if any(isinstance(own, jax.core.Tracer) for own in made.constants):
            return made
        if len(memory) >= _MOST_KEPT:
            memory.clear()
        memory[key] = made
    return memory[key]


_MOST_KEPT = 64
"""Of one function, for as many kinds of arguments."""
_memory: weakref.WeakKeyDictionary[Callable, dict[Hashable, Traced]] = (
    weakref.WeakKeyDictionary()
)


def _is_kept(function: StepFunction) -> bool:
    """Whether a function is one object as long as it is in use."""
    return isinstance(function, types.FunctionType)


def _traced(
    function: StepFunction,
    structure: jax.tree_util.PyTreeDef,
    given: Sequence[jax.ShapeDtypeStruct],
    count: tuple[int, int],
) -> Traced:
    def flat(*leaves: jax.Array) -> Any:
        return function(*jax.tree.unflatten(structure, leaves))

    closed, outputs = jax.make_jaxpr(flat, return_shape=True)(*given)
    moved = [_is_parameter(own) for own in closed.consts]
    pairs = list(zip(closed.jaxpr.constvars, closed.consts, moved, strict=True))
    lifted = closed.jaxpr.replace(
        constvars=[var for var, _, moves in pairs if not moves],
        invars=[*(var for var, _, moves in pairs if moves), *closed.jaxpr.invars],
    )
    closed = ClosedJaxpr(lifted, [value for _, value, moves in pairs if not moves])
    constants = tuple(value for _, value, moves in pairs if moves)
    parameters, carried = count[0] + len(constants), count[1]
    inputs = len(given) - sum(count)
    about = [f"{parameters} parameters, {carried} carried", *_described(closed)]
    name = hashlib.sha256("\n".join(about).encode()).hexdigest()
    step = Step(
        name,
        parameters,
        carried,
        _named(closed.in_avals, {"parameter": parameters, "carry": carried, "input": inputs}),
        _named(closed.out_avals, {"next": carried, "output": len(closed.out_avals) - carried}),
        lambda: closed,
    )
    return Traced(step, constants, outputs)


def _named(every: Sequence[Any], counts: dict[str, int]) -> dict[str, tuple[int, ...]]:
    """Names of arrays, so many of each kind in turn, with their shapes."""
    names = [f"{kind}{i}" for kind, count in counts.items() for i in range(count)]
    return {name: tuple(own.shape) for name, own in zip(names, every, strict=True)}


def _is_parameter(constant: Any) -> bool:
    """Whether what a function closes over is an argument: all but known integers."""
    return isinstance(constant, jax.core.Tracer) or np.issubdtype(constant.dtype, np.floating)


def _described(closed: ClosedJaxpr, *, derivatives: bool = True) -> Iterator[str]:
    """All that a jaxpr's results and first derivatives depend on, line by line."""
    jaxpr, names = closed.jaxpr, {}

    def named(var: Var) -> str:
        return f"v{names.setdefault(var, len(names))}:{var.aval.str_short()}"

    def atom(own: Var | Literal) -> str:
        return _value(own.val) if isinstance(own, Literal) else named(own)

    for var, value in zip(jaxpr.constvars, closed.consts, strict=True):
        yield f"{named(var)} = {_value(value)}"
    yield f"of {' '.join(map(named, jaxpr.invars))}"
    for equation in jaxpr.eqns:
        inputs, outputs = map(atom, equation.invars), map(named, equation.outvars)
        yield f"{' '.join(outputs)} = {equation.primitive.name} {' '.join(inputs)}"
        if equation.primitive.name == "custom_jvp_call" and is_real(equation):
            # Its derivative's own derivatives don't matter; it may well call itself.
            if derivatives:
                yield from _described(derivative(equation), derivatives=False)
            yield from _described(equation.params["call_jaxpr"], derivatives=derivatives)
            continue
        for key, own in sorted(equation.params.items()):
            if key not in _ASIDE:
                yield from _parameter(key, own, derivatives)
    yield f"is {' '.join(map(atom, jaxpr.outvars))}"


_ASIDE = frozenset({
    *("compiler_options_kvs", "ctx_mesh", "donated_invars", "in_layouts", "in_shardings"),
    *("inline", "keep_unused", "name", "out_layouts", "out_shardings", "sharding"),
})  # fmt: skip
"""Parameters of primitives that no number depends on."""


def _value(own: Any) -> str:
    array = np.asarray(own)
    return f"{array.dtype}{array.shape}{array.tobytes().hex()}"


def _parameter(key: str, own: Any, derivatives: bool) -> Iterator[str]:
    """A parameter of a primitive; one that can't be named has another name each time."""
    match own:
        case ClosedJaxpr():
            yield f"{key} {{"
            yield from _described(own, derivatives=derivatives)
            yield "}"
        case Jaxpr():
            yield from _parameter(key, closed_jaxpr(own), derivatives)
        case tuple() | list():
            yield f"{key} {len(own)}"
            for i, part in enumerate(own):
                yield from _parameter(f"{key}.{i}", part, derivatives)
        case np.ndarray() | np.generic() | jax.Array():
            yield f"{key} {_value(own)}"
        case _ if key in ("ft_in", "ft_out"):  # Which inputs of a `scan` are what.
            yield f"{key} {own!r}"
        case None | bool() | int() | float() | str() | np.dtype() | type() | enum.Enum():
            yield f"{key} {own!r}"
        case _:
            what = f"`{key}` of a primitive, {type(own).__name__}, has no name that lasts"
            warnings.warn(f"Machine code isn't kept: {what}.", RuntimeWarning, stacklevel=2)
            yield f"{key} {uuid.uuid4()}"
