"""Legs drawn at random over a workspace, as a controller meets them.

What is tuned on one manoeuvre serves that manoeuvre: friction makes each leg a case of its own.
So gains, shapers and plans are judged on many, of any direction, length and time, half of which
start where an earlier leg has left the carriages out of line.
"""

import dataclasses

import numpy as np
from jaxtyping import Float

from scdpr_jax.robot.fields import si
from scdpr_jax.robot.parameters import Frame

LEG_TIMES = (1.7, 4.0)
"""Shortest and longest time of a leg [s]."""
WIDE = (0.3 / 2.224, 1.9 / 2.224)
"""Ends of the horizontal positions, as shares of the frame's width [1]."""
HIGH = (0.25 / 1.112, 0.85 / 1.112)
"""Ends of the heights, as shares of the frame's height [1]."""
SHORTEST_WAY = 0.3 / 2.224
"""Least horizontal way, as a share of the frame's width [1]."""
OUT_OF_LINE = 0.8
"""Steepest start over what friction holds [1]."""


@dataclasses.dataclass(frozen=True, eq=False)
class RandomLegs:
    """Legs from rest to rest, one a row."""

    start: Float[np.ndarray, "legs 2"] = dataclasses.field(metadata=si("m"))
    """Where the end-effector rests before [m]."""
    end: Float[np.ndarray, "legs 2"] = dataclasses.field(metadata=si("m"))
    """Where it goes [m]."""
    time: Float[np.ndarray, " legs"] = dataclasses.field(metadata=si("s"))
    """Times of the legs [s]."""
    out_of_line: Float[np.ndarray, " legs"] = dataclasses.field(metadata=si("1"))
    """Slopes of the line between the carriages at the start over what friction holds [1]."""

    def __len__(self) -> int:
        return len(self.time)


def random_legs(
    frame: Frame,
    count: int,
    *,
    seed: int,
    x: tuple[float, float] | None = None,
    y: tuple[float, float] | None = None,
    leg_times: tuple[float, float] = LEG_TIMES,
) -> RandomLegs:
    """Legs over the workspace of a frame; every other one starts out of line.

    Args:
        frame: The frame.
        count: How many.
        seed: Of the random numbers.
        x: Horizontal positions that they end at [m]; None for all within `WIDE`.
        y: Heights that they end at [m]; None for all within `HIGH`.
        leg_times: Shortest and longest time of a leg [s].

    Returns:
        The legs.
    """
    random = np.random.default_rng(seed)
    width, height = float(frame.width), float(frame.height)
    low, high = np.array([WIDE, HIGH]).T * np.array([width, height])
    within = [
        np.clip((low[axis], high[axis]) if ends is None else ends, low[axis], high[axis])
        for axis, ends in enumerate((x, y))
    ]
    end = random.uniform(*np.transpose(within), size=(count, 2))
    start = random.uniform(low, high, size=(count, 2))
    # A uniform draw of what is as far as the shortest way at least, to either side.
    left = np.maximum(end[:, 0] - SHORTEST_WAY * width - low[0], 0.0)
    right = np.maximum(high[0] - end[:, 0] - SHORTEST_WAY * width, 0.0)
    along = random.uniform(size=count) * (left + right)
    start[:, 0] = np.where(along < left, low[0] + along, high[0] - (along - left))
    slopes = random.uniform(-OUT_OF_LINE, OUT_OF_LINE, count)
    slopes[::2] = 0.0
    return RandomLegs(start, end, random.uniform(*leg_times, count), slopes)
