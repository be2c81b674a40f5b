"""Shapers designed for a spread of modes: the best of their kind, not the nearest of a list."""

from tuning.shapers.design.criterion import Criterion as Criterion
from tuning.shapers.design.criterion import worst_residual as worst_residual
from tuning.shapers.design.fewest import fewest_impulses as fewest_impulses
from tuning.shapers.design.positive import Design as Design
from tuning.shapers.design.positive import least_duration as least_duration
from tuning.shapers.design.positive import least_residual as least_residual
from tuning.shapers.design.quantile import least_quantile as least_quantile
from tuning.shapers.design.several_modes import convolved as convolved
from tuning.shapers.design.several_modes import simultaneous as simultaneous
from tuning.shapers.design.specified_insensitivity import (
    specified_insensitivity as specified_insensitivity,
)
from tuning.shapers.design.unity_magnitude import least_unity_residual as least_unity_residual
