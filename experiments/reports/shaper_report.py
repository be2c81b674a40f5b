"""What is told of a shaper for a spectrum: in the terminal and as a page."""

from collections.abc import Sequence

import numpy as np
from rich.console import Console

from experiments.figures.tuning.spectrum import duration_against_vibration, shaped_spectrum
from experiments.page.console_text import print_lines, print_table, print_text
from experiments.page.number_text import percent, plain
from experiments.page.page import Pictures, page, versions
from experiments.page.table import Table
from experiments.studies.findings.responses import NamedShaper
from scdpr_jax.command.shaper import Shaper
from tuning.export.firmware import Pasted
from tuning.shapers.measures import smoothing
from tuning.shapers.shaper_file import ACCELERATION
from tuning.shapers.spectrum import THRESHOLD
from tuning.shapers.spectrum_design import SpectrumDesign
from tuning.shapers.spectrum_file import SpectrumFile

_METHOD = (
    "Vibration left is Σ max(V·P − P_max/20, 0) / Σ max(P − P_max/20, 0): P is the measured "
    "power over its frequency, V the share of a vibration at that frequency which the shaper "
    "leaves, and the worst damping ratio of those named below counts. 0 % doesn't mean no "
    "vibration, but none above a twentieth of the highest peak.",
    "Each shaper of the catalogue stands at the frequency that is best for it: of those that "
    "leave at most 0.05 % more than the least, the highest, which makes it shortest.",
    "An optimised shaper has the impulses, all positive, that leave least in a given time. "
    "For impulses at fixed instants that is a convex program: its minimum is the minimum, so "
    "no other shaper of positive impulses, known or not, is better in the same time. The "
    "instants are then moved by gradient.",
    "Smoothing is how far a corner of the path is rounded: a/2 times the variance of the "
    "impulses' instants, with their amplitudes as weights.",
)


def sentences(design: SpectrumDesign) -> list[str]:
    """What a design comes to, in plain words.

    Args:
        design: The design.

    Returns:
        Sentences.
    """
    best, picked = design.recommended, design.picked
    lines = [
        f"Recommended: {best.shaper.times.size} impulses in {_ms(best.shaper)} ms, which leave "
        f"{_left(best.residual)} of the vibration.",
        f"From the catalogue one would take {picked.entry.name} at "
        f"{plain(picked.frequency, 3)} Hz: {_ms(picked.shaper)} ms, "
        f"{_left(picked.residual)} left.",
        "Impulses at "
        + ", ".join(plain(1e3 * float(t), 4) for t in best.shaper.times)
        + " ms with the amplitudes "
        + ", ".join(f"{float(a):.4f}" for a in best.shaper.amplitudes)
        + ".",
    ]
    if design.recommended.residual > 0.05:
        lines.append(
            "More than 5 % is left: allow a longer shaper (`--max-duration`), or stiffen the "
            "machine at the peaks that the picture shows."
        )
    return lines


def tables(design: SpectrumDesign) -> tuple[Table, Table]:
    """The catalogue beside the optimised shapers, and the front.

    Args:
        design: The design.

    Returns:
        Two tables.
    """
    best = design.recommended
    rows = [("recommended", "", *_numbers(best.shaper, best.residual), "", "")]
    rows += [
        (
            one.fit.entry.name,
            plain(one.fit.frequency, 3),
            *_numbers(one.fit.shaper, one.fit.residual),
            f"{_ms(one.same_duration.shaper)} ms, {_left(one.same_duration.residual)}",
            f"{_ms(one.same_vibration.shaper)} ms, {_left(one.same_vibration.residual)}",
        )
        for one in design.compared
    ]
    catalogue = Table(
        "The catalogue, and what can be had instead",
        (
            "shaper",
            "frequency [Hz]",
            "duration [ms]",
            "vibration left",
            f"smoothing at {ACCELERATION:g} m/s² [mm]",
            "optimised, no longer",
            "optimised, no worse",
        ),
        tuple(rows),
        spare=((4,),),
    )
    front = Table(
        "Duration against vibration, optimised",
        ("impulses", "duration [ms]", "vibration left", "smoothing [mm]"),
        tuple(
            (str(each.shaper.times.size), *_numbers(each.shaper, each.residual))
            for each in design.front
        ),
        words=(),
    )
    return catalogue, front


def show(console: Console, file: SpectrumFile, design: SpectrumDesign) -> None:
    """Print a design.

    Args:
        console: Where to print it.
        file: The spectrum as it was read.
        design: The design.
    """
    print_lines(console, [*file.notes, _peaks(file)])
    for table in tables(design):
        print_table(console, table)
    print_lines(console, sentences(design))


def show_pasted(console: Console, pasted: Sequence[Pasted]) -> None:
    """Print the lines that a firmware is told of a shaper.

    Args:
        console: Where to print them.
        pasted: The lines for each firmware.
    """
    for each in pasted:
        name, left = each.fit.entry.name, _left(each.fit.residual)
        print_text(
            console,
            f"For {each.firmware}, which makes its impulses itself, of those that it knows "
            f"{name}, which leaves {left}; paste:",
        )
        for line in each.lines:
            print_text(console, f"    {line}")


def shaper_page(file: SpectrumFile, design: SpectrumDesign) -> str:
    """A design as a page that needs nothing else.

    Args:
        file: The spectrum as it was read.
        design: The design.

    Returns:
        HTML.
    """
    picture, ratios = Pictures(), ", ".join(f"{r:g}" for r in design.damping_ratios)
    band = (float(file.spectrum.frequency[0]), float(file.spectrum.frequency[-1]))
    drawn = [
        NamedShaper(name, shaper, design.damping_ratio, band)
        for name, shaper in (
            ("recommended", design.recommended.shaper),
            (design.picked.entry.name, design.picked.shaper),
        )
    ]
    return page(
        "findings.html.j2",
        title=f"Input shaper for {file.path.name}",
        sentences=[*sentences(design), *file.notes, _peaks(file)],
        tables=tables(design),
        pictures=[
            picture(
                shaped_spectrum(file.spectrum, drawn),
                "The measured spectrum before and after shaping (above), what the shapers "
                f"leave over the frequency at damping ratio {design.damping_ratio:g} (below), "
                "and their impulses. What is below the dashed line doesn't count.",
            ),
            picture(
                duration_against_vibration(design),
                "Vibration left over duration. No shaper of positive impulses lies below the "
                "line; what leaves less than 0.001 % is drawn there.",
            ),
        ],
        method=_METHOD,
        provenance=[
            ("spectrum", f"{file.path.name}, column {file.column}"),
            (
                "density over frequency",
                "as in the file" if file.was_normalised else "divided here",
            ),
            ("damping ratios judged at", ratios),
            ("catalogue designed for damping ratio", f"{design.damping_ratio:g}"),
            ("threshold", f"{percent(THRESHOLD)} of the highest peak"),
            *versions(),
        ],
    )


def _peaks(file: SpectrumFile) -> str:
    """Where each sensor's spectrum is highest."""
    peaks = " and ".join(f"{plain(peak, 3)} Hz" for peak in file.spectrum.peaks)
    return f"The spectrum is highest at {peaks}."


def _numbers(shaper: Shaper, residual: float) -> tuple[str, str, str]:
    rounding = 1e3 * float(smoothing(shaper, acceleration=ACCELERATION))
    return _ms(shaper), _left(residual), plain(rounding, 3)


def _ms(shaper: Shaper) -> str:
    return plain(1e3 * float(np.asarray(shaper.duration)), 4)


def _left(residual: float) -> str:
    return "0 %" if residual < 5e-7 else percent(residual, 3)
