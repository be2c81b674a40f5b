r"""A leg that arrives without vibration, and in line: motion and feed-forward for the drives.

Friction makes what a shaper can't take away. It drags the upper carriage behind the lower
one, excites the modes when it starts and when it ends, and holds the upper carriage up to
$\mu H$ out of line for good. While both carriages slide it is a constant force, though, and
a motion of the lower carriage can bring everything to rest at one moment: that motion is
found by least squares through the simulation with exact friction
(`tuning.plan.search.stages`), for the fitted robot, for robots that the fit doesn't rule out,
and for starts that friction holds out of line.

The drives are led by dynamics inversion, so that the search needs but the undriven coordinates
(`scdpr_jax.engines.led_stepping`); on robots that aren't as fitted the PD leaves deviations,
and the search knows those (`tuning.plan.led.servo`). What comes of a plan is computed by the
whole closed loop in the end (`tuning.plan.expectation`), and where the plain profile is
expected to leave less, the plain profile it is.
"""

import concurrent.futures
import dataclasses
import functools
from collections.abc import Iterable, Iterator, Sequence

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Float

from scdpr_jax.command.controller import PD
from scdpr_jax.numerics.progress import SILENT, Progress, listening
from scdpr_jax.numerics.side_by_side import CORES
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.robot.quantities import replace
from tuning.plan.at_rate import planned
from tuning.plan.expectation import ROBOTS, Expectation, expectation
from tuning.plan.leg import Leg
from tuning.plan.pace import Pace
from tuning.plan.plan import Plan
from tuning.plan.search.misfit import Misfit
from tuning.plan.search.scenarios import scenarios
from tuning.plan.search.stages import (
    COARSE,
    FINE,
    FIRST,
    Models,
    descend,
    models,
    search,
    stepped,
)

LEG_TIME = 2.0
"""Time of a leg that is not asked for otherwise, if the drives can [s]."""
LONGER = 1.12
"""By what a time is multiplied in which no motion is good [1]."""
ATTEMPTS = 4
"""Times that are tried; in the first of them the drives could follow the plain profile."""
STILL, ON_TARGET = 0.15e-3, 0.3e-3
"""Vibration and resting error of the fitted robot up to which a motion is good [m]."""
NEGLIGIBLE = 0.3e-3
"""Mean vibration up to which no plain profile is preferred, which rests millimetres off [m]."""
UNSTEADY = 2e-3
"""By how much a line's slope may be beyond twice what friction holds [1]: more is no noise of a
camera, but another quantity."""
WITHIN = 0.93
"""Share of the voltage limit up to which its commands are [1]."""


UNFORETOLD = 0.5
"""Share of the cables' give that leads a simulated plan astray [1]. A fit doesn't tell their
compliance from the drives' backlash and ripple, and as if half of the give were another's is
what elastic rigs do after their legs, to a fifth."""
_MOST = 16
"""Legs that another process is asked for at once, so that progress is seen."""
_PREPARED = 14
"""Legs whose planning takes as long as the robots' models, which are made before the first."""


@dataclasses.dataclass(frozen=True, eq=False)
class Planned:
    """A leg as it was planned, and what is expected of it."""

    leg: Leg
    """The leg; its time is longer than asked for where the drives can't do it in that."""
    plan: Plan
    """What the controller is told."""
    simulated: Plan
    """What stands for it in engines, whose cables don't give: led ahead by `UNFORETOLD` of what
    they would."""
    asked_time: float = dataclasses.field(metadata=si("s"))
    """Time that was asked for [s]."""
    expected: Expectation
    """Of the plan."""
    plain: Expectation
    """Of the plain profile in the time that was asked for, under the same PD alone."""

    @property
    def is_plain(self) -> bool:
        """Whether the plan is the plain profile, of which less vibration is expected."""
        return self.expected is self.plain


@dataclasses.dataclass(frozen=True)
class Wanted:
    """A leg that is asked for."""

    start: tuple[float, float]
    """Where the end-effector rests, $[x_e, y_e]$ [m]."""
    end: tuple[float, float]
    """Where it is to go [m]."""
    time: float | None = dataclasses.field(default=None, metadata=si("s"))
    """In which time [s]; None for `LEG_TIME`, or what the drives need."""
    slope: float | None = dataclasses.field(default=None, metadata=si("1"))
    """Slope of the line between the carriages, $(q_3 - q_4) / H$ [1]; None where it isn't told:
    in line, or any that friction holds."""


