"""`scdpr_controller.m`: plant, controller and shapers as a MATLAB script."""

import dataclasses

from jaxtyping import Array, Float

from tuning.export.description import Constants, Description, decimal
from tuning.export.template import fill_in
from tuning.loop.plant import MotorPlant
from tuning.result.regional_shaper import Range, RegionalShaper

FILE = "scdpr_controller.m"
"""The file's name."""


def matlab_script(description: Description) -> str:
    """The plant of Eq. (24), the controller and the shapers from literals, the loop closed.

    It needs the Control System Toolbox, or GNU Octave with its package control.

    Args:
        description: What is exported.

    Returns:
        MATLAB text.
    """
    return fill_in(
        FILE,
        controller="\n".join(
            [
                f"% {description.provenance}",
                *([f"% {description.caution}"] if description.caution else []),
                *(
                    _assign(field.name, getattr(description.constants, field.name), field)
                    for field in dataclasses.fields(Constants)
                ),
            ]
        ),
        plant="\n".join(
            _assign(f"plant_{field.name}", getattr(description.plant, field.name), field)
            for field in dataclasses.fields(MotorPlant)
        ),
        shapers="\n".join(
            _shaper(number, regional) for number, regional in enumerate(description.shapers, 1)
        ),
    )


def _assign(name: str, value: float | Float[Array, ""], field: dataclasses.Field) -> str:
    return f"{name} = {decimal(value)}; % [{field.metadata['unit']}]"


def _shaper(number: int, regional: RegionalShaper) -> str:
    region, shaper = regional.region, regional.shaper
    return "\n".join(
        [
            f"shapers({number}).x = {_vector(region.x)}; % [m]",
            f"shapers({number}).y = {_vector(region.y)}; % [m]",
            f"shapers({number}).pretension = {_vector(region.pretension)}; % [N]",
            f"shapers({number}).times = {_vector(shaper.times)}; % [s]",
            f"shapers({number}).amplitudes = {_vector(shaper.amplitudes)}; % [1]",
        ]
    )


def _vector(numbers: Range | Float[Array, " impulses"]) -> str:
    return "[" + ", ".join(decimal(number) for number in numbers) + "]"
