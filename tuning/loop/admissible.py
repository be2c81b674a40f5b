"""Which gains the flexible robot's margins allow, over poses, settings and both carriages."""

from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.controller import PD
from scdpr_jax.robot.drive import drive_gain, drive_pole
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from tuning.loop.flexible_margins import FlexibleMargins, flexible_margins
from tuning.loop.loop_shaping import shape_sampled_loop
from tuning.loop.plant import MotorPlant, sampled_response
from tuning.loop.responses import sampled_delay, sampled_derivative
from tuning.loop.worst_margins import reach

PHASE_MARGIN = np.deg2rad(30.0)
"""Least phase margin of the flexible robot's loops [rad]."""
PEAK_SENSITIVITY = 2.0
"""Largest peak sensitivity of them [1]."""
CROSSOVERS = (25.0, 100.0)
"""Gain crossovers of a bare drive that are searched [rad/s]; Eq. (25) asks for 40."""

_NODES = 5
"""Crossovers at which the least phase margin of a bare drive is found."""
_LOWEST = np.deg2rad(60.0)
"""Phase margin of a bare drive from which the search for it goes up [rad]."""
_STEPS = 3
"""Steps of the false position after both ends: to some tenths of a degree, never below."""
_RESERVE = np.deg2rad(1.0)
"""Phase margin of a bare drive beyond the least: between crossovers and heights [rad]."""
_SHORT_OF_END = np.deg2rad(2.0)
"""Distance from the phase margin of a controller without a derivative or with nothing else
[rad]."""


class Admissible(eqx.Module):
    """Gains by crossover and phase margin of a bare drive, between bounds."""

    plant: MotorPlant
    """The bare drive."""
    crossover: Float[Array, " nodes"] = eqx.field(metadata=si("rad/s", r"\\omega_c"))
    """Crossovers [rad/s]."""
    lowest: Float[Array, " nodes"] = eqx.field(metadata=si("rad", r"\\varphi_m"))
    """Least phase margin of the bare drive at each, where the flexible robot's hold [rad]."""
    highest: Float[Array, " nodes"] = eqx.field(metadata=si("rad", r"\\varphi_m"))
    """Largest phase margin of the bare drive [rad]."""

    def controller(self, share: Float[Array, "2"]) -> PD:
        """The controller at some place between the bounds.

        Args:
            share: Place of crossover and phase margin, from 0 to 1 [1].

        Returns:
            The controller at 1 kHz.
        """
        low, high = self.crossover[0], self.crossover[-1]
        crossover = low + (high - low) * share[0]
        least, most = (
            jnp.interp(crossover, self.crossover, bound)
            for bound in (self.lowest, self.highest)
        )
        margin = least + (most - least) * share[1]
        return shape_sampled_loop(self.plant, crossover=crossover, phase_margin=margin)

    def share(self, crossover: float, phase_margin: float) -> tuple[float, float]:
        """Where between the bounds a wish lies, or what comes nearest.

        Args:
            crossover: Gain crossover of the bare drive [rad/s].
            phase_margin: Its phase margin [rad].

        Returns:
            The shares [1], a little inside.
        """
        nodes = np.asarray(self.crossover)
        least, most = (np.interp(crossover, nodes, b) for b in (self.lowest, self.highest))
        return _share(crossover, nodes[0], nodes[-1]), _share(phase_margin, least, most)


_INSIDE = 0.03
"""Share that a start keeps from a bound, where a logit has no slope [1]."""


def _share(wish: float, low: float, high: float) -> float:
    # Bounds that meet leave nothing to choose.
    share = (wish - low) / (high - low) if high > low else 0.5
    return float(np.clip(share, _INSIDE, 1 - _INSIDE))


