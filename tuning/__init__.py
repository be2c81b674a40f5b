"""Parameters and measured frequencies to gains and input shapers."""

from tuning.catalogue import CATALOGUE as CATALOGUE
from tuning.catalogue import ei as ei
from tuning.catalogue import zv as zv
from tuning.catalogue import zvd as zvd
from tuning.document import read_tuning as read_tuning
from tuning.document import write_tuning as write_tuning
from tuning.loop_shaping import shape_loop as shape_loop
from tuning.loop_shaping import shape_sampled_loop as shape_sampled_loop
from tuning.margins import Margins as Margins
from tuning.margins import continuous_margins as continuous_margins
from tuning.margins import sampled_margins as sampled_margins
from tuning.plant import MotorPlant as MotorPlant
from tuning.tune import tune as tune
from tuning.types import RegionalShaper as RegionalShaper
from tuning.types import Tuning as Tuning
