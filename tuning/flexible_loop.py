r"""The joint loops of the flexible robot near an aligned pose, as the controller samples them.

One PD for each drive, alike, closes two loops that know nothing of each other. Where both
drives turn alike they move the lower carriage and excite the vibration of
$[x_e, \delta_e, q_3, q_4]$; where they turn oppositely they lift the end-effector, which has
no stiffness. Each is a loop of one command $V$ and one angle $\alpha$ [rad].
"""

import dataclasses

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Complex, Float

from scdpr_jax.controller import PD, PDState
from scdpr_jax.fields import real, si
from scdpr_jax.linear import linearise
from scdpr_jax.modes import Condition, Lower, Upper, natural_frequencies
from scdpr_jax.parameters import Robot
from tuning.plant import as_complex, shift_minus_one
from tuning.responses import pd_gain, sampled_delay, sampled_derivative

_COORDINATES = 5
"""How many coordinates the robot has."""
_LOWER, _UPPER, _HEIGHT = 2, 3, 4
"""Places of $q_3$, $q_4$ and $y_e$ among the coordinates."""


@dataclasses.dataclass(frozen=True)
class JointLoop:
    """One of the loops that the drives' controllers close."""

    name: str
    """What moves, for a table."""
    coordinates: tuple[int, ...]
    """Which of the five coordinates move."""
    driven: int
    r"""The coordinate that the drives move, $r \alpha$."""
    second_drive: float
    """What the second drive does while the first does 1 [1]."""
    upper: Upper | None
    """What the upper carriage does; None where the loop doesn't know of it."""


UPPER_FREE = JointLoop("sideways, upper carriage free", (0, 1, 2, 3), _LOWER, 1.0, Upper.FREE)
"""Both drives alike while the upper carriage slides."""
UPPER_HELD = JointLoop("sideways, upper carriage held", (0, 1, 2), _LOWER, 1.0, Upper.HELD)
"""Both drives alike while friction holds the upper carriage."""
LIFTING = JointLoop("lifting", (_HEIGHT,), _HEIGHT, -1.0, None)
"""The drives against each other."""

JOINT_LOOPS = (UPPER_FREE, UPPER_HELD, LIFTING)
"""Every loop of the flexible robot."""


class FlexiblePlant(eqx.Module):
    r"""Command to angle behind a zero-order hold, $x^+ - x = \Delta x + \Gamma V$."""

    difference: Float[Array, "... n n"] = eqx.field(
        converter=real, metadata=si("SI", r"\Delta")
    )
    r"""$\Delta = e^{A h} - I$ [SI units of the rows over those of the columns]."""
    input: Float[Array, "... n"] = eqx.field(converter=real, metadata=si("SI", r"\Gamma"))
    r"""$\Gamma = \int_0^h e^{A t} b\, \mathrm{d}t$ [SI units of the rows over V]."""
    output: Float[Array, "... n"] = eqx.field(converter=real, metadata=si("SI", "c"))
    r"""$\alpha = c x$ [rad over SI units of the columns]."""


def flexible_plant(
    robot: Robot, height: Float[Array, ""], loop: JointLoop, *, period: Float[Array, ""]
) -> FlexiblePlant:
    r"""The plant of a joint loop at an aligned pose, behind a zero-order hold, exactly.

    $$ \exp\left(h \begin{pmatrix} A & A & b \\ 0 & 0 & 0 \end{pmatrix}\right)
       = \begin{pmatrix} e^{Ah} & \Delta & \Gamma \\ 0 & I & \end{pmatrix} $$

    which gives $\Delta$ without the cancellation of $e^{Ah} - I$. The horizontal position
    doesn't matter: the loop's forces know only distances between the bodies.

    Args:
        robot: The robot; of its friction laws only the viscous part counts.
        height: Height $y_e$ of the end-effector [m].
        loop: Which loop.
        period: Sample period $h$ [s].

    Returns:
        The plant.
    """
    aligned = jnp.zeros(_COORDINATES, height.dtype).at[_HEIGHT].set(height)
    model = linearise(robot, aligned)
    moving = jnp.asarray([*loop.coordinates, *(c + _COORDINATES for c in loop.coordinates)])
    state = model.state_matrix[moving[:, None], moving]
    volts = model.input_matrix[moving]
    column = volts[:, :1] + loop.second_drive * volts[:, 1:2]

    count = moving.size
    above = jnp.concatenate([state, state, column], axis=1)
    exponential = jax.scipy.linalg.expm(
        period * jnp.concatenate([above, jnp.zeros((count + 1, 2 * count + 1), state.dtype)])
    )
    angle = jnp.zeros(count, state.dtype).at[loop.coordinates.index(loop.driven)]
    return FlexiblePlant(
        difference=exponential[:count, count : 2 * count],
        input=exponential[:count, -1],
        output=angle.set(1 / robot.drive.effective_radius),
    )


