"""The log of one motor-driven axis: time, voltage and position, from a CSV file."""

import pathlib

import equinox as eqx
import numpy as np
from jaxtyping import Array, Float

from identification.axis.jumps import continued
from identification.campaign.tables.columns import LENGTH, TIME, TURN, VOLTAGE, Column, Scale
from identification.campaign.tables.table import read_table
from scdpr_jax.robot.fields import real, si

_COLUMNS = (
    Column("t", TIME),
    Column("voltage", VOLTAGE),
    Column("position", {**LENGTH, "um": Scale(-6), **TURN}),
)
_SHORTEST = 16  # samples: four parameters, and as much again for each to be judged by


class AxisLog(eqx.Module):
    """What was commanded to an axis and where it went, one row for each sample."""

    time: Float[Array, " samples"] = eqx.field(converter=real, metadata=si("s", "t"))
    """Time of each sample [s], strictly increasing."""
    voltage: Float[Array, " samples"] = eqx.field(converter=real, metadata=si("V", "u"))
    """Command, held until the next sample [V]."""
    position: Float[Array, " samples"] = eqx.field(converter=real, metadata=si("m", "q"))
    """Position [m], or angle [rad] of a rotary axis."""
    position_unit: str = eqx.field(default="m", static=True)
    """SI unit of the positions: "m" or "rad"."""
    notes: tuple[str, ...] = eqx.field(default=(), static=True)
    """What was put right as it was read, a sentence each."""

    @property
    def is_rotary(self) -> bool:
        """Whether the axis turns."""
        return self.position_unit == "rad"


def read_axis_log(path: pathlib.Path) -> AxisLog:
    """Read the log of one axis.

    The file is CSV with a header row; a column's header is its name and its unit in
    square brackets: `t [s],voltage [V],position [m]`. Other columns are ignored. A counter's
    wraps are taken out of the position, at a turn or at 15 or 16 bits.

    Args:
        path: The CSV file.

    Returns:
        The log in SI units.

    Raises:
        ValueError: If there is no such file, a column or unit is missing, a cell isn't a
            finite number, a row is cut, or time doesn't increase. The message lists the faults
            with their rows.
    """
    table, faults = read_table(pathlib.Path(path), _COLUMNS, file=str(path), bare_extra=True)
    if table is None:
        raise ValueError("\n".join(map(str, faults)))
    time, voltage, position = (table.values[column.name] for column in _COLUMNS)
    if len(time) < _SHORTEST:
        raise ValueError(
            f"{path}: {len(time)} samples, expected at least {_SHORTEST}. "
            "Four parameters need a record in which the axis moves: log a longer run."
        )
    unit = table.units["position"]
    rotary = unit in TURN
    position, period, wraps = continued(time, position, rotary=rotary)
    notes = ()
    if wraps:
        written = period / _COLUMNS[2].units[unit](np.ones(1))[0]
        notes = (
            f"The position wraps {wraps} times, at {written:.6g} {unit}: the turns are "
            "counted.",
        )
    return AxisLog(time, voltage, position, "rad" if rotary else "m", notes)
