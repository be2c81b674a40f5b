"""What JAX's primitives do to arrays of values: most of them only move numbers.

An array is a NumPy array of values while a jaxpr is read, so that slicing and stacking cost
nothing and leave nothing.
"""

import functools
import itertools
from collections.abc import Callable, Iterable, Mapping

import jax
import numpy as np

from scdpr_jax.native.scalar.program import Cell, Constant, Value
from scdpr_jax.native.scalar.rules import RULES
from scdpr_jax.native.scalar.scope import FALSE, TRUE, ZERO, Scope, constant

Arrays = np.ndarray | list[np.ndarray]


def array(values: Iterable[Value | Cell], shape: tuple[int, ...]) -> np.ndarray:
    """Values in a shape.

    Args:
        values: As many values as the shape has.
        shape: The shape.

    Returns:
        An array of objects.
    """
    own = [*values]
    made = np.empty(len(own), object)
    made[:] = own
    return made.reshape(shape)


def constants(numbers: jax.typing.ArrayLike) -> np.ndarray:
    """Known numbers as values.

    Args:
        numbers: The numbers, or truth values.

    Returns:
        An array of constants.
    """
    numbers = np.asarray(numbers)
    return array((constant(number.item()) for number in numbers.flat), numbers.shape)


def _broadcast(_: Scope, x: np.ndarray, *, shape, broadcast_dimensions, **__: object):
    full = [1] * len(shape)
    for axis, size in zip(broadcast_dimensions, x.shape, strict=True):
        full[axis] = size
    return np.broadcast_to(x.reshape(full), shape)


def _sliced(_: Scope, x: np.ndarray, *, start_indices, limit_indices, strides) -> np.ndarray:
    steps = strides or [None] * x.ndim
    return x[tuple(map(slice, start_indices, limit_indices, steps))]


def _unstacked(_: Scope, x: np.ndarray, *, axis: int) -> list[np.ndarray]:
    return [np.asarray(row, object) for row in np.moveaxis(x, axis, 0)]


def _split(_: Scope, x: np.ndarray, *, sizes, axis) -> list[np.ndarray]:
    return np.split(x, [*itertools.accumulate(sizes)][:-1], axis)


def _padded(_: Scope, x: np.ndarray, value: np.ndarray, *, padding_config) -> np.ndarray:
    if any(low < 0 or high < 0 for low, high, _ in padding_config):
        raise NotImplementedError("`pad` that cuts away. Take a slice.")
    shape = tuple(
        int(low + high + max(0, size + between * (size - 1)))
        for size, (low, high, between) in zip(x.shape, padding_config, strict=True)
    )
    made = np.full(shape, value.item(), object)
    made[
        tuple(
            slice(low, low + size + between * (size - 1), between + 1)
            for size, (low, _, between) in zip(x.shape, padding_config, strict=True)
        )
    ] = x
    return made


def _moved_by_jax(
    primitive: jax.extend.core.Primitive, data: tuple[int, ...], scope: Scope, *operands, **how
) -> np.ndarray:
    """What a primitive moves by indices that are known: JAX moves the numbers of the numbers.

    `data` are the operands that hold numbers; the others are indices.
    """
    del scope
    values = np.concatenate([operands[i].ravel() for i in data])
    first, given = 0, []
    for i, x in enumerate(operands):
        if i in data:
            given.append(np.arange(first, first + x.size, dtype=float).reshape(x.shape))
            first += x.size
            continue
        given.append(_known(x, primitive.name))
    with jax.ensure_compile_time_eval():
        places = np.asarray(primitive.bind(*given, **how))
    # Where an index is outside, JAX fills with NaN.
    filled = np.append(values, Constant(float("nan")))
    return filled[np.where(np.isnan(places), values.size, places).astype(int)]


def _scattered_sum(
    scope: Scope, x: np.ndarray, place: np.ndarray, new: np.ndarray, **how: object
) -> np.ndarray:
    """An array with something added to some of it. JAX says where each number goes."""
    places, total = _known(place, "scatter-add"), x.copy()
    for i, value in enumerate(new.flat):
        only = np.zeros(new.size)
        only[i] = 1.0
        given = np.zeros(x.shape), places, only.reshape(new.shape)
        with jax.ensure_compile_time_eval():
            marks = np.asarray(jax.lax.scatter_add_p.bind(*given, **how))
        for k in np.flatnonzero(marks):
            total.flat[k] = scope.apply("add", total.flat[k], value)
    return total


def _known(indices: np.ndarray, name: str) -> np.ndarray:
    """Indices as integers."""
    if not all(isinstance(value, Constant) for value in indices.flat):
        raise NotImplementedError(
            f"`{name}` by indices that are computed. Select by comparisons."
        )
    return np.array([int(value.value) for value in indices.flat]).reshape(indices.shape)


