"""A program made anew, operation by operation, in the order that it has."""

from collections.abc import Callable

from scdpr_jax.native.scalar.program import (
    Block,
    Cell,
    Each,
    If,
    Loop,
    Operation,
    Value,
    Variable,
)
from scdpr_jax.native.scalar.scope import Scope

Renamed = dict[Variable, Value]
"""What has come of the old program's variables."""
Emit = Callable[[Scope, Operation, tuple[Value | Cell, ...]], Value | None]
"""Writes what an operation becomes into a scope. Given its sources as they are now, it says
what has come of its target, if that is a variable."""


def rewritten(block: Block, emit: Emit, *, first: int) -> Block:
    """A program's body made anew.

    Args:
        block: The body.
        emit: What comes of an operation; branches and loops stay what they are.
        first: The first number that is free for new variables and cells.

    Returns:
        The new body.
    """
    scope = Scope(first=first)
    _rewrite(scope, block, emit, {})
    return scope.block


def repeated(
    scope: Scope, operation: Operation, sources: tuple[Value | Cell, ...]
) -> Value | None:
    """Emits an operation as it is.

    Args:
        scope: The block in the making.
        operation: The operation.
        sources: Its sources as they are now.

    Returns:
        What has come of its target.
    """
    match operation:
        case Operation(Cell() as cell, "write", _):
            scope.write(cell, sources[0])
            return None
        case Operation(_, "read", (Cell() as cell,)):
            return scope.read(cell)
        case Operation(_, name, _):
            return scope.apply(name, *sources)


def _rewrite(scope: Scope, block: Block, emit: Emit, renamed: Renamed) -> None:
    for statement in block:
        match statement:
            case Operation(target, _, sources):
                made = emit(scope, statement, tuple(renamed.get(own, own) for own in sources))
                if made is not None:
                    renamed[target] = made
            case If(condition, then, otherwise):
                ways = Scope(scope), Scope(scope)
                for inner, own in zip(ways, (then, otherwise), strict=True):
                    _rewrite(inner, own, emit, renamed)
                scope.branch(renamed.get(condition, condition), *ways)
            case Loop(counter, times, body):
                inner = Scope(scope)
                _rewrite(inner, body, emit, renamed)
                scope.loop(counter, times, inner)
            case Each():
                raise ValueError("Loops over tangents are made last, after all rewriting.")