def flexible_loop(
    plant: FlexiblePlant,
    controller: PD,
    angular_frequency: Float[Array, ""],
    *,
    delay: int = 1,
) -> Complex[Array, ""]:
    r"""The open loop, $z^{-d} R(z)\, c\, ((z - 1) I - \Delta)^{-1} \Gamma$ at $z = e^{j\omega h}$.

    Args:
        plant: The plant at the controller's period.
        controller: The controller.
        angular_frequency: $\omega$ [rad/s], up to the Nyquist frequency $\pi / h$.
        delay: Samples $d$ from a measurement to its command.

    Returns:
        Response [1].
    """
    period = controller.period
    step = shift_minus_one(angular_frequency * period)
    difference, column, row = as_complex(plant.difference, plant.input, plant.output)
    identity = jnp.eye(column.size, dtype=column.dtype)
    response = row @ jnp.linalg.solve(step * identity - difference, column)
    derivative = sampled_derivative(
        angular_frequency, period=period, filter_time=controller.filter_time
    )
    lag = sampled_delay(angular_frequency, period=period, delay=delay)
    return lag * pd_gain(controller, derivative) * response


def closed_loop_matrix(
    plant: FlexiblePlant, controller: PD, *, delay: int = 1
) -> Float[Array, "m m"]:
    """One sample of the closed loop with its reference at zero, by the controller's own step.

    Args:
        plant: The plant at the controller's period.
        controller: The controller.
        delay: Samples from a measurement to its command.

    Returns:
        The matrix that takes the plant's state, the commands on their way and the
        controller's state from one sample to the next.
    """
    count = plant.input.size

    def advance(state: Float[Array, " m"]) -> Float[Array, " m"]:
        x, waiting = state[:count], state[count : count + delay]
        both = jnp.ones(2, state.dtype)
        remembered = PDState(error=state[-2] * both, derivative=state[-1] * both)
        following, voltage = controller.step(
            remembered, jnp.zeros_like(both), (plant.output @ x) * both
        )
        commands = jnp.concatenate([waiting, voltage[:1]])
        return jnp.concatenate(
            [
                x + plant.difference @ x + plant.input * commands[0],
                commands[1:],
                following.error[:1],
                following.derivative[:1],
            ]
        )

    return jax.jacfwd(advance)(jnp.zeros(count + delay + 2, plant.input.dtype))


def resonances(robot: Robot, height: Float[Array, ""], loop: JointLoop) -> Float[Array, " k"]:
    """Where the loop's gain has its peaks and its dips, without damping.

    Peaks are the modes with the drives at rest electrically, dips those with the lower
    carriage held.

    Args:
        robot: The robot.
        height: Height of the end-effector [m].
        loop: Which loop.

    Returns:
        Angular frequencies [rad/s], none for a loop without vibration.
    """
    if loop.upper is None:
        return jnp.zeros(0, height.dtype)
    conditions = (Condition(lower, loop.upper) for lower in (Lower.DRIVEN, Lower.HELD))
    found = [natural_frequencies(robot, height, condition) for condition in conditions]
    return 2 * jnp.pi * jnp.concatenate(found)
