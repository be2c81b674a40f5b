r"""The joint loops of the flexible robot near an aligned pose, as the controller samples them.

One PD for each drive, alike, closes two loops that know nothing of each other. Where both
drives turn alike they move the lower carriage and excite the vibration of
$[x_e, \delta_e, q_3, q_4]$; where they turn oppositely they lift the end-effector, which has
no stiffness. Each is a loop of one command $V$ and one angle $\alpha$ [rad].
"""

from collections.abc import Sequence
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Complex, Float

from scdpr_jax.command.controller import PD, PDState
from scdpr_jax.linear.model import linearise
from scdpr_jax.linear.modes import CONDITIONS, Lower, natural_frequencies
from scdpr_jax.robot.fields import real, si
from scdpr_jax.robot.parameters import Robot
from tuning.loop.plant import as_complex, shift_minus_one
from tuning.loop.responses import pd_gain, sampled_delay, sampled_derivative


class Motion(eqx.Module):
    """What moves in a joint loop: weights of the coordinates, as arrays."""

    moving: Float[Array, "... 5"] = eqx.field(converter=real, metadata=si("1"))
    """1 for each coordinate that moves, 0 for one that doesn't [1]."""
    driven: Float[Array, "... 5"] = eqx.field(converter=real, metadata=si("1"))
    r"""1 for the coordinate $r \alpha$ that the drives move, 0 for the others [1]."""
    second_drive: Float[Array, "..."] = eqx.field(converter=real, metadata=si("1"))
    """What the second drive does while the first does 1 [1]."""


class JointLoop(NamedTuple):
    """One of the loops that the drives' controllers close."""

    name: str
    """What moves, for a table and `tuning.json`."""
    moving: tuple[float, ...]
    r"""1 for each of $[x_e, \delta_e, q_3, q_4, y_e]$ that moves, else 0."""
    driven: tuple[float, ...]
    """1 for the coordinate that the drives move, else 0."""
    second_drive: float
    """What the second drive does while the first does 1 [1]."""


_LOWER, _HEIGHT = (0.0, 0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0, 1.0)

UPPER_FREE = JointLoop("sideways, upper carriage free", (1.0,) * 4 + (0.0,), _LOWER, 1.0)
"""Both drives alike while the upper carriage slides."""
UPPER_HELD = JointLoop("sideways, upper carriage held", (1.0,) * 3 + (0.0,) * 2, _LOWER, 1.0)
"""Both drives alike while friction holds the upper carriage."""
LIFTING = JointLoop("lifting", _HEIGHT, _HEIGHT, -1.0)
"""The drives against each other."""

JOINT_LOOPS = (UPPER_FREE, UPPER_HELD, LIFTING)
"""Every loop of the flexible robot."""


def motions(loops: Sequence[JointLoop] = JOINT_LOOPS) -> Motion:
    """Joint loops as arrays, one a row, to batch over.

    Args:
        loops: The loops.

    Returns:
        Their motions.
    """
    _, moving, driven, second_drive = zip(*loops, strict=True)
    return Motion(*(jnp.asarray(rows, dtype=float) for rows in (moving, driven, second_drive)))


class FlexiblePlant(eqx.Module):
    r"""Command to angle behind a zero-order hold, $x^+ - x = \Delta x + \Gamma V$."""

    difference: Float[Array, "... 10 10"] = eqx.field(
        converter=real, metadata=si("SI", r"\Delta")
    )
    r"""$\Delta = e^{A h} - I$ [SI units of the rows over those of the columns]."""
    input: Float[Array, "... 10"] = eqx.field(converter=real, metadata=si("SI", r"\Gamma"))
    r"""$\Gamma = \int_0^h e^{A t} b\, \mathrm{d}t$ [SI units of the rows over V]."""
    output: Float[Array, "... 10"] = eqx.field(converter=real, metadata=si("SI", "c"))
    r"""$\alpha = c x$ [rad over SI units of the columns]."""

    def response(self, step: Complex[Array, ""]) -> Complex[Array, ""]:
        r"""Angle over command, $c\, (s I - \Delta)^{-1} \Gamma$ [rad/V].

        Args:
            step: $s = z - 1$ [1].

        Returns:
            The response.
        """
        difference, column, row = as_complex(self.difference, self.input, self.output)
        identity = jnp.eye(column.size, dtype=column.dtype)
        return row @ jnp.linalg.solve(step * identity - difference, column)


