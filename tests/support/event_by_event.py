"""The robot's motion event by event: slow, and so simple that one can see that it is right.

Written anew from the paper's Eqs. (4), (7), (8), (16), (18) and (21), without `scdpr_jax`.
Dry friction acts at contacts: both carriages on their guides and, where they have friction,
both drives, each along its direction in the coordinates. A contact slides forwards (+1),
backwards (-1) or sticks (0). Between events the motion is smooth: DOP853 follows the nonlinear
robot, a matrix exponential the linear one. An event is where a sliding contact's speed or a
sticking one's reserve of friction passes zero. What contacts at rest do then is found by
trying all of it: of the accelerations that agree with themselves, Gauss's principle takes one.

Events are looked for at `LOOKS` places of each stretch of at most `STRETCH`, and in each dip
between them. Missed could be what leaves a mode and is back in it between two neighbouring
places without a dip at a place: two dips in an eighth of a stretch, or one beside its end.
"""

import dataclasses
import functools
import itertools
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq, minimize_scalar

LOOKS = 8
"""Places in a stretch at which an event is looked for."""
STRETCH = 5e-3
"""Longest stretch [s]; the fastest swings of the prototype take some 50 ms."""
MOST_EVENTS = 1000
"""Events in one interval beyond which the friction's modes can't be decided."""


@dataclasses.dataclass(frozen=True)
class Numbers:
    """The robot in SI units."""

    frame_height: float
    lower_offset: float
    upper_offset: float
    end_effector_mass: float
    end_effector_inertia: float
    lower_carriage_mass: float
    upper_carriage_mass: float
    lower_friction: float
    upper_friction: float
    effective_pretension: float
    effective_radius: float
    drive_inertia: float
    drive_damping: float
    torque_per_volt: float
    voltage_limit: float
    drive_frictions: tuple[float, float] = (0.0, 0.0)
    static_surplus: float = 0.0
    stribeck_velocity: float = 0.02
    knock_arm: float = 0.0

    @functools.cached_property
    def contacts(self):
        """Directions of the contacts: of the carriages, then of drives with friction."""
        carriages = [[0, 0, 1, 0, 0], [0, 0, 0, 1, 0]]
        drives = zip([[0, 0, 1, 0, 1], [0, 0, 1, 0, -1]], self.drive_frictions, strict=True)
        return np.array(carriages + [way for way, friction in drives if friction], float)

    @property
    def drive_limits(self):
        """Largest friction of the drives that have any, at their pulleys' rims [N]."""
        return [f / self.effective_radius for f in self.drive_frictions if f]

    def rise(self, velocity):
        """By how much the carriages' friction coefficient is higher at a velocity."""
        return self.static_surplus * np.exp(-((velocity / self.stribeck_velocity) ** 2))

    @functools.cached_property
    def masses(self):
        """Masses of [x_e, δ_e, q_3, q_4, y_e]."""
        drives = 2 * self.drive_inertia / self.effective_radius**2
        m_e = self.end_effector_mass
        m_3, m_4 = self.lower_carriage_mass + drives, self.upper_carriage_mass
        return np.array([m_e, self.end_effector_inertia, m_3, m_4, m_e + drives])

    def drives(self, velocity, voltage):
        """Forces of both drives on q_3 and on y_e, their viscous damping included [N]."""
        tau = self.torque_per_volt * np.clip(voltage, -self.voltage_limit, self.voltage_limit)
        drag = 2 * self.drive_damping / self.effective_radius**2
        pull = np.array([tau[0] + tau[1], tau[0] - tau[1]]) / self.effective_radius
        return pull[0] - drag * velocity[2], pull[1] - drag * velocity[4]


class Held(NamedTuple):
    """What acts through one interval."""

    duration: float
    voltage: np.ndarray
    knock: float


class Event(NamedTuple):
    """A contact changes its mode: 0 is the lower carriage, 1 the upper one, then drives."""

    time: float
    contact: int
    before: int
    after: int


class Run(NamedTuple):
    """States at the ends of the intervals, the start first, and what happened between."""

    positions: np.ndarray
    velocities: np.ndarray
    modes: np.ndarray
    """Modes of the contacts at the end of each interval."""
    events: list[Event]

    @property
    def sticks(self):
        """Which carriages stick at the end of each interval."""
        return self.modes[:, :2] == 0


