r"""A block in the making: constants are folded, and nothing is computed twice.

What is known in a block is known in the blocks inside it, and forgotten behind them.

Two laws of arithmetic are bent: $0 x = 0$ even where x isn't finite, and $-0$ is $0$.
"""

import collections
import contextlib
import itertools
import math
import operator
from collections.abc import Callable, Hashable, Iterator

from scdpr_jax.native.scalar.program import (
    Block,
    Cell,
    Constant,
    If,
    Loop,
    Operation,
    Statement,
    Value,
    Variable,
    operations,
)

ZERO, ONE = Constant(0.0), Constant(1.0)
FALSE, TRUE = Constant(0.0, True), Constant(1.0, True)

_FOLDED: dict[str, Callable[..., float]] = {
    "add": operator.add, "sub": operator.sub, "mul": operator.mul, "div": operator.truediv,
    "lt": operator.lt, "le": operator.le, "gt": operator.gt, "ge": operator.ge,
    "eq": operator.eq, "ne": operator.ne, "not": operator.not_, "neg": operator.neg,
    "abs": abs, "round": round, "floor": math.floor, "ceil": math.ceil, "sqrt": math.sqrt,
    "sin": math.sin, "cos": math.cos, "tan": math.tan, "exp": math.exp, "log": math.log,
    "atan": math.atan, "tanh": math.tanh, "pow": math.pow,
}  # fmt: skip
BOOLEAN = frozenset({"lt", "le", "gt", "ge", "eq", "ne", "and", "or", "not", "any"})
"""Operations whose result is boolean."""
_SYMMETRIC = {"add", "mul", "eq", "ne", "and", "or"}


class Scope:
    """A block in the making, and what is known in it."""

    def __init__(self, outer: "Scope | None" = None, *, first: int = 0, chains: bool = False):
        """An empty block.

        Args:
            outer: The scope around it; none for a program's.
            first: The first number that is free for variables and cells.
            chains: Whether values keep slopes of their own, as they are differentiated later.
        """
        self.statements: list[Statement] = []
        self.chains = outer.chains if outer else chains
        self._known = outer._known.new_child() if outer else collections.ChainMap()
        self._origins = outer._origins if outer else {}
        self._numbers = outer._numbers if outer else itertools.count(first)

    @property
    def block(self) -> Block:
        """The block as it is now."""
        return tuple(self.statements)

    @contextlib.contextmanager
    def without_chains(self) -> Iterator[None]:
        """Where values, such as slopes, aren't differentiated later."""
        before, self.chains = self.chains, False
        yield
        self.chains = before

    def variable(self, *, boolean: bool = False) -> Variable:
        """A new variable."""
        return Variable(next(self._numbers), boolean)

    def cell(self, *, boolean: bool = False) -> Cell:
        """A new cell of the program's own."""
        return Cell("", next(self._numbers), boolean)

    def read(self, cell: Cell) -> Variable:
        """What is in a cell now."""
        value = self.variable(boolean=cell.boolean)
        self.statements.append(Operation(value, "read", (cell,)))
        return value

    def write(self, cell: Cell, value: Value) -> None:
        """Puts a value into a cell."""
        self.statements.append(Operation(cell, "write", (value,)))

    def branch(self, condition: Value, then: "Scope", otherwise: "Scope") -> None:
        """Does one of two blocks that were made inside this one."""
        self.statements.append(If(condition, then.block, otherwise.block))

    def loop(self, counter: Variable, times: int, body: "Scope") -> None:
        """Does a block that was made inside this one a number of times."""
        self.statements.append(Loop(counter, times, body.block))

    def origin(self, value: Value) -> tuple[str, tuple[Value, ...]]:
        """The operation that a value is the result of."""
        return self._origins.get(value, ("", ()))

    def apply(self, name: str, *operands: Value) -> Value:
        """The result of an operation, which is done only if it must be."""
        if name in _SYMMETRIC:
            operands = tuple(sorted(operands, key=_rank))
        simple = self._simplified(name, operands)
        if simple is not None:
            return simple
        return self.once((name, *operands), lambda: self._operation(name, operands))

    def once(self, key: Hashable, make: Callable[[], Value]) -> Value:
        """A value that is made only if it isn't known in this scope or one around it."""
        if key not in self._known:
            self._known[key] = make()
        return self._known[key]

    def _operation(self, name: str, operands: tuple[Value, ...]) -> Variable:
        result = self.variable(boolean=name in BOOLEAN)
        self.statements.append(Operation(result, name, operands))
        self._origins[result] = name, operands
        return result

    def _simplified(self, name: str, operands: tuple[Value, ...]) -> Value | None:
        if name in _FOLDED and all(isinstance(operand, Constant) for operand in operands):
            return _folded(name, operands)
        last, inside = self.origin(operands[-1])
        match name, operands:
            case ("add", (Constant(0.0), x)) | ("mul", (Constant(1.0), x)):
                return x
            case ("sub", (x, Constant(0.0))) | ("div", (x, Constant(1.0))):
                return x
            case ("mul" | "div", (Constant(0.0), _)):
                return ZERO
            case ("mul", (Constant(-1.0), x)) | ("sub", (Constant(0.0), x)):
                return self.apply("neg", x)
            case ("neg" | "not", _) if last == name:
                return inside[0]
            case ("and" | "or", _):
                return _logic(name, *operands)
            case ("select", _):
                return self._selected(*operands)
            case ("ne", (Constant(0.0), _)) if last == "select" and inside[1:] == (ONE, ZERO):
                return inside[0]  # A truth value made a number, such as the index of a `cond`.
            case ("any", (Constant() as x,)):
                return x
        return None

    def _selected(self, chosen: Value, x: Value, y: Value) -> Value | None:
        if isinstance(chosen, Constant):
            return x if chosen.value else y
        if x == y:
            return x
        if x.boolean:
            otherwise = self.apply("and", self.apply("not", chosen), y)
            return self.apply("or", self.apply("and", chosen, x), otherwise)
        return None


def constant(value: float | int) -> Constant:
    """A known value; an integer is a real.

    Args:
        value: The number or truth value.

    Returns:
        It as a constant.
    """
    if isinstance(value, bool):
        return TRUE if value else FALSE
    return Constant(float(value) + 0.0)


def first_free(block: Block) -> int:
    """The first number that no variable and no cell of a block has.

    Args:
        block: A program's body.

    Returns:
        The number.
    """
    return 1 + max((operation.target.number for operation in operations(block)), default=-1)


def _folded(name: str, operands: tuple[Constant, ...]) -> Constant | None:
    try:
        return constant(_FOLDED[name](*(operand.value for operand in operands)))
    except (ArithmeticError, ValueError):
        return None  # The processor has infinities and NaN for it.


def _logic(name: str, x: Value, y: Value) -> Value | None:
    """What a constant, which comes first, or twice the same makes plain."""
    if isinstance(x, Constant):
        return y if x.value == (name == "and") else x
    return x if x == y else None


def _rank(value: Value) -> tuple[bool, float | int]:
    return (True, value.number) if isinstance(value, Variable) else (False, value.value)
