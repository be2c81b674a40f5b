"""Parameters and measured frequencies to gains, input shapers and planned legs."""

from types import ModuleType

from tuning.codesign.codesign_file import read_law as read_law
from tuning.codesign.codesign_file import write_codesign as write_codesign
from tuning.codesign.designed import Designed as Designed
from tuning.codesign.front import front as front
from tuning.codesign.front import knee as knee
from tuning.codesign.models import Models as Models
from tuning.codesign.models import models as models
from tuning.codesign.recommendation import CoDesign as CoDesign
from tuning.codesign.recommendation import Scope as Scope
from tuning.codesign.recommendation import recommend as recommend
from tuning.codesign.search import co_design as co_design
from tuning.export import control_objects as control_objects
from tuning.export import write_exports as write_exports
from tuning.gains.optimise import Effort as Effort
from tuning.gains.tune import tune as tune
from tuning.loop.admissible import admissible as admissible
from tuning.loop.flexible_margins import flexible_margins as flexible_margins
from tuning.loop.loop_shaping import shape_loop as shape_loop
from tuning.loop.loop_shaping import shape_sampled_loop as shape_sampled_loop
from tuning.loop.margins import Margins as Margins
from tuning.loop.margins import continuous_margins as continuous_margins
from tuning.loop.margins import sampled_margins as sampled_margins
from tuning.loop.plant import MotorPlant as MotorPlant
from tuning.loop.worst_margins import margin_map as margin_map
from tuning.loop.worst_margins import worst_margins as worst_margins
from tuning.plan.plan import Plan as Plan
from tuning.plan.plan_file import read_plan as read_plan
from tuning.plan.plan_file import write_plan as write_plan
from tuning.plan.planning import Planned as Planned
from tuning.plan.planning import Wanted as Wanted
from tuning.plan.planning import plan_leg as plan_leg
from tuning.plan.planning import plan_legs as plan_legs
from tuning.plan.planning import resting_start as resting_start
from tuning.refinement.logged_leg import LoggedLeg as LoggedLeg
from tuning.refinement.refine import Refined as Refined
from tuning.refinement.refine import refine as refine
from tuning.regions.residual_map import residual_map as residual_map
from tuning.regions.schedule import ScheduledTrajectory as ScheduledTrajectory
from tuning.regions.schedule import schedule_of as schedule_of
from tuning.regions.schedule import scheduled_samples as scheduled_samples
from tuning.result.document import read_tuning as read_tuning
from tuning.result.document import write_tuning as write_tuning
from tuning.result.regional_shaper import RegionalShaper as RegionalShaper
from tuning.result.tuning import FittedSetting as FittedSetting
from tuning.result.tuning import Tuning as Tuning
from tuning.shapers.catalogue import CATALOGUE as CATALOGUE
from tuning.shapers.catalogue import UNITY_MAGNITUDE as UNITY_MAGNITUDE
from tuning.shapers.catalogue import ei as ei
from tuning.shapers.catalogue import mzv as mzv
from tuning.shapers.catalogue import three_hump_ei as three_hump_ei
from tuning.shapers.catalogue import two_hump_ei as two_hump_ei
from tuning.shapers.catalogue import um_ei as um_ei
from tuning.shapers.catalogue import um_zv as um_zv
from tuning.shapers.catalogue import zv as zv
from tuning.shapers.catalogue import zvd as zvd
from tuning.shapers.catalogue import zvdd as zvdd
from tuning.shapers.design import least_duration as least_duration
from tuning.shapers.design import least_residual as least_residual
from tuning.shapers.design import worst_residual as worst_residual
from tuning.shapers.shaper_file import shaper_document as shaper_document
from tuning.shapers.spectrum import Spectrum as Spectrum
from tuning.shapers.spectrum_design import design_for_spectrum as design_for_spectrum
from tuning.shapers.spectrum_file import read_spectrum as read_spectrum


def __dir__() -> list[str]:
    """What a user calls; the wings stand behind it."""
    return sorted(
        name
        for name, thing in globals().items()
        if not (name.startswith("_") or thing is ModuleType or isinstance(thing, ModuleType))
    )
