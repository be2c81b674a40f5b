"""What the scheduled shapers leave of the held mode, between the grid's points too."""

import dataclasses
from typing import NamedTuple

import equinox as eqx
import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Float

from scdpr_jax.command.shaper import Shaper, residual_vibration
from scdpr_jax.linear.modes import held_frequency
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Robot
from scdpr_jax.statics.workspace import static_workspace
from tuning.loop.worst_margins import reach
from tuning.regions.schedule import Schedule, regions_at, schedule_of
from tuning.result.tuning import Tuning

_BAND_POINTS = 9
"""Frequencies at which a band is looked at; a shaper of 1 s has no structure between."""
_COLUMNS, _ROWS = 89, 41
"""Poses that are looked at: some 20 mm apart in the prototype's frame."""


class WorstResidual(NamedTuple):
    """The largest value of a map, and where it is."""

    value: float
    """Residual vibration $V$, or a difference of two [1]."""
    x: float
    """Horizontal position of the end-effector [m]."""
    y: float
    """Its height [m]."""


@dataclasses.dataclass(frozen=True, eq=False)
class ResidualMap:
    """Residual vibration after legs that end at a pose, over the workspace."""

    pretension: float = dataclasses.field(metadata=si("N", "T"))
    """Nominal setting of the cable loop [N]."""
    x: Float[np.ndarray, " columns"] = dataclasses.field(metadata=si("m", "x_e"))
    """Horizontal positions [m]."""
    y: Float[np.ndarray, " rows"] = dataclasses.field(metadata=si("m", "y_e"))
    """Heights [m]."""
    residual: Float[np.ndarray, "rows columns"] = dataclasses.field(metadata=si("1", "V"))
    """Largest residual vibration over the frequency's band [1]; without a shaper it is 1."""
    promised: Float[np.ndarray, "rows columns"] = dataclasses.field(metadata=si("1", "V"))
    """What the region of a pose promises at its own point [1]."""

    @property
    def worst(self) -> WorstResidual:
        """The largest one with its place."""
        return self._largest(self.residual)

    @property
    def beyond(self) -> WorstResidual:
        """By how much it exceeds what the pose's region promises, at most, with the place."""
        return self._largest(self.residual - self.promised)

    def _largest(self, values: Float[np.ndarray, "rows columns"]) -> WorstResidual:
        row, column = np.unravel_index(int(np.argmax(values)), values.shape)
        return WorstResidual(
            float(values[row, column]), float(self.x[column]), float(self.y[row])
        )


class HeldMode(eqx.Module):
    """The mode that friction holds, anywhere: the model's, corrected where it was measured."""

    robot: Robot
    """The robot at the setting."""
    schedule: Schedule
    """The shapers' schedule, whose weights interpolate between the regions."""
    ratio: Float[Array, " regions"]
    """Frequency of each region over the model's at the same height [1]."""
    spread: Float[Array, " regions"]
    """Two standard errors of it, as a share of it [1]."""
    damping_ratio: Float[Array, " regions"]
    """Damping ratio of each region [1]."""

    def band(self, position: Float[Array, "2"]) -> Float[Array, "2"]:
        r"""Where the natural frequency lies at a pose.

        $$ f(x, y) = f_\text{model}(y) \sum_i w_i(x, y)\, \frac{f_i}{f_\text{model}(y_i)} $$

        Args:
            position: Position $[x_e, y_e]$ of the end-effector [m].

        Returns:
            That frequency less and plus two standard errors [Hz].
        """
        weights = self.schedule.weights(position)
        frequency = held_frequency(self.robot, position[1]) * (weights @ self.ratio)
        spread = weights @ self.spread
        return frequency * jnp.stack([1 - spread, 1 + spread])

    def residual(self, position: Float[Array, "2"]) -> Float[Array, ""]:
        """What the schedule's shaper at a pose leaves of the mode there, at worst.

        Args:
            position: Position $[x_e, y_e]$ of the end-effector, where a leg ends [m].

        Returns:
            The largest residual vibration over the frequency's band [1].
        """
        return worst_in_band(
            self.schedule.at(position),
            band=self.band(position),
            damping_ratio=self.schedule.weights(position) @ self.damping_ratio,
        )


def held_mode(tuning: Tuning, pretension: float) -> HeldMode:
    """The mode that friction holds, from a tuning's robot and its shapers' frequencies.

    Args:
        tuning: The tuning.
        pretension: Nominal setting of the cable loop [N].

    Returns:
        The mode.

    Raises:
        ValueError: If the tuning has no robot at that setting, or no grid of shapers.
    """
    robot = tuning.robot_at(pretension).robot
    here = regions_at(tuning.shapers, pretension)
    frequency = np.array([regional.frequency for regional in here])
    band = np.array([regional.band for regional in here])
    heights = np.array([regional.height for regional in here])
    return HeldMode(
        robot=robot,
        schedule=schedule_of(tuning.shapers, pretension),
        ratio=jnp.asarray(frequency / np.asarray(_held_frequencies(robot, heights))),
        spread=jnp.asarray((band[:, 1] - band[:, 0]) / (2 * frequency)),
        damping_ratio=jnp.asarray(np.array([regional.damping_ratio for regional in here])),
    )


def residual_map(tuning: Tuning, pretension: float) -> ResidualMap:
    """What the shapers leave after legs that end anywhere in the workspace.

    Args:
        tuning: The tuning.
        pretension: Nominal setting of the cable loop [N].

    Returns:
        The map, over Eq. (1)'s horizontal positions and the heights within `reach`.

    Raises:
        ValueError: If the tuning has no robot at that setting, or no grid of shapers.
    """
    mode = held_mode(tuning, pretension)
    workspace = static_workspace(mode.robot)
    x = np.linspace(float(workspace.lowest[0]), float(workspace.highest[0]), _COLUMNS)
    y = np.linspace(*reach(mode.robot), _ROWS)
    poses = jnp.asarray(np.stack(np.meshgrid(x, y), axis=-1))
    promised = [
        [tuning.shaper_at(*place, pretension).residual_vibration.worst for place in row]
        for row in poses.tolist()
    ]
    residual = np.asarray(_residuals(mode, poses))
    return ResidualMap(pretension, x, y, residual, np.asarray(promised))


_held_frequencies = jax.jit(jax.vmap(held_frequency, (None, 0)))


@eqx.filter_jit
def _residuals(
    mode: HeldMode, poses: Float[Array, "rows columns 2"]
) -> Float[Array, "rows columns"]:
    return jax.vmap(jax.vmap(mode.residual))(poses)


@jax.jit
def worst_in_band(
    shaper: Shaper, *, band: Float[Array, "2"], damping_ratio: Float[Array, ""]
) -> Float[Array, ""]:
    """The largest residual vibration of a mode whose frequency is known to a band.

    Args:
        shaper: The impulses.
        band: Lowest and highest natural frequency [Hz].
        damping_ratio: Damping ratio of the mode [1].

    Returns:
        Residual vibration [1].
    """
    frequencies = jnp.linspace(band[0], band[1], _BAND_POINTS)
    left = jax.vmap(
        lambda f: residual_vibration(shaper, frequency=f, damping_ratio=damping_ratio)
    )
    return jnp.max(left(frequencies))
