"""Section on the claim about stiffness."""

from experiments.page.page import Pictures
from experiments.paper.content import Content, Section
from experiments.paper.topics.stiffness.claims import STIFFNESS
from experiments.paper.topics.stiffness.figure import draw_stiffness
from experiments.paper.topics.stiffness.numbers import CLEAR, TENSION, stiffness_map


def stiffness(picture: Pictures) -> Content:
    """Stiffness over the workspace.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    numbers = stiffness_map()
    return Content(
        "“The stiffness of the robot remains invariant for a given pretension”: over the "
        "width exactly, in the model; over the height the horizontal stiffness varies by "
        f"a factor of {numbers.loop_ratio:.1f} with both carriages held (poses "
        f"{1e3 * CLEAR:.0f} mm clear of the frame), as 1/z₁ + 1/z₂ of (20) does. The "
        f"conventional robot's varies by a factor of {numbers.conventional_ratio:.1f} over "
        "the same poses.",
        f"In the middle, at {TENSION:.0f} N, four cables of the same steel are "
        f"{numbers.advantage:.0f} times as stiff: they resist by their elasticity, the "
        f"single loop by its tension alone ({numbers.both_held[len(numbers.y) // 2]:.0f} "
        "N/m), as a string does.",
        "A push that lasts moves carriages that nothing holds: without friction and drives "
        "the single loop has no horizontal stiffness at all, it slides.",
        picture(
            draw_stiffness(numbers),
            "Horizontal stiffness at one pretension: over the height at mid-width, and the "
            "conventional robot's over the workspace.",
        ),
    )


SECTIONS = (Section("stiffness", "Stiffness over the workspace", 6.0, stiffness, STIFFNESS),)
"""Sections of this module."""
