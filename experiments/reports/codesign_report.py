"""What is told of a co-design: in the terminal and as a page."""

from collections.abc import Mapping

import numpy as np
from rich.console import Console

from experiments.figures.tuning.margin_curves import margin_curves
from experiments.figures.tuning.pareto import pareto
from experiments.page.console_text import print_lines, print_table
from experiments.page.number_text import plain, short
from experiments.page.page import Pictures, page, versions
from experiments.page.table import Table
from experiments.studies.findings.tuning import worst_margins_sentence
from tuning.codesign import CoDesign, Designed
from tuning.codesign.recommendation import DESIGNED
from tuning.loop.admissible import PEAK_SENSITIVITY, PHASE_MARGIN
from tuning.loop.worst_margins import MarginMap

_METHOD = (
    "Every model is a horizontal leg from rest to a pose of the grid, by a robot drawn from "
    "the fit's covariance, that begins somewhat out of line, as friction may have left it. "
    "It is run through the nonlinear robot with exact friction under the PD at 1 kHz, with "
    "the encoders' counts and the drives' limit. All legs take the same time.",
    "What is judged: vibration of the end-effector in the second after the reference's end, "
    "where it rests, the largest error against the commanded reference, Eq. (26), and the "
    "commands. The mean over the worst tenth of the models (the conditional value at risk) "
    "is made least by Levenberg and Marquardt's method, with derivatives through every stick "
    "and slip, over two gains, the shaper's impulses and the leg's shape, in a fixed time.",
    "Gains are searched only where every loop of the flexible robot keeps "
    f"{np.degrees(PHASE_MARGIN):.0f}° of phase and a peak sensitivity of "
    f"{PEAK_SENSITIVITY:g}, over all heights and settings, its upper carriage free or held.",
    "ZV is the zero-vibration shaper at the median of the models' frequencies while friction "
    "holds both carriages, its leg as much shorter that the move takes the same time.",
)


def sentences(design: CoDesign) -> list[str]:
    """What a co-design comes to, in plain words.

    Args:
        design: The co-design.

    Returns:
        Sentences.
    """
    chosen, law = design.chosen, design.chosen.law
    held = design.held_out
    alone, with_zv = (held[name] for name in held if name != DESIGNED)
    phase = next((m for m in design.margins if m.measure == "phase_margin"), None)
    lines = [
        f"Recommended: moves of {plain(chosen.move_time, 3)} s with the gains "
        f"{short(float(law.controller.proportional_gain), 4)} V/rad and "
        f"{short(float(law.controller.derivative_gain), 4)} V s/rad. On robots and poses that "
        f"it wasn't made for, the worst tenth vibrates {_mm(held[DESIGNED].vibration)} mm "
        f"after the move, against {_mm(alone.vibration)} mm with Eq. (25) alone and "
        f"{_mm(with_zv.vibration)} mm with a ZV shaper in the same time.",
        worst_margins_sentence(design.margins),
        "With the gains of Eq. (25): " + worst_margins_sentence(design.margins_before),
    ]
    if phase is not None:
        lines.append(
            f"Height {phase.height:.2f} m at {phase.pretension:g} N decides how stiff the "
            f"drives may be ({phase.loop})."
        )
    rest, before = (np.mean(one.measures.resting_error) for one in (held[DESIGNED], alone))
    if rest > before:
        lines.append(
            f"It rests further from the target than with Eq. (25): {_mm(rest)} mm on average "
            f"against {_mm(before)} mm. Friction holds the upper carriage out of line, and "
            "softer drives end further off: `scdpr plan` leads a leg into line."
        )
    if not design.holds:
        lines.append(
            "SHORT of what is asked: margins or the drives' limit aren't kept everywhere. "
            "Give the move more time, `--move-times`."
        )
    return lines


