"""Sections of Equations (24) and (25)."""

import math

from experiments.page.number_text import plain, rounded
from experiments.page.page import Pictures
from experiments.page.table import table_of
from experiments.paper.content import Content, Section
from experiments.paper.topics.loop.claims import EQ24, EQ25
from experiments.paper.topics.loop.figure import draw_bode, draw_step_response
from experiments.paper.topics.loop.numbers import (
    STEP,
    Design,
    designed,
    gain_from_table,
    printed,
    step_response,
)


def eq24(picture: Pictures) -> Content:
    """The drive's transfer function.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    response = step_response()
    return Content(
        f"A step of {STEP:g} V on a bare simulated drive, read by its encoder, gives "
        f"{rounded(response.gain, response.error[0])} ± {plain(response.error[0], 2)} over "
        f"s(s + {rounded(response.pole, response.error[1])} ± {plain(response.error[1], 2)}), "
        "the angle in degrees.",
        f"(24) calls its numerator 1/J, which is 78.5 with Table 1; it is (180/π) k_v/J = "
        f"{gain_from_table():.0f}: degrees, and volts through k_v = 0.482 N m/V.",
        picture(
            draw_step_response(response),
            "Speed of a bare drive after a step of its command, and the fitted (24).",
            narrow=True,
        ),
    )


def _row(name: str, design: Design) -> dict[str, str]:
    continuous, sampled = design.continuous, design.sampled
    proportional, derivative = design.gains_in_degrees
    return {
        "controller": name,
        "K_p [V/°]": f"{proportional:.5f}",
        "K_d [V s/°]": f"{derivative:.6f}",
        "ω_c [rad/s]": f"{float(continuous.gain_crossover):.2f}",
        "φ_m [°]": f"{math.degrees(continuous.phase_margin):.2f}",
        "ω_c at 1 kHz [rad/s]": f"{float(sampled.gain_crossover):.2f}",
        "φ_m at 1 kHz [°]": f"{math.degrees(sampled.phase_margin):.2f}",
    }


def eq25(picture: Pictures) -> Content:
    """The controller.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    response = step_response()
    designs = {"required, from (24)": designed(), "printed (25)": printed()}
    rows = (
        *(_row(name, design) for name, design in designs.items()),
        _row("required, from the step response", designed(response.gain, response.pole)),
    )
    return Content(
        "40 rad/s and 60° on (24) have one PD, in closed form: K_p = 0.63523, as printed, "
        "and K_d = 0.012126, printed as 0.0125.",
        "The printed pair crosses over a little higher, with a little more phase; at 1 kHz "
        "with one sample of delay either keeps over 55° of phase.",
        picture(
            draw_bode(designs),
            "The drive's open loop with the required and with the printed controller.",
        ),
        table_of("The controllers and their margins", rows),
    )


SECTIONS = (
    Section("eq24", "Equation (24): the drive", 2.0, eq24, EQ24),
    Section("eq25", "Equation (25): the controller", 6.0, eq25, EQ25),
)
"""Sections of this module."""
