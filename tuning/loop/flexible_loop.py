r"""The joint loops of the flexible robot near an aligned pose, as the controller samples them.

One PD for each drive, alike, closes two loops that know nothing of each other. Where both
drives turn alike they move the lower carriage and excite the vibration of
$[x_e, \delta_e, q_3, q_4]$; where they turn oppositely they lift the end-effector, which has
no stiffness. Each is a loop of one command $V$ and one angle $\alpha$ [rad].

Loops come by the hundred, of several robots and heights, as one row each in NumPy's arrays:
what has to be done to them are eigenvalues and searches, for which nothing needs compiling.
"""

import dataclasses
from typing import NamedTuple

import jax.numpy as jnp
import numpy as np
import scipy.linalg
from jaxtyping import Array, Complex, Float, Int

from scdpr_jax import native
from scdpr_jax.command.controller import PD, PDState
from scdpr_jax.linear.model import linearise, stiffness
from scdpr_jax.linear.modes import CONDITIONS, Lower
from scdpr_jax.robot.dynamics import masses
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot

_STATES = 10
"""Coordinates and velocities of the robot."""


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


@dataclasses.dataclass(frozen=True, eq=False)
class Plants:
    r"""Command to angle behind a zero-order hold, $x^+ - x = \Delta x + \Gamma V$."""

    difference: Float[np.ndarray, "loops 10 10"] = dataclasses.field(
        metadata=si("SI", r"\Delta")
    )
    r"""$\Delta = e^{A h} - I$ [SI units of the rows over those of the columns]."""
    input: Float[np.ndarray, "loops 10"] = dataclasses.field(metadata=si("SI", r"\Gamma"))
    r"""$\Gamma = \int_0^h e^{A t} b\, \mathrm{d}t$ [SI units of the rows over V]."""
    output: Float[np.ndarray, "loops 10"] = dataclasses.field(metadata=si("SI", "c"))
    r"""$\alpha = c x$ [rad over SI units of the columns]."""

    def response(
        self, row: Int[np.ndarray, "*n"], step: Complex[np.ndarray, "*n"]
    ) -> Complex[np.ndarray, "*n"]:
        r"""Angle over command, $c\, (s I - \Delta)^{-1} \Gamma$ [rad/V].

        Args:
            row: Which plants.
            step: $s = z - 1$ [1].

        Returns:
            Their responses.
        """
        matrix = step[..., None, None] * np.eye(_STATES) - self.difference[row]
        state = np.linalg.solve(matrix, self.input[row][..., None])[..., 0]
        return np.sum(self.output[row] * state, axis=-1)


@dataclasses.dataclass(frozen=True, eq=False)
class PlantsOfPoles:
    r"""The same plants by poles alone, for many frequencies.

    A feedback $V = -\kappa \alpha$ moves the poles $\lambda$ to $\mu$, and by how much tells
    the response:

    $$ \kappa\, c\, (s I - \Delta)^{-1} \Gamma
       = \frac{\det(s I - \Delta + \kappa \Gamma c)}{\det(s I - \Delta)} - 1
       = \prod_i \frac{s - \mu_i}{s - \lambda_i} - 1 $$

    which is twenty products where a solution takes hundreds. The difference loses digits
    where it is small: with the controller's gain for $\kappa$ it isn't near a crossing.
    """

    gain: Float[np.ndarray, " loops"] = dataclasses.field(metadata=si("V/rad", r"\kappa"))
    """The feedbacks [V/rad]."""
    moved: Complex[np.ndarray, "loops 10"] = dataclasses.field(metadata=si("1", r"\mu"))
    """Poles with the feedback [1]."""
    poles: Complex[np.ndarray, "loops 10"] = dataclasses.field(metadata=si("1", r"\lambda"))
    """Poles without it [1]."""

    @classmethod
    def of(cls, plants: Plants, gain: Float[np.ndarray, " loops"]) -> "PlantsOfPoles":
        """The poles of plants.

        Args:
            plants: The plants.
            gain: The feedback that tells of each [V/rad].

        Returns:
            The poles.
        """
        fed_back = gain[:, None, None] * plants.input[:, :, None] * plants.output[:, None, :]
        return cls(
            gain,
            np.linalg.eigvals(plants.difference - fed_back).astype(complex),
            np.linalg.eigvals(plants.difference).astype(complex),
        )

    def response(
        self, row: Int[np.ndarray, "*#n"], step: Complex[np.ndarray, "*n"]
    ) -> Complex[np.ndarray, "*n"]:
        """As of `Plants` [rad/V]; one row may serve several steps."""
        s = step[..., None]
        moved = np.prod((s - self.moved[row]) / (s - self.poles[row]), axis=-1)
        return (moved - 1) / self.gain[row]


