r"""What JAX's primitives do to single numbers, as scalar operations.

What JAX derives otherwise than its operations would say (a tie of `max`, a `custom_jvp`) is
`chained`: a value with the slopes that its derivative takes.

$$ \mathrm{chained}(y, x_1, s_1, x_2, s_2, \dots) = y, \qquad
   \mathrm{d}y = s_1 \mathrm{d}x_1 + s_2 \mathrm{d}x_2 + \dots $$
"""

import functools
import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from scdpr_jax.native.scalar.program import Constant, Value
from scdpr_jax.native.scalar.scope import BOOLEAN, ONE, ZERO, Scope

Rule = Callable[..., Value]

HALF = Constant(0.5)


def chained(scope: Scope, value: Value, *slopes: tuple[Value, Value]) -> Value:
    """A value whose derivative is given, where it is asked for.

    Args:
        scope: The block in the making.
        value: The value.
        slopes: What it depends on, each with the slope.

    Returns:
        The value as a variable of its own.
    """
    own = [pair for pair in slopes if not isinstance(pair[0], Constant)]
    if not scope.chains or (isinstance(value, Constant) and not own):
        return value
    return scope.apply("chained", value, *(part for pair in own for part in pair))


def _operation(name: str, scope: Scope, *operands: Value, **_: object) -> Value:
    return scope.apply(name, *operands)


def _greater(scope: Scope, a: Value, b: Value, *, test: str = "gt") -> Value:
    """The greater one; not a number if either isn't. At a tie each has half of the slope."""
    first = scope.apply("or", scope.apply(test, a, b), scope.apply("ne", a, a))
    greater = scope.apply("select", first, a, b)
    tie = scope.apply("eq", a, b)

    def slope(x: Value, y: Value) -> Value:
        passed = scope.apply("select", scope.apply(test, x, y), ONE, ZERO)
        return scope.apply("select", tie, HALF, passed)

    return chained(scope, greater, (a, slope(a, b)), (b, slope(b, a)))


def _clamped(scope: Scope, low: Value, x: Value, high: Value) -> Value:
    """A number within limits; beyond them, and at them, its slope is the limit's or none."""
    below, above = scope.apply("lt", x, low), scope.apply("gt", x, high)
    value = scope.apply("select", above, high, scope.apply("select", below, low, x))
    inside = scope.apply("and", scope.apply("gt", x, low), scope.apply("lt", x, high))
    passed = ((low, below), (x, inside), (high, above))
    return chained(
        scope, value, *((y, scope.apply("select", mark, ONE, ZERO)) for y, mark in passed)
    )


def _sign(scope: Scope, x: Value) -> Value:
    below = scope.apply("select", scope.apply("lt", x, ZERO), Constant(-1.0), x)
    return chained(scope, scope.apply("select", scope.apply("gt", x, ZERO), ONE, below))


def _power(scope: Scope, x: Value, *, y: int) -> Value:
    if y < 0:
        return scope.apply("div", ONE, _power(scope, x, y=-y))
    if y < 2:
        return x if y else ONE
    half = _power(scope, x, y=y // 2)
    square = scope.apply("mul", half, half)
    return scope.apply("mul", square, x) if y % 2 else square


def _rounded(scope: Scope, x: Value, *, rounding_method: Any) -> Value:
    if rounding_method == 0:
        raise NotImplementedError(
            "`round` half away from zero has no rule. Round to even, as `jnp.round` does."
        )
    return scope.apply("round", x)


def _converted(scope: Scope, x: Value, *, new_dtype: np.dtype, **_: object) -> Value:
    boolean = np.issubdtype(new_dtype, np.bool_)
    if x.boolean == boolean:
        return x
    return scope.apply("ne", x, ZERO) if boolean else scope.apply("select", x, ONE, ZERO)


def _chosen(scope: Scope, which: Value, *cases: Value) -> Value:
    """One of several; a truth value chooses the second one of two where it is true."""
    if which.boolean:
        return scope.apply("select", which, cases[1], cases[0])
    value = cases[0]
    for place, case in enumerate(cases[1:], 1):
        after = scope.apply("ge", which, Constant(float(place)))
        value = scope.apply("select", after, case, value)
    return value


def _finite(scope: Scope, x: Value) -> Value:
    return scope.apply("lt", scope.apply("abs", x), Constant(math.inf))


def _reciprocal_root(scope: Scope, x: Value, **_: object) -> Value:
    return scope.apply("div", ONE, scope.apply("sqrt", x))


def _logistic(scope: Scope, x: Value, **_: object) -> Value:
    grown = scope.apply("exp", scope.apply("neg", x))
    return scope.apply("div", ONE, scope.apply("add", ONE, grown))


def _different(scope: Scope, a: Value, b: Value) -> Value:
    """Whether two numbers, or two truth values, differ."""
    if not a.boolean:
        return scope.apply("ne", a, b)
    other = scope.apply("not", b)
    return scope.apply("select", a, other, b)


def _equal(scope: Scope, a: Value, b: Value) -> Value:
    if a.boolean:
        return scope.apply("not", _different(scope, a, b))
    return scope.apply("eq", a, b)


_PLAIN = (
    *("add", "sub", "mul", "div", "neg", "abs", "sqrt", "floor", "ceil"),
    *("sin", "cos", "tan", "atan", "exp", "log", "tanh", "pow"),
)
"""Primitives that are an operation of the same name."""

RULES: Mapping[str, Rule] = {
    **{name: functools.partial(_operation, name) for name in (*_PLAIN, *BOOLEAN - {"any"})},
    "add_any": functools.partial(_operation, "add"),
    "clamp": _clamped,
    "convert_element_type": _converted,
    "eq": _equal,
    "ne": _different,
    "copy": lambda _, x: x,
    "copy_p": lambda _, x: x,
    "integer_pow": _power,
    "is_finite": _finite,
    "logistic": _logistic,
    "max": _greater,
    "min": functools.partial(_greater, test="lt"),
    "once": lambda _, x: x,
    "reduce_precision": lambda _, x, **__: x,
    "round": _rounded,
    "rsqrt": _reciprocal_root,
    "select_n": _chosen,
    "sign": _sign,
    "square": lambda scope, x: scope.apply("mul", x, x),
    "stop_gradient": lambda scope, x: chained(scope, x),
    "unvmap_any": lambda scope, x: scope.apply("any", x),
    "xor": _different,
}
"""What primitives do to each number of their arrays."""
