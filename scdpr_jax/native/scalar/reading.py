"""A jaxpr read as a program of scalar operations.

What XLA compiles is a graph of arrays; here a jaxpr is taken apart into the numbers in them,
with the control flow that is in it: a `cond` becomes an `If`, a `scan` a `Loop`. A `cond` that
not all lanes need go one way does both, and each number is selected, as `jax.vmap` has it.
"""

import functools
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import jax
import numpy as np
from jax.extend.core import ClosedJaxpr, Jaxpr, JaxprEqn, Literal, Var, jaxpr_as_fun

from scdpr_jax.native.scalar.arrays import ARRAYS, array, constants
from scdpr_jax.native.scalar.program import Cell, Constant, Program, Value
from scdpr_jax.native.scalar.rules import RULES, chained
from scdpr_jax.native.scalar.scope import ONE, ZERO, Scope

MOST_TURNS = 64
"""Turns of a `scan` with rows of its own that are written out; code grows with them."""


def read(
    closed: ClosedJaxpr,
    arguments: Mapping[str, tuple[int, ...]],
    results: Sequence[str],
    *,
    chains: bool = False,
) -> Program:
    """A jaxpr as a program.

    Args:
        closed: The jaxpr; what it closes over is constant.
        arguments: Names of its arguments, with their shapes.
        results: Names of its results.
        chains: Whether some values are `chained`, as the program is differentiated later.

    Returns:
        The program.

    Raises:
        NotImplementedError: If there is a primitive without a rule.
    """
    scope = Scope(chains=chains)
    inputs = [
        array(_put_in(scope, name, shape, own.aval.dtype == bool), shape)
        for (name, shape), own in zip(arguments.items(), closed.jaxpr.invars, strict=True)
    ]
    outputs = _evaluated(scope, closed, inputs)
    for name, made in zip(results, outputs, strict=True):
        for i, value in enumerate(made.flat):
            number = scope.apply("select", value, ONE, ZERO) if value.boolean else value
            scope.write(Cell(name, i), number)
    return Program(
        {name: int(np.prod(shape)) for name, shape in arguments.items()},
        {name: made.size for name, made in zip(results, outputs, strict=True)},
        scope.block,
    )


def _put_in(scope: Scope, name: str, shape: tuple[int, ...], boolean: bool) -> Iterable[Value]:
    """An argument's numbers; a truth value is the number 0 or 1 in the caller's array."""
    for i in range(int(np.prod(shape))):
        number = scope.read(Cell(name, i))
        yield scope.apply("ne", number, ZERO) if boolean else number


def _evaluated(
    scope: Scope, closed: ClosedJaxpr, inputs: Sequence[np.ndarray]
) -> list[np.ndarray]:
    """What a jaxpr makes of arrays of values."""
    values = _begun(closed, inputs)
    for equation in closed.jaxpr.eqns:
        _evaluate(scope, equation, values)
    return [_of(atom, values) for atom in closed.jaxpr.outvars]


_Values = dict[object, np.ndarray]
"""Arrays of values by the variables of a jaxpr."""


def _begun(closed: ClosedJaxpr, inputs: Sequence[np.ndarray]) -> _Values:
    """What is known of a jaxpr before its equations."""
    values = dict(zip(closed.jaxpr.constvars, map(constants, closed.consts), strict=True))
    return values | dict(zip(closed.jaxpr.invars, inputs, strict=False))


def _evaluate(scope: Scope, equation: JaxprEqn, values: _Values) -> None:
    results = _results(scope, equation, [_of(atom, values) for atom in equation.invars])
    values.update(zip(equation.outvars, results, strict=True))


def _of(atom: object, values: _Values) -> np.ndarray:
    return constants(atom.val) if isinstance(atom, Literal) else values[atom]


def _results(scope: Scope, equation: JaxprEqn, inputs: list[np.ndarray]) -> list[np.ndarray]:
    params = equation.params
    match equation.primitive.name:
        case "jit" | "pjit" | "closed_call":
            inner = params["jaxpr"] if "jaxpr" in params else params["call_jaxpr"]
            return _evaluated(scope, inner, inputs)
        case "checkpoint" | "remat2":
            return _evaluated(scope, closed_jaxpr(params["jaxpr"]), inputs)
        case "custom_jvp_call":
            return _with_own_derivative(scope, equation, inputs)
        case "cond":
            return _branched(scope, inputs, params["branches"])
        case "scan":
            return _repeated(scope, inputs, _scan_counts(params), params)
        case name if name in ARRAYS:
            made = ARRAYS[name](scope, *inputs, **params)
            return made if isinstance(made, list) else [made]
        case name if name in RULES and not _is_of_integers(equation):
            rule = functools.partial(RULES[name], scope, **_without_accuracy(params))
            return [np.asarray(np.frompyfunc(rule, len(inputs), 1)(*inputs), object)]
        case name:
            raise NotImplementedError(
                f"There is no rule for `{name}`, in: {equation}. Give it one in "
                "`scdpr_jax.native.scalar.rules`, or write the step without it."
            )