@dataclasses.dataclass(frozen=True)
class Nonlinear:
    """The robot with its true angles, Eqs. (4), (7), (8) and (16)."""

    numbers: Numbers

    def balance(self, state, held):
        """Forces without dry friction, and the largest friction of the contacts [N]."""
        robot, velocity = self.numbers, state[5:]
        x, tilt, lower, upper, y = state[:5]
        a, b, H = robot.lower_offset, robot.upper_offset, robot.frame_height
        alpha = np.arctan2(lower - x - a * np.sin(tilt), y - a * np.cos(tilt))
        beta = np.arctan2(x - upper - b * np.sin(tilt), H - y - b * np.cos(tilt))
        gamma = np.arctan2(lower - upper, H)
        T = 2 * robot.effective_pretension
        along, up = robot.drives(velocity, held.voltage)
        forces = [
            T * (np.sin(alpha) - np.sin(beta)) + held.knock,
            T * (a * np.sin(alpha - tilt) + b * np.sin(beta - tilt))
            - robot.knock_arm * held.knock,
            -T * (np.sin(gamma) + np.sin(alpha)) + along,
            T * (np.sin(gamma) + np.sin(beta)),
            T * (np.cos(beta) - np.cos(alpha)) + up,
        ]
        limits = [
            (robot.lower_friction + robot.rise(velocity[2]))
            * T
            * (np.cos(gamma) + np.cos(alpha)),
            (robot.upper_friction + robot.rise(velocity[3]))
            * T
            * (np.cos(gamma) + np.cos(beta)),
        ]
        limits += [limit + 0 * x for limit in robot.drive_limits]
        return np.array(forces), np.array(limits)

    def energy(self, state):
        """Kinetic energy and the potential of the three pairs of cables [J]."""
        robot = self.numbers
        x, tilt, lower, upper, y = state[:5]
        a, b, H = robot.lower_offset, robot.upper_offset, robot.frame_height
        lengths = (
            np.hypot(lower - x - a * np.sin(tilt), y - a * np.cos(tilt))
            + np.hypot(x - upper - b * np.sin(tilt), H - y - b * np.cos(tilt))
            + np.hypot(lower - upper, H)
        )
        return robot.masses @ state[5:] ** 2 / 2 + 2 * robot.effective_pretension * lengths

    def flow(self, state, modes, held):
        """The smooth motion in these modes, as long as they last."""
        return _Integrated(self, state, modes, held)


@dataclasses.dataclass(frozen=True)
class Linear:
    """The robot near the aligned pose at a height, Eqs. (18) and (21) with its drives.

    Its friction has no rise, and its knocks no arm.
    """

    numbers: Numbers
    height: float

    def balance(self, state, held):
        """Forces without dry friction, and the largest friction of the contacts [N]."""
        robot, velocity = self.numbers, state[5:]
        x, tilt, lower, upper, _ = state[:5]
        a, b, H = robot.lower_offset, robot.upper_offset, robot.frame_height
        alpha = (lower - x - a * tilt) / (self.height - a)
        beta = (x - upper - b * tilt) / (H - self.height - b)
        gamma = (lower - upper) / H
        T = 2 * robot.effective_pretension
        along, up = robot.drives(velocity, held.voltage)
        forces = [
            T * (alpha - beta) + held.knock,
            T * (a * (alpha - tilt) + b * (beta - tilt)),
            -T * (gamma + alpha) + along,
            T * (gamma + beta),
            up,
        ]
        carriages = [2 * T * robot.lower_friction, 2 * T * robot.upper_friction]
        limits = np.array(carriages + robot.drive_limits)
        return np.array(forces), np.multiply.outer(limits, np.ones_like(x))

    def flow(self, state, modes, held):
        """The smooth motion in these modes, as long as they last."""
        return _Exponential(self, state, modes, held)


def slope(system, state, modes, held):
    """Time derivative of the state while the contacts keep their modes."""
    robot = system.numbers
    forces, limits = system.balance(state, held)
    acceleration = (forces - robot.contacts.T @ (modes * limits)) / robot.masses
    return np.concatenate([state[5:], _holding(robot, modes) @ acceleration])


def _holding(robot, modes):
    """Takes out of a velocity, or acceleration, what moves the contacts that stick."""
    return _projection(robot, tuple(np.equal(modes, 0)))


@functools.cache
def _projection(robot, sticking):
    rows = robot.contacts[np.array(sticking)]
    answer = rows.T / robot.masses[:, None]
    projection = np.eye(5) - answer @ np.linalg.pinv(rows @ answer) @ rows
    # What is held has exactly no velocity.
    return np.where(np.abs(projection) < 1e-12, 0.0, projection)


