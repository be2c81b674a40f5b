"""Functions that read jaxprs must know, and programs made runnable by LLVM and by `cc`."""

import ctypes
import pathlib
import shutil
import subprocess
import tempfile

import jax
import jax.numpy as jnp
import llvmlite.binding as llvm
import numpy as np
import pytest

from scdpr_jax.native.machine import _processor
from scdpr_jax.native.printers.c99 import INCLUDES, c99
from scdpr_jax.native.printers.llvm_ir import llvm_ir
from scdpr_jax.native.scalar.reading import read
from scdpr_jax.native.traced import trace


def switched(x):
    which = jnp.where(x[0] > 0.5, 2, jnp.where(x[0] > 0, 1, 0))
    return jax.lax.switch(which, [jnp.sin, jnp.cos, lambda y: y * y], x)


def branched(x):
    return jax.lax.cond(x[1] > x[0], lambda y: y * 2, lambda y: -jnp.exp(y), x)


def counted(x):
    return jax.lax.fori_loop(0, 5, lambda i, y: jnp.cos(y) * x + y / (1 + i), x)


def scanned(x):
    last, rows = jax.lax.scan(lambda y, row: (y + row, y * row), x[0], x)
    back, more = jax.lax.scan(lambda y, row: (y - row, y), last, x, reverse=True)
    return jnp.concatenate([rows, more, jnp.stack([last, back])])


def indexed(x):
    y = x.at[1].set(2.0).at[jnp.array([0, 2])].add(x[1:])
    return jnp.concatenate([y, x[jnp.array([2, 0])], jax.lax.dynamic_slice(x, (1,), (2,))])


@jax.custom_jvp
def stairs(x):
    return jnp.round(x * 4) / 4


@stairs.defjvp
def _stairs_jvp(primals, tangents):
    return stairs(*primals), 3 * tangents[0] * primals[0]


@jax.custom_jvp
def swelling(x, y):
    return jnp.sin(x) * y


@swelling.defjvp
def _swelling_jvp(primals, tangents):
    # The call makes values and tangents both, and those hang on x's alone.
    (x, y), (along_x, along_y) = primals, tangents
    wave, slope = jax.jvp(jax.jit(jnp.sin), (x,), (along_x,))
    return wave * y, slope * y + wave * along_y


FUNCTIONS = {
    "arithmetic": lambda x: (x[0] + x[1]) * x[2] / (2 + x[1] * x[1]) - x,
    "powers": lambda x: jnp.stack([x[0] ** 3, (2 + x[1]) ** -2, x[2] ** 0, x[0] ** 1]),
    "powers of reals": lambda x: jnp.abs(x) ** (1.5 + x[::-1]),
    "roots": lambda x: jnp.sqrt(1 + x * x) + jax.lax.rsqrt(2 + x),
    "circle": lambda x: jnp.sin(x) * jnp.cos(3 * x) + jnp.tan(x / 2),
    "angles": lambda x: jnp.arctan(4 * x) + jnp.tanh(x),
    "growth": lambda x: jnp.exp(-x * x) + jnp.log(2 + x) + jax.nn.sigmoid(x),
    "limits": lambda x: jnp.maximum(x, x[::-1]) - jnp.minimum(x, 0.25) + jnp.clip(x, -0.5, 0.5),
    "clamped": lambda x: jax.lax.clamp(-0.5, x, 0.5),
    "signs": lambda x: jnp.sign(x) * x + jnp.abs(x),
    "whole": lambda x: jnp.floor(3 * x) + jnp.ceil(3 * x) + jnp.round(3 * x) + x,
    "logic": lambda x: jnp.where((x > 0) & ~(x > 0.5) | (x == 0), x, 2 * x),
    "choices": lambda x: jnp.where(jnp.isfinite(x) ^ (x < 0), x * x, x),
    "conversions": lambda x: (x > 0).astype(float) + (x <= x[1]).astype(int).astype(float) + x,
    "products": lambda x: jnp.outer(x, x) @ jnp.stack([x, x * x], 1) + x[:, None],
    "batches": lambda x: jnp.einsum("ij,ik->kj", jnp.outer(x, x), jnp.outer(x, x) + 1),
    "sums": lambda x: jnp.stack(
        [jnp.sum(x), jnp.max(x), jnp.min(x), jnp.prod(x), jnp.dot(x, x)]
    ),
    "running sums": lambda x: jnp.cumsum(x) + jnp.cumsum(x[::-1])[::-1],
    "moves": lambda x: jnp.concatenate(
        [jnp.flip(x), jnp.pad(x, (1, 2)), jnp.tile(x, 2), jnp.outer(x, x).T.ravel(), x[::2]]
    ),
    "parts": lambda x: jnp.concatenate([y * i for i, y in enumerate(jnp.split(x, 3))]),
    "indices": indexed,
    "branches": branched,
    "switches": switched,
    "counting": counted,
    "scans": scanned,
    "own derivative": lambda x: stairs(x) * x[::-1],
    "own derivative's calls": lambda x: swelling(x, x[::-1]),
    "no derivative": lambda x: jax.lax.stop_gradient(x * x) * x,
    "checkpoints": lambda x: jax.checkpoint(jnp.sin)(x) * x,
}
"""Functions of three numbers between -1 and 1."""