def plants(
    robots: Robot, heights: Float[np.ndarray, " heights"], *, period: float
) -> tuple[Plants, Float[np.ndarray, "loops modes"]]:
    r"""The plants of every joint loop at aligned poses, behind a zero-order hold, exactly.

    $$ \exp\left(h \begin{pmatrix} A & A & b \\ 0 & 0 & 0 \end{pmatrix}\right)
       = \begin{pmatrix} e^{Ah} & \Delta & \Gamma \\ 0 & I & \end{pmatrix} $$

    which gives $\Delta$ without the cancellation of $e^{Ah} - I$. The horizontal position
    doesn't matter: the loop's forces know only distances between the bodies.

    Args:
        robots: Robots, stacked leaf by leaf; of their friction laws only the viscous part
            counts.
        heights: Heights $y_e$ of the end-effector [m].
        period: Sample period $h$ [s].

    Returns:
        A row for each of `JOINT_LOOPS`, robot and height, the last one fastest: the plants,
        and where their gain may have a peak or a dip without damping [rad/s]. Peaks are the
        modes with the drives free to turn, dips those with the lower carriage held.
    """
    _, (state, volts, restoring) = native.Runs(_model, robots)((), heights[None])
    loops, shape = len(JOINT_LOOPS), restoring.shape[:2]
    _, moving, driven, second = map(np.array, zip(*JOINT_LOOPS, strict=True))
    still = np.tile(moving, 2)[:, None, None, :]
    both = still[..., :, None] * still[..., None, :]
    radius = np.broadcast_to(robots.drive.effective_radius, shape[:1])[:, None, None]

    above = np.zeros((loops, *shape, 2 * _STATES + 1, 2 * _STATES + 1))
    above[..., :_STATES, :_STATES] = above[..., :_STATES, _STATES:-1] = state * both
    first, other = volts[..., 0], volts[..., 1]
    above[..., :_STATES, -1] = still * (first + second[:, None, None, None] * other)
    held = scipy.linalg.expm(period * above)[..., :_STATES, :]
    # What doesn't move is forgotten in a sample: a pole at zero, which counts for nothing.
    forgotten = np.eye(_STATES) * (1 - still)[..., None]
    angle = np.zeros((loops, *shape, _STATES))
    angle[..., :5] = driven[:, None, None, :] / radius
    made = (held[..., _STATES:-1] - forgotten, held[..., -1], angle)
    rows = [own.reshape(-1, *own.shape[3:]) for own in made]
    modes = np.concatenate([_frequencies(restoring, own) for own in _PEAKS_AND_DIPS], axis=-1)
    return Plants(*rows), np.tile(modes.reshape(-1, modes.shape[-1]), (loops, 1))


_PEAKS_AND_DIPS = [own.moving for own in CONDITIONS if own.lower is not Lower.FREE]


def _model(
    robot: Robot, _: tuple, height: Float[Array, ""]
) -> tuple[tuple, tuple[Float[Array, "10 10"], Float[Array, "10 2"], Float[Array, "5 5"]]]:
    """The linear model at an aligned pose, and its stiffness over the roots of the masses."""
    place = jnp.stack([0 * height] * 4 + [height])
    model, root = linearise(robot, place), jnp.sqrt(masses(robot))
    even = stiffness(robot, place) / root[:, None] / root[None, :]
    return (), (model.state_matrix, model.input_matrix[:, :2], even)


