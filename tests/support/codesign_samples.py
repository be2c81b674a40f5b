"""A made-up co-design: no search, numbers known beforehand."""

import jax.numpy as jnp
import numpy as np

from scdpr_jax.command.controller import published_pd
from scdpr_jax.command.shaper import Shaper
from scdpr_jax.legs.measures import LegMeasures
from scdpr_jax.robot.prototype import consistent
from tuning.codesign.designed import Designed
from tuning.codesign.recommendation import DESIGNED, CoDesign, Scope
from tuning.codesign.unknowns import Law, plain_profile
from tuning.loop.worst_margins import WorstMargin
from tuning.result.tuning import FittedSetting

LAW = Law(
    published_pd(),
    Shaper([0.0, 0.1, 0.2, 0.3], [0.4, 0.3, 0.2, 0.1]),
    jnp.asarray(plain_profile()),
    jnp.asarray(2.0),
)
MARGINS = (
    WorstMargin("phase_margin", 0.6, "lifting", 0.4, 350.0),
    WorstMargin("gain_margin", float("inf"), "lifting", 0.4, 350.0),
    WorstMargin("peak_sensitivity", 1.8, "lifting", 0.4, 350.0),
    WorstMargin("delay_margin", 0.02, "lifting", 0.4, 350.0),
)


def designed(vibration, *, volts=9.0):
    count = len(vibration)
    numbers = {name: np.zeros(count) for name in LegMeasures.__dataclass_fields__}
    numbers |= {"residual_vibration": np.asarray(vibration)}
    numbers |= {"largest_voltage": np.full(count, volts)}
    return Designed(LAW, 2.3, np.full(count, 3.0), LegMeasures(**numbers))


def co_design(**changed):
    chosen = designed([1e-3, 2e-3])
    return CoDesign(
        scope=Scope((1, 2), 1, (350.0,), (2.3,), 1),
        chosen=chosen,
        front=(chosen,),
        compared={"Eq. (25)": (designed([8e-3, 9e-3]),)},
        held_out={DESIGNED: designed([3e-3], **changed)},
        margins=MARGINS,
        margins_before=MARGINS,
        robots=(FittedSetting(350.0, consistent()),),
        voltage_limit=10.0,
    )
