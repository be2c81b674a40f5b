r"""A run of many steps as JAX primitives: its results, their derivatives, and both in one pass.

Where XLA compiles for a processor, each is a custom call of machine code (`machine`), with
robots in lanes and groups of them on XLA's threads; elsewhere, and where there is no machine
code, it is the ordinary XLA program of the same step.

Whoever pushes tangents gets results and derivatives of one call. Where the results are needed
before the tangents are known, as `linearize` and `grad` need them, and where only one of both
is used, the call is taken apart.

Operands have a leading axis of robots, tangents one of tangents behind it. Either is of length
one where all share the row: nothing is copied for it. `vmap` over tangents alone, as `jacfwd`
has it, lengthens the axis of tangents, any other the one of robots. Derivatives have their
tangents last. Reverse mode by few numbers is forward mode by each of them (`reverse`), that by
many and derivatives of derivatives are XLA's.
"""

import functools
import warnings
from collections.abc import Callable, Sequence
from typing import Any

import jax
import jax.numpy as jnp
from jax.extend.core import JaxprEqn, Primitive, Var, jaxpr_as_fun
from jax.interpreters import ad, batching, mlir, partial_eval

from scdpr_jax.native import machine, reverse
from scdpr_jax.native.traced import Step
from scdpr_jax.numerics.lean_scan import lean_scan

LANES = 8
"""Robots in a vector; a robot alone has code of its own."""

Shapes = list[jax.core.ShapedArray]


def results(operands: Sequence[jax.Array], *, step: Step) -> list[jax.Array]:
    """What a run of steps makes of its operands.

    Args:
        operands: Arguments of the step in float64 behind an axis of robots, its inputs with
            one of steps behind that.
        step: The step.

    Returns:
        What the last step carries on, and outputs, behind the same axes.
    """
    return _results_p.bind(*operands, step=step)


def _longest(arrays: Sequence, axis: int) -> int:
    return max(own.shape[axis] for own in arrays)


def _inputs_from(step: Step) -> int:
    """The first argument with a row for each step."""
    return step.parameters + step.carried


# The ordinary XLA way.


def results_by_xla(*operands: jax.Array, step: Step) -> list[jax.Array]:
    """`results` as an ordinary program of XLA's.

    Args:
        operands: Arguments of the step, as `results` has them.
        step: The step.

    Returns:
        What the last step carries on, and outputs.
    """
    function = jaxpr_as_fun(step.closed)
    kinds = [own.aval.dtype for own in step.closed.jaxpr.invars]

    def one(*own: jax.Array) -> list[jax.Array]:
        given = [x.astype(kind) for x, kind in zip(own, kinds, strict=True)]
        parameters, held = given[: step.parameters], given[_inputs_from(step) :]

        def advance(carry: list, row: list) -> tuple[list, list]:
            made = function(*parameters, *carry, *row)
            return made[: step.carried], made[step.carried :]

        start = given[step.parameters : _inputs_from(step)]
        last, outputs = lean_scan(advance, start, held)
        return [x.astype(jnp.float64) for x in (*last, *outputs)]

    robots = _longest(operands, 0)
    axes = [0 if len(own) == robots else None for own in operands]
    own = [x if axis == 0 else x[0] for x, axis in zip(operands, axes, strict=True)]
    if robots == 1:
        return [x[None] for x in one(*(x[0] for x in own))]
    return jax.vmap(one, axes)(*own)


def _moved(
    given: Sequence, moving: tuple[bool, ...], **static: Step
) -> tuple[Callable[..., list[jax.Array]], tuple[jax.Array, ...]]:
    """Results as a function of what has tangents, and that, for each robot a tangent is for."""
    operands, seeds = given[: len(moving)], given[len(moving) :]
    own = [x for x, moves in zip(operands, moving, strict=True) if moves]
    robots = [max(len(x), seed.aval.shape[0]) for x, seed in zip(own, seeds, strict=True)]

    def function(*moved: jax.Array) -> list[jax.Array]:
        new = iter(moved)
        pairs = zip(operands, moving, strict=True)
        return results_by_xla(*(next(new) if moves else x for x, moves in pairs), **static)

    rows = zip(own, robots, strict=True)
    return function, tuple(jnp.broadcast_to(x, (n, *x.shape[1:])) for x, n in rows)


