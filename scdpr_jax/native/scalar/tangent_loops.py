"""Tangents in loops, so that derivatives by many parameters are no more code than by one."""

import itertools
from collections.abc import Mapping
from dataclasses import replace

from scdpr_jax.native.scalar.elimination import eliminated
from scdpr_jax.native.scalar.program import (
    Block,
    Cell,
    Each,
    Operation,
    Program,
    Statement,
    Value,
    Variable,
    changed,
    operations,
    statements,
)
from scdpr_jax.native.scalar.scope import first_free


def loop_over_tangents(program: Program) -> Program:
    """A program with what depends on tangents in loops over them.

    Between two pieces of control flow that tangents take part in, all the rest is done first
    and the tangents then, one after the other. What one loop leaves to another is in cells, one
    for each tangent.

    Args:
        program: A program for one tangent.

    Returns:
        The program for any number of them.
    """
    linear = _linear(program)
    body = eliminated(_split(program.body, linear), linear)
    body = _handed_on(body, linear)
    return replace(program, body=body)


def _linear(program: Program) -> set[Value | Cell]:
    """Variables and cells that depend on a tangent."""
    every = operations(program.body)
    ends = {end for operation in every for end in (operation.target, *operation.sources)}
    linear = {end for end in ends if isinstance(end, Cell) and end.array in program.each}
    size = -1
    while size < len(linear):  # Again, as a turn of a loop leaves them to the next one.
        size = len(linear)
        linear |= {o.target for o in every if not linear.isdisjoint(o.sources)}
    return linear


def _split(block: Block, linear: set[Value | Cell]) -> Block:
    """A block with its tangents behind the rest, up to each piece of control flow of theirs."""
    done: list = []
    waiting: list[Operation] = []
    for statement in block:
        if isinstance(statement, Operation):
            (waiting if statement.target in linear else done).append(statement)
            continue
        inner = changed(statement, lambda own: _split(own, linear))
        if waiting and any(isinstance(own, Each) for own in statements((inner,))):
            done.append(Each(tuple(waiting)))
            waiting = []
        done.append(inner)
    return (*done, Each(tuple(waiting))) if waiting else tuple(done)


def _handed_on(block: Block, linear: set[Value | Cell]) -> Block:
    """A block in which each loop over tangents keeps what later ones need of it."""
    loops = [own for own in statements(block) if isinstance(own, Each)]
    homes = {own.target: i for i, loop in enumerate(loops) for own in loop.body}
    numbers = itertools.count(first_free(block))
    kept = {
        source: Cell("", next(numbers), each=True)
        for i, loop in enumerate(loops)
        for source in _sources(loop)
        if isinstance(source, Variable) and homes.get(source, i) != i
    }
    order = itertools.count()

    def each(loop: Each) -> Each:
        i = next(order)
        new = {
            source: Variable(next(numbers))
            for source in _sources(loop)
            if source in kept and homes[source] != i
        }
        return _linked(loop, new, kept, linear)

    def linked(statement: Statement) -> Statement:
        match statement:
            case Operation():
                return statement
            case Each():
                return each(statement)
            case _:
                return changed(statement, rest)

    def rest(block: Block) -> Block:
        return tuple(map(linked, block))

    return rest(block)


def _sources(loop: Each) -> dict[Value | Cell, None]:
    """All sources of a loop's operations, each once, in their order."""
    return dict.fromkeys(source for own in loop.body for source in own.sources)


def _linked(
    loop: Each,
    new: Mapping[Variable, Variable],
    kept: Mapping[Variable, Cell],
    linear: set[Value | Cell],
) -> Each:
    """A loop that reads what others left, under new names, and leaves what others need."""

    def placed(end: Value | Cell) -> Value | Cell:
        if isinstance(end, Cell):
            return replace(end, each=True) if end in linear else end
        return new.get(end, end)

    reads = [Operation(there, "read", (kept[source],)) for source, there in new.items()]
    own = [
        Operation(placed(one.target), one.name, tuple(map(placed, one.sources)))
        for one in loop.body
    ]
    writes = [
        Operation(kept[one.target], "write", (one.target,))
        for one in loop.body
        if one.target in kept
    ]
    return Each((*reads, *own, *writes))
