"""A co-design as a tuning: what plans legs, runs in a controller and is exported."""

import jax.numpy as jnp
import numpy as np

from scdpr_jax.command.shaper import residual_vibration
from scdpr_jax.linear.modes import held_frequency
from scdpr_jax.robot.drive import drive_gain, drive_pole
from tuning.codesign.recommendation import CoDesign
from tuning.loop.margins import sampled_margins
from tuning.loop.plant import MotorPlant
from tuning.result.regional_shaper import Region, RegionalShaper, ResidualVibration
from tuning.result.tuning import FittedSetting, Tuning

_HEIGHTS = 9
"""Heights at which the mode is looked at: its frequency hardly curves between them."""


def tuning_of(design: CoDesign, *, caution: str = "") -> Tuning:
    """The recommended gains and shaper, which hold everywhere, at every setting.

    Args:
        design: The co-design.
        caution: What it has to warn of; empty for nothing.

    Returns:
        The tuning, without predictions: what the design does is told in `codesign.json`.
    """
    law, drive = design.chosen.law, design.robots[0].robot.drive
    plant = MotorPlant(gain=drive_gain(drive), pole=drive_pole(drive))
    return Tuning(
        controller=law.controller,
        margins=sampled_margins(plant, law.controller),
        shapers=tuple(_everywhere(design, fitted) for fitted in design.robots),
        predicted=(),
        robots=design.robots,
        worst_margins=design.margins,
        notes=(
            "Gains and shaper of `scdpr codesign`: one shaper for the whole workspace, made "
            f"for moves of {design.chosen.move_time:.3g} s with the leg of codesign.json.",
        ),
        caution=caution,
    )


def _everywhere(design: CoDesign, fitted: FittedSetting) -> RegionalShaper:
    """The shaper at one setting, and what it leaves of the held mode without damping."""
    frame, shaper = fitted.robot.frame, design.chosen.law.shaper
    width, height = float(frame.width), float(frame.height)
    parts = fitted.robot.end_effector
    heights = np.linspace(
        float(parts.lower_offset), height - float(parts.upper_offset), _HEIGHTS + 2
    )[1:-1]
    frequencies = [float(held_frequency(fitted.robot, np.asarray(at))) for at in heights]
    left = [
        float(
            residual_vibration(
                shaper, frequency=jnp.asarray(at), damping_ratio=jnp.asarray(0.0)
            )
        )
        for at in frequencies
    ]
    middle = _HEIGHTS // 2
    return RegionalShaper(
        region=Region((0.0, width), (0.0, height), (fitted.pretension,) * 2),
        height=float(heights[middle]),
        shaper=shaper,
        frequency=frequencies[middle],
        band=(min(frequencies), max(frequencies)),
        damping_ratio=0.0,
        measured=False,
        residual_vibration=ResidualVibration(left[middle], max(left)),
        kind="codesign",
    )
