"""The catalogue of input shapers, each by its defining conditions."""

from tuning.catalogue.entries import CATALOGUE as CATALOGUE
from tuning.catalogue.entries import UNITY_MAGNITUDE as UNITY_MAGNITUDE
from tuning.catalogue.entries import Entry as Entry
from tuning.catalogue.extra_insensitive import ei as ei
from tuning.catalogue.extra_insensitive import extra_insensitive as extra_insensitive
from tuning.catalogue.extra_insensitive import three_hump_ei as three_hump_ei
from tuning.catalogue.extra_insensitive import two_hump_ei as two_hump_ei
from tuning.catalogue.periods import damped_period as damped_period
from tuning.catalogue.periods import half_period_decay as half_period_decay
from tuning.catalogue.unity_magnitude import um_ei as um_ei
from tuning.catalogue.unity_magnitude import um_zv as um_zv
from tuning.catalogue.zero_vibration import mzv as mzv
from tuning.catalogue.zero_vibration import zv as zv
from tuning.catalogue.zero_vibration import zvd as zvd
from tuning.catalogue.zero_vibration import zvdd as zvdd
