"""A program of scalar operations: what a step is to a processor.

A program reads cells of named arrays, does thousands of operations on single numbers, few
branches and loops, and writes cells of named arrays. It says nothing of lanes: each robot is a
program's whole world, but for the operation `any`, which asks all robots that are computed
together. `reading` makes one of a jaxpr, `differentiation` adds derivatives to it and
`tangent_loops` puts them into loops; `native.printers` print it.

Numbers are real or boolean. Integers, which only count here, are reals.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace


@dataclass(frozen=True, slots=True)
class Constant:
    """A value that is known when the program is printed."""

    value: float
    boolean: bool = False


@dataclass(frozen=True, slots=True)
class Variable:
    """The result of one operation."""

    number: int
    boolean: bool = False


@dataclass(frozen=True, slots=True)
class Cell:
    """A place in memory: in an array of the caller's, or what branches and turns share."""

    array: str
    """Name of an argument or a result; empty for the program's own."""
    number: int
    boolean: bool = False
    each: bool = False
    """Whether there is one for each tangent."""


Value = Constant | Variable


@dataclass(frozen=True, slots=True)
class Operation:
    """One scalar operation. `read` gets what is in a cell, `write` puts a value there."""

    target: Variable | Cell
    name: str
    sources: tuple[Value | Cell, ...]


@dataclass(frozen=True, slots=True)
class If:
    """Two blocks, of which one is done, by a condition that is the same in all lanes."""

    condition: Value
    then: "Block"
    otherwise: "Block"


@dataclass(frozen=True, slots=True)
class Loop:
    """A block that is done a number of times."""

    counter: Variable
    times: int
    body: "Block"


@dataclass(frozen=True, slots=True)
class Each:
    """Operations that are done for each tangent."""

    body: "Block"


Statement = Operation | If | Loop | Each
Block = tuple[Statement, ...]


@dataclass(frozen=True)
class Program:
    """A function that reads named arrays and writes named arrays, which may be the same."""

    arguments: Mapping[str, int]
    """Numbers in each argument, in the function's order; of one tangent, where there is one
    for each."""
    results: Mapping[str, int]
    """Numbers in each result, likewise."""
    body: Block
    each: frozenset[str] = frozenset()
    """Arrays that there are for each tangent, one after the other."""

    def size(self, array: str) -> int:
        """Numbers in an array.

        Args:
            array: Name of an argument or a result.

        Returns:
            How many, of one tangent.
        """
        return {**self.arguments, **self.results}[array]


def statements(block: Block) -> Iterator[Statement]:
    """All statements of a block and those inside it.

    Args:
        block: The block.

    Yields:
        The statements, in the order of the text.
    """
    for statement in block:
        yield statement
        match statement:
            case If(_, then, otherwise):
                yield from statements(then + otherwise)
            case Loop(_, _, body) | Each(body):
                yield from statements(body)


def operations(block: Block) -> list[Operation]:
    """All operations of a block and those inside it.

    Args:
        block: The block.

    Returns:
        The operations, in the order of the text.
    """
    return [statement for statement in statements(block) if isinstance(statement, Operation)]


def changed(statement: If | Loop | Each, change: Callable[[Block], Block]) -> Statement:
    """Control flow with its blocks changed.

    Args:
        statement: The control flow.
        change: What to make of a block.

    Returns:
        The same with the changed blocks.
    """
    match statement:
        case If(condition, then, otherwise):
            return If(condition, change(then), change(otherwise))
        case _:
            return replace(statement, body=change(statement.body))


def own_cells(block: Block) -> list[Cell]:
    """Cells of a program's own that are written in it.

    Args:
        block: The program's body.

    Returns:
        The cells, each once.
    """
    written = [operation.target for operation in operations(block) if operation.name == "write"]
    return [*dict.fromkeys(cell for cell in written if not cell.array)]


def needed(block: Block) -> Block:
    """A block without operations that no result depends on.

    Args:
        block: The program's body.

    Returns:
        What is left of it.
    """
    every = operations(block)
    wanted: set[Value | Cell] = {s.condition for s in statements(block) if isinstance(s, If)}
    size = -1
    while size < len(wanted):  # Again, as a turn of a loop leaves what the next one needs.
        size = len(wanted)
        for operation in reversed(every):
            target = operation.target
            if target in wanted or (isinstance(target, Cell) and target.array):
                wanted.update((target, *operation.sources))

    def rest(block: Block) -> Block:
        kept = (s if isinstance(s, Operation) else changed(s, rest) for s in block)
        return tuple(
            s
            for s in kept
            if not isinstance(s, Operation)
            or s.target in wanted
            or (isinstance(s.target, Cell) and s.target.array)
        )

    return rest(block)