def _slopes(*given: jax.Array, moving: tuple[bool, ...], **static: Step) -> list[jax.Array]:
    function, own = _moved(given, moving, **static)
    seeds = given[len(moving) :]
    shapes = [(len(x), _longest(seeds, 1), *x.shape[1:]) for x in own]
    seeds = [jnp.broadcast_to(x, shape) for x, shape in zip(seeds, shapes, strict=True)]
    return jax.vmap(lambda *along: jax.jvp(function, own, along)[1], 1, -1)(*seeds)


def both_by_xla(*given: jax.Array, moving: tuple[bool, ...], **static: Step) -> list[jax.Array]:
    """Results and derivatives as an ordinary program of XLA's.

    Args:
        given: Arguments of the step, then tangents of those that move.
        moving: Which move.
        static: The step.

    Returns:
        Results, then their derivatives, which have tangents last.
    """
    values = results_by_xla(*given[: len(moving)], **static)
    return [*values, *_slopes(*given, moving=moving, **static)]


# The printed way.


def _lowered(
    by_xla: Callable,
    values: bool,
    ctx: mlir.LoweringRuleContext,
    *given: object,
    step: Step,
    moving: tuple[bool, ...] = (),
) -> object:
    lanes = LANES if _longest(ctx.avals_in, 0) > 1 else 1
    wanted = machine.Wanted(moving, values)
    name = _handler_name(step, wanted, lanes) if machine.is_checked() else None
    if name:
        return jax.ffi.ffi_lowering(name)(ctx, *given)
    static = {"moving": moving, "step": step} if moving else {"step": step}
    own = functools.partial(by_xla, **static)
    return mlir.lower_fun(own, multiple_results=True)(ctx, *given)


@functools.cache
def _handler_name(step: Step, wanted: machine.Wanted, lanes: int) -> str | None:
    """Name of a handler; none if there can't be one, which is said once."""
    try:
        return machine.handler_name(step, wanted, lanes=lanes)
    except (ImportError, NotImplementedError, OSError, KeyError, RuntimeError) as reason:
        warnings.warn(
            f"A step runs as an XLA program, ten to fifty times slower: {reason!s:.500}",
            RuntimeWarning,
            stacklevel=2,
        )
        return None


# The primitives.


def _merged(arrays: Sequence, axes: Sequence, size: int, at: int) -> list[jax.Array]:
    """Arrays with a mapped axis put into another one; what all share stays of length one."""
    pairs = zip(arrays, axes, strict=True)
    wide = [jnp.expand_dims(x, at) if i is None else jnp.moveaxis(x, i, at) for x, i in pairs]
    inner, merged = _longest(wide, at + 1), []
    for x in wide:
        both = (1, 1) if x.shape[at : at + 2] == (1, 1) else (size, inner)
        full = jnp.broadcast_to(x, x.shape[:at] + both + x.shape[at + 2 :])
        merged.append(full.reshape(*x.shape[:at], both[0] * both[1], *x.shape[at + 2 :]))
    return merged


