"""Operations moved into the branch that alone needs them.

JAX computes all that a `cond` is given before it: of a step the whole motion that events are
looked for in, with its tangents, though few steps have an event.
"""

import collections
from collections.abc import Iterator
from dataclasses import replace

from scdpr_jax.native.scalar.program import (
    Block,
    Cell,
    If,
    Operation,
    Program,
    Statement,
    Value,
    changed,
    statements,
)

_FIXED = ("read", "write")
"""Operations whose place matters, as memory changes."""


def sunk(program: Program) -> Program:
    """A program that does in a branch what is needed there alone.

    Args:
        program: The program.

    Returns:
        One that does the same.
    """
    return replace(program, body=_sunk(program.body, _uses(program.body)))


def _uses(block: Block) -> collections.Counter[Value | Cell]:
    """How often values are used in a block and those inside it."""
    return collections.Counter(
        source for statement in statements(block) for source in _sources(statement)
    )


def _sources(statement: Statement) -> Iterator[Value | Cell]:
    match statement:
        case Operation(_, _, sources):
            yield from sources
        case If(condition):
            yield condition


def _sunk(block: Block, uses: collections.Counter[Value | Cell]) -> Block:
    """A block whose branches have what they alone need, and theirs likewise."""
    done: list[Statement] = []
    for statement in block:
        match statement:
            case If(condition, then, otherwise):
                then = (*_taken(done, then, uses), *then)
                otherwise = (*_taken(done, otherwise, uses), *otherwise)
                done.append(If(condition, _sunk(then, uses), _sunk(otherwise, uses)))
            case Operation():
                done.append(statement)
            case _:
                done.append(changed(statement, lambda own: _sunk(own, uses)))
    return tuple(done)


def _taken(
    done: list[Statement], branch: Block, uses: collections.Counter[Value | Cell]
) -> list[Operation]:
    """Takes operations that only a branch needs from what is done before it."""
    inside, taken = _uses(branch), []
    for i in reversed(range(len(done))):
        own = done[i]
        if not isinstance(own, Operation) or own.name in _FIXED:
            continue
        if 0 < uses[own.target] == inside[own.target]:
            inside.update(own.sources)
            taken.append(own)
            del done[i]
    return taken[::-1]
