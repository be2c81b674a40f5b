"""Machine code of a step: made, or found on disk, and made known to XLA."""

import hashlib
import platform
import sys
import threading
from dataclasses import replace
from typing import NamedTuple

import jax

from scdpr_jax.native.kept import store
from scdpr_jax.native.kept.names import fingerprint
from scdpr_jax.native.kernel import Kernel
from scdpr_jax.native.scalar.differentiation import PREFIX, differentiated
from scdpr_jax.native.scalar.elementary import vectorised
from scdpr_jax.native.scalar.program import Cell, Operation, Program, needed
from scdpr_jax.native.scalar.reading import read
from scdpr_jax.native.scalar.sinking import sunk
from scdpr_jax.native.scalar.tangent_loops import loop_over_tangents
from scdpr_jax.native.traced import Step
from scdpr_jax.native.xla.handler import handler_ir

CHECKED = ("linux", "x86_64")
"""The system and the processor that this was checked on."""


def is_checked() -> bool:
    """Whether machine code was checked on this system.

    Returns:
        Whether it was.
    """
    return (sys.platform, platform.machine()) == CHECKED


class Wanted(NamedTuple):
    """What runs of a step are to bring."""

    moving: tuple[bool, ...]
    """Which of its arguments have tangents; empty if none."""
    values: bool
    """Whether results are wanted besides their derivatives."""


def handler_name(step: Step, wanted: Wanted, *, lanes: int) -> str:
    """A handler that XLA knows, which does a step's runs.

    Args:
        step: The step.
        wanted: What they are to bring.
        lanes: Robots in a vector.

    Returns:
        The handler's name.

    Raises:
        ImportError: If there is no llvmlite.
        NotImplementedError: If a primitive has no rule, or XLA's interface is unknown.
        RuntimeError: If LLVM or XLA refuses the code.
        OSError: If the interface's header is missing.
    """
    about = repr((step.name, wanted, lanes)).encode()
    name = HANDLER + hashlib.sha256(fingerprint() + about).hexdigest()[:40]
    with _one_at_a_time:
        if name not in _handlers:
            _handlers[name] = _registered(name, _emitted(step, wanted, lanes, name))
        return name


def group_address(step: Step, wanted: Wanted, *, lanes: int) -> int:
    """Where a step's machine code for a group of robots begins (`kernel.Kernel.text`).

    Args:
        step: The step.
        wanted: What its runs are to bring.
        lanes: Robots in a vector.

    Returns:
        Address of a function of a task and the group's number.

    Raises:
        ImportError: If there is no llvmlite.
        NotImplementedError: If a primitive has no rule, or XLA's interface is unknown.
        RuntimeError: If LLVM or XLA refuses the code.
        OSError: If the interface's header is missing.
    """
    name = handler_name(step, wanted, lanes=lanes)
    return _handlers[name].get_function_address(f"{name}_group")


HANDLER = "run_"
"""What the name of every handler begins with; forty hexadecimal digits follow."""
_one_at_a_time = threading.Lock()
_handlers: dict[str, object] = {}
"""Engines of the handlers that XLA knows."""


def register_kept(name: str) -> bool:
    """Makes a handler of an earlier process known to XLA, which a kept program calls.

    Args:
        name: The handler's name.

    Returns:
        Whether it is known now; not if its machine code isn't kept any more.

    Raises:
        ImportError: If there is no llvmlite.
        RuntimeError: If LLVM or XLA refuses the code.
    """
    with _one_at_a_time:
        if name not in _handlers:
            code = store.kept(f"{name}.o")
            if code is None:
                return False
            _handlers[name] = _registered(name, code)
        return True


def _emitted(step: Step, wanted: Wanted, lanes: int, name: str) -> bytes:
    import llvmlite.binding as llvm

    code = store.kept(f"{name}.o")
    if code is None:
        text = handler_ir(kernel(step, wanted, name=name, lanes=lanes))
        code = _processor().emit_object(llvm.parse_assembly(text))
        store.keep(f"{name}.o", code)
    return code


def _registered(name: str, code: bytes) -> object:
    """LLVM's engine, as long as which the code lives, which XLA knows from now on."""
    import llvmlite.binding as llvm

    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _processor())
    engine.add_object_file(llvm.ObjectFileRef.from_data(code))
    engine.finalize_object()
    capsule = jax.ffi.pycapsule(engine.get_function_address(f"{name}_handler"))
    jax.ffi.register_ffi_target(name, capsule, platform="cpu")
    return engine


def _processor() -> object:
    """LLVM's code generator for this processor.

    LLVM's optimiser is left out: it takes twice as long as the rest, and what it could do has
    been done.
    """
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(),
        features=llvm.get_host_cpu_features().flatten(),
        opt=2,
        jit=True,
    )


def kernel(step: Step, wanted: Wanted, *, name: str, lanes: int) -> Kernel:
    """A step as a kernel that repeats it.

    Args:
        step: The step.
        wanted: What its runs are to bring.
        name: The step's name in the text.
        lanes: Robots in a vector.

    Returns:
        The kernel.

    Raises:
        NotImplementedError: If a primitive has no rule.
    """
    arguments = step.arguments
    seeds = [own for own, moves in zip(arguments, wanted.moving, strict=False) if moves]
    program = scalar_program(step, seeds, values=wanted.values, vectors=lanes > 1)
    own = {f"next{i}": f"carry{i}" for i in range(step.carried)}
    carried = own | {PREFIX + n: PREFIX + c for n, c in own.items()}
    return Kernel(
        name,
        program,
        carried={n: c for n, c in carried.items() if n in program.results},
        rows=frozenset(
            array
            for array in (*program.arguments, *program.results)
            if array.removeprefix(PREFIX).startswith(("input", "output"))
        ),
        silent=frozenset() if wanted.values else frozenset(step.results),
        lanes=lanes,
    )


def scalar_program(
    step: Step, moving: list[str], *, values: bool = True, vectors: bool
) -> Program:
    """A step as a program.

    Args:
        step: The step.
        moving: Arguments with tangents; derivatives of all results come along.
        values: Whether results are wanted besides their derivatives; if not, only what is
            carried stays.
        vectors: Whether it is for vectors, which have no sine of their own.

    Returns:
        The program.

    Raises:
        NotImplementedError: If a primitive has no rule.
    """
    program = read(step.closed, step.arguments, [*step.results], chains=bool(moving))
    if moving:
        program = differentiated(program, moving)
    if not values:
        program = _without(program, {own for own in step.results if own.startswith("output")})
    program = sunk(replace(program, body=needed(program.body)))
    if vectors:
        program = vectorised(program)
    return loop_over_tangents(program) if moving else program


def _without(program: Program, results: set[str]) -> Program:
    """A program that leaves out some results."""
    body = tuple(
        statement
        for statement in program.body
        if not isinstance(statement, Operation)
        or not isinstance(statement.target, Cell)
        or statement.target.array not in results
    )
    kept = {name: size for name, size in program.results.items() if name not in results}
    return replace(program, results=kept, body=body)
