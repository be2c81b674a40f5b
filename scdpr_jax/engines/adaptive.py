r"""The adaptive solvers, for smooth friction laws: the only caller of diffrax.

`scdpr_jax.engines.stepping` has exact friction and a fixed cost; these solvers take any smooth
law (`SmoothCoulomb`) and any accuracy, and are what the fixed grid is held
against. A narrow law makes the problem stiff, yet the explicit `diffrax.Tsit5()` stays
ahead of `diffrax.Kvaerno5()` down to a width of 1e-5 m/s, where both take as long.

Derivatives: the default adjoint is for reverse mode (`jax.grad`, `jax.vjp`); for forward
mode (`jax.jvp`, `jax.jacfwd`) pass `Adaptive(adjoint=diffrax.ForwardMode())`. Explicit solvers
of loose tolerance have wrong derivatives on stiff friction, without a word: see
`docs/validity.md`. `smooth_sensitivities` solves for the derivatives as it does for the
motion, and has right ones on stiff friction too.
"""

from collections.abc import Callable
from typing import Any, NamedTuple, TypeVar

import diffrax
import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float, Int

from scdpr_jax import native
from scdpr_jax.command.controller import Controller
from scdpr_jax.command.sensors import Encoder
from scdpr_jax.engines.arguments import check_finite, check_shape, check_start
from scdpr_jax.engines.closed_loop import ClosedLoop, sampled_loop
from scdpr_jax.engines.stepping import Inputs
from scdpr_jax.robot.drive import motor_torque
from scdpr_jax.robot.dynamics import accelerations
from scdpr_jax.robot.fields import concrete, refuse, si
from scdpr_jax.robot.friction import Coulomb
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.state import State

_Inputs = Callable[[Float[Array, ""]], tuple[Float[Array, "2"], Float[Array, ""]]]
"""Commands [V] and knock [N] as a function of time."""

_X = TypeVar("_X")
_Field = Callable[[Float[Array, ""], _X, None], _X]
"""The time derivative of something that is solved for."""


class Adaptive(eqx.Module):
    """An adaptive solver and its options."""

    solver: diffrax.AbstractSolver = diffrax.Tsit5()
    """The solver."""
    rtol: float | Float[Array, ""] = eqx.field(default=1e-7, metadata=si("1"))
    """Relative tolerance of a step [1]."""
    atol: float | Float[Array, ""] = eqx.field(default=1e-9, metadata=si("SI"))
    """Absolute tolerance of a step [m, rad, m/s, rad/s]."""
    max_steps: int = eqx.field(default=100_000, static=True)
    """Most steps of a solve."""
    adjoint: diffrax.AbstractAdjoint = diffrax.RecursiveCheckpointAdjoint()
    """How a solve is differentiated."""

    @property
    def step_control(self) -> diffrax.PIDController:
        """How the steps are chosen."""
        return diffrax.PIDController(rtol=self.rtol, atol=self.atol)


def simulate_smooth(
    robot: Robot,
    start: State,
    *,
    voltage: Float[Array, "intervals 2"],
    times: Float[Array, " intervals+1"],
    knock: Float[Array, " intervals"] | None = None,
    save_at: Float[Array, " saved"],
    method: Adaptive | None = None,
) -> State:
    """Trajectory of the robot with smooth friction, by an adaptive solver.

    The solver steps exactly to the instants where a held input changes, and nowhere else:
    a grid of many equal inputs costs nothing.

    Args:
        robot: The robot, with smooth friction laws on both carriages.
        start: State at the first time.
        voltage: Commands to the two drives, held in the intervals of a time grid [V].
        times: Ends of these intervals, ascending, one more than intervals [s].
        knock: Horizontal force on the end-effector in the intervals [N]; `None` for none.
        save_at: Times of the wanted states, ascending and within the grid [s].
        method: The solver and its options, `Adaptive()` by default.

    Returns:
        States at the wanted times.

    Raises:
        TypeError: If a carriage has exact `Coulomb` friction.
        ValueError: If a shape is another, times go back, or a number isn't finite.
        RuntimeError: If the solver gives up; under `equinox.filter_jit` too, while plain
            `jax.jit` wraps the same message in an error of its own.
    """
    _require_smooth(robot)
    check_start(robot, start)
    method = Adaptive() if method is None else method
    solution = _solve(
        lambda inputs: _equations(robot, inputs),
        start,
        voltage=voltage,
        times=times,
        knock=knock,
        save_at=save_at,
        method=method,
    )
    return _unless_given_up(solution, method)


class Sensitivities(NamedTuple):
    """A trajectory with smooth friction and its derivatives by the robot's unknowns."""

    states: State
    """States at the wanted times."""
    derivatives: State
    """Their derivatives, an axis of the unknowns after that of the times."""
    steps: Int[Array, ""]
    """Steps that the solver tried."""


