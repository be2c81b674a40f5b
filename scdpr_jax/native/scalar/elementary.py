r"""Sine, cosine and exponential in operations that a vector has.

LLVM takes the sine of a vector apart and calls the C library once a lane. These are as exact
as that to a few ulp. Where a lane's argument is beyond their range the library is asked after
all, for all lanes.

$$ \sin x = (-1)^n \sin(x - n \pi), \qquad e^x = 2^n e^{x - n \ln 2} $$

with n the nearest integer, and polynomials for what is left. Coefficients and parts of
constants are those of SLEEF, N. Shibata and F. Petrogalli, IEEE Trans. Parallel Distrib. Syst.
31(6), 2020, doi:10.1109/TPDS.2019.2960333.
"""

import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from scdpr_jax.native.scalar.program import Cell, Constant, Operation, Program, Value
from scdpr_jax.native.scalar.rewriting import repeated, rewritten
from scdpr_jax.native.scalar.scope import ONE, ZERO, Scope, first_free

Method = Callable[[Scope, Value], Value]

LARGEST_ANGLE = 1e5
"""Up to which n times the first part of pi is exact [rad]."""
LARGEST_EXPONENT = 708.0
"""Below its negative the exponential is zero here; it would be denormal soon [1]."""
_PI = (
    3.1415926218032836914,
    3.1786509424591713469e-08,
    1.2246467864107188502e-16,
    1.2736634327021899816e-24,
)
_LN_2 = (0.69314718055966295651, 2.8235290563031577122588e-13)
_SINE = (
    -7.97255955009037868891952e-18,
    2.81009972710863200091251e-15,
    -7.64712219118158833488484e-13,
    1.60590430605664501629054e-10,
    -2.50521083763502045810755e-08,
    2.75573192239198747630416e-06,
    -0.000198412698412696162806809,
    0.00833333333333332974823815,
    -0.166666666666666657414808,
)
_EXPONENTIAL = (
    2.08860621107283687536341e-09,
    2.51112930892876518610661e-08,
    2.75573911234900471893338e-07,
    2.75572362911928827629423e-06,
    2.4801587159235472998791e-05,
    0.000198412698960509205564975,
    0.00138888888889774492207962,
    0.00833333333331652721664984,
    0.0416666666666665047591422,
    0.166666666666666851703837,
    0.5,
)


def vectorised(program: Program) -> Program:
    """A program whose sines, cosines and exponentials are a vector's operations.

    Args:
        program: The program.

    Returns:
        The same function to a few ulp.
    """
    body = rewritten(program.body, _emit, first=first_free(program.body))
    return replace(program, body=body)


def _emit(
    scope: Scope, operation: Operation, sources: tuple[Value | Cell, ...]
) -> Value | None:
    name = operation.name
    if name in _METHODS and not isinstance(sources[0], Constant):
        return _guarded(name, scope, sources[0])
    return repeated(scope, operation, sources)


def _guarded(name: str, scope: Scope, x: Value) -> Value:
    """A function by a method, and by the library where an argument is beyond its limit."""
    method, beyond = _METHODS[name]

    def make() -> Value:
        value, cell = method(scope, x), scope.cell()
        far, near = Scope(scope), Scope(scope)
        far.write(cell, far.apply(name, x))
        near.write(cell, value)
        scope.branch(scope.apply("any", beyond(scope, x)), far, near)
        return scope.read(cell)

    return scope.once(("guarded", name, x), make)


def _sine(scope: Scope, x: Value, *, cosine: bool) -> Value:
    """The sine; the cosine is that of an odd number of half turns less or more."""
    turns = scope.apply("mul", x, Constant(1 / math.pi))
    if cosine:
        turns = scope.apply("sub", turns, Constant(0.5))
    n = scope.apply("round", turns)
    whole = scope.apply("add", n, Constant(0.5)) if cosine else n
    r = _less(scope, x, whole, _PI)
    square = scope.apply("mul", r, r)
    cubic = scope.apply("mul", scope.apply("mul", r, square), _polynomial(scope, square, _SINE))
    sine = scope.apply("add", r, cubic)
    half = scope.apply("mul", n, Constant(0.5))
    even = scope.apply("eq", half, scope.apply("round", half))
    up, down = (scope.apply("neg", sine), sine) if cosine else (sine, scope.apply("neg", sine))
    return scope.apply("select", even, up, down)


def _exponential(scope: Scope, x: Value) -> Value:
    n = scope.apply("round", scope.apply("mul", x, Constant(1 / math.log(2))))
    r = _less(scope, x, n, _LN_2)
    rest = scope.apply("mul", scope.apply("mul", r, r), _polynomial(scope, r, _EXPONENTIAL))
    near = scope.apply("add", ONE, scope.apply("add", r, rest))
    scaled = scope.apply("mul", near, scope.apply("power_of_two", n))
    vanishes = scope.apply("lt", x, Constant(-LARGEST_EXPONENT))
    return scope.apply("select", vanishes, ZERO, scaled)


def _far_angle(scope: Scope, x: Value) -> Value:
    return scope.apply("gt", scope.apply("abs", x), Constant(LARGEST_ANGLE))


def _overflows(scope: Scope, x: Value) -> Value:
    return scope.apply("gt", x, Constant(LARGEST_EXPONENT))


def _less(scope: Scope, x: Value, n: Value, parts: Sequence[float]) -> Value:
    """What is left of a number without n times another one, which is given in parts."""
    for part in parts:
        x = scope.apply("sub", x, scope.apply("mul", n, Constant(part)))
    return x


def _polynomial(scope: Scope, x: Value, coefficients: Sequence[float]) -> Value:
    value: Value = Constant(coefficients[0])
    for coefficient in coefficients[1:]:
        value = scope.apply("add", scope.apply("mul", value, x), Constant(coefficient))
    return value


_METHODS: Mapping[str, tuple[Method, Method]] = {
    "sin": (functools.partial(_sine, cosine=False), _far_angle),
    "cos": (functools.partial(_sine, cosine=True), _far_angle),
    "exp": (_exponential, _overflows),
}
"""How to find each function, and whether an argument is beyond that."""
