"""A step repeated for a group of robots in LLVM IR: what is copied in, done, and copied out.

The robots of a group lie side by side, one in each lane; where robots are missing the last one
is taken again. A kernel's arrays are XLA's: a robot's numbers lie together, those of a step in
a row, and behind each number of a result's derivative all its tangents. In the group's memory
each tangent has its numbers together, but for a robot alone, whose tangents are its lanes. More
tangents than the stack has room for go in parts, one after the other.
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from scdpr_jax.native.printers.llvm_ir import ABREAST, MOST_TANGENTS, llvm_ir, loop
from scdpr_jax.native.scalar.program import Program

MOST_NUMBERS = 1600
"""Numbers of a robot in all arrays of a step, without tangents: they lie on the stack."""

TASK = ("next", "done", "users", "groups", "last", "steps", "tangents", "begun")
"""What a task says of its own, 8 bytes each; `WORDS` of each array follow. `begun` is where it
says how many of the tangents have begun in each step, the first ones; 0 where all have. What
the others' derivatives are is nothing yet, and isn't written."""
WORDS = (("data", "ptr"), ("robot", "i64"), ("tangent", "i64"))
"""Where an array begins, and how far its robots and its tangents are apart."""


@dataclass(frozen=True)
class Array:
    """An operand or a result of XLA's."""

    name: str
    size: int
    """Numbers of a robot, in a step and of a tangent, if there are several."""
    rows: bool
    """Whether it has a row for each step."""
    each: bool
    """Whether it is there for each tangent."""
    local: str
    """The group's memory of it, which carried results share with the start."""
    result: bool


