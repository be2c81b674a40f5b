"""A program printed as C99, for a controller on board or any other compiler.

A step has few branches and loops and thousands of operations, so each operation is a line.
"""

from collections.abc import Iterator

from scdpr_jax.native.scalar.program import (
    Block,
    Cell,
    Constant,
    Each,
    If,
    Loop,
    Operation,
    Program,
    Value,
    operations,
    own_cells,
)

_TERMS = {
    "add": "{} + {}", "sub": "{} - {}", "mul": "{} * {}", "div": "{} / {}", "neg": "-{}",
    "lt": "{} < {}", "le": "{} <= {}", "gt": "{} > {}", "ge": "{} >= {}",
    "eq": "{} == {}", "ne": "{} != {}", "and": "{} & {}", "or": "{} | {}", "not": "!{}",
    "select": "{} ? {} : {}", "abs": "fabs({})", "sqrt": "sqrt({})", "round": "rint({})",
    "floor": "floor({})", "ceil": "ceil({})", "sin": "sin({})", "cos": "cos({})",
    "tan": "tan({})", "exp": "exp({})", "log": "log({})", "atan": "atan({})",
    "tanh": "tanh({})", "pow": "pow({}, {})", "power_of_two": "ldexp(1.0, (int){})",
    "any": "{}", "read": "{}",
}  # fmt: skip
_TYPES = {False: "double", True: "bool"}


INCLUDES = "#include <math.h>\n#include <stdbool.h>\n"
"""What printed functions need."""


def c99(program: Program, name: str, *, most_tangents: int) -> str:
    """A program as a function of C99 that needs nothing but its mathematics, and `INCLUDES`.

    It gets a pointer for each argument and each result, in their order, and, where it has
    tangents, how many there are; a result may be written where an argument was. Where tangents
    are the same for all, or none, is the caller's to say: each argument has one for each.

    Args:
        program: The program.
        name: Name of the function. Not one that the C library has, such as `step`.
        most_tangents: For how many there is memory, which is on the stack.

    Returns:
        The text.
    """
    used = {
        source.array
        for own in operations(program.body)
        for source in own.sources
        if isinstance(source, Cell)
    }
    inputs = [f"const double *{array}" for array in program.arguments]
    outputs = [f"double *{array}" for array in program.results]
    count = ["long tangents"] * bool(program.each)
    cells = [
        f"{_TYPES[cell.boolean]} c{cell.number}" + f"[{most_tangents}]" * cell.each + ";"
        for cell in own_cells(program.body)
    ]
    lines = [
        f"static void {name}({', '.join(inputs + outputs + count)})",
        "{",
        *(f"(void){array};" for array in program.arguments if array not in used),
        *cells,
        *_block(program, program.body),
        "}",
    ]
    return "\n".join(lines) + "\n"


def _block(program: Program, block: Block) -> Iterator[str]:
    for statement in block:
        match statement:
            case Operation(cell, "write", (value,)):
                yield f"{_operand(program, cell)} = {_operand(program, value)};"
            case Operation(target, name, sources):
                term = _TERMS[name].format(*(_operand(program, own) for own in sources))
                yield f"const {_TYPES[target.boolean]} v{target.number} = {term};"
            case If(condition, then, otherwise):
                yield f"if ({_operand(program, condition)}) {{"
                yield from _block(program, then)
                yield "} else {"
                yield from _block(program, otherwise)
                yield "}"
            case Loop(counter, times, body):
                n = counter.number
                yield f"for (int k{n} = 0; k{n} < {times}; k{n}++) {{"
                yield f"const double v{n} = k{n};"
                yield from _block(program, body)
                yield "}"
            case Each(body):
                yield "for (long p = 0; p < tangents; p++) {"
                yield from _block(program, body)
                yield "}"


def _operand(program: Program, operand: Value | Cell) -> str:
    match operand:
        case Constant(value, True):
            return str(bool(value)).lower()
        case Constant(value):
            special = {"inf": "INFINITY", "-inf": "-INFINITY", "nan": "NAN"}
            return f"({special.get(repr(value), repr(value))})"
        case Cell("", number, each=each):
            return f"c{number}[p]" if each else f"c{number}"
        case Cell(array, number, each=each):
            row = f"{program.size(array)} * p + " if each else ""
            return f"{array}[{row}{number}]"
        case _:
            return f"v{operand.number}"