def _elementwise(scope: Scope, name: str, *operands: np.ndarray) -> np.ndarray:
    rule = functools.partial(RULES[name], scope)
    return np.asarray(np.frompyfunc(rule, len(operands), 1)(*operands), object)


def _reduced(
    name: str, start: Constant | None, scope: Scope, x: np.ndarray, *, axes, **_: object
) -> np.ndarray:
    """An operation over all numbers along axes."""
    kept = [axis for axis in range(x.ndim) if axis not in axes]
    rows = x.transpose(*kept, *axes).reshape(*(x.shape[axis] for axis in kept), -1)
    if not rows.shape[-1] and start is None:
        raise NotImplementedError(f"`{name}` over nothing.")
    total = rows[..., 0] if rows.shape[-1] else np.full(rows.shape[:-1], start, object)
    for i in range(1, rows.shape[-1]):
        total = _elementwise(scope, name, total, rows[..., i])
    return np.asarray(total, object)


def _summed_up(scope: Scope, x: np.ndarray, *, axis: int, reverse: bool) -> np.ndarray:
    rows = [np.asarray(row, object) for row in np.moveaxis(x, axis, 0)[:: -1 if reverse else 1]]
    total = list(itertools.accumulate(rows, functools.partial(_elementwise, scope, "add")))
    return np.moveaxis(np.stack(total)[:: -1 if reverse else 1], 0, axis)


def _product(scope: Scope, x: np.ndarray, y: np.ndarray, *, dimension_numbers, **_: object):
    """A general product of matrices: over the contracted axes, for each place of the shared."""
    (over_x, over_y), (with_x, with_y) = dimension_numbers
    letters = iter("abcdefghijklmnopqrstuvwxyz")
    names_x = [next(letters) for _ in range(x.ndim)]
    names_y = [next(letters) for _ in range(y.ndim)]
    for own, other in zip((*over_x, *with_x), (*over_y, *with_y), strict=True):
        names_y[other] = names_x[own]
    shared = [names_x[i] for i in with_x]
    summed = [names_x[i] for i in over_x]
    free = [n for n in names_x + names_y if n not in shared + summed]
    order = shared + list(dict.fromkeys(free))

    def spread(own: np.ndarray, names: list[str]) -> np.ndarray:
        every = order + summed
        moved = own.transpose([names.index(n) for n in every if n in names])
        return moved[tuple(slice(None) if n in names else None for n in every)]

    terms = _elementwise(scope, "mul", spread(x, names_x), spread(y, names_y))
    axes = tuple(range(len(order), len(order) + len(summed)))
    return _reduced("add", ZERO, scope, terms, axes=axes)


ARRAYS: Mapping[str, Callable[..., Arrays]] = {
    "broadcast_in_dim": _broadcast,
    "concatenate": lambda _, *x, dimension: np.concatenate(x, dimension),
    "cumsum": _summed_up,
    "dot_general": _product,
    "expand_dims": lambda _, x, *, dimensions: np.expand_dims(x, dimensions),
    "dynamic_slice": functools.partial(_moved_by_jax, jax.lax.dynamic_slice_p, (0,)),
    "dynamic_update_slice": functools.partial(
        _moved_by_jax, jax.lax.dynamic_update_slice_p, (0, 1)
    ),
    "gather": functools.partial(_moved_by_jax, jax.lax.gather_p, (0,)),
    "iota": lambda _, *, shape, dimension, **__: constants(np.indices(shape)[dimension]),
    "pad": _padded,
    "reduce_and": functools.partial(_reduced, "and", TRUE),
    "reduce_max": functools.partial(_reduced, "max", None),
    "reduce_min": functools.partial(_reduced, "min", None),
    "reduce_or": functools.partial(_reduced, "or", FALSE),
    "reduce_prod": functools.partial(_reduced, "mul", Constant(1.0)),
    "reduce_sum": functools.partial(_reduced, "add", ZERO),
    "reshape": lambda _, x, *, new_sizes, **__: x.reshape(new_sizes),
    "rev": lambda _, x, *, dimensions: np.flip(x, dimensions),
    "scatter": functools.partial(_moved_by_jax, jax.lax.scatter_p, (0, 2)),
    "scatter-add": _scattered_sum,
    "slice": _sliced,
    "split": _split,
    "squeeze": lambda _, x, *, dimensions: np.squeeze(x, dimensions),
    "stack": lambda _, *x, axis: np.stack(x, axis),
    "tile": lambda _, x, *, reps: np.tile(x, reps),
    "transpose": lambda _, x, *, permutation: x.transpose(permutation),
    "unstack": _unstacked,
}
"""What primitives do to whole arrays."""