class PlantOfPoles(eqx.Module):
    r"""The same plant by poles alone, for many frequencies; without useful derivatives.

    A feedback $V = -\kappa \alpha$ moves the poles $\lambda$ to $\mu$, and by how much tells
    the response:

    $$ \kappa\, c\, (s I - \Delta)^{-1} \Gamma
       = \frac{\det(s I - \Delta + \kappa \Gamma c)}{\det(s I - \Delta)} - 1
       = \prod_i \frac{s - \mu_i}{s - \lambda_i} - 1 $$

    which is twenty products where a solution takes hundreds. The difference loses digits
    where it is small: with the controller's gain for $\kappa$ it isn't near a crossing.
    """

    gain: Float[Array, "..."] = eqx.field(converter=real, metadata=si("V/rad", r"\kappa"))
    """The feedback [V/rad]."""
    moved: Complex[Array, "... 10"] = eqx.field(metadata=si("1", r"\mu"))
    """Poles with the feedback [1]."""
    poles: Complex[Array, "... 10"] = eqx.field(metadata=si("1", r"\lambda"))
    """Poles without it [1]."""

    @classmethod
    def of(cls, plant: FlexiblePlant, gain: Float[Array, ""]) -> "PlantOfPoles":
        """The poles of a plant.

        Args:
            plant: The plant.
            gain: The feedback that tells of it [V/rad].

        Returns:
            The poles.
        """
        fed_back = plant.difference - gain * jnp.outer(plant.input, plant.output)
        both = jnp.linalg.eigvals(jnp.stack([fed_back, plant.difference]))
        return cls(gain, both[0], both[1])

    def response(self, step: Complex[Array, ""]) -> Complex[Array, ""]:
        """As of `FlexiblePlant` [rad/V]."""
        moved = jnp.prod((step - self.moved) / (step - self.poles))
        return (moved - 1) / self.gain.astype(moved.dtype)


def flexible_plant(
    robot: Robot, height: Float[Array, ""], motion: Motion, *, period: Float[Array, ""]
) -> FlexiblePlant:
    r"""The plant of a joint loop at an aligned pose, behind a zero-order hold, exactly.

    $$ \exp\left(h \begin{pmatrix} A & A & b \\ 0 & 0 & 0 \end{pmatrix}\right)
       = \begin{pmatrix} e^{Ah} & \Delta & \Gamma \\ 0 & I & \end{pmatrix} $$

    which gives $\Delta$ without the cancellation of $e^{Ah} - I$. The horizontal position
    doesn't matter: the loop's forces know only distances between the bodies.

    Args:
        robot: The robot; of its friction laws only the viscous part counts.
        height: Height $y_e$ of the end-effector [m].
        motion: What moves.
        period: Sample period $h$ [s].

    Returns:
        The plant.
    """
    zero = jnp.zeros_like(height)
    model = linearise(robot, jnp.stack([zero, zero, zero, zero, height]))
    moving = jnp.tile(motion.moving, 2)
    state = model.state_matrix * jnp.outer(moving, moving)
    first, second = model.input_matrix[:, 0], model.input_matrix[:, 1]
    volts = moving * (first + motion.second_drive * second)

    above = jnp.concatenate([state, state, volts[:, None]], axis=1)
    square = jnp.concatenate([above, jnp.zeros((11, 21), state.dtype)])
    exponential = jax.scipy.linalg.expm(period * square)
    angle = motion.driven / robot.drive.effective_radius
    return FlexiblePlant(
        # What doesn't move is forgotten in a sample: a pole at zero, which counts for nothing.
        difference=exponential[:10, 10:20] - jnp.diag(1 - moving),
        input=exponential[:10, 20],
        output=jnp.concatenate([angle, jnp.zeros_like(angle)]),
    )


def flexible_loop(
    plant: FlexiblePlant | PlantOfPoles,
    controller: PD,
    angular_frequency: Float[Array, ""],
    *,
    delay: int = 1,
) -> Complex[Array, ""]:
    r"""The open loop of the flexible robot as the controller runs it, $z = e^{j\omega h}$.

    $$ L = z^{-d} R(z)\, c\, ((z - 1) I - \Delta)^{-1} \Gamma $$

    Args:
        plant: The plant at the controller's period.
        controller: The controller.
        angular_frequency: $\omega$ [rad/s], up to the Nyquist frequency $\pi / h$.
        delay: Samples $d$ from a measurement to its command.

    Returns:
        Response [1].
    """
    period = controller.period
    response = plant.response(shift_minus_one(angular_frequency * period))
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


def resonances(robot: Robot, height: Float[Array, ""]) -> Float[Array, " modes"]:
    """Where the loops' gain may have a peak or a dip, without damping.

    Peaks are the modes with the drives free to turn, dips those with the lower carriage held.

    Args:
        robot: The robot.
        height: Height of the end-effector [m].

    Returns:
        Angular frequencies of all conditions of the carriages [rad/s].
    """
    conditions = [condition for condition in CONDITIONS if condition.lower is not Lower.FREE]
    frequencies = [natural_frequencies(robot, height, condition) for condition in conditions]
    return 2 * jnp.pi * jnp.concatenate(frequencies)