def smooth_sensitivities(
    robot_of: Callable[[Float[Array, " unknowns"]], Robot],
    start: State,
    *,
    unknowns: Float[Array, " unknowns"],
    voltage: Float[Array, "intervals 2"],
    times: Float[Array, " intervals+1"],
    knock: Float[Array, " intervals"] | None = None,
    save_at: Float[Array, " saved"],
    method: Adaptive | None = None,
) -> Sensitivities:
    r"""Trajectory of the robot with smooth friction, and what its unknowns do to it.

    The variational equations of $\dot x = f(x, p)$ are solved beside the motion, and the
    steps are chosen for both:

    $$ \dot s_k = \frac{\partial f}{\partial x} s_k + \frac{\partial f}{\partial p_k},
       \qquad s_k = \frac{\partial x}{\partial p_k} $$

    Derivatives through the steps of `simulate_smooth` have no such control.

    Reference: E. Hairer, S. P. Nørsett, G. Wanner, "Solving Ordinary Differential Equations
    I", 2nd ed., 1993, section I.14, doi:10.1007/978-3-540-78862-1.

    Args:
        robot_of: The robot of some unknowns, with smooth friction laws on both carriages.
        start: State at the first time, which doesn't depend on the unknowns.
        unknowns: Where the derivatives are wanted [in the units of `robot_of`].
        voltage: Commands to the two drives, held in the intervals of a time grid [V].
        times: Ends of these intervals, ascending, one more than intervals [s].
        knock: Horizontal force on the end-effector in the intervals [N]; `None` for none.
        save_at: Times of the wanted states, ascending and within the grid [s].
        method: The solver and its options, `Adaptive()` by default; its tolerances are those of
            the derivatives, too.

    Returns:
        States at the wanted times, their derivatives, and the number of steps.

    Raises:
        TypeError: If a carriage has exact `Coulomb` friction.
        RuntimeError: If the solver gives up; under `equinox.filter_jit` too, while plain
            `jax.jit` wraps the same message in an error of its own.
    """
    _require_smooth(robot_of(unknowns))
    method = Adaptive() if method is None else method
    directions = jnp.eye(unknowns.size, dtype=unknowns.dtype)

    def variational(inputs: _Inputs) -> _Field[tuple[State, State]]:
        def field(
            time: Float[Array, ""], both: tuple[State, State], _: None
        ) -> tuple[State, State]:
            state, derivatives = both

            def motion(at: State, of: Float[Array, " unknowns"]) -> State:
                return _equations(robot_of(of), inputs)(time, at, None)

            slope, along = jax.linearize(motion, state, unknowns)
            return slope, jax.vmap(along)(derivatives, directions)

        return field

    fixed = jax.tree.map(lambda x: jnp.zeros((unknowns.size, *x.shape), x.dtype), start)
    solution = _solve(
        variational,
        (start, fixed),
        voltage=voltage,
        times=times,
        knock=knock,
        save_at=save_at,
        method=method,
    )
    states, derivatives = _unless_given_up(solution, method)
    return Sensitivities(states, derivatives, solution.stats["num_steps"])


def simulate_closed_loop(
    robot: Robot,
    start: State,
    controller: Controller,
    *,
    reference: Float[Array, "samples 2"],
    knock: Float[Array, " samples-1"] | None = None,
    encoder: Encoder | None = None,
    delay_samples: int = 0,
    method: Adaptive | None = None,
) -> ClosedLoop:
    """The robot with smooth friction under a sampled controller, by an adaptive solver.

    One solve for each sample period; `scdpr_jax.engines.closed_loop` does the same with exact
    friction on the fixed grid.

    Args:
        robot: The robot, with smooth friction laws on both carriages.
        start: State at the first sample.
        controller: The controller, run at its own period.
        reference: Commanded end-effector positions $[x_e, y_e]$ at the samples [m]; the
            encoders show zero at the start, and the controller takes it for the first one.
        knock: Horizontal force on the end-effector, held between the samples [N].
        encoder: Encoders that the angles are read by; `None` for exact angles.
        delay_samples: Whole periods by which a command comes late; 0 V until the first.
        method: The solver and its options in each period, `Adaptive(max_steps=1_000)` by
            default.

    Returns:
        States at the samples and commands between them.

    Raises:
        TypeError: If a carriage has exact `Coulomb` friction.
        ValueError: If the delay is negative.
        RuntimeError: If the solver gives up; under `equinox.filter_jit` too, while plain
            `jax.jit` wraps the same message in an error of its own.
    """
    _require_smooth(robot)
    method = Adaptive(max_steps=1_000) if method is None else method

    def advance(robot: Robot, state: State, inputs: Inputs) -> State:
        solution = diffrax.diffeqsolve(
            diffrax.ODETerm(_equations(robot, lambda _: (inputs.voltage, inputs.knock))),
            method.solver,
            t0=jnp.zeros_like(inputs.duration),
            t1=inputs.duration,
            # Most periods are one step; the controller shortens it where friction turns.
            dt0=inputs.duration,
            y0=state,
            stepsize_controller=method.step_control,
            max_steps=method.max_steps,
            adjoint=method.adjoint,
            throw=False,
        )
        final = _unless_given_up(solution, method)
        return State(final.position[0], final.velocity[0])

    return sampled_loop(
        advance,
        robot,
        start,
        controller,
        reference=reference,
        knock=knock,
        encoder=encoder,
        delay_samples=delay_samples,
        # The solver takes as many steps as it needs.
        run=native.scan,
    )


