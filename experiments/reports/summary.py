"""The results in a terminal: aligned tables and the summary's sentences."""

from collections.abc import Mapping, Sequence

from rich.console import Console

from experiments.page.console_text import print_lines, print_table, print_text
from experiments.reports.calibration.influence_tables import influence_tables
from experiments.reports.calibration.knock_table import knock_table
from experiments.reports.drive.words import (
    axis_rows,
    axis_sentences,
    axis_verdict,
    law_sentences,
)
from experiments.reports.model_tables import (
    measured_tables,
    model_tables,
    posterior_table,
    profile_table,
)
from experiments.reports.parameter_table import parameter_row, parameters_table
from experiments.reports.tuning.tables import tuning_tables
from experiments.studies.findings.findings import Findings
from experiments.studies.findings.influence import influence_sentences
from experiments.studies.findings.parameters import estimated
from experiments.studies.findings.tuning import tuning_sentences
from identification.axis.law import AxisLaws
from identification.checks.posterior import Posterior
from identification.checks.profile import Profile
from identification.knocks.frequency_map import FrequencyMap
from tuning.result.tuning import Tuning

_STYLES = {
    "identified": "green",
    "weak": "yellow",
    "unidentifiable": "red",
    "at bound": "red",
    "model does not fit": "red",
    "yes": "green",
    "no": "red",
}


def show(
    console: Console,
    findings: Findings,
    *,
    truth: Mapping[str, float] | None = None,
    profiles: Sequence[Profile] = (),
    posterior: Posterior | None = None,
) -> None:
    """Print what a campaign says about a robot.

    Args:
        console: Where to print it.
        findings: What it comes to.
        truth: True values by name [SI], printed beside the estimates.
        profiles: Profiles of the estimated quantities, where they were traced.
        posterior: Draws from what the logs leave possible, where they were made.
    """
    estimate = findings.estimate
    for number, line in enumerate(findings.verdict):
        print_text(console, line, style="bold red" if number == 0 else "red")
    rows = [
        parameter_row(parameter, truth=dict(truth or {})) for parameter in estimated(estimate)
    ]
    print_table(console, parameters_table(rows, with_truth=bool(truth)), styles=_STYLES)
    for table in (
        *((profile_table(profiles),) if profiles else ()),
        *(() if posterior is None else (posterior_table(posterior),)),
        *measured_tables(findings.measured),
        *model_tables(estimate),
    ):
        print_table(console, table)
    words = findings.words
    # The parameters are in the table already.
    print_lines(console, words.found[len(rows) :])
    for title, lines in (
        ("How far to trust it", words.sure),
        ("What to do next", words.next),
    ):
        if lines:
            print_text(console, title, style="bold")
        print_lines(console, lines)
    if findings.tuning is not None:
        show_tuning(console, findings.tuning.tuning)


def show_influence(console: Console, findings: Findings) -> None:
    """Print which run moves which quantity.

    Args:
        console: Where to print it.
        findings: What a campaign comes to.
    """
    for table in influence_tables(findings.estimate):
        print_table(console, table)
    print_lines(console, influence_sentences(findings.influence))


def show_tuning(console: Console, tuning: Tuning) -> None:
    """Print gains, shapers and what they are predicted to do.

    Args:
        console: Where to print them.
        tuning: The tuning.
    """
    for table in tuning_tables(tuning):
        print_table(console, table)
    print_lines(console, tuning_sentences(tuning))


def show_frequencies(console: Console, frequencies: FrequencyMap) -> None:
    """Print the natural frequencies that the knocks gave.

    Args:
        console: Where to print them.
        frequencies: The map.
    """
    print_table(console, knock_table(frequencies))
    sliding = [
        run
        for run, noise in zip(frequencies.runs, frequencies.residuals_are_noise, strict=True)
        if not noise
    ]
    lines = [f"{name} gives no frequency: {why}" for name, why in frequencies.unresolved]
    if sliding:
        lines.append(
            f"More than noise is left of {', '.join(sliding)}: the carriages were still "
            "sliding, and the errors are widened for it."
        )
    print_lines(console, lines)


def show_axis(console: Console, laws: AxisLaws) -> None:
    """Print an axis's parameters.

    Args:
        console: Where to print them.
        laws: The usual friction law, and the extended one beside it.
    """
    estimate = laws.usual
    for line in axis_verdict(laws):
        print_text(console, line, style="bold red")
    rows = axis_rows(estimate)
    print_table(console, parameters_table(rows, with_truth=False), styles=_STYLES)
    for note in estimate.notes:
        print_text(console, f"note: {note}")
    # The parameters are in the table already.
    print_lines(console, [*axis_sentences(estimate)[len(rows) :], *law_sentences(laws)])
