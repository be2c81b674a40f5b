"""Section of Table 1."""

from experiments.page.number_text import plain, readable_unit, short
from experiments.page.page import Pictures
from experiments.page.table import table_of
from experiments.paper.content import Content, Section
from experiments.paper.topics.prototype.claims import TABLE1
from experiments.paper.topics.prototype.numbers import derived_as_printed, derived_consistently
from scdpr_jax.robot.prototype import PROVENANCE
from scdpr_jax.robot.quantities import quantity

_DERIVED = (
    ("reflected_inertia", "both drives' inertia at the cable, 2J/r²", "kg"),
    ("reflected_damping", "both drives' damping at the cable, 2b/r²", "N s/m"),
    ("top_speed", "speed of the cable at 10 V, r k_v V/b", "m/s"),
    ("largest_force", "force of both drives at 10 V", "N"),
    ("breakaway_force", "force of both drives at breakaway, 2τ_f/r", "N"),
    ("printed_friction", "friction of one carriage by 5.1, 4Tμ", "N"),
    ("diagonal_voltage", "diagonal manoeuvre at 2.5 s a leg, mid-leg", "V"),
    ("axial_stiffness", "EA of the cable", "N"),
    ("loop_stiffness", "EA/L of the loop", "N/m"),
    ("stretch", "stretch of the loop at 350 N", "m"),
)


def table1(picture: Pictures) -> Content:
    """Table 1 with its derived quantities.

    Args:
        picture: The page's figures; none is drawn.

    Returns:
        The section.
    """
    printed, used = derived_as_printed(), derived_consistently()
    derived = (
        {
            "quantity": meaning,
            "as printed": plain(getattr(printed, name), 3),
            "consistent": plain(getattr(used, name), 3),
            "unit": unit,
        }
        for name, meaning, unit in _DERIVED
    )
    numbers = (
        {
            "quantity": quantity(source.name).meaning,
            "printed": short(source.published),
            "used": short(source.consistent, 4),
            "unit": readable_unit(quantity(source.name).unit),
            "where from": source.provenance,
        }
        for source in PROVENANCE
    )
    return Content(
        f"With the printed radius of 7.3 mm the drives' inertia weighs "
        f"{printed.reflected_inertia:.0f} kg at the cable and 10 V move it at "
        f"{printed.top_speed:.2f} m/s: no experiment could be run. With 73 mm it is "
        f"{used.reflected_inertia:.2f} kg and {used.top_speed:.2f} m/s.",
        f"The robot breaks away at {used.breakaway_force:.1f} N; the printed μ makes "
        f"{printed.printed_friction:.0f} N on each carriage, more than the "
        f"{used.largest_force:.0f} N of both drives at 10 V.",
        table_of("What follows from it", derived),
        table_of("Table 1 and sections 5.1, 6.1", numbers),
    )


SECTIONS = (Section("table1", "Table 1, and what follows from it", 1.0, table1, TABLE1),)
"""Sections of this module."""
