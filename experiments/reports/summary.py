"""The results in a terminal: aligned tables and the summary's sentences."""

from collections.abc import Mapping, Sequence

from rich.console import Console
from rich.table import Table
from rich.text import Text

from experiments.page.console_text import print_lines, rich_table
from experiments.page.number_text import rounded
from experiments.page.table import Table as PlainTable
from experiments.reports.drive_report import axis_rows, axis_sentences, law_sentences
from experiments.reports.influence_section import influence_sentences, influence_tables
from experiments.reports.measured_section import measured_tables
from experiments.reports.model_section import model_tables, posterior_table, profile_table
from experiments.reports.parameter_table import Row, inside, parameter_row
from experiments.reports.tuning_section import tuning_sentences, tuning_tables
from experiments.reports.verdict import Words, estimated, words
from identification.axis.drive_axis import DriveAxisEstimate
from identification.axis.law import AxisLaws
from identification.campaign.types import Campaign
from identification.checks.posterior import Posterior
from identification.checks.profile import Profile
from identification.knocks.frequency_map import FrequencyMap
from identification.result.estimate import Estimate
from tuning.result.types import Tuning

_STYLES = {
    "identified": "green",
    "weak": "yellow",
    "unidentifiable": "red",
    "at bound": "red",
    "yes": "green",
    "no": "red",
}


def covers(estimate: Estimate, truth: Mapping[str, float]) -> bool:
    """Whether every estimate's 99.7 % interval covers the truth.

    Args:
        estimate: The estimate.
        truth: True values by name [SI]; what isn't estimated isn't looked at.

    Returns:
        Whether all do.
    """
    known = [p for p in estimated(estimate) if p.name in truth]
    return all(inside(parameter, truth[parameter.name]) for parameter in known)


def show(
    console: Console,
    estimate: Estimate,
    *,
    campaign: Campaign | None = None,
    frequencies: FrequencyMap | None = None,
    truth: Mapping[str, float] | None = None,
    tuning: Tuning | None = None,
    profiles: Sequence[Profile] = (),
    posterior: Posterior | None = None,
) -> None:
    """Print what a campaign says about a robot.

    Args:
        console: Where to print it.
        estimate: The estimate.
        campaign: The campaign, for its clocks and skipped runs; None without.
        frequencies: Natural frequencies, None without.
        truth: True values by name [SI], printed beside the estimates.
        tuning: Gains and shapers, None without.
        profiles: Profiles of the estimated quantities, where they were traced.
        posterior: Draws from what the logs leave possible, where they were made.
    """
    rows = [
        parameter_row(parameter, truth=dict(truth or {})) for parameter in estimated(estimate)
    ]
    console.print(_parameters(rows, with_truth=bool(truth)))
    if profiles:
        console.print(rich_table(profile_table(profiles)))
    if posterior is not None:
        console.print(rich_table(posterior_table(posterior)))
    for table in (*measured_tables(estimate), *model_tables(estimate)):
        console.print(rich_table(table))
    said = words(campaign, estimate, frequencies=frequencies, tuned=tuning is not None)
    _print_words(console, said, parameters=len(rows))
    if tuning is not None:
        show_tuning(console, tuning)


def show_influence(console: Console, estimate: Estimate) -> None:
    """Print which run moves which quantity.

    Args:
        console: Where to print it.
        estimate: The estimate.
    """
    for table in influence_tables(estimate):
        console.print(rich_table(table))
    print_lines(console, influence_sentences(estimate))


def show_tuning(console: Console, tuning: Tuning) -> None:
    """Print gains, shapers and what they are predicted to do.

    Args:
        console: Where to print them.
        tuning: The tuning.
    """
    for table in tuning_tables(tuning):
        console.print(rich_table(table))
    print_lines(console, tuning_sentences(tuning))


def show_frequencies(console: Console, frequencies: FrequencyMap) -> None:
    """Print the natural frequencies that were found.

    Args:
        console: Where to print them.
        frequencies: The map.
    """
    header = ("run", "x [mm]", "y [mm]", "T [N]", "f [Hz]", "± σ", "damping [1]", "± σ")
    rows = []
    for row, run in enumerate(frequencies.runs):
        sigma = float(frequencies.frequency_sigma[row])
        damping_sigma = float(frequencies.damping_ratio_sigma[row])
        rows.append(
            (
                run,
                f"{1e3 * float(frequencies.x[row]):.1f}",
                f"{1e3 * float(frequencies.y[row]):.1f}",
                f"{float(frequencies.pretension[row]):g}",
                rounded(float(frequencies.frequency[row]), sigma),
                rounded(sigma, sigma),
                rounded(float(frequencies.damping_ratio[row]), damping_sigma),
                rounded(damping_sigma, damping_sigma),
            )
        )
    console.print(rich_table(PlainTable("Natural frequencies", header, tuple(rows))))
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


def show_axis(
    console: Console,
    estimate: DriveAxisEstimate,
    laws: AxisLaws,
    *,
    position_unit: str = "m",
) -> None:
    """Print an axis's parameters.

    Args:
        console: Where to print them.
        estimate: The estimate.
        laws: The extended friction law beside the usual one.
        position_unit: SI unit of its log's positions, "m" or "rad".
    """
    console.print(
        _parameters(axis_rows(estimate, position_unit=position_unit), with_truth=False)
    )
    # The parameters are in the table already.
    told = axis_sentences(estimate, position_unit=position_unit)[len(estimate.names) :]
    print_lines(console, [*told, *law_sentences(laws, position_unit=position_unit)])


def _parameters(rows: Sequence[Row], *, with_truth: bool) -> Table:
    table = Table(box=None, pad_edge=False, header_style="bold")
    for name in ("quantity", "setting"):
        table.add_column(name, no_wrap=True)
    for name in ("value", "95 % from", "to"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("unit")
    table.add_column("±", justify="right")
    table.add_column("status")
    if with_truth:
        for name in ("truth", "error"):
            table.add_column(name, justify="right")
        table.add_column("inside 99.7 %")
    for row in rows:
        cells = [Text(row.name), Text(row.setting)]
        cells += [Text(text) for text in (row.value, row.low, row.high, row.unit, row.relative)]
        cells.append(Text(row.status, style=_STYLES.get(row.status, "")))
        if with_truth:
            cells += [Text(row.truth), Text(row.error)]
            cells.append(Text(row.covered, style=_STYLES.get(row.covered, "")))
        table.add_row(*cells)
    return table


def _print_words(console: Console, said: Words, *, parameters: int) -> None:
    # The parameters are in the table already.
    for title, lines in (
        ("", said.found[parameters:]),
        ("How far to trust it", said.sure),
        ("What to do next", said.next),
    ):
        if title and lines:
            console.print(Text(title, style="bold"))
        print_lines(console, lines)
