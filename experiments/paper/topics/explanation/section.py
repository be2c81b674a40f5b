"""Section on the best explanation of everything that is reported."""

from experiments.page.page import Pictures
from experiments.page.table import table_of
from experiments.paper.content import Content, Section
from experiments.paper.topics.explanation.figure import draw_explanations
from experiments.paper.topics.explanation.numbers import (
    NOMINAL,
    REPORTED,
    Explanation,
    explanations,
)
from experiments.paper.topics.manoeuvres.numbers import GRAVITY, ONE_LEG, tracked


def _row(fit: Explanation) -> dict[str, str]:
    names = [f"{result.name} [{result.unit}]" for result in REPORTED]
    return {
        "hypothesis": fit.hypothesis.name,
        "cost": f"{fit.cost:.1f}",
        "T_eff/T": f"{fit.share:.3f}",
        "T_eff at 350 N [N]": f"{NOMINAL * fit.share:.0f}",
        "friction [N]": f"{fit.friction:.2f}",
        **{name: f"{value:.3g}" for name, value in zip(names, fit.computed, strict=True)},
        "middle over ends": f"{fit.rise:.2f}",
        "unexplained": ", ".join(fit.unexplained) or "–",
    }


def explanation(picture: Pictures) -> Content:
    """The best explanation, and what remains.

    Args:
        picture: The page's figures.

    Returns:
        The section.
    """
    fits = explanations()
    best = fits[0]
    results = "; ".join(
        f"{one.name} {value:.3g} {one.unit} (reported {one.value:g})"
        for one, value in zip(REPORTED, best.computed, strict=True)
    )
    diagonal = tracked("diagonal", ONE_LEG["diagonal"], NOMINAL * best.share, GRAVITY)
    return Content(
        f"Two unknowns, the effective share of the nominal pretension and a carriage's "
        f"friction force, fitted under {len(fits)} hypotheses on what the paper leaves "
        f"unsaid, (24) met exactly. Closest comes: {best.hypothesis.name}, with T_eff = "
        f"{best.share:.3f} T ({NOMINAL * best.share:.0f} N at 350 N) and "
        f"{best.friction:.2f} N: {results}.",
        "Left over by it: why the effective pretension is a fifth of the nominal; why the "
        "drives' inertia, without which the open-loop runs and the closed loop are not the "
        "paper's (E25), should be absent from a knock, and friction with it; and that the "
        "same weight that makes the vertical error 8 mm would saturate the diagonal "
        f"({1e3 * diagonal.error.max():.0f} mm of error on the way up, not reported).",
        "The runner-up holds both carriages by friction, as the simulated knocks do; it "
        "misses only the shape of the frequency over the height.",
        "“About” is read as a tenth of the 50 mm, a twentieth of the frequencies, 1 mm of "
        "8 mm, three times the vision system's angle and three standard errors of the "
        "0.68 V.",
        picture(
            draw_explanations(fits),
            "The best eight fits: what each makes of the reported results; colours are "
            "deviations over what the print bears, bold beyond two.",
        ),
        table_of("Every hypothesis", map(_row, fits)),
    )


SECTIONS = (
    Section("explanation", "The best explanation of all results at once", 60.0, explanation),
)
"""The section of this module."""
