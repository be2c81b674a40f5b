"""The equations of a plan as C99, printed from the functions that Python plans with.

Arguments are flat arrays there: a robot is the numbers of `jax.tree.leaves`, in their order.
"""

import dataclasses
import functools
import hashlib
from collections.abc import Callable, Iterator
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array

from scdpr_jax.command.controller import PD, PDState
from scdpr_jax.engines.led_stepping import Lead, Undriven, step, whole_position
from scdpr_jax.native.kept import store
from scdpr_jax.native.kept.names import sources
from scdpr_jax.native.machine import fingerprint, scalar_program
from scdpr_jax.native.printers.c99 import INCLUDES, c99
from scdpr_jax.native.traced import trace
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import State
from tuning.plan.expectation import Loop, Told, sample
from tuning.plan.feedforward import inverse_dynamics, stretch
from tuning.plan.led.arrival import Goal, arrival, vibration
from tuning.plan.led.servo import (
    Deviation,
    Led,
    Servo,
    Transition,
    deviating_step,
    led_force,
    transition,
)
from tuning.plan.leg import MOST_SPLINES
from tuning.plan.profile import Course, Moment, plain_profile, splines


@dataclasses.dataclass(frozen=True)
class Kernel:
    """A function that is printed."""

    name: str
    """Its name in C; with tangents `_along` is behind that."""
    function: Callable[..., Any]
    """From tuples of flat arrays, parameters, carried and inputs, to carried and outputs."""
    parameters: tuple[int, ...]
    """Numbers in each parameter."""
    carried: tuple[int, ...]
    """Numbers in each array that is carried on."""
    inputs: tuple[int, ...]
    """Numbers in each input."""
    moving: tuple[str, ...] = ()
    """Arguments that have tangents; none for a function without derivatives."""

    def text(self) -> Iterator[str]:
        """The function in C99, and the one with tangents."""
        likes = [
            tuple(jax.ShapeDtypeStruct((size,), np.float64) for size in sizes)
            for sizes in (self.parameters, self.carried, self.inputs)
        ]
        traced = trace(self.function, *likes).step
        kinds = [(self.name, [])]
        if self.moving:
            kinds.append((f"{self.name}_along", [*self.moving]))
        for name, moving in kinds:
            program = scalar_program(traced, moving, vectors=False)
            yield c99(program, name, most_tangents=MOST_SPLINES)


def kernels_text(robot: Robot) -> str:
    """Every function that a plan on board needs; printed once for all robots of one make.

    Args:
        robot: A robot like the one that is planned for.

    Returns:
        C99.
    """
    about = str(jax.tree.structure(robot)).encode()
    depends = fingerprint() + sources("tuning") + about
    file = f"c99_{hashlib.sha256(depends).hexdigest()[:40]}"
    text = store.kept(file)
    if text is None:
        parts = (part for own in kernels(robot) for part in own.text())
        text = (INCLUDES + "\n".join(parts)).encode()
        store.keep(file, text)
    return text.decode()


def kernels(robot: Robot) -> tuple[Kernel, ...]:
    """The functions.

    Args:
        robot: A robot like the one that is planned for.

    Returns:
        The functions that are printed.
    """
    leaves, structure = jax.tree.flatten(robot)
    count = len(leaves)

    def own(numbers: Array) -> Robot:
        return jax.tree.unflatten(structure, list(jnp.unstack(numbers)))

    # A function of this module's for each, bound to what a robot is made of.
    bound = {
        function: functools.partial(function, own)
        for function in (_lead, _deviate, _command, _stretch, _force, _arrive, _vibrate, _loop)
    }
    return (
        Kernel("plain_at", _plain, (7,), (), (1,)),
        Kernel("splines_at", _splines, (2,), (), (1,)),
        Kernel("servo_over", _servo, (3,), (), (1,)),
        Kernel("lead", bound[_lead], (count, 1), (6,), (3, 3), ("carry0", "input0")),
        Kernel(
            "deviate",
            bound[_deviate],
            (count, 1, 3, 3, 3, 3, 3),
            (6, 2),
            (3, 3, 1, 1),
            ("carry0", "carry1", "input0", "input3"),
        ),
        Kernel("command", bound[_command], (count,), (), (3, 6), ("input0", "input1")),
        Kernel("force", bound[_force], (count,), (), (3, 2, 1), ("input0", "input1")),
        Kernel("stretch", bound[_stretch], (count,), (), (3, 6)),
        Kernel("arrive", bound[_arrive], (count,), (), (6, 3), ("input0", "input1")),
        Kernel("vibrate", bound[_vibrate], (count,), (), (6, 3)),
        Kernel("loop", bound[_loop], (count, 4, 2), (10, 4), (2, 2)),
    )


