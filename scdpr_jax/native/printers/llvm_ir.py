"""A program printed as LLVM IR, with a robot in each lane, or a tangent of a robot alone.

Every number is a vector of lanes, those in arrays too. A step has few branches and loops and
thousands of operations, so each operation is a line. Cells are plain memory; they stay in
registers or in the first cache.

Robots side by side take one tangent after the other. A robot alone would leave its registers
empty, and has most of its work in its tangents: there those lie side by side.
"""

import itertools
import struct
from collections.abc import Iterable, Iterator, Mapping

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
    Variable,
    own_cells,
)
from scdpr_jax.native.scalar.scope import first_free

TOGETHER = 2
"""Tangents that a loop takes at a time where robots lie side by side."""
ABREAST = 8
"""Tangents of a robot alone that lie side by side."""
MOST_TANGENTS = 40
"""Tangents that a group's memory has room for, a multiple of `ABREAST`."""

_INTRINSICS = {
    **{own: own for own in ("sqrt", "floor", "ceil", "sin", "cos", "tan", "atan")},
    **{own: own for own in ("exp", "log", "tanh")},
    "abs": "fabs",
    "round": "rint",
}
_LINES = {
    **{
        own: f"{{target}} = f{own} contract {{real}} {{}}, {{}}"
        for own in ("add", "sub", "mul", "div")
    },
    **{
        own: f"{{target}} = fcmp o{own} {{real}} {{}}, {{}}"
        for own in ("lt", "le", "gt", "ge", "eq")
    },
    **{
        own: f"{{target}} = call {{real}} @llvm.{intrinsic}.{{reals}}({{real}} {{}})"
        for own, intrinsic in _INTRINSICS.items()
    },
    "pow": "{target} = call {real} @llvm.pow.{reals}({real} {}, {real} {})",
    "ne": "{target} = fcmp une {real} {}, {}",
    "neg": "{target} = fneg {real} {}",
    "and": "{target} = and {boolean} {}, {}",
    "or": "{target} = or {boolean} {}, {}",
    "not": "{target} = xor {boolean} {}, splat (i1 true)",
    "select": "{target} = select {boolean} {}, {real} {}, {real} {}",
    "any": """\
{target}.any = call i1 @llvm.vector.reduce.or.{booleans}({boolean} {})
{target}.first = insertelement {boolean} poison, i1 {target}.any, i64 0
{target} = shufflevector {boolean} {target}.first, {boolean} poison, {firsts}""",
    "counter": """\
{target}.real = sitofp i64 {} to double
{target}.first = insertelement {real} poison, double {target}.real, i64 0
{target} = shufflevector {real} {target}.first, {real} poison, {firsts}""",
    # In 2^52 + 1023 + x the last bits of the mantissa are the exponent of 2^x.
    "power_of_two": """\
{target}.sum = fadd {real} {}, splat (double 4503599627371519.0)
{target}.bits = bitcast {real} {target}.sum to {integer}
{target}.shifted = shl {integer} {target}.bits, splat (i64 52)
{target} = bitcast {integer} {target}.shifted to {real}""",
}
"""Contracted, $a b + c$ has one rounding, as XLA has it too."""


def llvm_ir(program: Program, name: str, *, lanes: int) -> str:
    """A program as a function of LLVM IR.

    It gets a pointer for each argument and each result, in their order, and how many tangents
    there are; a result may be written where an argument was. A robot alone has all tangents of
    a number together, `MOST_TANGENTS` apart from those of the next one, and as many are
    computed as fill the last register.

    Args:
        program: The program.
        name: Name of the function.
        lanes: Robots in a vector.

    Returns:
        The text.
    """
    return "\n".join(_Printer(program, lanes).function(name))


