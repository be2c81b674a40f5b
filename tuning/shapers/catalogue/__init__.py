"""The catalogue of input shapers, each by its defining conditions."""

from tuning.shapers.catalogue.entries import CATALOGUE as CATALOGUE
from tuning.shapers.catalogue.entries import UNITY_MAGNITUDE as UNITY_MAGNITUDE
from tuning.shapers.catalogue.entries import Entry as Entry
from tuning.shapers.catalogue.extra_insensitive import ei as ei
from tuning.shapers.catalogue.extra_insensitive import extra_insensitive as extra_insensitive
from tuning.shapers.catalogue.extra_insensitive import three_hump_ei as three_hump_ei
from tuning.shapers.catalogue.extra_insensitive import two_hump_ei as two_hump_ei
from tuning.shapers.catalogue.periods import damped_period as damped_period
from tuning.shapers.catalogue.periods import half_period_decay as half_period_decay
from tuning.shapers.catalogue.unity_magnitude import um_ei as um_ei
from tuning.shapers.catalogue.unity_magnitude import um_zv as um_zv
from tuning.shapers.catalogue.zero_vibration import mzv as mzv
from tuning.shapers.catalogue.zero_vibration import zv as zv
from tuning.shapers.catalogue.zero_vibration import zvd as zvd
from tuning.shapers.catalogue.zero_vibration import zvdd as zvdd