class _Integrated:
    """A smooth motion by DOP853."""

    def __init__(self, system, state, modes, held):
        self.problem = {
            "fun": lambda _, at: slope(system, at, modes, held),
            "y0": state,
            "method": "DOP853",
            "rtol": 1e-13,
            "atol": 1e-16,
            "max_step": STRETCH,
        }
        self.state = state

    def search(self, end):
        """The motion up to `end`: instants that bound its stretches, and its dense output."""
        smooth = solve_ivp(t_span=(0.0, end), dense_output=True, **self.problem)
        return smooth.t, smooth.sol

    def at(self, time):
        """The state at an instant, not interpolated."""
        if time == 0:
            return self.state.copy()
        return solve_ivp(t_span=(0.0, time), **self.problem).y[:, -1]


class _Exponential:
    """A smooth motion of a linear system, exact at every instant."""

    def __init__(self, system, state, modes, held):
        constant = slope(system, np.zeros(10), modes, held)
        columns = [slope(system, unit, modes, held) - constant for unit in np.eye(10)]
        # One more state, which stays 1, carries the inputs and the friction.
        self.matrix = np.zeros((11, 11))
        self.matrix[:10] = np.column_stack([*columns, constant])
        self.state = np.append(state, 1.0)

    def search(self, end):
        """The motion up to `end`: instants that bound its stretches, and the motion."""
        return np.linspace(0.0, end, 1 + int(np.ceil(end / STRETCH))), self._states

    def _states(self, time):
        if np.ndim(time) == 0:
            return self.at(time)
        return np.stack([self.at(t) for t in time], axis=1)

    def at(self, time):
        """The state at an instant."""
        return (expm(self.matrix * time) @ self.state)[:10]


def simulate(system, start, durations, voltages, knocks):
    """The run of a system from its `start`, 5 positions and 5 velocities.

    Voltages of both drives [V] and the knock on the end-effector [N] are held through each
    interval.
    """
    state, begin = np.array(start, dtype=float), 0.0
    states, kept, events = [state], [], []
    modes = None
    for held in itertools.starmap(Held, zip(durations, voltages, knocks, strict=True)):
        state, modes, found = _interval(system, state, modes, held)
        states.append(state)
        kept.append(modes)
        events += [event._replace(time=begin + event.time) for event in found]
        begin += held.duration
    states = np.array(states)
    return Run(states[:, :5], states[:, 5:], np.array(kept), events)


def _interval(system, state, modes, held):
    """The state and the modes at the interval's end, and the events on the way."""
    speeds = system.numbers.contacts @ state[5:]
    before, time = modes, 0.0
    modes = np.sign(speeds if before is None else np.where(np.equal(before, 0), 0, speeds))
    modes = _set_going(system, state, modes, held)
    # New inputs may break a contact away at once.
    events = [] if before is None else _changes(0.0, before, modes)
    for _ in range(MOST_EVENTS):
        passed, state, contact = _to_event(system, state, modes, held, held.duration - time)
        if contact is None:
            return state, modes, events
        time, was = time + passed, modes
        if modes[contact] == 0:
            # It is at its limit up to roundings, which are to be out of the decision.
            modes = _set_going(system, state, modes, held, reached=1 - 1e-6)
        else:
            modes = _set_going(system, state, _at_rest(system.numbers, modes, contact), held)
        events += _changes(time, was, modes)
    raise ArithmeticError(f"more than {MOST_EVENTS} events in {held.duration} s")


def _changes(time, before, after):
    changed = np.flatnonzero(before != after)
    return [Event(time, int(i), int(before[i]), int(after[i])) for i in changed]


def _at_rest(robot, modes, stopping):
    """The modes, with 0 for every contact that rests as this one stops."""
    modes = np.where(np.arange(len(modes)) == stopping, 0, modes)
    # Where two of the lower carriage and the drives rest, the pulleys and the height do.
    left = robot.contacts @ _holding(robot, modes)
    return np.where(np.abs(left).max(axis=1) < 1e-9, 0, modes)