def step_of(function, *arrays):
    """A function as a step that carries nothing."""
    likes = [jax.ShapeDtypeStruct(own.shape, own.dtype) for own in arrays]
    return trace(lambda given, _, __: ((), function(*given)), likes, (), ()).step


def read_function(function, *arrays, chains=False):
    step = step_of(function, *arrays)
    return read(step.closed, step.arguments, [*step.results], chains=chains)


ENGINES = []
"""Machine code lives as long as its engine."""


def by_llvm(program, *, lanes):
    """A program as a function of arrays, robots first; and tangents, where it has them."""
    processor = _processor()
    code = llvm_ir(program, "printed_program", lanes=lanes)
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(code), processor)
    engine.finalize_object()
    ENGINES.append(engine)
    function = engine.get_function_address("printed_program")

    def turned(arrays):
        return [np.ascontiguousarray(np.moveaxis(own, 0, -1)) for own in arrays]

    def back(arrays):
        return [np.moveaxis(own, -1, 0) for own in arrays]

    return _called(program, function, (lanes,), turned, back)


def by_cc(program):
    """A program of one robot by the C compiler."""
    if shutil.which("cc") is None:
        pytest.skip("There is no C compiler.")
    with tempfile.TemporaryDirectory() as folder:
        source, library = pathlib.Path(folder, "printed.c"), pathlib.Path(folder, "printed.so")
        inputs = [f"const double *{own}" for own in program.arguments]
        counted = ["long tangents"] * bool(program.each)
        calling = ", ".join([*inputs, *(f"double *{own}" for own in program.results), *counted])
        names = ", ".join(own.split()[-1].strip("*") for own in calling.split(", "))
        declared = f"void entry({calling});"
        entry = f"{declared}\n{declared[:-1]} {{ printed_program({names}); }}\n"
        printed = c99(program, "printed_program", most_tangents=8)
        source.write_text(INCLUDES + printed + entry)
        # Every warning but those on names that are not used.
        options = ["-std=c99", "-pedantic", "-Wall", "-Werror", "-Wno-unused", "-O1"]
        subprocess.run(
            ["cc", *options, "-shared", "-fPIC", "-o", library, source, "-lm"], check=True
        )
        loaded = ctypes.CDLL(str(library))
    ENGINES.append(loaded)
    address = ctypes.cast(loaded.entry, ctypes.c_void_p).value
    return _called(program, address, (), list, list)


def _called(program, address, lanes, turned, back):
    def run(arrays, tangents=1):
        given = turned([np.array(own, float) for own in arrays])
        made = [
            np.empty((*((tangents,) if name in program.each else ()), size, *lanes))
            for name, size in program.results.items()
        ]
        pointers = [own.ctypes.data_as(ctypes.c_void_p) for own in (*given, *made)]
        kinds = [ctypes.c_void_p] * len(pointers) + [ctypes.c_long]
        ctypes.CFUNCTYPE(None, *kinds)(address)(*pointers, tangents)
        return back(made)

    return run