def admissible(robots: Sequence[Robot], heights: Sequence[float] = ()) -> Admissible:
    """The gains with which every loop of the flexible robot keeps its margins.

    Args:
        robots: The robot at each of its settings.
        heights: Heights of the end-effector at which margins are looked at [m]; none for the
            lowest and the highest within reach and the middle, one of which has the least.

    Returns:
        The bounds. Where no gains that are searched keep the margins, the most damped of
        them: `worst_margins` tells what is left.
    """
    every = np.asarray(heights or np.linspace(*reach(robots[0]), 3))
    stacked = jax.tree.map(lambda *leaves: np.stack(leaves), *robots)
    plant = _plant(robots[0])
    crossover = np.geomspace(*CROSSOVERS, _NODES)
    without, alone = map(np.asarray, _ends(plant, crossover))
    highest = alone - _SHORT_OF_END

    def slack(margin: Float[np.ndarray, " nodes"]) -> Float[np.ndarray, " nodes"]:
        return slack_of(flexible_margins(stacked, every, _shaped(plant, crossover, margin)))

    good, bad = highest, np.clip(_LOWEST, without + _SHORT_OF_END, highest)
    above, below = slack(good), slack(bad)
    usable = above >= 0
    if not usable.any():
        return Admissible(plant, *map(jnp.asarray, (crossover, highest, highest)))
    for _ in range(_STEPS):
        # The false position, its standing end weighed by half (Illinois).
        bracketed = (below < 0) & usable
        middle = bad.copy()
        np.divide(good * below - bad * above, below - above, out=middle, where=bracketed)
        between = slack(middle)
        kept = between >= 0
        good, bad = np.where(kept, middle, good), np.where(kept, bad, middle)
        above, below = (
            np.where(kept, between, above / 2),
            np.where(kept, np.where(bracketed, below / 2, below), between),
        )
    first = int(np.argmax(usable))
    last = first + int(np.argmin(np.append(usable[first:], False))) - 1
    # The last node again for each that is left out: one compiled function serves all bounds.
    chosen = np.minimum(first + np.arange(_NODES), last)
    lowest = np.minimum(good + _RESERVE, highest)
    return Admissible(
        plant, *(jnp.asarray(each[chosen]) for each in (crossover, lowest, highest))
    )


def any_bounds(robot: Robot) -> Admissible:
    """Bounds that nothing is known to keep, to compile with.

    Args:
        robot: A robot.

    Returns:
        The bounds.
    """
    plant, crossover = _plant(robot), np.geomspace(*CROSSOVERS, _NODES)
    lowest = np.full(_NODES, _LOWEST)
    return Admissible(plant, *map(jnp.asarray, (crossover, lowest, lowest + _RESERVE)))


@jax.jit
def _plant(robot: Robot) -> MotorPlant:
    return MotorPlant(gain=drive_gain(robot.drive), pole=drive_pole(robot.drive))


def slack_of(flexible: FlexibleMargins) -> Float[np.ndarray, "*controllers"]:
    """By how much the worst loop keeps its margins, relative to what it must.

    Args:
        flexible: Margins by controller, loop, robot and height.

    Returns:
        Slack under each controller [1].
    """
    # A loop whose gain never reaches one has no phase margin, and none to worry about.
    phase = np.nan_to_num(flexible.margins.phase_margin, nan=np.inf)
    peak = flexible.margins.peak_sensitivity
    least = np.minimum(phase / PHASE_MARGIN, PEAK_SENSITIVITY / peak)
    kept = np.where(flexible.spectral_radius < 1, least, 0.0)
    return np.min(kept, axis=(-3, -2, -1)) - 1


@jax.jit
def _shaped(
    plant: MotorPlant,
    crossover: Float[Array | np.ndarray, " nodes"],
    phase_margin: Float[Array | np.ndarray, " nodes"],
) -> PD:
    """Controllers of bare drives, stacked."""
    return jax.vmap(lambda w, m: shape_sampled_loop(plant, crossover=w, phase_margin=m))(
        crossover, phase_margin
    )


@jax.jit
def _ends(
    plant: MotorPlant, crossover: Float[Array | np.ndarray, " nodes"]
) -> tuple[Float[Array, " nodes"], Float[Array, " nodes"]]:
    """Phase margins of the bare drive without a derivative and with nothing else [rad]."""
    period, filter_time = jnp.asarray(1e-3), jnp.asarray(0.0)

    def of(w: Float[Array, ""]) -> tuple[Float[Array, ""], Float[Array, ""]]:
        lag = sampled_delay(w, period=period, delay=1)
        drive = lag * sampled_response(plant, w, period=period)
        derivative = sampled_derivative(w, period=period, filter_time=filter_time)
        return jnp.angle(-drive), jnp.angle(-derivative * drive)

    return jax.vmap(of)(crossover)