def _batched(
    own: Primitive, given: Sequence, axes: Sequence, **static: object
) -> tuple[list[jax.Array], list[int | None]]:
    count = len(static.get("moving", given))
    pairs = zip(given, axes, strict=True)
    size = next(x.shape[axis] for x, axis in pairs if axis is not None)
    if any(axis is not None for axis in axes[:count]):
        found = own.bind(*_merged(given, axes, size, 0), **static)
        return [x.reshape(size, len(x) // size, *x.shape[1:]) for x in found], [0] * len(found)
    seeds = _merged(given[count:], axes[count:], size, 1)
    found = own.bind(*given[:count], *seeds, **static)
    values, slopes = _parted(found) if own is _both_p else ([], found)
    split = [x.reshape(*x.shape[:-1], size, x.shape[-1] // size) for x in slopes]
    return [*values, *split], [None] * len(values) + [x.ndim - 1 for x in slopes]


def _parted(results: Sequence) -> tuple[Sequence, Sequence]:
    """Results, and their derivatives."""
    half = len(results) // 2
    return results[:half], results[half:]


def _pushed(primals: Sequence, tangents: Sequence, *, step: Step) -> tuple[list, list]:
    tangents = list(tangents)
    for i in range(step.parameters, _inputs_from(step)):
        tangents[i] = ad.instantiate_zeros(tangents[i])  # The next step's aren't zero.
    moving = tuple(not isinstance(own, ad.Zero) for own in tangents)
    seeds = [own[:, None] for own, moves in zip(tangents, moving, strict=True) if moves]
    values, slopes = _parted(_both_p.bind(*primals, *seeds, moving=moving, step=step))
    # A sum over one keeps mapped axes where they are; an index would move them to the front.
    return values, [jnp.sum(own, -1) for own in slopes]


def _pushed_again(
    by_xla: Callable, primals: Sequence, tangents: Sequence, **static: object
) -> tuple:
    along = tuple(ad.instantiate_zeros(own) for own in tangents)
    return jax.jvp(functools.partial(by_xla, **static), tuple(primals), along)


def _partly_known(
    trace: Any,
    *tracers: partial_eval.JaxprTracer,
    moving: tuple[bool, ...],
    step: Step,
) -> list:
    """Results now and derivatives later, where only the tangents aren't known yet."""
    operands = tracers[: len(moving)]
    static = {"moving": moving, "step": step}
    if not all(own.is_known() for own in operands):
        return trace.default_process_primitive(_both_p, tracers, static)
    values = _results_p.bind(*(own.pval.get_known() for own in operands), step=step)
    return [*values, *trace.default_process_primitive(_slopes_p, tracers, static)]


def _partly_kept(
    _: Any, unknown: Sequence[bool], there: Sequence[bool], equation: JaxprEqn
) -> tuple:
    """The same in a jaxpr of which a part is done now; all of it is done again later."""
    count = len(equation.outvars)
    late = [own for own, is_there in zip(equation.invars, there, strict=True) if not is_there]
    again = [own for own in late if isinstance(own, Var)]
    if any(unknown[: len(equation.params["moving"])]):
        return None, equation, [True] * count, [True] * count, again
    if not any(unknown):
        return equation, equation, [False] * count, [True] * count, again
    values, slopes = _parted([False] * count)
    _, alone = _partly_used([True] * len(values) + [False] * len(slopes), equation)
    kept = [*values, *(not own for own in slopes)]
    return alone, equation, kept, [True] * count, again


def _partly_used(
    used: Sequence[bool], equation: JaxprEqn
) -> tuple[list[bool], JaxprEqn | None]:
    """Results alone, derivatives alone, or both."""
    count, given = len(equation.params["moving"]), equation.invars
    values, slopes = _parted(equation.outvars)
    by_value, by_slope = map(any, _parted(used))
    if not (by_value or by_slope):
        return [False] * len(given), None
    if by_value and by_slope:
        return [True] * len(given), equation
    if by_slope:
        return [True] * len(given), equation.replace(primitive=_slopes_p, outvars=slopes)
    only = {"step": equation.params["step"]}
    alone = equation.replace(
        primitive=_results_p, invars=given[:count], outvars=values, params=only
    )
    return [i < count for i in range(len(given))], alone


@functools.partial(jax.jit, static_argnames=("wanted", "moving", "step"))
def _by_few(
    operands: Sequence[jax.Array],
    cotangents: Sequence[jax.Array],
    *,
    wanted: reverse.Shapes,
    moving: tuple[bool, ...],
    step: Step,
) -> list[jax.Array | None]:
    """Reverse mode by few numbers, one program where it isn't part of one."""
    shapes = [own.shape[1:] for own, moves in zip(operands, moving, strict=True) if moves]

    def slopes(along: Sequence[jax.Array]) -> list[jax.Array]:
        return _slopes_p.bind(*operands, *along, moving=moving, step=step)

    return reverse.contracted(slopes, shapes, cotangents, wanted=wanted)


def _pulled(
    cotangents: Sequence, *given: object, moving: tuple[bool, ...], **static: Step
) -> list:
    operands, seeds = given[: len(moving)], given[len(moving) :]
    cotangents = [ad.instantiate_zeros(own) for own in cotangents]
    wanted = reverse.wanted(seeds)
    if wanted is None:
        function, own = _moved(given, moving, **static)
        found = jax.vmap(jax.vjp(function, *own)[1], -1, 1)(cotangents)
    else:
        found = _by_few(operands, cotangents, wanted=wanted, moving=moving, **static)
    pulled: list = [None] * len(moving)
    for x, seed in zip(found, seeds, strict=True):
        wanted = ad.is_undefined_primal(seed)
        pulled.append(reverse.summed(x, seed.aval.shape) if wanted else None)
    return pulled


def _results_like(*given: jax.core.ShapedArray, step: Step) -> Shapes:
    robots, rows = _longest(given, 0), {own.shape[1] for own in given[_inputs_from(step) :]}
    if len(rows) != 1 or {own.shape[0] for own in given} - {1, robots}:
        raise ValueError(
            f"Arrays of a run differ in length [rows]: {[own.shape for own in given]}. Give "
            "all inputs as many rows as there are steps."
        )
    shapes = [*step.results.values()]
    long = [(robots, *own) for own in shapes[: step.carried]]
    long += [(robots, *rows, *own) for own in shapes[step.carried :]]
    return [given[0].update(shape=shape, weak_type=False) for shape in long]


def _slopes_like(*given: jax.core.ShapedArray, moving: tuple[bool, ...], step: Step) -> Shapes:
    values = _results_like(*given[: len(moving)], step=step)
    seeds = given[len(moving) :]
    robots, tangents = _longest(given, 0), _longest(seeds, 1)
    return [own.update(shape=(robots, *own.shape[1:], tangents)) for own in values]


def _both_like(*given: jax.core.ShapedArray, moving: tuple[bool, ...], step: Step) -> Shapes:
    values = _results_like(*given[: len(moving)], step=step)
    return [*values, *_slopes_like(*given, moving=moving, step=step)]


@functools.cache
def _compiled(own: Primitive, static: tuple) -> Callable:
    return jax.jit(functools.partial(own.bind, **dict(static)))


def _primitive(name: str, like: Callable, by_xla: Callable, *, values: bool) -> Primitive:
    own = Primitive(name)
    own.multiple_results = True
    own.def_impl(lambda *given, **static: _compiled(own, (*static.items(),))(*given))
    own.def_abstract_eval(like)
    ad.primitive_jvps[own] = functools.partial(_pushed_again, by_xla)
    batching.primitive_batchers[own] = functools.partial(_batched, own)
    mlir.register_lowering(own, mlir.lower_fun(by_xla, multiple_results=True))
    mlir.register_lowering(own, functools.partial(_lowered, by_xla, values), platform="cpu")
    return own


_results_p = _primitive("native_run", _results_like, results_by_xla, values=True)
ad.primitive_jvps[_results_p] = _pushed
_slopes_p = _primitive("native_run_slopes", _slopes_like, _slopes, values=False)
ad.primitive_transposes[_slopes_p] = _pulled
_both_p = _primitive("native_run_with_slopes", _both_like, both_by_xla, values=True)
partial_eval.custom_partial_eval_rules[_both_p] = _partly_known
partial_eval.partial_eval_jaxpr_custom_rules[_both_p] = _partly_kept
# JAX 0.12 tells between what is used and the equation which of its inputs are alive.
partial_eval.dce_rules[_both_p] = lambda used, *rest: _partly_used(used, rest[-1])