def plan_leg(
    robot: Robot,
    controller: PD,
    start: tuple[float, float],
    end: tuple[float, float],
    *,
    leg_time: float | None = None,
    slope: float | None = None,
    progress: Progress | bool = SILENT,
) -> Planned:
    """The motion of one leg from rest to rest.

    Args:
        robot: The fitted robot, with exact friction.
        controller: The PD controller that it will run under.
        start: Where the end-effector rests [m].
        end: Where it is to go [m].
        leg_time: Time of the leg [s]; None for `LEG_TIME`, or where the drives can't the
            shortest in which they can.
        slope: Slope of the line between the carriages, see `resting_start` [1]; None where it
            isn't told.
        progress: Told what is being done and which share of it is done;
            True shows it in a notebook.

    Returns:
        The plan, and what is expected of it.

    Raises:
        ValueError: If a number isn't finite, the time isn't positive, or the leg leads nowhere.
    """
    progress = listening(progress)
    planner = Planner(robot, controller)
    wanted = Wanted(tuple(map(float, start)), tuple(map(float, end)), leg_time, slope)
    return planner(wanted, progress=progress)


def plan_legs(
    robot: Robot,
    controller: PD,
    legs: Iterable[Wanted],
    *,
    processes: concurrent.futures.Executor | None = None,
    progress: Progress | bool = SILENT,
) -> list[Planned]:
    """Plans of many legs.

    Args:
        robot: The fitted robot, with exact friction.
        controller: The PD controller that it will run under.
        legs: What is asked for.
        processes: Who shares them out, a `concurrent.futures.ProcessPoolExecutor()` for one;
            None for this process alone. Threads would wait for each other: a third of a
            search is Python.
        progress: Told which share is done;
            True shows it in a notebook.

    Returns:
        A plan for each, the same as `plan_leg` makes.

    Raises:
        ValueError: If one of them can't be planned.
    """
    progress = listening(progress)
    legs = list(legs)
    for leg in legs:
        _refuse(leg)
    made: list[Planned] = []
    for some in _parts(robot, controller, legs, processes):
        made += some
        share = (_PREPARED + len(made)) / (_PREPARED + len(legs))
        progress(f"{len(made)} of {len(legs)} legs", share)
    return made