def tables(design: CoDesign) -> tuple[Table, Table, Table]:
    """The design in numbers, the front, and the models that weren't seen.

    Args:
        design: The co-design.

    Returns:
        Three tables.
    """
    law = design.chosen.law
    impulses = zip(law.shaper.times, law.shaper.amplitudes, strict=True)
    recommended = Table(
        "The recommended design",
        ("quantity", "value"),
        (
            ("proportional gain [V/rad]", short(float(law.controller.proportional_gain), 5)),
            ("derivative gain [V s/rad]", short(float(law.controller.derivative_gain), 5)),
            ("leg without the shaper [s]", short(float(law.leg_time), 5)),
            (
                "impulses, time [ms]: amplitude [1]",
                ", ".join(f"{1e3 * float(t):.1f}: {float(a):.4f}" for t, a in impulses),
            ),
            (
                "Bézier curve's control points, share of the way [1]",
                ", ".join(f"{float(point):.4f}" for point in law.profile),
            ),
        ),
        words=(0, 1),
    )
    named = {DESIGNED: design.front, **design.compared}
    return (
        recommended,
        _figures("Move time against vibration, all models", named),
        _figures(
            "Robots and poses that no design has seen",
            {name: (one,) for name, one in design.held_out.items()},
        ),
    )


def _figures(title: str, named: Mapping[str, tuple[Designed, ...]]) -> Table:
    return Table(
        title,
        (
            "design",
            "move time [s]",
            "vibration, worst tenth [mm]",
            "worst [mm]",
            "mean [mm]",
            "resting error, mean [mm]",
            "worst [mm]",
            "largest error, Eq. (26) [mm]",
            "largest command [V]",
        ),
        tuple((name, *_row(one)) for name, designs in named.items() for one in designs),
        spare=((4,), (6,), (8,)),
    )


def _row(one: Designed) -> tuple[str, ...]:
    measures = one.measures
    return (
        plain(one.move_time, 3),
        _mm(one.vibration),
        _mm(np.max(measures.residual_vibration)),
        _mm(np.mean(measures.residual_vibration)),
        _mm(np.mean(measures.resting_error)),
        _mm(np.max(measures.resting_error)),
        plain(1e3 * float(np.max(measures.largest_error)), 3),
        plain(float(np.max(measures.largest_voltage)), 3),
    )


def _mm(metres: float) -> str:
    return plain(1e3 * float(metres))


def show(console: Console, design: CoDesign, *, caution: str = "") -> None:
    """Print a co-design.

    Args:
        console: Where to print it.
        design: The co-design.
        caution: What it has to warn of; empty for nothing.
    """
    for table in tables(design):
        print_table(console, table)
    print_lines(console, [*filter(None, [caution]), *sentences(design)])


def codesign_page(design: CoDesign, margins: MarginMap, *, name: str, caution: str = "") -> str:
    """A co-design as a page that needs nothing else.

    Args:
        design: The co-design.
        margins: Margins over the workspace with the recommended gains.
        name: Where the robot's parameters were read from.
        caution: What it has to warn of; empty for nothing.

    Returns:
        HTML.
    """
    picture, scope = Pictures(), design.scope
    columns, rows = scope.grid
    settings = ", ".join(f"{setting:g} N" for setting in scope.settings)
    return page(
        "findings.html.j2",
        title="Co-design of gains, shaper and leg",
        sentences=[*filter(None, [caution]), *sentences(design)],
        tables=tables(design),
        pictures=[
            picture(
                pareto(
                    {DESIGNED: design.front, **design.compared},
                    design.held_out,
                    chosen=design.chosen,
                ),
                "First: what the worst tenth of the models vibrates after a move (solid, mean) "
                "and the worst of all (dashed), over the move's time. Then: robots and poses "
                "that no design has seen, for the recommended move time; further to the left "
                "is better.",
            ),
            picture(
                margin_curves(margins),
                "Margins of the flexible robot's loops with the recommended gains over the "
                "height of the end-effector. Dotted: 30° and 2, which the design keeps.",
            ),
        ],
        method=_METHOD,
        provenance=[
            ("parameters", name),
            ("poses", f"{columns} x {rows}"),
            ("settings", settings),
            ("samples", f"{scope.samples}, seed {scope.seed}"),
            *versions(),
        ],
    )
