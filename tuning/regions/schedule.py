"""The shapers of a pretension setting as one map over the workspace, without jumps."""

import itertools
from collections.abc import Sequence

import equinox as eqx
import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from scdpr_jax.command.shaper import Shaper, padded, shape_samples
from scdpr_jax.command.trajectory import Trajectory
from scdpr_jax.robot.fields import real, si
from tuning.result.regional_shaper import Range, RegionalShaper, nearest_setting

HANDOVER = 0.5
"""Width of a hand-over, as a share of the smaller region beside it [1].

At 1 two hand-overs of a region would meet in its middle; so each region keeps half of its
size, at least, to its own shaper alone.
"""


class HandOvers(eqx.Module):
    """Where shapers hand over to each other along one axis."""

    middle: Float[Array, " lines"] = eqx.field(converter=real, metadata=si("m"))
    """Lines between the stretches of the axis, ascending [m]."""
    width: Float[Array, " lines"] = eqx.field(converter=real, metadata=si("m"))
    """Width of the hand-over about each line [m]."""

    def weights(self, place: Float[Array, ""]) -> Float[Array, " stretches"]:
        r"""How much each stretch of the axis counts at a place.

        $$ w_i = S(u_i)\, S(1 - u_{i+1}), \qquad u_i = \frac{x - x_i}{h_i} + \frac12, \qquad
           S(u) = 10u^3 - 15u^4 + 6u^5 $$

        with $x_i$, $h_i$ the line below stretch i and the width of its hand-over; the first
        stretch has no line below it, the last none above, so beyond the frame they hold.
        $S(u) + S(1 - u) = 1$ and hand-overs don't overlap: the sum is one.

        Args:
            place: Coordinate of the end-effector [m].

        Returns:
            Weights [1], not negative, of sum 1; one more than lines.
        """
        along = (place - self.middle) / self.width
        whole = jnp.ones(1, dtype=along.dtype)
        above = jnp.concatenate([whole, _smoothstep(0.5 + along)])
        below = jnp.concatenate([_smoothstep(0.5 - along), whole])
        return above * below


class Schedule(eqx.Module):
    """Shapers of regions in a grid, each of which hands over smoothly to the next."""

    shaper: Shaper
    """The regions' shapers, row by row from the lower left, as many impulses each."""
    columns: HandOvers
    """Hand-overs along $x_e$."""
    rows: HandOvers
    """Hand-overs along $y_e$."""

    def weights(self, position: Float[Array, "2"]) -> Float[Array, " regions"]:
        r"""How much each region's shaper counts at a pose: $w_i(x, y)$.

        Args:
            position: Position $[x_e, y_e]$ of the end-effector [m].

        Returns:
            Weights [1], not negative, of sum 1; a single one where no shaper hands over.
        """
        x, y = position
        return jnp.outer(self.rows.weights(y), self.columns.weights(x)).ravel()

    def at(self, position: Float[Array, "2"]) -> Shaper:
        """The one shaper that the schedule is at a pose.

        Args:
            position: Position $[x_e, y_e]$ of the end-effector [m].

        Returns:
            Impulses of all regions, their amplitudes times the regions' weights. Those
            without any stand at 0, so that the last one tells the duration.
        """
        amplitudes = (self.weights(position)[:, None] * self.shaper.amplitudes).ravel()
        times = jnp.where(amplitudes == 0, 0.0, self.shaper.times.ravel())
        order = jnp.argsort(times)
        return Shaper(times[order], amplitudes[order])


class ScheduledTrajectory(Trajectory):
    r"""A trajectory shaped by the shaper of where it is.

    $$ p_s(t) = \sum_i w_i(p(t)) \sum_k A_{ik}\, p(t - t_{ik}) $$

    Both coordinates have the same weights: a straight path stays straight. A hand-over at
    speed is itself a motion, as shapers delay by different times, $\dot p_s = \sum_i w_i
    \dot p_i + \sum_i \dot w_i p_i$, and it excites the mode: for a leg whose end is known,
    `ShapedTrajectory` with `Schedule.at` its end leaves less.
    """

    trajectory: Trajectory
    """The reference to shape."""
    schedule: Schedule
    """The shapers."""

    @property
    def duration(self) -> Float[Array, "..."]:
        return self.trajectory.duration + jnp.max(self.schedule.shaper.duration)

    def position(self, time: Float[Array, ""]) -> Float[Array, "2"]:
        position, shaper = self.trajectory.position, self.schedule.shaper
        weights = self.schedule.weights(position(time))
        delayed = jax.vmap(jax.vmap(position))(time - shaper.times)
        return jnp.einsum("i,ik,ika->a", weights, shaper.amplitudes, delayed)