def _without_accuracy(params: Mapping[str, object]) -> dict[str, object]:
    """Parameters of a primitive without those that ask for more or less exact results."""
    return {name: own for name, own in params.items() if name != "accuracy"}


def _is_of_integers(equation: JaxprEqn) -> bool:
    """Whether a primitive makes integers in a way that reals don't know."""
    given, made = (
        {np.dtype(atom.aval.dtype).kind for atom in atoms}
        for atoms in (equation.invars, equation.outvars)
    )
    own = equation.primitive.name in ("and", "div", "not", "or", "xor") or "f" in given
    return own and not made.isdisjoint("iu") and equation.primitive.name != "select_n"


def _with_own_derivative(
    scope: Scope, equation: JaxprEqn, inputs: list[np.ndarray]
) -> list[np.ndarray]:
    """What a function with a derivative of its own makes, with the slopes by all inputs.

    JAX traces the derivative. What of it holds along any tangent is read once, the rest once
    for each number that comes in, as far as a tangent along that reaches.
    """
    values = _evaluated(scope, equation.params["call_jaxpr"], inputs)
    if not scope.chains:
        return values
    if not is_real(equation):
        raise NotImplementedError(f"A `custom_jvp` of other than reals, in: {equation}.")
    pairs = zip(equation.invars, inputs, strict=True)
    given = {atom: x for atom, x in pairs if not isinstance(atom, Literal)}
    slopes = derivative(equation)
    chains: list[list[list]] = [[[] for _ in own.flat] for own in values]
    with scope.without_chains():
        along_unit = _linear(scope, slopes, [*given.values()])
    for i, x in enumerate(given.values()):
        for k, source in enumerate(x.flat):
            along = [_still(own) for own in given.values()]
            along[i].flat[k] = ONE
            with scope.without_chains():
                rows = along_unit(along)
            for row, chain in zip(rows, chains, strict=True):
                for slope, own in zip(row.flat, chain, strict=True):
                    own.append((source, slope))
    return [
        array(map(functools.partial(_chained, scope), made.flat, chain), made.shape)
        for made, chain in zip(values, chains, strict=True)
    ]


def _linear(
    scope: Scope, slopes: ClosedJaxpr, at: Sequence[np.ndarray]
) -> Callable[[Sequence[np.ndarray]], list[np.ndarray]]:
    """Tangents of results by those of inputs; all that hangs on no tangent is read at once."""
    values = _begun(slopes, at)
    tangents = slopes.jaxpr.invars[len(at) :]
    moved, linear = set(tangents), []
    for equation in slopes.jaxpr.eqns:
        sources = [own for own in _variables(equation) if own in moved]
        if sources:
            moved.update(equation.outvars)
            linear.append((equation, sources))
        else:
            _evaluate(scope, equation, values)

    def push(along: Sequence[np.ndarray]) -> list[np.ndarray]:
        own = values | dict(zip(tangents, along, strict=True))
        for equation, sources in linear:
            if any(x != ZERO for source in sources for x in own[source].flat):
                _evaluate(scope, equation, own)
            else:
                own.update((out, _still(out.aval)) for out in equation.outvars)
        return [_of(atom, own) for atom in slopes.jaxpr.outvars]

    return push


def _still(like: jax.core.ShapedArray) -> np.ndarray:
    """No tangents."""
    return array([ZERO] * like.size, like.shape)


def _variables(equation: JaxprEqn) -> list[Var]:
    """What an equation takes that isn't a literal, each once."""
    return [*dict.fromkeys(own for own in equation.invars if not isinstance(own, Literal))]


def _chained(scope: Scope, value: Value, slopes: list[tuple[Value, Value]]) -> Value:
    return chained(
        scope, value, *((source, slope) for source, slope in slopes if slope != ZERO)
    )


def is_real(equation: JaxprEqn) -> bool:
    """Whether all numbers that come into an equation are real.

    Args:
        equation: The equation.

    Returns:
        Whether it is so.
    """
    kinds = (atom.aval.dtype for atom in equation.invars)
    return all(np.issubdtype(kind, np.floating) for kind in kinds)


def derivative(equation: JaxprEqn) -> ClosedJaxpr:
    """The derivative of a single equation of reals.

    Args:
        equation: The equation.

    Returns:
        The tangents of its results, from its inputs that aren't literals and tangents along
        them; each of its equations that takes a tangent is linear in all that it takes of
        these, and makes nothing else.
    """
    inputs = _variables(equation)
    empty = jax.make_jaxpr(lambda: ())().jaxpr
    alone = empty.replace(invars=inputs, outvars=equation.outvars, eqns=[equation])
    function = jaxpr_as_fun(ClosedJaxpr(alone, ()))
    like = tuple(jax.ShapeDtypeStruct(own.aval.shape, own.aval.dtype) for own in inputs)
    return jax.make_jaxpr(lambda at, along: jax.linearize(function, *at)[1](*along))(like, like)