_Own = Callable[[Array], Robot]
"""A robot from its numbers."""


def _plain(given: tuple, _: tuple, row: tuple) -> tuple[tuple, Array]:
    (numbers,), (time,) = given, row
    course = Course(numbers[:2], numbers[2:4], numbers[4:6], numbers[6])
    return (), jnp.concatenate(plain_profile(course, time[0]))


def _splines(given: tuple, _: tuple, row: tuple) -> tuple[tuple, Array]:
    (numbers,), (time,) = given, row
    first, active = splines(time[0], numbers[0], numbers[1])
    return (), jnp.concatenate([first[None], *active])


def _servo(given: tuple, _: tuple, row: tuple) -> tuple[tuple, tuple[Array, Array]]:
    (numbers,), (time,) = given, row
    return (), transition(Servo(*jnp.unstack(numbers)), time[0])


def _undriven(numbers: Array) -> Undriven:
    return Undriven(numbers[:3], numbers[3:])


def _lead(own: _Own, given: tuple, carry: tuple, row: tuple) -> tuple[tuple, tuple]:
    robot, duration = given
    made = step(own(robot), _undriven(carry[0]), Lead(*row), duration[0])
    return (jnp.concatenate(made),), ()


def _deviate(own: _Own, given: tuple, carry: tuple, row: tuple) -> tuple[tuple, tuple]:
    robot, duration, servo, *moved = given
    parameters = (
        own(robot),
        duration[0],
        Servo(*jnp.unstack(servo)),
        (Transition(*moved[:2]), Transition(*moved[2:])),
    )
    state, deviation = _undriven(carry[0]), Deviation(*jnp.unstack(carry[1]))
    lower, height, velocity, force = row
    led = Led(Lead(lower, height), velocity[0], force[0])
    (state, deviation), _ = deviating_step(parameters, (state, deviation), led)
    return (jnp.concatenate(state), jnp.stack(deviation)), ()


def _command(own: _Own, given: tuple, _: tuple, row: tuple) -> tuple[tuple, Array]:
    position, motion = row
    whole = whole_position(position, motion[0], motion[1])
    return (), inverse_dynamics(own(given[0]), whole, motion[2:4], motion[4:])


def _stretch(own: _Own, given: tuple, _: tuple, row: tuple) -> tuple[tuple, Array]:
    position, motion = row
    whole = whole_position(position, motion[0], motion[1])
    moment = Moment(motion[:2], motion[2:4], motion[4:])
    return (), stretch(own(given[0]), whole, moment)[None]


def _force(own: _Own, given: tuple, _: tuple, row: tuple) -> tuple[tuple, Array]:
    position, place, velocity = row
    whole = whole_position(position, place[0], place[1])
    return (), led_force(own(given[0]), whole, velocity[0])[0][None]


def _arrive(own: _Own, given: tuple, _: tuple, row: tuple) -> tuple[tuple, Array]:
    state, goal = row
    made = arrival(own(given[0]), _undriven(state), Goal(*jnp.unstack(goal)))
    return (), jnp.concatenate([made.vibration, made.sliding[None], made.rest[None]])


def _vibrate(own: _Own, given: tuple, _: tuple, row: tuple) -> tuple[tuple, Array]:
    state, goal = row
    return (), vibration(own(given[0]), _undriven(state), Goal(*jnp.unstack(goal)))[None]


def _loop(own: _Own, given: tuple, carry: tuple, row: tuple) -> tuple[tuple, tuple]:
    robot, gains, begin = given
    state = State(carry[0][:5], carry[0][5:])
    memory = PDState(carry[1][:2], carry[1][2:])
    loop = Loop(own(robot), PD(*jnp.unstack(gains)), begin)
    (state, memory), _ = sample(loop, (state, memory), Told(*row))
    return (
        jnp.concatenate([state.position, state.velocity]),
        jnp.concatenate([memory.error, memory.derivative]),
    ), ()
