"""Shapers designed for a spread of modes: the best of their kind, not the nearest of a list."""

from tuning.design.criterion import Criterion as Criterion
from tuning.design.criterion import worst_residual as worst_residual
from tuning.design.positive import Design as Design
from tuning.design.positive import least_duration as least_duration
from tuning.design.positive import least_residual as least_residual
from tuning.design.quantile import least_quantile as least_quantile
from tuning.design.several_modes import convolved as convolved
from tuning.design.several_modes import simultaneous as simultaneous
from tuning.design.specified_insensitivity import (
    specified_insensitivity as specified_insensitivity,
)
from tuning.design.unity_magnitude import least_unity_residual as least_unity_residual
