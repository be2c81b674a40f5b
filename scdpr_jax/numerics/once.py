"""Keeping XLA's CPU back end from computing a value anew for each of its uses.

A step of the engine is a long chain of cheap scalars, each used several times. XLA fuses a
cheap value into all of its uses and computes it in each, and a chain of those doubles with
every link. `jax.lax.optimization_barrier` would say it plainly and is removed before the
fusion. A division is too dear to be doubled, so what is to be computed once passes through
one.

Equations are written without regard to that. `computed_once` finds the values in their jaxpr.
"""

import collections
from collections.abc import Callable, Hashable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

import jax
import jax.numpy as jnp
from jax.extend.core import ClosedJaxpr, JaxprEqn, Literal, Primitive, jaxpr_as_fun
from jax.interpreters import ad, batching, mlir
from jaxtyping import Array, Float

DEAREST = 6
"""Operations that XLA may do anew for the uses of one value."""


def once(value: Float[Array, "..."]) -> Float[Array, "..."]:
    """What it is given, to the bit, computed once however often it is used.

    XLA's CPU back end fuses a cheap value into each of its uses and computes it there; chains
    of such values grow without bounds. A division is too dear for that, so the value is
    divided by one, which XLA can't tell, but LLVM can: the division itself is gone in the
    end. Derivatives of either direction are wrapped likewise, in their own shape.

    Args:
        value: Any value.

    Returns:
        The same.
    """
    return _once_p.bind(value)


def computed_once(function: Callable[..., Any], *like: Any) -> Callable[..., Any]:
    """A function that does the same and in which values of several uses are computed once.

    Args:
        function: The function.
        like: What it is given, or shapes of it.

    Returns:
        The function, for arguments like those.
    """
    closed, outputs = jax.make_jaxpr(function, return_shape=True)(*like)
    structure = jax.tree.structure(outputs)
    flat = _inlined(closed)

    def same(*given: Any) -> Any:
        return jax.tree.unflatten(structure, _evaluated(flat, jax.tree.leaves(given)))

    return same


@dataclass
class _Flat:
    """A jaxpr without the functions that it calls; values are numbered or literals."""

    known: dict[int, Any] = field(default_factory=dict)
    equations: list[tuple[JaxprEqn, list, list[int]]] = field(default_factory=list)
    inputs: list[int] = field(default_factory=list)
    outputs: list[int | Literal] = field(default_factory=list)
    count: int = 0

    def number(self) -> int:
        """A new value's."""
        self.count += 1
        return self.count


def _inlined(closed: ClosedJaxpr) -> _Flat:
    flat = _Flat()
    flat.inputs = [flat.number() for _ in closed.jaxpr.invars]
    flat.outputs = _put_in(flat, closed, flat.inputs)
    return flat


def _put_in(flat: _Flat, closed: ClosedJaxpr, inputs: Sequence) -> list:
    jaxpr = closed.jaxpr
    values: dict[Hashable, Any] = dict(zip(jaxpr.invars, inputs, strict=True))
    for var, constant in zip(jaxpr.constvars, closed.consts, strict=True):
        values[var] = flat.number()
        flat.known[values[var]] = constant

    def of(atom: Any) -> Any:
        return atom if isinstance(atom, Literal) else values[atom]

    for equation in jaxpr.eqns:
        given = [of(atom) for atom in equation.invars]
        if equation.primitive.name in ("jit", "pjit"):
            made = _put_in(flat, equation.params["jaxpr"], given)
        else:
            made = [flat.number() for _ in equation.outvars]
            flat.equations.append((equation, given, made))
        values.update(zip(equation.outvars, made, strict=True))
    return [of(atom) for atom in jaxpr.outvars]


def _evaluated(flat: _Flat, given: Sequence[Any]) -> list:
    """The outputs: arrays, tracers of them, or constants of the jaxpr, as JAX keeps those."""
    uses = collections.Counter(
        number
        for numbers in (*(own for _, own, _ in flat.equations), flat.outputs)
        for number in numbers
        if isinstance(number, int)
    )
    values = {**flat.known, **dict(zip(flat.inputs, given, strict=True))}
    costs = dict.fromkeys(values, 0)

    def of(number: int | Literal) -> Any:
        return number.val if isinstance(number, Literal) else values[number]

    for equation, own, made in flat.equations:
        cost = _cost(equation) + sum(costs[n] for n in own if isinstance(n, int))
        for number, value in zip(made, _done(equation, map(of, own)), strict=True):
            dear = cost * (uses[number] - 1) > DEAREST
            wraps = dear and jnp.issubdtype(value.dtype, jnp.floating)
            values[number] = once(value) if wraps else value
            costs[number] = 0 if wraps else cost
    return [of(number) for number in flat.outputs]


_FREE = frozenset({
    *("broadcast_in_dim", "concatenate", "expand_dims", "reshape", "slice", "squeeze"),
    *("stack", "transpose", "unstack"),
})  # fmt: skip
"""Primitives that only move numbers."""


def _cost(equation: JaxprEqn) -> int:
    return 0 if equation.primitive.name in _FREE else 1


def _done(equation: JaxprEqn, given: Iterator[Any]) -> Sequence:
    """What an equation makes, its own jaxprs treated likewise."""
    primitive, params = equation.primitive, equation.params
    match primitive.name:
        case "cond":
            branches = tuple(map(_treated, params["branches"]))
            return primitive.bind(*given, **(params | {"branches": branches}))
        case "scan":
            return primitive.bind(*given, **(params | {"jaxpr": _treated(params["jaxpr"])}))
        case "custom_jvp_call" | "custom_vjp_call" | "checkpoint":
            return _by_jax(equation, [*given])
        case _:
            made = primitive.bind(*given, **params)
            return made if primitive.multiple_results else [made]


def _treated(closed: ClosedJaxpr) -> ClosedJaxpr:
    like = closed.in_avals
    return jax.make_jaxpr(computed_once(jaxpr_as_fun(closed), *like))(*like)


def _by_jax(equation: JaxprEqn, given: Sequence[Any]) -> Sequence:
    """What an equation with functions in it makes."""
    pairs = zip(equation.invars, given, strict=True)
    inputs = {own: value for own, value in pairs if not isinstance(own, Literal)}
    empty = jax.make_jaxpr(lambda: ())().jaxpr
    alone = empty.replace(invars=[*inputs], outvars=equation.outvars, eqns=[equation])
    return jaxpr_as_fun(ClosedJaxpr(alone, ()))(*inputs.values())


def _divided(value: Array) -> Array:
    one = jnp.ones((), value.dtype)
    return value / jax.lax.clamp(one, value, one)


_once_p = Primitive("once")
_once_p.def_impl(lambda value: value)
_once_p.def_abstract_eval(lambda value: value)
ad.deflinear2(_once_p, lambda cotangent, _: [_once_p.bind(cotangent)])
batching.primitive_batchers[_once_p] = lambda values, axes: (_once_p.bind(*values), axes[0])
mlir.register_lowering(_once_p, mlir.lower_fun(_divided, multiple_results=False))