def _set_going(system, state, modes, held, reached=1.0):
    r"""The modes, with those of contacts at rest (0) as the next instant makes them.

    Gauss's principle: of all accelerations a, the true one has the least
    $a^T M a / 2 - F^T a + \sum l_i |c_i^T a|$, the sum over the contacts at rest. Each
    pattern of their modes has one candidate. What moves past these contacts is left out, F
    is what they would have to hold.
    """
    robot = system.numbers
    forces, limits = system.balance(state, held)
    limits = np.where(np.equal(modes, 0), reached, 1.0) * limits
    forces = forces - robot.contacts.T @ (modes * limits)
    forces = forces - robot.masses * (_holding(robot, modes) @ (forces / robot.masses))
    resting = np.flatnonzero(np.equal(modes, 0))

    def tried(pattern):
        new = np.array(modes)
        new[resting] = pattern
        acceleration = _holding(robot, new) @ (
            (forces - robot.contacts[resting].T @ (pattern * limits[resting])) / robot.masses
        )
        rates = robot.contacts[resting] @ acceleration
        agrees = np.all(rates[np.not_equal(pattern, 0)] * pattern[pattern != 0] > 0)
        energy = robot.masses @ acceleration**2 / 2 - forces @ acceleration
        return energy + limits[resting] @ np.abs(rates) if agrees else np.inf, new

    patterns = map(np.array, itertools.product([0, 1, -1], repeat=len(resting)))
    return min(map(tried, patterns), key=lambda candidate: candidate[0])[1]


def _to_event(system, state, modes, held, remaining):
    """Time passed, state and contact of the first event; no contact at the interval's end."""
    if remaining <= 0:
        return 0.0, state, None
    robot, flow = system.numbers, system.flow(state, modes, held)
    bounds, path = flow.search(remaining)
    looks = np.concatenate(
        [np.linspace(*ends, LOOKS, endpoint=False) for ends in itertools.pairwise(bounds)]
        + [bounds[-1:]]
    )

    def speed(time, i):
        """Positive until sliding contact `i` stops."""
        return modes[i] * (robot.contacts[i] @ path(time)[5:])

    def reserve(time, way):
        """Positive until the sticking contacts give way to a motion."""
        forces, limits = system.balance(path(time), held)
        # The sliding contacts' friction pulls, the sticking ones' holds.
        pull = way @ forces - (modes * (robot.contacts @ way)) @ limits
        holding = np.where(modes == 0, np.abs(robot.contacts @ way), 0) @ limits
        return holding - np.abs(pull)

    slides = [(speed, i, i) for i in np.flatnonzero(modes != 0)]
    gives = [(reserve, way, i) for i, way in _ways(robot, modes)]
    instant, contact = remaining, None
    for positive, which, i in slides + gives:
        crossing = _crossing(lambda t, f=positive, w=which: f(t, w), looks)
        if crossing < instant:
            instant, contact = crossing, i
    state = flow.at(instant)
    # What sticks rests, and what stops does: the rounding of neither may set it going.
    rests = modes if contact is None else _at_rest(robot, modes, contact)
    state[5:] = _holding(robot, rests) @ state[5:]
    return instant, state, contact


def _ways(robot, modes):
    """Motions to which sticking contacts may give way first, with one of those contacts."""
    for group in ([1], [0, *range(2, len(modes))]):
        sticking = [i for i in group if modes[i] == 0]
        for i in sticking:
            row = robot.contacts[i]
            if len(sticking) == 1:
                yield i, row / robot.masses
            else:
                # Everything rests, and would move as this one contact allows.
                yield i, np.array([0, 0, row[4], 0, -row[2]])


def _crossing(reserve, looks):
    """First instant at which the reserve falls below zero; infinity without one."""
    values = reserve(looks)
    for k in range(1, len(looks)):
        if values[k] < 0:
            # What begins at zero, as a break-away does, may rise at first.
            nearer = [looks[0] + (looks[1] - looks[0]) / 2**n for n in range(50)]
            before = [looks[k - 1]] if values[k - 1] > 0 else nearer
            above = [t for t in before if reserve(t) > 0]
            return _root(reserve, above[0], looks[k]) if above else looks[0]
        if k > 1 and values[k - 1] < min(values[k - 2], values[k]):
            lowest = minimize_scalar(reserve, bounds=looks[[k - 2, k]], method="bounded").x
            if reserve(lowest) < 0:
                return _root(reserve, looks[k - 2], lowest)
    return np.inf


def _root(function, begin, end):
    """A zero to the last digit that brentq allows."""
    return brentq(function, begin, end, xtol=1e-17, rtol=4 * np.finfo(float).eps)
