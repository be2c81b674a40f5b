"""Section on what smoothed friction does to what is identified."""

import numpy as np

from experiments.page.number_text import percent, plain, short
from experiments.page.page import Pictures
from experiments.page.table import table_of
from experiments.paper.content import Content, Section
from experiments.paper.topics.smoothing.claims import SMOOTHING
from experiments.paper.topics.smoothing.figure import draw_smoothing
from experiments.paper.topics.smoothing.numbers import STEPS, SYMBOLS, WANTED, WIDTHS, Errors
from experiments.paper.topics.smoothing.numbers import smoothing as smoothing_numbers
from scdpr_jax.robot.parameters import SMOOTHING_WIDTH


def smoothing(picture: Pictures) -> Content:
    """Bias, gradient and cost by the width of the smoothed friction.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    numbers = smoothing_numbers()
    default, fine = numbers.default, numbers.exact[-1]
    named = [f"{width:.2g} m/s" for width in WIDTHS]
    named += [f"exact, {1e3 * step:g} ms" for step in STEPS]
    named[len(WIDTHS)] += ", the truth"
    return Content(
        "Both drives pull for half a second with Table 2's torques, then the robot "
        "coasts until friction holds both carriages. The exact engine's runs at "
        f"{1e3 * STEPS[0]:g} ms, seen at 100 Hz by a camera without noise, are fitted with "
        "smoothed friction, μN tanh(v/vₛ); every fit begins 20 to 100 % off. What is left "
        "is the smoothing's bias.",
        f"At the default width of {SMOOTHING_WIDTH:g} m/s μ comes out "
        f"{percent(default.bias[0])} off; {percent(WANTED, 1)} asks for "
        f"{plain(numbers.width_for_wanted)} m/s. The bias goes with the width to the power "
        f"{numbers.order:.2f}.",
        "The derivative by μ of where the robot is errs by "
        f"{percent(default.sliding)} while the carriages slide and by "
        f"{percent(default.held)} once friction holds them: a smoothed carriage creeps on "
        "where it should have stopped. That is with the variational equations solved "
        "beside the motion; derivatives through the adaptive solver's steps can be wrong "
        "by any factor, docs/validity.md.",
        f"Narrow is stiff: {numbers.by_width[-1].steps:.0f} steps a run at the widest, "
        f"{numbers.by_width[0].steps:.0f} at the narrowest. The exact engine takes "
        f"{fine.steps:.0f} steps of {1e3 * STEPS[-1]:g} ms, and its fit is off by "
        f"{short(float(np.abs(100 * fine.bias).max()), 1)} % at most: fits are made with it.",
        picture(
            draw_smoothing(numbers),
            "Left: bias of the estimates, and error of the derivative of the position by "
            "μ, over the width of the smoothed friction. Right: steps of a run with its "
            "derivatives.",
        ),
        table_of(
            "Errors of fits and of derivatives, by the friction's width",
            map(_row, named, (*numbers.by_width, *numbers.exact)),
        ),
    )


def _row(name: str, errors: Errors) -> dict[str, str]:
    biases = zip(SYMBOLS, errors.bias, strict=True)
    return {
        "vₛ": name,
        **{f"bias of {symbol} [%]": short(100 * bias, 2) for symbol, bias in biases},
        "∂/∂μ, sliding [%]": short(100 * errors.sliding, 2),
        "∂/∂μ, held [%]": short(100 * errors.held, 2),
        "steps of a run": f"{errors.steps:.0f}",
    }


SECTIONS = (
    Section(
        "smoothing",
        "What smoothed friction does to what is identified",
        30.0,
        smoothing,
        SMOOTHING,
    ),
)
"""Sections of this module."""