def loop(index: str, times: str, inside: Iterable[str]) -> Iterator[str]:
    """A loop that counts from zero.

    Args:
        index: Name of the counter, which also names its labels.
        times: How often, an operand.
        inside: Lines of a turn.

    Yields:
        The lines.
    """
    yield f"br label %{index}.start"
    yield f"{index}.start:"
    yield f"br label %{index}.head"
    yield f"{index}.head:"
    yield f"%{index} = phi i64 [0, %{index}.start], [%{index}.next, %{index}.end]"
    yield f"%{index}.more = icmp slt i64 %{index}, {times}"
    yield f"br i1 %{index}.more, label %{index}.body, label %{index}.done"
    yield f"{index}.body:"
    yield from inside
    yield f"br label %{index}.end"
    yield f"{index}.end:"
    yield f"%{index}.next = add i64 %{index}, 1"
    yield f"br label %{index}.head"
    yield f"{index}.done:"


class _Printer:
    """Prints the blocks of one program."""

    def __init__(self, program: Program, lanes: int):
        self.program, self.lanes, self.alone = program, lanes, lanes == 1
        self.types = _types(lanes)
        self.numbers = itertools.count()
        self.free = itertools.count(first_free(program.body))

    def function(self, name: str) -> Iterator[str]:
        """All lines of the function."""
        arrays = [*self.program.arguments, *self.program.results]
        pointers = ", ".join(f"ptr %{array}" for array in arrays)
        yield f"define void @{name}({pointers}, i64 %tangents) {{"
        yield f"%tangents.wide = add i64 %tangents, {ABREAST - 1}"
        yield f"%registers = sdiv i64 %tangents.wide, {ABREAST}"
        yield f"%tangents.room = mul i64 %registers, {ABREAST}"
        for cell in own_cells(self.program.body):
            many = ", i64 %tangents.room" * cell.each
            yield f"%c{cell.number} = alloca {self.types[cell.boolean]}{many}, align 64"
        yield from self._block(self.program.body, "0")
        yield "ret void\n}"

    def _block(self, block: Block, tangent: str) -> Iterator[str]:
        for statement in block:
            n = next(self.numbers)
            match statement:
                case Operation(target, name, sources):
                    yield from self._statement(target, name, sources, tangent)
                case If(condition, then, otherwise):
                    lanes = f"{self.types[True]} {_operand(condition)}"
                    yield f"%if{n} = extractelement {lanes}, i64 0"
                    yield f"br i1 %if{n}, label %then{n}, label %else{n}"
                    for label, own in (("then", then), ("else", otherwise)):
                        yield f"{label}{n}:"
                        yield from self._block(own, tangent)
                        yield f"br label %end{n}"
                    yield f"end{n}:"
                case Loop(counter, times, body):
                    count = _line(counter, "counter", f"%k{n}", lanes=self.lanes)
                    inside = itertools.chain([count], self._block(body, tangent))
                    yield from loop(f"k{n}", str(times), inside)
                case Each(body) if self.alone:
                    yield from loop(f"q{n}", "%registers", self._abreast(body, f"%q{n}"))
                case Each(body):
                    yield from self._each(body, n)

    def _each(self, body: Block, n: int) -> Iterator[str]:
        """A loop over tangents, some at a time: what they share is loaded once for them."""
        yield f"%q{n}.all = sdiv i64 %tangents, {TOGETHER}"
        yield from loop(f"q{n}", f"%q{n}.all", self._together(body, f"%q{n}"))
        yield f"%r{n}.first = mul i64 %q{n}.all, {TOGETHER}"
        yield f"%r{n}.rest = sub i64 %tangents, %r{n}.first"
        alone = itertools.chain(
            [f"%p{n} = add i64 %r{n}.first, %r{n}"], self._block(body, f"%p{n}")
        )
        yield from loop(f"r{n}", f"%r{n}.rest", alone)

    def _together(self, body: Block, group: str) -> Iterator[str]:
        """A loop's operations for some tangents, each operation for all of them in turn."""
        yield f"{group}.0 = mul i64 {group}, {TOGETHER}"
        for i in range(1, TOGETHER):
            yield f"{group}.{i} = add i64 {group}.0, {i}"
        own = [operation.target for operation in body]
        new = [
            {v: Variable(next(self.free)) for v in own if isinstance(v, Variable)}
            for _ in range(TOGETHER)
        ]
        for operation in body:
            for i, names in enumerate(new):
                ends = (operation.target, *operation.sources)
                target, *sources = (names.get(end, end) for end in ends)
                yield from self._statement(target, operation.name, (*sources,), f"{group}.{i}")

    def _abreast(self, body: Block, register: str) -> Iterator[str]:
        """A loop's operations for a register of tangents of a robot alone."""
        yield f"{register}.first = mul i64 {register}, {ABREAST}"
        own = {operation.target for operation in body}
        names: dict[Value, str] = {}
        for value in dict.fromkeys(value for operation in body for value in operation.sources):
            if isinstance(value, Variable) and value not in own:
                names[value] = f"{register}.{value.number}"
                yield _spread(names[value], _operand(value), self.types[value.boolean])
        for each in body:
            ends = each.target, each.name, each.sources
            yield from self._statement(*ends, f"{register}.first", names, lanes=ABREAST)

    def _statement(
        self,
        target: Variable | Cell,
        name: str,
        sources: tuple,
        tangent: str,
        names: Mapping[Value, str] | None = None,
        *,
        lanes: int | None = None,
    ) -> Iterator[str]:
        """An operation; of tangents side by side if there are more lanes than robots."""
        n, lanes, names = next(self.numbers), lanes or self.lanes, names or {}
        match name:
            case "write":
                (source,), kind = sources, _types(lanes)[target.boolean]
                yield f"%at{n} = {self._place(target, tangent)}"
                written = names.get(source) or _operand(source)
                yield f"store {kind} {written}, ptr %at{n}, align 8"
            case "read":
                (cell,) = sources
                own = lanes if cell.each else self.lanes
                kind, to = _types(own)[target.boolean], _operand(target)
                yield f"%at{n} = {self._place(cell, tangent)}"
                yield f"{to if own == lanes else f'%one{n}'} = load {kind}, ptr %at{n}, align 8"
                if own != lanes:
                    yield _spread(to, f"%one{n}", kind)
            case _:
                given = (names.get(source) or _operand(source) for source in sources)
                yield _line(target, name, *given, lanes=lanes)

    def _place(self, cell: Cell, tangent: str) -> str:
        """Where a cell is: in which tangent's row of what array, and where there."""
        kind, row = self.types[cell.boolean], tangent if cell.each else "0"
        if not cell.array:
            return f"getelementptr {kind}, ptr %c{cell.number}, i64 {row}"
        if cell.each and self.alone:
            kind = f"[{MOST_TANGENTS} x double]"
            return f"getelementptr {kind}, ptr %{cell.array}, i64 {cell.number}, i64 {row}"
        size = self.program.size(cell.array)
        return (
            f"getelementptr [{size} x {kind}], ptr %{cell.array}, i64 {row}, i64 {cell.number}"
        )


