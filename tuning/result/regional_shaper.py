"""A shaper and the part of the workspace that it is for."""

import dataclasses
from collections.abc import Iterable

from scdpr_jax.command.shaper import Shaper
from scdpr_jax.robot.fields import si
from scdpr_jax.robot.stated.ranges import SETTING_TOLERANCE

Range = tuple[float, float]
"""Lower and upper end."""


@dataclasses.dataclass(frozen=True)
class Region:
    """A part of the workspace at some pretension settings."""

    x: Range = dataclasses.field(metadata=si("m", "x_e"))
    """Horizontal positions of the end-effector [m]."""
    y: Range = dataclasses.field(metadata=si("m", "y_e"))
    """Heights of the end-effector [m]."""
    pretension: Range = dataclasses.field(metadata=si("N", "T"))
    """Nominal settings of the cable loop [N]."""

    def contains(self, x: float, y: float, pretension: float) -> bool:
        """Whether a pose at a setting lies in the region, its edges included.

        Args:
            x: Horizontal position of the end-effector [m].
            y: Its height [m].
            pretension: Nominal setting [N].

        Returns:
            Whether it does.
        """
        pairs = ((x, self.x), (y, self.y), (pretension, self.pretension))
        return all(low <= number <= high for number, (low, high) in pairs)


def nearest_setting(settings: Iterable[Range], pretension: float) -> Range | None:
    """The range of settings that a pretension belongs to, as a controller reads it.

    Args:
        settings: Ranges of nominal settings [N].
        pretension: What was read [N].

    Returns:
        The nearest one, the first of several; None where none is within
        `SETTING_TOLERANCE` of it.
    """
    off = {span: max(span[0] - pretension, pretension - span[1], 0.0) for span in settings}
    nearest = min(off, key=off.__getitem__, default=None)
    if nearest is None or off[nearest] > SETTING_TOLERANCE * nearest[0]:
        return None
    return nearest


@dataclasses.dataclass(frozen=True)
class ResidualVibration:
    """Share of a linear mode's vibration that a shaper leaves, see `residual_vibration`."""

    nominal: float = dataclasses.field(metadata=si("1", "V"))
    """At the cell's frequency [1]."""
    worst: float = dataclasses.field(metadata=si("1", "V"))
    """Largest over the frequency's band of two standard errors [1]."""


@dataclasses.dataclass(frozen=True, eq=False)
class RegionalShaper:
    """The shaper of a region, for legs that end in it."""

    region: Region
    """Where it holds."""
    height: float = dataclasses.field(metadata=si("m", "y_e"))
    """Height at which its frequency holds [m]."""
    shaper: Shaper
    """The impulses."""
    frequency: float = dataclasses.field(metadata=si("Hz", "f_n"))
    """Natural frequency with both carriages held by friction [Hz]."""
    band: Range = dataclasses.field(metadata=si("Hz"))
    """That frequency less and plus two standard errors [Hz]."""
    damping_ratio: float = dataclasses.field(metadata=si("1", r"\zeta"))
    """Damping ratio at that frequency [1]."""
    measured: bool
    """Whether the frequency was measured in the region; otherwise it is the model's."""
    residual_vibration: ResidualVibration
    """What the shaper leaves of the linear mode that is held by friction."""
    kind: str = ""
    """Its name in the catalogue, `own` or `none`; empty if unknown."""
    share: float | None = dataclasses.field(default=None, metadata=si("1"))
    """What gains and shaper are predicted to leave of the vibration of Eq. (25), geometric mean
    over random legs that end in the region, with friction [1]; None if unknown."""