def _parts(
    robot: Robot,
    controller: PD,
    legs: list[Wanted],
    processes: concurrent.futures.Executor | None,
) -> Iterator[list[Planned]]:
    """The plans in order, some at a time."""
    if processes is None:
        planner = Planner(robot, controller)
        yield from ([planner(leg)] for leg in legs)
        return
    size = min(-(-len(legs) // (2 * CORES)), _MOST)
    rows = [legs[k : k + size] for k in range(0, len(legs), size or 1)]
    # JAX's arrays would arrive in the precision that the other process has so far.
    told = jax.tree.map(np.asarray, (robot, controller))
    part = functools.partial(_part, bool(jax.config.jax_enable_x64), *told)
    yield from processes.map(part, rows)


def _part(double: bool, robot: Robot, controller: PD, legs: list[Wanted]) -> list[Planned]:
    """Plans of some legs, as another process makes them: in the precision of the first."""
    jax.config.update("jax_enable_x64", double)
    return list(map(Planner(*jax.tree.map(jnp.asarray, (robot, controller))), legs))


class Planner:
    """Plans legs of one robot."""

    def __init__(self, robot: Robot, controller: PD):
        """The robots that its legs are planned for are made here.

        Args:
            robot: The fitted robot, with exact friction.
            controller: The PD controller that it runs under.
        """
        self._robot, self._controller, self._pace = robot, controller, Pace(robot)
        # A list of legs shares them; a leg alone needs but one kind.
        self._models = functools.cache(lambda told: models(robot, controller, told=told))
        self._judges = functools.cache(lambda told: scenarios(robot, ROBOTS, told=told))

    def __call__(self, wanted: Wanted, *, progress: Progress = SILENT) -> Planned:
        """A leg's plan.

        Args:
            wanted: The leg.
            progress: Told what is being done and which share of it is done.

        Returns:
            The plan, and what is expected of it.

        Raises:
            ValueError: If it is no leg.
        """
        _refuse(wanted)
        robot, controller, told = self._robot, self._controller, wanted.slope is not None
        time = LEG_TIME if wanted.time is None else wanted.time
        leg = Leg(wanted.start, wanted.end, time, wanted.slope or 0.0)
        found, coefficients = _motion(self._pace, self._models(told), leg, progress)
        progress("what is expected of it", 0.9)
        period = float(controller.period)
        plan = simulated = planned(_rigid(robot), found, coefficients, period=period)
        if float(robot.drive.compliance):
            plan = planned(robot, found, coefficients, period=period)
            ahead = UNFORETOLD * (plan.angle - simulated.angle)
            simulated = dataclasses.replace(simulated, angle=simulated.angle + ahead)
        judges = self._judges(told)
        expected = expectation(judges, controller, found, simulated)
        profile = plain_plan(leg, controller, radius=float(robot.drive.effective_radius))
        plain = expectation(judges, controller, leg, profile)
        if plain.mean < expected.mean and expected.mean > NEGLIGIBLE:
            return Planned(leg, profile, profile, time, plain, plain)
        return Planned(found, plan, simulated, time, expected, plain)


def resting_start(
    robot: Robot, pose: Sequence[float] | Float[np.ndarray, "5"]
) -> tuple[tuple[float, float], float]:
    r"""Where a robot rests, from what a camera tells of it.

    The end-effector lies on the line between the carriages; that line is the least squares' one
    through the three places, which a camera knows alike.

    Args:
        robot: The robot.
        pose: $[x_e, \delta_e, q_3, q_4, y_e]$ [m, rad, m, m, m]; the rotation isn't needed.

    Returns:
        Place of the end-effector on the line [m], and the line's slope [1].
    """
    x, _, lower, upper, height = map(float, pose)
    heights = np.array([height, 0.0, float(robot.frame.height)])
    places = np.array([x, lower, upper])
    middle = np.mean(heights)
    away = heights - middle
    slope = -float(away @ places / (away @ away))
    return (float(np.mean(places)) - slope * (height - middle), height), slope


def plain_plan(leg: Leg, controller: PD, *, radius: float) -> Plan:
    """The curve of section 6.2 as a plan without feed-forward.

    Args:
        leg: The leg.
        controller: The controller, for its period.
        radius: Effective radius of the driver pulleys [m].

    Returns:
        The plan.
    """
    period = float(controller.period)
    samples = int(np.ceil(leg.time / period - 1e-9))
    s = np.minimum(period * np.arange(samples + 1) / leg.time, 1.0)
    way = np.outer(s * s * (3 - 2 * s), np.subtract(leg.end, leg.start))
    angle = np.stack([way[:, 0] + way[:, 1], way[:, 0] - way[:, 1]], axis=1) / radius
    return Plan(
        time=period * np.arange(samples + 1),
        position=np.array(leg.start) + way,
        angle=angle,
        feedforward=np.zeros_like(angle),
    )


def _rigid(robot: Robot) -> Robot:
    return replace(robot, {"drive_compliance": 0.0})


def _motion(
    pace: Pace, about: Models, leg: Leg, progress: Progress
) -> tuple[Leg, Float[np.ndarray, " splines"]]:
    """A leg's motion, in the first time in which the fitted robot has a good one."""
    leg = pace.possible(leg)
    for attempt in range(ATTEMPTS):
        progress(f"motion in {leg.time:.3g} s", 0.2 * attempt / ATTEMPTS)
        coarse = stepped(leg, COARSE)
        alone = Misfit(about.fitted, coarse)
        first = descend(alone, np.zeros(leg.splines), FIRST).point
        if attempt == ATTEMPTS - 1 or _is_good(alone, first):
            break
        leg = pace.paced(dataclasses.replace(leg, time=leg.time * LONGER))
    progress(f"motion in {leg.time:.3g} s for robots as they might be", 0.2)
    fine = Misfit(about.every, stepped(leg, FINE))
    return leg, min(search(about, coarse, fine), first, key=fine.cost)


def _is_good(fitted: Misfit, point: Float[np.ndarray, " splines"]) -> bool:
    """Whether the fitted robot is at rest at the target, and its drives within their limits."""
    run = fitted.rehearsed(point)
    (*_, rest), (vibration,) = run.arrived[0], run.vibrations()
    most = WITHIN * float(fitted.team.robots.robot.drive.voltage_limit[0])
    asked = float(np.max(np.abs(run.commands)))
    return bool(vibration <= STILL and abs(rest) <= ON_TARGET and asked <= most)


def _refuse(leg: Wanted) -> None:
    """Refuse what is no leg."""
    numbers = (*leg.start, *leg.end, leg.time or 1.0, leg.slope or 0.0)
    if not np.all(np.isfinite(numbers)):
        raise ValueError(
            f"a leg's numbers must be finite, got {leg}. Give places within the frame [m], a "
            "time [s] and a slope [1]."
        )
    if leg.time is not None and not leg.time > 0:
        raise ValueError(
            f"`leg_time` must be positive, got {leg.time:g} s. Give the leg a time; what the "
            "drives can't do in it gets a longer one."
        )
    if leg.start == leg.end:
        raise ValueError(
            f"`end` is where the leg starts, got {leg.end} [m]: there is no leg to plan. "
            "Name another place."
        )