def _types(lanes: int) -> Mapping[bool, str]:
    """Types of numbers, of real and of boolean ones."""
    return {False: f"<{lanes} x double>", True: f"<{lanes} x i1>"}


def _words(lanes: int) -> Mapping[str, str]:
    """What stands in `_LINES` for each number of lanes."""
    real, boolean = (_types(lanes)[own] for own in (False, True))
    return {
        "real": real,
        "boolean": boolean,
        "reals": f"v{lanes}f64",
        "booleans": f"v{lanes}i1",
        "integer": f"<{lanes} x i64>",
        "firsts": f"<{lanes} x i32> zeroinitializer",
    }


def _line(target: Variable, name: str, *sources: str, lanes: int) -> str:
    """An operation of numbers of so many lanes."""
    return _LINES[name].format(*sources, target=_operand(target), **_words(lanes))


def _spread(target: str, one: str, kind: str) -> str:
    """A robot's number for all its tangents."""
    shuffled = f"shufflevector {kind} {one}, {kind} poison"
    return f"{target} = {shuffled}, <{ABREAST} x i32> zeroinitializer"


def _operand(value: Value) -> str:
    match value:
        case Constant(known, True):
            return f"splat (i1 {str(bool(known)).lower()})"
        case Constant(known):
            return f"splat (double 0x{struct.pack('>d', known).hex()})"
        case _:
            return f"%v{value.number}"