def _solve(
    field_of: Callable[[_Inputs], _Field[_X]],
    start: _X,
    *,
    voltage: Float[Array, "intervals 2"],
    times: Float[Array, " intervals+1"],
    knock: Float[Array, " intervals"] | None,
    save_at: Float[Array, " saved"],
    method: Adaptive,
) -> diffrax.Solution:
    """The solution, whole or given up, of equations under held inputs."""
    times = _check_inputs(voltage, times, knock)
    check_shape(save_at, ("saved",), name="save_at", unit="s")
    check_finite(save_at, name="save_at", unit="s")
    knock = jnp.zeros_like(voltage[:, 0]) if knock is None else knock

    def inputs(time: Float[Array, ""]) -> tuple[Float[Array, "2"], Float[Array, ""]]:
        interval = jnp.searchsorted(times, time, side="right") - 1
        interval = jnp.clip(interval, 0, voltage.shape[0] - 1)
        return voltage[interval], knock[interval]

    jumps = _jumps(jnp.concatenate([voltage, knock[:, None]], axis=1), times)
    return diffrax.diffeqsolve(
        diffrax.ODETerm(field_of(inputs)),
        method.solver,
        t0=times[0],
        t1=times[-1],
        dt0=None,
        y0=start,
        saveat=diffrax.SaveAt(ts=save_at),
        stepsize_controller=diffrax.ClipStepSizeController(method.step_control, jump_ts=jumps),
        max_steps=method.max_steps,
        adjoint=method.adjoint,
        throw=False,
    )


def _check_inputs(
    voltage: Float[Array, "intervals 2"],
    times: Float[Array, " intervals+1"],
    knock: Float[Array, " intervals"] | None,
) -> Float[Array, " intervals+1"]:
    """Refuse inputs that can't be; the times, NaN where they are traced and go back."""
    check_shape(voltage, ("n", 2), name="voltage", unit="V")
    check_finite(voltage, name="voltage", unit="V")
    intervals = jnp.shape(voltage)[0]
    check_shape(times, (intervals + 1,), name="times", unit="s")
    check_finite(times, name="times", unit="s")
    if knock is not None:
        check_shape(knock, (intervals,), name="knock", unit="N")
        check_finite(knock, name="knock", unit="N")
    known = concrete(times)
    message = (
        "`times` must ascend [s], got some that go back. Sort the rows by time, and give each "
        "instant once."
    )
    return refuse(times, (known[1:] < known[:-1]).any(), message)


def _equations(robot: Robot, inputs: _Inputs) -> _Field[State]:
    """The equations of motion under inputs that are a function of time."""

    def field(time: Float[Array, ""], state: State, _: None) -> State:
        voltage, knock = inputs(time)
        torque = motor_torque(robot.drive, voltage)
        return State(state.velocity, accelerations(robot, state, torque=torque, knock=knock))

    return field


def _jumps(
    inputs: Float[Array, "intervals inputs"], times: Float[Array, " intervals+1"]
) -> Float[Array, " intervals"]:
    """When the inputs change; where they don't, a time after the end stands instead."""
    changes = jnp.any(inputs[1:] != inputs[:-1], axis=1)
    never = 2 * times[-1] - times[0] + 1
    # One time after the end is always there: the solver takes no empty array.
    return jnp.sort(jnp.append(jnp.where(changes, times[1:-1], never), never))


def _unless_given_up(solution: diffrax.Solution, method: Adaptive) -> Any:
    """What a solution found, raising where the solver didn't reach its end."""
    ran_out = solution.result == diffrax.RESULTS.max_steps_reached
    states = eqx.error_if(
        solution.ys,
        ran_out,
        "`max_steps` must carry the adaptive solver to the end [steps], got "
        f"{method.max_steps}, which don't. Raise it, loosen `rtol` and `atol`, or widen the "
        "friction's `width`: a narrow one is stiff.",
    )
    return eqx.error_if(
        states,
        ~ran_out & (solution.result != diffrax.RESULTS.successful),
        "the adaptive solver must find its steps' states [m, rad, m/s, rad/s], got none "
        "that satisfies its equations. Widen the friction's `width` or start from finite "
        "states and parameters.",
    )


def _require_smooth(robot: Robot) -> None:
    for name, carriage in (("lower", robot.lower_carriage), ("upper", robot.upper_carriage)):
        if isinstance(carriage.friction, Coulomb):
            raise TypeError(
                f"`robot.{name}_carriage.friction` must be a smooth law for the adaptive "
                "solvers, got exact `Coulomb`, which has a jump at 0 m/s. Use "
                "`scdpr_jax.smoothed(robot, width=1e-3)`, or `scdpr_jax.engines.stepping` and "
                "`scdpr_jax.engines.closed_loop` for exact friction."
            )
