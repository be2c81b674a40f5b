"""Section on where the linear model holds."""

import numpy as np

from experiments.page.page import Pictures
from experiments.page.table import table_of
from experiments.paper.content import Content, Section
from experiments.paper.topics.validity.figure import draw_linear_error, draw_sticking
from experiments.paper.topics.validity.numbers import CAMERA, HEIGHTS, TENSIONS, VOLTAGES
from experiments.paper.topics.validity.numbers import validity as validity_numbers


def validity(picture: Pictures) -> Content:
    """The linear against the nonlinear model, and sticking.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    numbers = validity_numbers()
    worst, lag = numbers.error[:, :, -1].max(axis=1), numbers.lag[:, :, -1].max(axis=1)
    commands = [
        f"{acceleration:.1f} m/s² ({volts:g} V)"
        for acceleration, volts in zip(numbers.acceleration, VOLTAGES, strict=True)
    ]
    errors = [[f"{1e3 * error:.2f}" for error in row] for row in numbers.error.max(axis=1)]
    rows = (
        {
            "T_eff [N]": f"{tension:g}",
            **dict(zip(commands, errors[index], strict=True)),
            "lag at 10 V [mm]": f"{1e3 * lag[index]:.0f}",
            "error of it [%]": f"{100 * worst[index] / lag[index]:.0f}",
            "carriages held up to [mm]": f"{1e3 * numbers.threshold[index]:.1f}",
        }
        for index, tension in enumerate(TENSIONS)
    )
    inside = np.mean(numbers.error <= CAMERA)
    return Content(
        "Both drives at some volts for half a second, then coasting: the linear model (18) "
        "with drives and exact friction against the nonlinear one, the largest distance in "
        f"1.2 s. It stays below the camera's 0.19 mm in {100 * inside:.0f} % of the map's "
        "cells.",
        "The small-angle assumption costs most where the cables incline most: low "
        "tension, hard acceleration, and an end-effector low in the frame, near the "
        "driven carriage.",
        "Friction holds both carriages while the end-effector's deflection stays below "
        "2μ z/(1 − μ²), 11 mm at 85 N and mid-height: small knocks ring with held "
        "carriages, hard ones don't, and the last part of every ring-down does.",
        picture(
            draw_linear_error(numbers),
            "Largest error of the end-effector by the linear model, over height, "
            "pretension and commanded acceleration.",
        ),
        picture(
            draw_sticking(numbers),
            "Share of the three seconds after a knock in which the carriages rest, at "
            "mid-height, friction of 4.5 N on each.",
        ),
        table_of(f"Largest error over {len(HEIGHTS)} heights [mm]", rows),
    )


SECTIONS = (Section("validity", "Where the linear model holds", 10.0, validity),)
"""Sections of this module."""
