"""CasADi's generated C on the smoothed nonlinear model, by the classical Runge-Kutta method.

The equations are those of `scdpr_jax.robot.dynamics`, read from their jaxpr and given to CasADi
operation by operation. Friction that turns round over a millimetre a second is stiff while a
carriage rests, and an explicit method has to follow it all the time: its step is the longest
that adds nothing to the error of the smoothing.
"""

import functools
import importlib.util
import operator
import pathlib
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from typing import TYPE_CHECKING

import jax
import numpy as np
from jaxtyping import Float

from experiments.benchmarks.peers.smoothed_robot import begin, slope
from experiments.benchmarks.problem import FREE, LOG, ROWS, TORQUE_STEP
from scdpr_jax.native.scalar.program import Cell, Constant, Operation, Program, Value
from scdpr_jax.native.scalar.reading import read

if TYPE_CHECKING:
    import casadi

PARTS = 50
"""Steps in an interval of the log."""
NAME = f"CasADi's C, RK4 at {PARTS / LOG / 1e3:g} kHz"
_SHAPES = {"state": (10,), "values": (len(FREE),), "voltage": (2,)}


def missing() -> str:
    """What this contender lacks here.

    Returns:
        It; nothing if it can run.
    """
    if importlib.util.find_spec("casadi") is None:
        return "casadi isn't installed, see the extra of that name"
    return "" if shutil.which("cc") else "there is no C compiler, `cc`"


def slope_in_casadi() -> "casadi.Function":
    """The equations of motion for CasADi.

    Returns:
        Its function of state, values and commands.
    """
    import casadi

    like = (jax.ShapeDtypeStruct(shape, np.float64) for shape in _SHAPES.values())
    program = read(jax.make_jaxpr(slope)(*like), _SHAPES, ["slope"])
    given = {name: casadi.SX.sym(name, *shape) for name, shape in _SHAPES.items()}
    made = casadi.vertcat(*_evaluated(program, given))
    return casadi.Function("slope", [*given.values()], [made])


def run(values: Float[np.ndarray, "4"]) -> Float[np.ndarray, "rows 5"]:
    """The problem's run.

    Args:
        values: Values of `experiments.benchmarks.problem.FREE`.

    Returns:
        Positions at the log's instants [m, rad, m, m, m].
    """
    state = np.asarray(begin(values))
    states = np.asarray(_compiled()(np.concatenate([state, values]), TORQUE_STEP.T))
    return np.vstack([state, states[:10].T])[:, :5]


def _evaluated(program: Program, given: "dict[str, casadi.SX]") -> "list[casadi.SX]":
    """A program's results; this one has neither branches nor loops."""
    values: dict[Value, casadi.SX] = {}
    written: dict[int, casadi.SX] = {}

    def of(source: Value | Cell) -> "casadi.SX | float":
        if isinstance(source, Cell):
            return given[source.array][source.number]
        return source.value if isinstance(source, Constant) else values[source]

    for statement in program.body:
        if not isinstance(statement, Operation):
            raise NotImplementedError(f"CasADi is given no control flow, got {statement}.")
        sources = [of(source) for source in statement.sources]
        if isinstance(statement.target, Cell):
            (written[statement.target.number],) = sources
        else:
            values[statement.target] = _operation(statement.name)(*sources)
    return [written[number] for number in sorted(written)]


def _operation(name: str) -> "Callable[..., casadi.SX]":
    """What CasADi calls an operation of a program."""
    import casadi

    plain = {"read": operator.pos, "div": operator.truediv, "select": casadi.if_else}
    return plain.get(name) or getattr(operator, name, None) or getattr(casadi, name)


@functools.cache
def _compiled() -> "casadi.Function":
    """All steps of a run, as machine code: from state and values, and commands in columns."""
    import casadi

    right, duration = slope_in_casadi(), LOG / PARTS
    all_of_it = casadi.SX.sym("all", sum(shape[0] for shape in _SHAPES.values()))
    state, values, voltage = casadi.vertsplit(all_of_it, [0, 10, 14, 16])
    slopes = [right(state, values, voltage)]
    for share in (0.5, 0.5, 1.0):
        slopes.append(right(state + share * duration * slopes[-1], values, voltage))
    one, two, three, four = slopes
    after = state + duration / 6 * (one + 2 * two + 2 * three + four)
    step = casadi.Function("step", [all_of_it], [casadi.vertcat(after, values, voltage)])
    going, commands = casadi.MX.sym("going", 14), casadi.MX.sym("commands", 2)
    interval = casadi.Function(
        "interval",
        [going, commands],
        [step.fold(PARTS)(casadi.vertcat(going, commands))[:14]],
    )
    with tempfile.TemporaryDirectory() as folder:
        source, library = pathlib.Path(folder, "run.c"), pathlib.Path(folder, "run.so")
        code = casadi.CodeGenerator(source.name)
        code.add(interval.mapaccum("run", ROWS))
        code.generate(f"{folder}/")
        flags = ("-O3", "-march=native", "-fPIC", "-shared")
        subprocess.run(["cc", *flags, str(source), "-o", str(library), "-lm"], check=True)
        return casadi.external("run", str(library))
