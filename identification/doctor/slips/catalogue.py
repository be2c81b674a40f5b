"""Everything that the doctor tries, the likelier first: ties are decided by this order."""

from identification.doctor.slips.clocks import CLOCKS, RATES
from identification.doctor.slips.labels import KINDS, STARTS
from identification.doctor.slips.scales import ONE_COLUMN_UNITS, SCALES
from identification.doctor.slips.signs import LIMITS, SIGNS, SWAPS
from identification.doctor.slips.slip import Slip
from identification.doctor.slips.units import (
    ANGLE_UNITS,
    LENGTH_UNITS,
    ROTATION_UNITS,
    TIME_UNITS,
    VOLTAGE_UNITS,
)

CATALOGUE: tuple[Slip, ...] = (
    *KINDS,
    *ANGLE_UNITS,
    *ROTATION_UNITS,
    *LENGTH_UNITS,
    *TIME_UNITS,
    *SIGNS,
    *SWAPS,
    *VOLTAGE_UNITS,
    *LIMITS,
    *RATES,
    *ONE_COLUMN_UNITS,
    *SCALES,
    *CLOCKS,
    *STARTS,
)
"""The slips."""
