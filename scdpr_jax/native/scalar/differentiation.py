r"""A program with its derivative along one direction, by a dozen rules.

The rules are JAX's own, so that both ways agree at kinks, too. As the program consists of
single numbers there is a rule for an operation, not for an array, and what doesn't depend on
the direction costs nothing. A division, which is ten times as dear as a product, is made once
for all directions, as that by one:

$$ \dot{(a b)} = \dot a b + a \dot b, \qquad \dot{\sqrt a} = \dot a / (2 \sqrt a), \qquad
   \dot{\mathrm{select}(c, a, b)} = \mathrm{select}(c, \dot a, \dot b), \dots $$
"""

import functools
from collections.abc import Callable, Collection, Mapping, Sequence

from scdpr_jax.native.scalar.program import (
    Block,
    Cell,
    Constant,
    Operation,
    Program,
    Value,
    Variable,
    operations,
)
from scdpr_jax.native.scalar.rewriting import repeated, rewritten
from scdpr_jax.native.scalar.scope import BOOLEAN, ONE, ZERO, Scope, first_free

PREFIX = "d_"
"""Of the names of tangents."""

_STEPS = BOOLEAN | {"round", "floor", "ceil", "power_of_two"}
"""Operations whose derivative is zero wherever they have one."""


def differentiated(program: Program, moving: Collection[str]) -> Program:
    """A program that also pushes a tangent forward.

    Args:
        program: The program, as it was read.
        moving: Arguments that have a tangent.

    Returns:
        The program with an argument for each tangent behind its own, and the derivative of
        each result behind its results.
    """
    active = _active(program.body, moving)
    free = first_free(program.body)
    cells = sorted({c.number for c in active if isinstance(c, Cell) and not c.array})
    twins = {number: Cell("", free + i) for i, number in enumerate(cells)}
    body = rewritten(program.body, _Forward(active, twins).emit, first=free + len(twins))
    seeds = {PREFIX + name: program.arguments[name] for name in moving}
    slopes = {PREFIX + name: size for name, size in program.results.items()}
    return Program(
        {**program.arguments, **seeds},
        {**program.results, **slopes},
        body,
        frozenset({*seeds, *slopes}),
    )


def _active(block: Block, moving: Collection[str]) -> set[Variable | Cell]:
    """Variables and cells that depend on what has a tangent."""
    every = operations(block)
    active: set[Variable | Cell] = {
        source
        for own in every
        for source in own.sources
        if isinstance(source, Cell) and source.array in moving
    }
    size = -1
    while size < len(active):  # Again, as a turn of a loop leaves what the next one reads.
        size = len(active)
        active |= {own.target for own in every if not active.isdisjoint(_smooth(own))}
    return active


def _smooth(operation: Operation) -> Sequence[Value | Cell]:
    """The sources on which an operation's derivative depends."""
    match operation.name:
        case "chained":
            return operation.sources[1::2]
        case "select":
            return operation.sources[1:]
        case name if name in _STEPS or operation.target.boolean:
            return ()
        case _:
            return operation.sources


class _Forward:
    """What comes of each operation where tangents go along."""

    def __init__(self, active: set[Variable | Cell], twins: Mapping[int, Cell]):
        self.active, self.twins = active, twins
        self.tangents: dict[Variable, Value] = {}

    def emit(
        self, scope: Scope, operation: Operation, sources: tuple[Value | Cell, ...]
    ) -> Value | None:
        """Emits an operation, then its tangent."""
        name, target = operation.name, operation.target
        value = sources[0] if name == "chained" else repeated(scope, operation, sources)
        if name == "write":
            self._write(scope, target, self._tangent(operation.sources[0]))
        elif target in self.active:
            self.tangents[target] = self._pushed(scope, operation, sources, value)
        return value

    def _write(self, scope: Scope, cell: Cell, tangent: Value) -> None:
        if cell.array:
            scope.write(Cell(PREFIX + cell.array, cell.number), tangent)
        elif cell in self.active:
            scope.write(self.twins[cell.number], tangent)

    def _pushed(
        self, scope: Scope, operation: Operation, sources: tuple, value: Value
    ) -> Value:
        match operation:
            case Operation(_, "read", (Cell("", number),)):
                return scope.read(self.twins[number])
            case Operation(_, "read", (Cell(array, number),)):
                return scope.read(Cell(PREFIX + array, number))
            case Operation(_, "chained", (_, *pairs)):
                inner, slopes = pairs[::2], sources[2::2]
                tangents = map(self._tangent, inner)
                terms = map(functools.partial(_times, scope), tangents, slopes)
                return functools.reduce(functools.partial(scope.apply, "add"), terms, ZERO)
            case Operation(_, name, own):
                along = tuple(map(self._tangent, own))
                return _PUSHED[name](scope, value, sources, along)

    def _tangent(self, source: Value) -> Value:
        return self.tangents.get(source, ZERO)


