"""Runs of a step between NumPy's arrays: no program is compiled, whatever their shapes.

A search outside of JAX has runs of another length, or another number of tangents, each time.
As part of a program of XLA's each would be compiled anew; a step's machine code holds for all.
"""

import ctypes
import functools
import itertools
from collections.abc import Callable, Hashable, Sequence
from typing import Any, Generic, NamedTuple

import jax
import numpy as np
from jaxtyping import Int, PyTree

from scdpr_jax.native import machine, primitive
from scdpr_jax.native.kept.traces import kept_trace
from scdpr_jax.native.kernel import TASK
from scdpr_jax.native.running import Carry, Inputs, Outputs, Parameters
from scdpr_jax.native.traced import Step, StepFunction, Traced


class Slopes(NamedTuple):
    """Tangents of a run, or what they come to."""

    carried: PyTree
    """Of what is carried: into the first step, or from the last one on."""
    rows: PyTree
    """Of the inputs, or of the outputs."""


class Runs(Generic[Parameters, Carry, Inputs, Outputs]):
    """Runs of a step with the same parameters."""

    def __init__(
        self,
        step: Callable[[Parameters, Carry, Inputs], tuple[Carry, Outputs]],
        parameters: Parameters,
    ):
        """Nothing is traced until it runs.

        Args:
            step: The step, a function that lasts.
            parameters: What is the same in all steps, as NumPy's arrays behind an axis of
                robots; of length one where all share it, here and below.
        """
        self._step = step
        leaves, self._structure = jax.tree.flatten(parameters)
        self._parameters = [np.ascontiguousarray(leaf, float) for leaf in leaves]
        # They stay where they are, so that only what is new is looked up in each call.
        self._words = [word for own in self._parameters for word in _own_words(own)]
        self._traced: dict[Hashable, tuple[Step, jax.tree_util.PyTreeDef]] = {}
        self._robots = max(map(len, self._parameters), default=1)

    def __call__(self, start: Carry, inputs: Inputs) -> tuple[Carry, Outputs]:
        """What `scdpr_jax.native.run` does.

        Args:
            start: What is carried into the first step, behind an axis of robots.
            inputs: Inputs of the steps, behind axes of robots and of steps.

        Returns:
            What the last step carries on and the outputs, likewise.
        """
        held = self.held(start, inputs)
        held()
        return held.results

    def linearised(
        self,
        start: Carry,
        inputs: Inputs,
        *,
        along: Slopes,
        begun: Int[np.ndarray, " steps"] | None = None,
    ) -> tuple[tuple[Carry, Outputs], Slopes]:
        """The same with derivatives along tangents.

        Args:
            start: What is carried into the first step.
            inputs: Inputs of the steps.
            along: Tangents of both, behind axes of robots and of tangents; None in place of an
                input that doesn't move. What is carried all has some.
            begun: How many of the tangents, the first ones, move anything by the end of each
                step, in which the others cost nothing; None for all.

        Returns:
            Results, and derivatives, which have an axis of tangents last.
        """
        held = self.held(start, inputs, along=along, begun=begun)
        held()
        return held.results, held.slopes

    def held(
        self,
        start: Carry,
        inputs: Inputs,
        *,
        along: Slopes | None = None,
        begun: Int[np.ndarray, " steps"] | None = None,
    ) -> "Held[Carry, Outputs]":
        """A run that can be made again and again, of whatever its arrays hold by then.

        Args:
            start: As in `linearised`, here and below. Arrays of whole float64 rows are read
                where they are in every run; others are copied now.
            inputs: Inputs of the steps.
            along: Tangents; None for no derivatives.
            begun: How many of them have begun.

        Returns:
            The run, not made yet.
        """
        step, structure, operands = self._given(start, inputs)
        leaves = jax.tree.leaves(tuple(along or ()), is_leaf=lambda own: own is None)
        moving = tuple(own is not None for own in [None] * step.parameters + leaves)
        seeds = [np.ascontiguousarray(own, float) for own in leaves if own is not None]
        room = self._results(step, operands, seeds)
        arrays = _Arrays(self._parameters, operands, seeds, begun, *room)
        made = jax.tree.unflatten(structure, arrays.results)
        slopes = Slopes(*jax.tree.unflatten(structure, arrays.slopes)) if along else None
        return Held(made, slopes, self._made(step, moving if along else (), arrays))

    def _results(
        self, step: Step, operands: Sequence[np.ndarray], seeds: Sequence[np.ndarray]
    ) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Room for results, and for derivatives if there are tangents."""
        robots = max(self._robots, *map(len, (*operands, *seeds)))
        steps = operands[-1].shape[1]
        shapes = [
            (robots, steps, *own) if name.startswith("output") else (robots, *own)
            for name, own in step.results.items()
        ]
        tangents = max((own.shape[1] for own in seeds), default=0)
        # Derivatives along tangents that haven't begun stay zero.
        slopes = [np.zeros((*own, tangents)) for own in shapes] if seeds else []
        return [np.empty(own) for own in shapes], slopes

    def _given(
        self, start: Carry, inputs: Inputs
    ) -> tuple[Step, jax.tree_util.PyTreeDef, Sequence[np.ndarray]]:
        """The step for such arrays, the structure of its results, and these arrays."""
        carried, first = jax.tree.flatten(start)
        rows, second = jax.tree.flatten(inputs)
        held = [np.ascontiguousarray(leaf, float) for leaf in carried]
        told = [np.ascontiguousarray(leaf, float) for leaf in rows]
        shapes = (*[own.shape[1:] for own in held], *[own.shape[2:] for own in told])
        kind = (first, second, shapes)
        if kind not in self._traced:
            given = tuple(own.shape[1:] for own in self._parameters)
            structures = (self._structure, first, second)
            traced = _traced(self._step, structures, given + shapes)
            if traced.constants:
                raise ValueError(
                    f"the step {self._step.__name__} closes over {len(traced.constants)} "
                    "arrays, expected none. Give it what it needs through its parameters."
                )
            self._traced[kind] = traced.step, jax.tree.structure(traced.outputs)
        return *self._traced[kind], held + told

    def _made(
        self, step: Step, moving: tuple[bool, ...], arrays: "_Arrays"
    ) -> Callable[[], None]:
        """What fills the arrays of results."""
        robots = len(arrays.results[0])
        lanes = primitive.LANES if robots > 1 else 1
        code = _code(step, moving, lanes) if machine.is_checked() else None
        if code is not None:
            return code.run(self._words, arrays)

        def by_xla() -> None:
            every = [*arrays.parameters, *arrays.operands]
            made = _by_xla(every, arrays.seeds, step=step, moving=moving)
            for own, other in zip((*arrays.results, *arrays.slopes), made, strict=True):
                own[...] = other

        return by_xla


class Held(Generic[Carry, Outputs]):
    """A run with its arrays."""

    def __init__(
        self,
        results: tuple[Carry, Outputs],
        slopes: Slopes | None,
        run: Callable[[], None],
    ):
        """Made by `Runs.held`.

        Args:
            results: What the last step carries on and the outputs, of the last call.
            slopes: Their derivatives; None without tangents.
            run: What computes both.
        """
        self.results, self.slopes, self._run = results, slopes, run

    def __call__(self) -> None:
        """Make the run: `results` and `slopes` are overwritten."""
        self._run()


class _Arrays(NamedTuple):
    """Arrays of a run, which are there as long as it is."""

    parameters: Sequence[np.ndarray]
    operands: Sequence[np.ndarray]
    seeds: Sequence[np.ndarray]
    begun: np.ndarray | None
    results: Sequence[np.ndarray]
    slopes: Sequence[np.ndarray]


@functools.cache
def _traced(
    step: StepFunction,
    structures: tuple[jax.tree_util.PyTreeDef, ...],
    shapes: tuple[tuple[int, ...], ...],
) -> Traced:
    likes = iter([jax.ShapeDtypeStruct(shape, np.float64) for shape in shapes])
    return kept_trace(
        step,
        *(
            jax.tree.unflatten(own, list(itertools.islice(likes, own.num_leaves)))
            for own in structures
        ),
    )


@functools.partial(jax.jit, static_argnames=("step", "moving"))
def _by_xla(
    operands: Sequence[jax.Array],
    seeds: Sequence[jax.Array],
    *,
    step: Step,
    moving: tuple[bool, ...],
) -> list[jax.Array]:
    if not moving:
        return primitive.results_by_xla(*operands, step=step)
    return primitive.both_by_xla(*operands, *seeds, step=step, moving=moving)


@functools.cache
def _code(step: Step, moving: tuple[bool, ...], lanes: int) -> "_Code":
    return _Code(step, moving, lanes)


class _Code:
    """A kernel's group of robots as a function of memory."""

    def __init__(self, step: Step, moving: tuple[bool, ...], lanes: int):
        self.lanes = lanes
        self.group: Callable[[Any, int], None] = ctypes.CFUNCTYPE(
            None, ctypes.c_void_p, ctypes.c_long
        )(machine.group_address(step, machine.Wanted(moving, values=True), lanes=lanes))

    def run(self, parameters: list[int], arrays: _Arrays) -> Callable[[], None]:
        """A run of these arrays, wherever they are.

        Args:
            parameters: Words of the parameters.
            arrays: The arrays.

        Returns:
            What makes it.
        """
        first, rows = arrays.results[0], arrays.operands[-1]
        groups = -(-len(first) // self.lanes)
        tangents = arrays.slopes[0].shape[-1] if arrays.slopes else 1
        words = {"last": len(first) - 1, "steps": rows.shape[1]}
        words |= {"tangents": tangents, "groups": groups}
        begun = arrays.begun
        if begun is not None:
            begun = np.ascontiguousarray(begun, np.int64)
            words["begun"] = _place(begun)
        numbers = [words.get(word, 0) for word in TASK] + parameters
        for own in arrays.operands:
            numbers += _own_words(own)
        for own in arrays.seeds:
            numbers += _seed_words(own)
        for own in itertools.chain(arrays.results, arrays.slopes):
            numbers += _own_words(own)
        task = np.array(numbers, np.int64)
        return functools.partial(self._run, _place(task), groups, (arrays, begun, task))

    def _run(self, task: int, groups: int, _: object) -> None:
        """The last argument is the memory that the task is of."""
        for group in range(groups):
            self.group(task, group)


_BYTES = 8
"""Of a number."""


def _place(own: np.ndarray) -> int:
    return own.__array_interface__["data"][0]


def _own_words(own: np.ndarray) -> tuple[int, int, int]:
    """Where an array is, and how far apart its robots are; tangents, if any, come last."""
    return _place(own), 0 if own.shape[0] == 1 else own.strides[0] // _BYTES, 1


def _seed_words(own: np.ndarray) -> tuple[int, int, int]:
    """The same of tangents, which are behind the robots."""
    tangent = 0 if own.shape[1] == 1 else own.strides[1] // _BYTES
    return _place(own), 0 if own.shape[0] == 1 else own.strides[0] // _BYTES, tangent