def _frequencies(
    even: Float[np.ndarray, "robots heights 5 5"], moving: tuple[int, ...]
) -> Float[np.ndarray, "robots heights modes"]:
    """Angular frequencies of modes, of coordinates that move [rad/s]."""
    square = np.linalg.eigvalsh(even[..., np.array(moving)[:, None], np.array(moving)])
    # The whole robot slides at no frequency, or at that of a rounding.
    return np.sqrt(np.maximum(square, 0.0))


def controller_response(
    controllers: PD,
    row: Int[np.ndarray, "*#n"],
    angular_frequency: Float[np.ndarray, "*n"],
    *,
    delay: int,
) -> Complex[np.ndarray, "*n"]:
    r"""Controllers as they run, $z^{-d} R(z)$ at $z = e^{j\omega h}$.

    That of `tuning.loop.responses`, of any number of frequencies at once.

    Args:
        controllers: The controllers, stacked leaf by leaf.
        row: Which of them.
        angular_frequency: $\omega$ [rad/s], up to the Nyquist frequency $\pi / h$.
        delay: Samples $d$ from a measurement to its command.

    Returns:
        Responses [V/rad].
    """
    angle = angular_frequency * controllers.period[row]
    difference = -np.expm1(-1j * angle)
    filtered = controllers.period[row] + controllers.filter_time[row] * difference
    slope = controllers.derivative_gain[row] * difference / filtered
    return np.exp(-1j * delay * angle) * (controllers.proportional_gain[row] + slope)


def closed_loop_matrices(
    own: Plants, controllers: PD, *, delay: int
) -> Float[np.ndarray, "loops m m"]:
    """One sample of closed loops with their reference at zero, by the controller's own step.

    Args:
        own: The plants at the controllers' period.
        controllers: A controller for each, stacked leaf by leaf.
        delay: Samples from a measurement to its command.

    Returns:
        The matrices that take a plant's state, the commands on their way and the
        controller's state from one sample to the next.
    """
    count, size = len(own.input), _STATES + delay + 2
    # A command, what is remembered of it and what waits, by all that is there before.
    remembers_angle = np.zeros((count, 3, size))
    of_memory, of_angle = np.split(_controller_slopes(controllers), [2], axis=-1)
    remembers_angle[..., -2:] = of_memory
    remembers_angle[..., :_STATES] = of_angle * own.output[:, None, :]
    waiting = np.zeros((count, delay, size))
    waiting[:] = np.eye(size)[_STATES : _STATES + delay]
    commands = np.concatenate([waiting, remembers_angle[:, 2:]], axis=1)
    state = own.input[:, :, None] * commands[:, :1]
    state[..., :_STATES] += np.eye(_STATES) + own.difference
    return np.concatenate([state, commands[:, 1:], remembers_angle[:, :2]], axis=1)


def _controller_slopes(controllers: PD) -> Float[np.ndarray, "controllers 3 3"]:
    """What is remembered, and the command, of one drive, by what was and by the angle."""
    error, derivative, angle = np.eye(3)[:, None, :, None] * np.ones(2)
    still = np.zeros((1, 2))
    _, slopes = native.Runs(_controller_step, controllers).linearised(
        PDState(still, still),
        still[None],
        along=native.Slopes(PDState(error, derivative), angle[:, :, None]),
    )
    made = slopes.carried.error, slopes.carried.derivative, slopes.rows[:, 0]
    return np.stack([each[:, 0] for each in made], axis=1)


def _controller_step(
    controller: PD, memory: PDState, angle: Float[Array, "2"]
) -> tuple[PDState, Float[Array, "2"]]:
    return controller.step(memory, jnp.zeros_like(angle), angle)