def _branched(
    scope: Scope, inputs: list[np.ndarray], branches: Sequence[ClosedJaxpr]
) -> list[np.ndarray]:
    index, *given = inputs
    which = index.item()
    if isinstance(which, Constant):
        return _evaluated(
            scope, branches[min(max(int(which.value), 0), len(branches) - 1)], given
        )
    condition = which if which.boolean else scope.apply("ne", which, ZERO)
    if len(branches) == 2 and scope.origin(condition)[0] == "any":
        return _together(scope, condition, given, branches)
    made = [_evaluated(scope, branch, given) for branch in branches]
    rule = functools.partial(RULES["select_n"], scope, which)
    return [
        np.asarray(np.frompyfunc(rule, len(made), 1)(*own), object)
        for own in zip(*made, strict=True)
    ]


def _together(
    scope: Scope, condition: Value, given: list[np.ndarray], branches: Sequence[ClosedJaxpr]
) -> list[np.ndarray]:
    """One of two branches, the same in all lanes."""
    cells = [_cells(scope, own) for own in branches[0].out_avals]
    inner = Scope(scope), Scope(scope)
    for own, branch in zip(inner, branches, strict=True):
        _write(own, cells, _evaluated(own, branch, given))
    scope.branch(condition, inner[1], inner[0])
    return _read(scope, cells)


def closed_jaxpr(jaxpr: Jaxpr | ClosedJaxpr) -> ClosedJaxpr:
    """A jaxpr of an equation that closes over nothing.

    Args:
        jaxpr: The jaxpr, open as JAX 0.10 has it or closed as JAX 0.12.

    Returns:
        It closed.
    """
    return jaxpr if isinstance(jaxpr, ClosedJaxpr) else ClosedJaxpr(jaxpr, ())


def _scan_counts(params: Mapping[str, Any]) -> tuple[int, int]:
    """How many constants and how many carried arrays come into a `scan`."""
    if "num_carry" in params:
        return params["num_consts"], params["num_carry"]
    constants_, carried, _ = params["ft_in"].unpack()  # From JAX 0.12 on.
    return len(constants_), len(carried)


def _repeated(
    scope: Scope,
    inputs: list[np.ndarray],
    counts: tuple[int, int],
    params: Mapping[str, Any],
) -> list[np.ndarray]:
    num_consts, num_carry = counts
    jaxpr, length = closed_jaxpr(params["jaxpr"]), params["length"]
    carried, rows = num_consts + num_carry, inputs[num_consts + num_carry :]
    counted = [Constant(float(turn)) for turn in range(length)]
    written = len(jaxpr.out_avals) > num_carry or any([*own.flat] != counted for own in rows)
    if length == 1 or params["reverse"] or written:
        return _written_out(scope, inputs, jaxpr, length, counts, reverse=params["reverse"])
    cells = [_cells(scope, own) for own in jaxpr.out_avals]
    _write(scope, cells, inputs[num_consts:carried])
    inner = Scope(scope)
    counter = inner.variable()
    turn = [array([counter], ()) for _ in rows]
    given = [*inputs[:num_consts], *_read(inner, cells), *turn]
    _write(inner, cells, _evaluated(inner, jaxpr, given))
    scope.loop(counter, length, inner)
    return _read(scope, cells)


def _written_out(
    scope: Scope,
    inputs: list[np.ndarray],
    jaxpr: ClosedJaxpr,
    length: int,
    counts: tuple[int, int],
    *,
    reverse: bool,
) -> list[np.ndarray]:
    """A `scan` turn by turn."""
    num_consts, num_carry = counts
    if length > MOST_TURNS:
        raise NotImplementedError(
            f"A `scan` with rows or outputs of its own over {length} turns, more than "
            f"{MOST_TURNS}: its code would be as long."
        )
    carry = inputs[num_consts : num_consts + num_carry]
    outputs: list[list[np.ndarray]] = []
    for turn in range(length)[:: -1 if reverse else 1]:
        row = [np.asarray(own[turn], object) for own in inputs[num_consts + num_carry :]]
        made = _evaluated(scope, jaxpr, [*inputs[:num_consts], *carry, *row])
        carry = made[:num_carry]
        outputs.append(made[num_carry:])
    columns = zip(*outputs[:: -1 if reverse else 1], strict=True)
    return [*carry, *(np.stack(column) for column in columns)]


def _cells(scope: Scope, like: jax.core.ShapedArray) -> np.ndarray:
    size, boolean = int(np.prod(like.shape)), like.dtype == bool
    return array((scope.cell(boolean=boolean) for _ in range(size)), like.shape)


def _read(scope: Scope, cells: list[np.ndarray]) -> list[np.ndarray]:
    return [array(map(scope.read, own.flat), own.shape) for own in cells]


def _write(scope: Scope, cells: list[np.ndarray], values: list[np.ndarray]) -> None:
    for own, given in zip(cells, values, strict=True):
        for cell, value in zip(own.flat, given.flat, strict=True):
            scope.write(cell, value)
