"""Runs of a step between NumPy's arrays: no program is compiled, whatever their shapes.

A search outside of JAX has runs of another length, or another number of tangents, each time.
As part of a program of XLA's each would be compiled anew; a step's machine code holds for all.
"""

import ctypes
import functools
import itertools
import math
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
        *,
        teams: bool = False,
    ):
        """Nothing is traced until it runs.

        Args:
            step: The step, a function that lasts.
            parameters: What is the same in all steps, as NumPy's arrays behind an axis of
                robots; of length one where all share it, here and below.
            teams: Whether every array has an axis of teams in front of that of robots.
        """
        self._step, self._ahead = step, 2 if teams else 1
        leaves, self._structure = jax.tree.flatten(parameters)
        self._parameters = [np.ascontiguousarray(leaf, float) for leaf in leaves]
        # They stay where they are, so that only what is new is looked up in each call.
        words = [word for own in self._parameters for word in _own_words(own, self._ahead)]
        self._words = np.array(words, np.int64)
        self._robots = _most(self._parameters, self._ahead)
        self._traced: dict[Hashable, tuple[Step, jax.tree_util.PyTreeDef]] = {}

    def __call__(self, start: Carry, inputs: Inputs) -> tuple[Carry, Outputs]:
        """What `scdpr_jax.native.run` does.

        Args:
            start: What is carried into the first step, behind an axis of robots.
            inputs: Inputs of the steps, behind axes of robots and of steps.

        Returns:
            What the last step carries on and the outputs, likewise.
        """
        step, structure, operands = self._given(start, inputs)
        return jax.tree.unflatten(structure, self._made(step, operands, (), (), None))

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
        step, structure, operands = self._given(start, inputs)
        leaves = jax.tree.leaves(tuple(along), is_leaf=lambda own: own is None)
        seeds = [None] * step.parameters + leaves
        moving = tuple(seed is not None for seed in seeds)
        given = [np.ascontiguousarray(seed, float) for seed in seeds if seed is not None]
        made = self._made(step, operands, moving, given, begun)
        count = len(made) // 2
        values, slopes = (
            jax.tree.unflatten(structure, own) for own in (made[:count], made[count:])
        )
        return values, Slopes(*slopes)

    def _given(
        self, start: Carry, inputs: Inputs
    ) -> tuple[Step, jax.tree_util.PyTreeDef, Sequence[np.ndarray]]:
        """The step for such arrays, the structure of its results, and these arrays."""
        carried, first = jax.tree.flatten(start)
        rows, second = jax.tree.flatten(inputs)
        held = [np.ascontiguousarray(leaf, float) for leaf in carried]
        told = [np.ascontiguousarray(leaf, float) for leaf in rows]
        ahead = self._ahead
        shapes = (
            *[own.shape[ahead:] for own in held],
            *[own.shape[ahead + 1 :] for own in told],
        )
        kind = (first, second, shapes)
        if kind not in self._traced:
            given = tuple(own.shape[ahead:] for own in self._parameters)
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
        self,
        step: Step,
        operands: Sequence[np.ndarray],
        moving: tuple[bool, ...],
        seeds: Sequence[np.ndarray],
        begun: np.ndarray | None,
    ) -> list[np.ndarray]:
        """Results, and derivatives where there are tangents."""
        own = _most((*operands, *seeds), self._ahead)
        robots = tuple(map(max, self._robots, own))
        lanes = primitive.LANES if math.prod(robots) > 1 else 1
        code = _code(step, moving, lanes) if machine.is_checked() else None
        if code is None:
            given = [_in_line(own, robots) for own in (*self._parameters, *operands)]
            along = [_in_line(own, robots) for own in seeds]
            made = _by_xla(given, along, step=step, moving=moving)
            return [np.asarray(own).reshape(*robots, *own.shape[1:]) for own in made]
        return code(self._words, robots, operands, seeds, begun)


def _most(arrays: Sequence[np.ndarray], ahead: int) -> tuple[int, ...]:
    """The longest axes of teams and robots, or of robots alone."""
    return tuple(max([own.shape[axis] for own in arrays], default=1) for axis in range(ahead))


def _in_line(own: np.ndarray, robots: tuple[int, ...]) -> np.ndarray:
    """An array behind a single axis of robots, those of each team in turn."""
    ahead = len(robots)
    shared = all(size == 1 for size in own.shape[:ahead])
    full = own if shared else np.broadcast_to(own, (*robots, *own.shape[ahead:]))
    return full.reshape(-1, *own.shape[ahead:])


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
        # Shapes of the results, and which of them have a row for each step.
        self.results = [(n.startswith("output"), s) for n, s in step.results.items()]
        self.lanes = lanes
        self.group: Callable[[Any, int], None] = ctypes.CFUNCTYPE(
            None, ctypes.c_void_p, ctypes.c_long
        )(machine.group_address(step, machine.Wanted(moving, values=True), lanes=lanes))

    def __call__(
        self,
        parameters: np.ndarray,
        robots: tuple[int, ...],
        operands: Sequence[np.ndarray],
        seeds: Sequence[np.ndarray],
        begun: np.ndarray | None,
    ) -> list[np.ndarray]:
        ahead, many = len(robots), math.prod(robots)
        steps = operands[-1].shape[ahead]
        tangents = max((own.shape[ahead] for own in seeds), default=1)
        results = [
            np.empty((*robots, steps, *shape) if rows else (*robots, *shape))
            for rows, shape in self.results
        ]
        slopes = [np.zeros((*own.shape, tangents)) for own in results] if seeds else []
        groups = -(-many // self.lanes)
        words = {
            "last": many - 1,
            "team": robots[-1],
            "steps": steps,
            "tangents": tangents,
            "groups": groups,
        }
        if begun is not None:
            begun = np.ascontiguousarray(begun, np.int64)
            words["begun"] = _place(begun)
        numbers: list[int] = []
        for own in operands:
            numbers += _own_words(own, ahead)
        for own in seeds:
            numbers += _seed_words(own, ahead)
        for own in itertools.chain(results, slopes):
            numbers += _own_words(own, ahead)
        head = [words.get(word, 0) for word in TASK]
        task = np.concatenate([head, parameters, numbers], dtype=np.int64)
        place = _place(task)
        for group in range(groups):
            self.group(place, group)
        return [*results, *slopes]


_BYTES = 8
"""Of a number."""


def _place(own: np.ndarray) -> int:
    return own.__array_interface__["data"][0]


def _apart(own: np.ndarray, axis: int) -> int:
    """How far neighbours along an axis are apart; not at all where all share one."""
    return 0 if own.shape[axis] == 1 else own.strides[axis] // _BYTES


def _own_words(own: np.ndarray, ahead: int) -> tuple[int, int, int, int]:
    """Where an array is, and how far its teams and robots are apart; tangents come last."""
    team = _apart(own, 0) if ahead == 2 else 0
    return _place(own), team, _apart(own, ahead - 1), 1


def _seed_words(own: np.ndarray, ahead: int) -> tuple[int, int, int, int]:
    """The same of tangents, which are behind the robots."""
    return *_own_words(own, ahead)[:3], _apart(own, ahead)
