"""Sections of Figures 11 and 12."""

import numpy as np

from experiments.page.page import Pictures
from experiments.page.table import Table, table_of
from experiments.paper.content import Content, Section
from experiments.paper.topics.knocks.claims import FIG11, FIG12
from experiments.paper.topics.knocks.figure import draw_fig11, draw_fig12
from experiments.paper.topics.knocks.numbers import (
    FORCE,
    MEASURED,
    ROWS,
    SETTINGS,
    Level,
    effective_share,
)
from experiments.paper.topics.knocks.numbers import fig11 as fig11_numbers
from experiments.paper.topics.knocks.numbers import fig12 as fig12_numbers


def fig11(picture: Pictures) -> Content:
    """One knock.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    knock = fig11_numbers()
    return Content(
        f"A push of {FORCE:g} N for 30 ms in the middle of the frame, nominal 350 N, "
        "drives at 0 V: recorded at 30 frames a second with 0.19 mm of noise, mean "
        f"removed, transformed. The highest peak stands at {knock.peak.frequency:.2f} Hz; "
        f"four seconds resolve {knock.peak.resolution:.2f} Hz.",
        "The force of the paper's knocks isn't printed. Friction of the carriages is "
        "inside the loop of motion: a harder knock moves them, and the peak with them "
        "(Figure 12).",
        picture(
            draw_fig11(knock),
            "A simulated knock as the vision system records it, and its amplitude spectrum "
            "with the peak that is picked.",
        ),
    )


def _row(level: Level) -> dict[str, str]:
    return {
        "lower carriage": level.condition.lower.value,
        "upper carriage": level.condition.upper.value,
        **{f"T = {each:.0f} N [Hz]": f"{level.nominal(each):.2f}" for each in SETTINGS},
        **{f"T_eff/T for {f} Hz": f"{level.share(each):.3f}" for each, f in MEASURED.items()},
        "middle over ends": f"{level.rise:.2f}",
    }


def fig12(picture: Pictures) -> Content:
    """Frequencies over the workspace.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    gentle, harder = fig12_numbers(), fig12_numbers(4 * FORCE)
    conditions = table_of(
        "First elastic mode at mid-height, and what the reported level asks for",
        map(_row, gentle.levels),
    )
    knocks = Table(
        "Peak of the simulated knocks [Hz], mean of the five columns",
        ("knock", "setting", *(f"y = {1e3 * y:.0f} mm" for y in ROWS), "reported"),
        tuple(
            (
                f"{force:g} N",
                f"{setting:.0f} N",
                *(f"{p:.2f}" for p in numbers.peaks[index].mean(axis=1)),
                f"about {MEASURED[setting]}" if setting in MEASURED else "–",
            )
            for force, numbers in ((FORCE, gentle), (4 * FORCE, harder))
            for index, setting in enumerate(SETTINGS)
        ),
    )
    spread = float(np.ptp(gentle.peaks, axis=2).max())
    return Content(
        f"With T_eff = {effective_share():.3f} of the nominal tension, which the 50 mm of "
        "section 6 ask for and nothing of section 5.2 was used for, knocks at mid-height "
        f"ring at {gentle.peak(200.0):.2f} Hz at 200 N and {gentle.peak(500.0):.2f} Hz at "
        "500 N; reported are about 2.4 and 3.9 Hz.",
        "With the nominal tension no carriage condition gives these levels; what each "
        "would need is in the table. Their ratio is the root of the tensions' within 3 %.",
        "The shape over the height is what stays unexplained: the reported frequencies are "
        "highest at mid-height, as with both carriages free of the drives; the levels are "
        "those of held carriages, whose frequency is lowest there.",
        f"Over the width the frequency is constant: the columns differ by {spread:.2f} Hz.",
        f"Knocks of {4 * FORCE:g} N move the carriages, and the highest peak is then the "
        "slide's in part of the poses: peak picking needs knocks that leave them alone.",
        picture(
            draw_fig12(gentle),
            "First elastic mode over the height for each carriage condition at T_eff = "
            f"{effective_share():.3f} of the nominal tension, the simulated knocks, and "
            "the reported levels.",
        ),
        conditions,
        knocks,
    )


SECTIONS = (
    Section("fig11", "Figure 11: a knock and its spectrum", 4.0, fig11, FIG11),
    Section("fig12", "Figure 12: natural frequency over the workspace", 8.0, fig12, FIG12),
)
"""Sections of this module."""