def scheduled_samples(
    schedule: Schedule,
    samples: Float[Array, "time 2"],
    *,
    places: Float[Array, "time 2"],
    period: Float[Array, ""],
) -> Float[Array, "time 2"]:
    r"""A sampled reference shaped by the shapers of some places, see `shape_samples`.

    $$ s_n = \sum_i w_i(x_n, y_n) \sum_k A_{ik}\, p(nh - t_{ik}) $$

    Args:
        schedule: The shapers.
        samples: Reference $p$, $[x_e, y_e]$ at a constant rate [m].
        places: $[x_n, y_n]$ whose shapers count at each sample [m]: the reference itself for
            those of where it is, the end of the leg that is under way for the end's.
        period: Sample period $h$ [s].

    Returns:
        Shaped reference at the same instants [m].
    """
    weights = jax.vmap(schedule.weights)(places)
    shaped = jax.vmap(lambda shaper: shape_samples(shaper, samples, period=period))(
        schedule.shaper
    )
    return jnp.einsum("ti,ita->ta", weights, shaped)


def schedule_of(shapers: Sequence[RegionalShaper], pretension: float) -> Schedule:
    """The shapers of a setting as a schedule.

    Args:
        shapers: The shapers of a tuning.
        pretension: Nominal setting of the cable loop [N], one that was tuned.

    Returns:
        The schedule.

    Raises:
        ValueError: If no shaper is for that setting, or their regions aren't a grid.
    """
    here = regions_at(shapers, pretension)
    most = max(regional.shaper.times.size for regional in here)
    each = [padded(regional.shaper, most) for regional in here]
    return Schedule(
        shaper=jax.tree.map(lambda *leaves: jnp.stack(leaves), *each),
        columns=_hand_overs([regional.region.x for regional in here]),
        rows=_hand_overs([regional.region.y for regional in here]),
    )


def regions_at(
    shapers: Sequence[RegionalShaper], pretension: float
) -> tuple[RegionalShaper, ...]:
    """The regional shapers of a setting, in the order of a schedule's weights.

    Args:
        shapers: The shapers of a tuning.
        pretension: Nominal setting of the cable loop [N].

    Returns:
        Those of the nearest range of settings, row by row.

    Raises:
        ValueError: If no shaper is for that setting, or their regions aren't a grid.
    """
    grids = grids_of(shapers)
    near = nearest_setting(grids, pretension)
    if near is not None:
        return grids[near]
    settings = ", ".join(f"{low:g} to {high:g} N" for low, high in grids) or "none"
    raise ValueError(
        f"`shapers` has none for {pretension:g} N, got: {settings}. A shaper isn't carried "
        "over from one pretension to another: name a setting that was tuned, or tune there."
    )


def grids_of(
    shapers: Sequence[RegionalShaper],
) -> dict[Range, tuple[RegionalShaper, ...]]:
    """The regional shapers of every range of settings.

    Args:
        shapers: The shapers of a tuning.

    Returns:
        Shapers row by row from the lower left, by their range of nominal settings [N].

    Raises:
        ValueError: If the regions of a range aren't a grid.
    """
    ranges = dict.fromkeys(regional.region.pretension for regional in shapers)
    return {
        setting: _in_rows(
            [regional for regional in shapers if regional.region.pretension == setting]
        )
        for setting in ranges
    }


def handover_widths(spans: Sequence[Range]) -> dict[float, float]:
    """How wide the hand-over about each line of a grid is.

    Args:
        spans: The regions' stretches of an axis [m].

    Returns:
        Width by the line's coordinate [m].
    """
    return {
        line: HANDOVER * min(line - low, high - line)
        for (low, line), (_, high) in itertools.pairwise(sorted(set(spans)))
    }


def _hand_overs(spans: Sequence[Range]) -> HandOvers:
    widths = handover_widths(spans)
    return HandOvers(list(widths.keys()), list(widths.values()))


def _in_rows(here: Sequence[RegionalShaper]) -> tuple[RegionalShaper, ...]:
    ordered = tuple(sorted(here, key=lambda regional: (regional.region.y, regional.region.x)))
    columns, rows = (
        sorted({getattr(regional.region, axis) for regional in here}) for axis in "xy"
    )
    joined = all(
        low < line == above < high
        for spans in (columns, rows)
        for (low, line), (above, high) in itertools.pairwise(spans)
    )
    cells = [(regional.region.y, regional.region.x) for regional in ordered]
    if not joined or cells != list(itertools.product(rows, columns)):
        raise ValueError(
            f"the regions of `shapers` at {here[0].region.pretension[0]:g} N must be a grid, "
            f"got stretches of x {columns} and of y {rows} [m] that overlap, leave gaps, or "
            "aren't all there. Write tuning.json anew with `scdpr tune` or `scdpr calibrate`."
        )
    return ordered


def _smoothstep(share: Float[Array, " lines"]) -> Float[Array, " lines"]:
    """$S(u)$, which has two continuous derivatives; held at its ends."""
    u = jnp.clip(share, 0, 1)
    return u**3 * (10 + u * (6 * u - 15))