@dataclass(frozen=True)
class Kernel:
    """A step and how it is repeated."""

    name: str
    program: Program
    """The step. Its arguments and results are `arrays` by name."""
    carried: Mapping[str, str]
    """Results that are an argument in the next step, and that argument."""
    rows: frozenset[str]
    """Arguments and results with a row for each step."""
    silent: frozenset[str]
    """Results that XLA isn't given."""
    lanes: int

    @property
    def arrays(self) -> Sequence[Array]:
        """Operands, then results, in XLA's order."""
        program = self.program
        return [
            Array(
                name,
                size,
                rows=name in self.rows,
                each=name in program.each,
                local=self.carried.get(name, name),
                result=name in program.results,
            )
            for name, size in (*program.arguments.items(), *program.results.items())
            if name not in self.silent
        ]

    def places(self) -> Iterator[tuple[Array, tuple[str, str], int]]:
        """Words of arrays, and where a task has them [bytes]."""
        every = itertools.product(self.arrays, WORDS)
        return ((own, word, 8 * (len(TASK) + i)) for i, (own, word) in enumerate(every))

    def text(self) -> str:
        """The step, and `..._group`, which does all steps of a task's group.

        Raises:
            NotImplementedError: If a robot has more numbers than there is room for.
        """
        numbers = sum(own.size for own in self.arrays)
        if numbers > MOST_NUMBERS:
            raise NotImplementedError(
                f"A step has {numbers} numbers in its arrays, more than {MOST_NUMBERS}. Give "
                "it what it needs of a long array as a row of its inputs."
            )
        step = llvm_ir(self.program, self.name, lanes=self.lanes)
        return "\n".join([step, *self._copy(), *self._group()])

    def _copy(self) -> Iterator[str]:
        """Copies what a group's robots have of an array that is the same in all steps."""
        yield f"""\
define void @{self.name}_copy(ptr %to, ptr %data, i64 %robot, i64 %tangent, i64 %size,
  i64 %begin, i64 %tangents, i64 %apart, i64 %next, i64 %first, i64 %last) {{"""
        number = f"""\
%wanted = add i64 %first, %l
%own = call i64 @llvm.smin.i64(i64 %wanted, i64 %last)
%a = mul i64 %own, %robot
%p = add i64 %begin, %t
%b = mul i64 %p, %tangent
%c = add i64 %a, %b
%d = add i64 %c, %n
%from = getelementptr double, ptr %data, i64 %d
%x = load double, ptr %from, align 8
%e = mul i64 %t, %apart
%i = mul i64 %n, %next
%f = add i64 %e, %i
%g = mul i64 %f, {self.lanes}
%h = add i64 %g, %l
%there = getelementptr double, ptr %to, i64 %h
store double %x, ptr %there, align 8"""
        lanes = loop("l", str(self.lanes), loop("n", "%size", [number]))
        yield from loop("t", "%tangents", lanes)
        yield "ret void\n}"

    def _apart(self, own: Array) -> tuple[int, int]:
        """How far an array's tangents and numbers are apart in the group's memory."""
        return (1, MOST_TANGENTS) if self._abreast(own) else (own.size, 1)

    def _abreast(self, own: Array) -> bool:
        """Whether the tangents of a number lie side by side, some of them for none."""
        return own.each and self.lanes == 1

    def _group(self) -> Iterator[str]:
        """All steps of as many robots as there are lanes."""
        yield f"define void @{self.name}_group(ptr %task, i64 %group) {{"
        for own in self.arrays:
            if own.local == own.name:
                count = own.size * self.lanes * (MOST_TANGENTS if own.each else 1)
                yield f"%{own.local} = alloca [{count} x double], align 64"
                if self._abreast(own):
                    ends = f"ptr %{own.local}, i8 0, i64 {8 * count}, i1 false"
                    yield f"call void @llvm.memset.p0.i64({ends})"
        for place, word in enumerate(TASK):
            yield from load(f"%{word}", "i64", "%task", 8 * place)
        for own, (word, kind), place in self.places():
            yield from load(f"%{own.name}.{word}", kind, "%task", place)
        yield f"%first = mul i64 %group, {self.lanes}"
        for lane in range(self.lanes):
            yield f"%wanted{lane} = add i64 %first, {lane}"
            yield f"%robot{lane} = call i64 @llvm.smin.i64(i64 %wanted{lane}, i64 %last)"
        yield f"%parts.wide = add i64 %tangents, {MOST_TANGENTS - 1}"
        yield f"%parts = sdiv i64 %parts.wide, {MOST_TANGENTS}"
        yield from loop("part", "%parts", self._part())
        yield "ret void\n}"

    def _part(self) -> Iterator[str]:
        """All steps with some of the tangents."""
        yield f"""\
%begin = mul i64 %part, {MOST_TANGENTS}
%rest = sub i64 %tangents, %begin
%some = call i64 @llvm.smin.i64(i64 %rest, i64 {MOST_TANGENTS})"""
        every, program = self.arrays, self.program
        for own in every:
            if not own.rows and not own.result:
                words = ", ".join(f"{kind} %{own.name}.{word}" for word, kind in WORDS)
                many = "i64 %begin, i64 %some" if own.each else "i64 0, i64 1"
                apart = "i64 {}, i64 {}".format(*self._apart(own))
                ends = f"i64 {own.size}, {many}, {apart}, i64 %first, i64 %last"
                yield f"call void @{self.name}_copy(ptr %{own.local}, {words}, {ends})"
        named = (*program.arguments, *program.results)
        pointers = ", ".join(f"ptr %{self.carried.get(name, name)}" for name in named)
        rows = [own for own in every if own.rows]
        step = itertools.chain(
            self._begun(),
            *(self._moved(own, "%k", many="%now") for own in rows if not own.result),
            [f"call void @{self.name}({pointers}, i64 %now)"],
            *(self._moved(own, "%k", many="%now") for own in rows if own.result),
        )
        yield from loop("k", "%steps", step)
        for own in every:
            if own.result and not own.rows:
                yield from self._moved(own, "0", many="%some")

    def _begun(self) -> Iterator[str]:
        """How many of the part's tangents have begun in a step."""
        yield f"""\
%listed = icmp ne i64 %begun, 0
%list = inttoptr i64 %begun to ptr
%in.list = getelementptr i64, ptr %list, i64 %k
%in.task = getelementptr i64, ptr %task, i64 {TASK.index("tangents")}
%begun.place = select i1 %listed, ptr %in.list, ptr %in.task
%begun.now = load i64, ptr %begun.place, align 8
%now.rest = sub i64 %begun.now, %begin
%now.any = call i64 @llvm.smax.i64(i64 %now.rest, i64 0)"""
        # Those that are computed beside them have begun, too: what they are told isn't stale.
        beside = ABREAST if self.lanes == 1 else 1
        yield f"""\
%now.wide = add i64 %now.any, {beside - 1}
%now.registers = sdiv i64 %now.wide, {beside}
%now.full = mul i64 %now.registers, {beside}
%now = call i64 @llvm.smin.i64(i64 %now.full, i64 %some)"""

    def _moved(self, own: Array, row: str, *, many: str) -> Iterator[str]:
        """A row of each lane's robot: an operand's into the group's memory, a result's out."""
        tag = f"{own.name}.moved"
        return loop(f"{tag}.p", many if own.each else "1", self._moved_tangent(own, row, tag))

    def _moved_tangent(self, own: Array, row: str, tag: str) -> Iterator[str]:
        apart = "%tangents" if own.each and own.result else "1"
        tangent, number = self._apart(own)
        yield f"""\
%{tag}.begin = add i64 {"%begin" if own.each else "0"}, %{tag}.p
%{tag}.row = mul i64 {row}, {own.size}
%{tag}.far = mul i64 %{tag}.row, {apart}
%{tag}.tangent = mul i64 %{tag}.begin, %{own.name}.tangent
%{tag}.both = add i64 %{tag}.far, %{tag}.tangent
%{tag}.here = getelementptr [{tangent * self.lanes} x double], ptr %{own.local}, i64 %{tag}.p"""
        for lane in range(self.lanes):
            yield f"""\
%{tag}.robot{lane} = mul i64 %robot{lane}, %{own.name}.robot
%{tag}.sum{lane} = add i64 %{tag}.robot{lane}, %{tag}.both
%{tag}.base{lane} = getelementptr double, ptr %{own.name}.data, i64 %{tag}.sum{lane}"""
        for cell in range(own.size):
            yield f"%{tag}.cell{cell} = mul i64 {cell}, {apart}"
            for lane in range(self.lanes):
                place = cell * number * self.lanes + lane
                yield from self._moved_number(own, tag, cell, lane, place)

    def _moved_number(
        self, own: Array, tag: str, cell: int, lane: int, place: int
    ) -> Iterator[str]:
        n = f"{tag}.{cell}.{lane}"
        source, end = ("here", "there") if own.result else ("there", "here")
        yield f"""\
%{n}.there = getelementptr double, ptr %{tag}.base{lane}, i64 %{tag}.cell{cell}
%{n}.here = getelementptr double, ptr %{tag}.here, i64 {place}
%{n}.x = load double, ptr %{n}.{source}, align 8
store double %{n}.x, ptr %{n}.{end}, align 8"""


def load(target: str, kind: str, base: str, place: int) -> Iterator[str]:
    """Loads a field.

    Args:
        target: The variable that gets it.
        kind: Its type.
        base: Pointer to its struct.
        place: Where it is there [bytes].

    Yields:
        The lines.
    """
    yield f"{target}.at = getelementptr i8, ptr {base}, i64 {place}"
    yield f"{target} = load {kind}, ptr {target}.at, align 4"