def _times(scope: Scope, tangent: Value, slope: Value) -> Value:
    return scope.apply("mul", tangent, slope)


def _of_division(scope: Scope, value: Value, of: tuple, along: tuple) -> Value:
    (_, b), (da, db) = of, along
    rest = scope.apply("sub", da, _times(scope, db, value))
    return _times(scope, rest, scope.apply("div", ONE, b))


def _of_product(scope: Scope, _: Value, of: tuple, along: tuple) -> Value:
    (a, b), (da, db) = of, along
    return scope.apply("add", _times(scope, da, b), _times(scope, db, a))


def _of_absolute(scope: Scope, _: Value, of: tuple, along: tuple) -> Value:
    up = scope.apply("ge", of[0], ZERO)
    return scope.apply("select", up, along[0], scope.apply("neg", along[0]))


def _of_root(scope: Scope, value: Value, _: tuple, along: tuple) -> Value:
    return _times(scope, along[0], scope.apply("div", Constant(0.5), value))


def _of_sine(scope: Scope, _: Value, of: tuple, along: tuple) -> Value:
    return _times(scope, along[0], scope.apply("cos", of[0]))


def _of_cosine(scope: Scope, _: Value, of: tuple, along: tuple) -> Value:
    return scope.apply("neg", _times(scope, along[0], scope.apply("sin", of[0])))


def _of_tangent(scope: Scope, value: Value, _: tuple, along: tuple) -> Value:
    slope = scope.apply("add", ONE, scope.apply("mul", value, value))
    return _times(scope, along[0], slope)


def _of_arc_tangent(scope: Scope, _: Value, of: tuple, along: tuple) -> Value:
    square = scope.apply("mul", of[0], of[0])
    return scope.apply("div", along[0], scope.apply("add", ONE, square))


def _of_hyperbolic_tangent(scope: Scope, value: Value, _: tuple, along: tuple) -> Value:
    slope = scope.apply("sub", ONE, scope.apply("mul", value, value))
    return _times(scope, along[0], slope)


def _of_power(scope: Scope, value: Value, of: tuple, along: tuple) -> Value:
    """Of a power; where the base is zero the exponent's part is none, as in JAX."""
    (a, b), (da, db) = of, along
    less = scope.apply("pow", a, scope.apply("sub", b, ONE))
    flat = scope.apply("eq", b, ZERO)
    base = scope.apply("select", flat, ZERO, scope.apply("mul", b, less))
    safe = scope.apply("select", scope.apply("eq", a, ZERO), ONE, a)
    exponent = scope.apply("mul", scope.apply("log", safe), value)
    return scope.apply("add", _times(scope, da, base), _times(scope, db, exponent))


_PUSHED: Mapping[str, Callable[[Scope, Value, tuple, tuple], Value]] = {
    "add": lambda scope, _, __, along: scope.apply("add", *along),
    "sub": lambda scope, _, __, along: scope.apply("sub", *along),
    "neg": lambda scope, _, __, along: scope.apply("neg", *along),
    "select": lambda scope, _, of, along: scope.apply("select", of[0], *along[1:]),
    "exp": lambda scope, value, _, along: _times(scope, along[0], value),
    "log": lambda scope, _, of, along: _times(scope, along[0], scope.apply("div", ONE, of[0])),
    "mul": _of_product,
    "div": _of_division,
    "abs": _of_absolute,
    "sqrt": _of_root,
    "sin": _of_sine,
    "cos": _of_cosine,
    "tan": _of_tangent,
    "atan": _of_arc_tangent,
    "tanh": _of_hyperbolic_tangent,
    "pow": _of_power,
}
"""Tangents of operations, from the value, the sources and their tangents."""
