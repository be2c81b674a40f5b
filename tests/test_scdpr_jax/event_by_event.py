"""The robot's motion event by event: slow, and so simple that one can see that it is right.

Written anew from the paper's Eqs. (4), (7), (8), (16) and (21), without `scdpr_jax`. Each
carriage slides forwards (+1), backwards (-1) or sticks (0). Between events the motion is
smooth, and DOP853 follows it to rounding; an event is where a sliding carriage's velocity
or a sticking one's reserve of friction crosses zero, found on the integrator's own dense
output. Within one interval of the inputs, events closer than an eighth of a solver's step
to the one before could be missed.
"""

import dataclasses
import itertools

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

LOOKS = 8
"""Places in a solver's step at which an event is looked for."""


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

    @property
    def masses(self):
        """Masses of [x_e, δ_e, q_3, q_4, y_e]."""
        drives = 2 * self.drive_inertia / self.effective_radius**2
        m_e = self.end_effector_mass
        m_3, m_4 = self.lower_carriage_mass + drives, self.upper_carriage_mass
        return np.array([m_e, self.end_effector_inertia, m_3, m_4, m_e + drives])


def balance(robot, position, velocity, voltage, knock):
    """Forces without dry friction, and the largest friction of both carriages [N]."""
    x, tilt, lower, upper, y = position
    a, b, H = robot.lower_offset, robot.upper_offset, robot.frame_height
    alpha = np.arctan2(lower - x - a * np.sin(tilt), y - a * np.cos(tilt))
    beta = np.arctan2(x - upper - b * np.sin(tilt), H - y - b * np.cos(tilt))
    gamma = np.arctan2(lower - upper, H)
    T = 2 * robot.effective_pretension
    tau = robot.torque_per_volt * np.clip(voltage, -robot.voltage_limit, robot.voltage_limit)
    r = robot.effective_radius
    drag = 2 * robot.drive_damping / r**2
    forces = [
        T * (np.sin(alpha) - np.sin(beta)) + knock,
        T * (a * np.sin(alpha - tilt) + b * np.sin(beta - tilt)),
        -T * (np.sin(gamma) + np.sin(alpha)) + (tau[0] + tau[1]) / r - drag * velocity[2],
        T * (np.sin(gamma) + np.sin(beta)),
        T * (np.cos(beta) - np.cos(alpha)) + (tau[0] - tau[1]) / r - drag * velocity[4],
    ]
    limits = [
        robot.lower_friction * T * (np.cos(gamma) + np.cos(alpha)),
        robot.upper_friction * T * (np.cos(gamma) + np.cos(beta)),
    ]
    return np.array(forces), np.array(limits)


def simulate(robot, start, *, duration, voltage, knock=None):
    """States at the ends of the intervals, and which carriages stick there.

    `start` holds 5 positions and 5 velocities; inputs are held through their interval.
    """
    knock = np.zeros(len(duration)) if knock is None else knock
    state, modes = np.array(start, dtype=float), None
    states, sticks = [state], []
    for held in zip(duration, voltage, knock, strict=True):
        state, modes = _interval(robot, state, *held)
        states.append(state)
        sticks.append([mode == 0 for mode in modes])
    return np.array(states), np.array(sticks)


def _interval(robot, state, duration, voltage, knock):
    forces, limits = balance(robot, state[:5], state[5:], voltage, knock)
    modes = [_mode(state[7 + i], forces[2 + i], limits[i]) for i in range(2)]
    time = 0.0
    while time < duration:
        time, state, event = _until_event(robot, state, modes, time, duration, voltage, knock)
        if event is None:
            break
        forces, limits = balance(robot, state[:5], state[5:], voltage, knock)
        if modes[event] == 0:
            modes[event] = int(np.sign(forces[2 + event]))
        else:
            modes[event] = _mode(0.0, forces[2 + event], limits[event])
    return state, modes


def _mode(velocity, force, limit):
    if velocity != 0:
        return int(np.sign(velocity))
    return int(np.sign(force)) if abs(force) > limit else 0


def _until_event(robot, state, modes, time, duration, voltage, knock):
    """Follow the smooth motion to the first event or to the interval's end."""

    def slope(_, state):
        forces, limits = balance(robot, state[:5], state[5:], voltage, knock)
        for i, mode in enumerate(modes):
            forces[2 + i] = 0.0 if mode == 0 else forces[2 + i] - mode * limits[i]
        return np.concatenate([state[5:], forces / robot.masses])

    def reserve(state, i):
        """Positive until carriage `i` leaves its mode."""
        if modes[i] != 0:
            return modes[i] * state[7 + i]
        forces, limits = balance(robot, state[:5], state[5:], voltage, knock)
        return limits[i] - abs(forces[2 + i])

    smooth = solve_ivp(
        slope,
        (time, duration),
        state,
        method="DOP853",
        rtol=1e-12,
        atol=1e-14,
        dense_output=True,
        max_step=5e-3,
    )
    looks = np.concatenate(
        [np.linspace(*ends, LOOKS, endpoint=False) for ends in itertools.pairwise(smooth.t)]
        + [smooth.t[-1:]]
    )
    found = []
    for i in range(2):
        reserves = [reserve(smooth.sol(t), i) for t in looks]
        # What begins an interval at its limit has no reserve there.
        for k in range(1, len(looks)):
            if reserves[k] < 0 and (reserves[k - 1] > 0 or k > 1):
                if reserves[k - 1] > 0:
                    instant = brentq(
                        lambda t, i=i: reserve(smooth.sol(t), i),
                        looks[k - 1],
                        looks[k],
                        xtol=1e-16,
                        rtol=8.9e-16,
                    )
                    found.append((instant, i))
                break
    if not found:
        end = smooth.y[:, -1].copy()
        end[[7 + i for i in range(2) if modes[i] == 0]] = 0.0
        return duration, end, None
    instant, event = min(found)
    at = smooth.sol(instant)
    at[[7 + i for i in range(2) if modes[i] == 0 or i == event]] = 0.0
    return instant, at, event
