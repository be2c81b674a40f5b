"""Sections on the loop's cable and on Figure 21."""

from experiments.page.page import Pictures
from experiments.page.table import table_of
from experiments.paper.content import Content, Section
from experiments.paper.topics.prototype.numbers import derived_as_printed, derived_consistently
from experiments.paper.topics.tensioning.claims import FIG21
from experiments.paper.topics.tensioning.figure import draw_creep, draw_tensions
from experiments.paper.topics.tensioning.numbers import (
    HOURS,
    STRAINS,
    TOP_SPEED,
    creep,
    lost_frequency,
    runs,
    strain_of_the_pretension,
)


def cable(picture: Pictures) -> Content:
    """Elasticity, lengthening and creep.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    printed, used, histories = derived_as_printed(), derived_consistently(), creep()
    worst = histories.bare[STRAINS[-1]]
    share = float(worst[-1] / worst[0])
    rows = (
        {
            "creep [µm/m a decade]": f"{1e6 * strain:g}",
            "of 350 N left [N]": f"{values[-1]:.0f}",
            "tension [%]": f"{100 * (1 - values[-1] / values[0]):.1f}",
            "frequency [%]": f"{100 * (1 - lost_frequency(values[-1] / values[0])):.1f}",
        }
        for strain, values in histories.bare.items()
    )
    return Content(
        f"EA is {1e-3 * used.axial_stiffness:.0f} kN with steel and "
        f"{1e-3 * printed.axial_stiffness:.2f} kN as printed; over the loop's 8.33 m "
        f"{1e-3 * used.loop_stiffness:.0f} N/mm against "
        f"{1e-3 * printed.loop_stiffness:.1f} N/mm.",
        f"350 N are {1e6 * strain_of_the_pretension():.0f} µm/m of strain in steel, "
        f"{1e3 * used.stretch:.1f} mm of the loop: any creep of that size takes the whole "
        "pretension. Each 10 µm/m costs 6.6 N.",
        f"At {1e6 * STRAINS[-1]:g} µm/m a decade {100 * (1 - share):.0f} % of the tension "
        f"and {100 * (1 - lost_frequency(share)):.0f} % of the frequency are gone after "
        f"{HOURS:g} h. The paper names creep and gives no number; these strains are "
        "examples.",
        picture(
            draw_creep(histories),
            "Pretension of a resting robot under logarithmic creep, and the natural "
            "frequency that is left (f ~ √T): bare loops, the printed modulus, and the "
            "actuator of Figure 21.",
        ),
        table_of(f"After {HOURS:g} h, bare steel loop", rows),
    )


def fig21(picture: Pictures) -> Content:
    """The modified scheme.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    loops = runs()
    rows = (
        {
            "actuator": name,
            "highest tension [N]": f"{loops.tension[name].max():.0f}",
            "lowest [N]": f"{loops.tension[name].min():.0f}",
            "largest travel [mm]": f"{1e3 * abs(loops.travel[name]).max():.2f}",
            "experiment 1 ends at [m]": f"{loops.end[name]:.3f}",
            "knock [Hz]": f"{loops.frequency[name]:.2f}",
        }
        for name in loops.tension
    )
    bare = loops.tension["no actuator"].max()
    return Content(
        f"With constant tension the path lengthens by {1e3 * loops.path:.1f} mm in "
        "experiment 1. A bare steel loop doesn't let it: its tension rises from 85 to "
        f"{bare:.0f} N, which keeps the robot in line. (The stiffness times the "
        "lengthening, 1.5 kN, leaves out that the rise holds it back: E24.)",
        "An actuator for maintenance, a minute slow, changes nothing in a manoeuvre and "
        "holds the pretension against creep. One that is to hold it during manoeuvres has "
        f"to answer in milliseconds: 20 ms and {TOP_SPEED:g} m/s halve the rise.",
        f"A knock of 10 N in the middle rings at {loops.constant:.2f} Hz with constant "
        f"tension and at {loops.frequency['no actuator']:.2f} Hz on the bare loop: the "
        "vibration itself stretches it, twice a period, and stiffens it. At small "
        "amplitudes both have the same frequency, since the lengthening is of second "
        "order.",
        picture(
            draw_tensions(loops),
            "Experiment 1 on an elastic loop: tension, and the travel of the linear "
            "actuator; dashed the constant tension of the model and its path's "
            "lengthening.",
        ),
        table_of("Modified scheme: tension sensor and linear actuator, setpoint 85 N", rows),
    )


SECTIONS = (
    Section("cable", "The loop's cable: elasticity, path and creep", 2.0, cable),
    Section("fig21", "Figure 21: tension sensor and linear actuator", 15.0, fig21, FIG21),
)
"""Sections of this module."""
