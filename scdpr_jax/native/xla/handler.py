"""What XLA calls: a handler in LLVM IR that shares a kernel's groups out to XLA's threads.

When XLA registers a handler it asks for the version that it speaks; the handler then compares
the sizes of what it is handed with those that it was printed for, and names a version that
can't be if they differ: XLA refuses it.
"""

import itertools
from collections.abc import Iterator, Mapping

from scdpr_jax.native.kernel import TASK, WORDS, Array, Kernel, load
from scdpr_jax.native.printers.llvm_ir import loop
from scdpr_jax.native.xla.interface import Layout, header, layout, version


def handler_ir(kernel: Kernel) -> str:
    """A kernel with its handler.

    Args:
        kernel: The kernel.

    Returns:
        LLVM IR; XLA calls the function `..._handler`.

    Raises:
        KeyError: If the interface's header has a type that isn't known.
        NotImplementedError: If a robot has more numbers than there is room for.
        OSError: If there is no header.
    """
    printer = _Handler(kernel, layout(header()))
    return "\n".join([kernel.text(), *printer.lines()])


class _Handler:
    """Prints the functions around a kernel."""

    def __init__(self, kernel: Kernel, places: Layout):
        self.kernel, self.name = kernel, kernel.name
        self.layout, self.numbers = places, itertools.count()

    def lines(self) -> Iterator[str]:
        """Both functions, and what they need of the process."""
        yield "declare ptr @malloc(i64)\ndeclare void @free(ptr)\ndeclare i32 @sched_yield()"
        yield f"define void @{self.name}_work(ptr %task) {{"
        yield from self._work()
        yield "}"
        yield f"define ptr @{self.name}_handler(ptr %frame) {{"
        yield from self._handler()
        yield "}"

    def _work(self) -> Iterator[str]:
        """Takes groups until there are none, and frees the task if nobody needs it then."""
        yield from load("%groups", "i64", "%task", 8 * TASK.index("groups"))
        yield f"""\
%done = getelementptr i8, ptr %task, i64 {8 * TASK.index("done")}
br label %head
head:
%group = atomicrmw add ptr %task, i64 1 seq_cst
%more = icmp slt i64 %group, %groups
br i1 %more, label %body, label %end
body:
call void @{self.name}_group(ptr %task, i64 %group)
%finished = atomicrmw add ptr %done, i64 1 seq_cst
br label %head
end:"""
        yield from self._released("ret void")

    def _released(self, leave: str) -> Iterator[str]:
        yield f"""\
%users.at = getelementptr i8, ptr %task, i64 {8 * TASK.index("users")}
%left = atomicrmw sub ptr %users.at, i64 1 seq_cst
%unused = icmp eq i64 %left, 1
br i1 %unused, label %free, label %kept
free:
call void @free(ptr %task)
{leave}
kept:
{leave}"""

    def _handler(self) -> Iterator[str]:
        """Answers for its version, or shares the groups with XLA's threads and waits.

        It waits only for groups that a thread is at, so that it can't wait for itself. A thread
        that comes later finds nothing to do.
        """
        frame, ask = self.layout["XLA_FFI_CallFrame"], self._pool("NumThreads")
        yield f"%asking = alloca [{ask['bytes']} x i8], align 8\n%count = alloca i64"
        yield f"%giving = alloca [{self._pool('Schedule')['bytes']} x i8], align 8"
        yield from load("%extension", "ptr", "%frame", frame["extension_start"])
        yield "%any = icmp ne ptr %extension, null"
        yield "br i1 %any, label %which, label %run\nwhich:"
        kind = self.layout["XLA_FFI_Metadata_Extension"]["extension_base.type"]
        yield from load("%kind", "i32", "%extension", kind)
        yield "%asks = icmp eq i32 %kind, 1"
        yield "br i1 %asks, label %asked, label %run\nasked:"
        yield from self._metadata()
        yield "run:"
        for target, field in (("args", "args.args"), ("rets", "rets.rets")):
            yield from load(f"%{target}", "ptr", "%frame", frame[field])
        for target in ("api", "ctx"):
            yield from load(f"%{target}", "ptr", "%frame", frame[target])
        words = len(TASK) + len(WORDS) * len(self.kernel.arrays)
        yield f"%task = call ptr @malloc(i64 {8 * words})"
        yield from self._buffers()
        yield from self._shares(ask)
        yield from self._shared()

    def _pool(self, function: str) -> Mapping[str, int]:
        return self.layout[f"XLA_FFI_ThreadPool_{function}_Args"]

    def _shares(self, ask: Mapping[str, int]) -> Iterator[str]:
        """Into how many groups the robots fall, and how many threads take them."""
        api = self.layout["XLA_FFI_Api"]
        yield "store i64 1, ptr %count, align 8"
        yield from self._filled("%asking", ask, ctx="ptr %ctx", num_threads="ptr %count")
        yield from load("%ask", "ptr", "%api", api["XLA_FFI_ThreadPool_NumThreads"])
        yield f"""\
%failed = call ptr %ask(ptr %asking)
%threads = load i64, ptr %count, align 8
%wide = add i64 %robots, {self.kernel.lanes - 1}
%groups = sdiv i64 %wide, {self.kernel.lanes}
%last = sub i64 %robots, 1
%busy.most = call i64 @llvm.smin.i64(i64 %threads, i64 %groups)
%useful = call i64 @llvm.smax.i64(i64 %busy.most, i64 1)
%others = sub i64 %useful, 1
%users = add i64 %useful, 1"""
        # All robots are one team.
        values = dict.fromkeys(("next", "done", "begun"), "0") | {"team": "%robots"}
        for place, word in enumerate(TASK):
            value = values.get(word, f"%{word}")
            yield from self._store(f"i64 {value}", "%task", 8 * place)

    def _shared(self) -> Iterator[str]:
        """Gives the task to other threads, works, and waits."""
        give, api = self._pool("Schedule"), self.layout["XLA_FFI_Api"]
        work = f"ptr @{self.name}_work"
        yield from self._filled("%giving", give, ctx="ptr %ctx", task=work, data="ptr %task")
        yield from load("%give", "ptr", "%api", api["XLA_FFI_ThreadPool_Schedule"])
        shared = f"""\
%refused = call ptr %give(ptr %giving)
%given = icmp eq ptr %refused, null
br i1 %given, label %shared, label %alone
alone:
call void @{self.name}_work(ptr %task)
br label %shared
shared:"""
        yield from loop("t", "%others", [shared])
        yield f"""\
call void @{self.name}_work(ptr %task)
%done.at = getelementptr i8, ptr %task, i64 {8 * TASK.index("done")}
br label %wait
wait:
%done = load atomic i64, ptr %done.at acquire, align 8
%busy = icmp slt i64 %done, %groups
br i1 %busy, label %again, label %over
again:
%nothing = call i32 @sched_yield()
br label %wait
over:"""
        yield from self._released("ret ptr null")

    def _metadata(self) -> Iterator[str]:
        """Names the version, if sizes are those of the header."""
        about, extension = (self.layout[f"XLA_FFI_Metadata{own}"] for own in ("", "_Extension"))
        yield from load("%about", "ptr", "%extension", extension["metadata"])
        sizes = {"frame": self.layout["XLA_FFI_CallFrame"], "about": about}
        same = "true"
        for name, own in (sizes | {"extension": extension}).items():
            yield from load(f"%{name}.bytes", "i64", f"%{name}", 0)
            yield f"%{name}.right = icmp eq i64 %{name}.bytes, {own['bytes']}"
            yield f"%{name}.same = and i1 {same}, %{name}.right"
            same = f"%{name}.same"
        major, minor = (version(header(), part) for part in ("MAJOR", "MINOR"))
        yield f"%major = select i1 {same}, i32 {major}, i32 -1"
        yield from self._store("i32 %major", "%about", about["api_version.major_version"])
        yield from self._store(f"i32 {minor}", "%about", about["api_version.minor_version"])
        yield from self._store("i32 0", "%about", about["traits"])
        yield "ret ptr null"

    def _buffers(self) -> Iterator[str]:
        """Fills in a task's words of arrays, and finds how many robots and steps there are."""
        every = self.kernel.arrays
        operands = [own for own in every if not own.result]
        results = [own for own in every if own.result]
        for base, arrays in (("%args", operands), ("%rets", results)):
            for i, own in enumerate(arrays):
                yield from self._buffer(own, base, 8 * i)
        held, first = next(own for own in operands if own.rows), results[0]
        yield f"%steps = add i64 0, %{held.name}.dim1"
        yield f"%robots = add i64 0, %{first.name}.robots"
        many = next((f"%{own.name}.many" for own in results if own.each), "1")
        yield f"%tangents = add i64 0, {many}"
        for own in every:
            yield from self._distances(own)
        for own, (word, kind), place in self.kernel.places():
            yield from self._store(f"{kind} %{own.name}.{word}", "%task", place)

    def _buffer(self, own: Array, base: str, place: int) -> Iterator[str]:
        """What XLA says of an array."""
        buffer, tag = self.layout["XLA_FFI_Buffer"], f"%{own.name}"
        yield from load(f"{tag}.buffer", "ptr", base, place)
        yield from load(f"{tag}.data", "ptr", f"{tag}.buffer", buffer["data"])
        yield from load(f"{tag}.dims", "ptr", f"{tag}.buffer", buffer["dims"])
        yield from load(f"{tag}.rank", "i64", f"{tag}.buffer", buffer["rank"])
        yield from load(f"{tag}.robots", "i64", f"{tag}.dims", 0)
        if own.rows or own.each:
            yield f"""\
{tag}.end = getelementptr i64, ptr {tag}.dims, i64 {tag}.rank
{tag}.final = getelementptr i64, ptr {tag}.end, i64 -1
{tag}.many = load i64, ptr {tag}.final, align 8"""
            yield from load(f"{tag}.dim1", "i64", f"{tag}.dims", 8)

    def _distances(self, own: Array) -> Iterator[str]:
        """How far an array's robots and tangents are apart; not at all where all share one."""
        tag, rows = f"%{own.name}", "%steps" if own.rows else "1"
        yield f"{tag}.whole = mul i64 {rows}, {own.size}"
        if own.each and not own.result:
            yield f"{tag}.shared = icmp eq i64 {tag}.dim1, 1"
            yield f"{tag}.tangent = select i1 {tag}.shared, i64 0, i64 {tag}.whole"
            yield f"{tag}.one = mul i64 {tag}.whole, {tag}.dim1"
        else:
            many = "%tangents" if own.each else "1"
            yield f"{tag}.tangent = add i64 0, 1"
            yield f"{tag}.one = mul i64 {tag}.whole, {many}"
        yield f"{tag}.team = add i64 0, 0"
        yield f"{tag}.alone = icmp eq i64 {tag}.robots, 1"
        yield f"{tag}.robot = select i1 {tag}.alone, i64 0, i64 {tag}.one"

    def _filled(self, struct: str, places: Mapping[str, int], **values: str) -> Iterator[str]:
        """What is in a struct of XLA's."""
        always = {"struct_size": f"i64 {places['bytes']}", "extension_start": "ptr null"}
        for field, value in (always | values).items():
            yield from self._store(value, struct, places[field])

    def _store(self, value: str, base: str, place: int) -> Iterator[str]:
        n = next(self.numbers)
        yield f"%to{n} = getelementptr i8, ptr {base}, i64 {place}"
        yield f"store {value}, ptr %to{n}, align 4"
