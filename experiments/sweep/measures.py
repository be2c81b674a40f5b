"""Everything that can be swept."""

from experiments.sweep.frequency import FREQUENCY
from experiments.sweep.measure import Measure
from experiments.sweep.move import CLOSED_LOOP
from experiments.sweep.static_workspace import WORKSPACE

MEASURES: tuple[Measure, ...] = (FREQUENCY, WORKSPACE, CLOSED_LOOP)
"""What can be swept."""
