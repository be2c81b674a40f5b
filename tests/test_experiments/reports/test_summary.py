import dataclasses
import io
import re

from axis_samples import axis, laws
from report_samples import TRUTH, campaign, estimate, frequencies, tuning
from rich.console import Console

from experiments.reports import summary
from experiments.reports.drive.report import write_drive_report
from experiments.studies.findings.findings import findings
from identification.axis.estimate import DOES_NOT_FIT, Change


def printed(show, *args, **kwargs):
    file = io.StringIO()
    show(Console(file=file, width=200), *args, **kwargs)
    return file.getvalue()


def test_truth_stands_beside_the_estimate():
    text = printed(summary.show, findings(estimate(), campaign=campaign()), truth=TRUTH)
    line = next(line for line in text.splitlines() if "effective_pretension" in line)
    assert re.split(r"\s{2,}", line.strip()) == [
        *("effective_pretension", "350 N", "85.000", "84.900", "85.100", "N", "0.12 %"),
        *("identified", "85.500", "−0.58 %", "no"),
    ]


def test_markup_in_a_name_is_printed_as_it_is():
    text = printed(summary.show, findings(estimate(), tuning=tuning()))
    assert "A note of the <tuning>." in text


def test_gains_and_shapers_are_printed():
    text = printed(summary.show_tuning, tuning())
    for number in ("36", "0.7", "3.2", "5.7 %"):
        assert number in text


def test_frequencies_are_printed_with_their_errors():
    line = next(
        line
        for line in printed(summary.show_frequencies, frequencies()).splitlines()
        if "0003" in line
    )
    assert line.split()[4:] == ["3.2000", "0.0040", "0.0100", "0.0010"]


def test_an_axis_is_printed_with_its_units():
    text = printed(summary.show_axis, laws(axis()[1], ahead=6.9e-3))
    line = next(line for line in text.splitlines() if line.startswith("viscous"))
    assert "203.5" in line
    assert "N s/m" in line
    assert "1.20 mm rms" in text


def test_the_report_of_an_axis_needs_nothing_else_and_has_its_numbers(tmp_path):
    log, found = axis()
    write_drive_report(tmp_path / "report.html", log=log, laws=laws(found, ahead=5.9e-3))
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert re.search("https?:", page) is None
    assert "1.20\N{NO-BREAK SPACE}mm rms" in page
    page = page.replace("\N{NO-BREAK SPACE}", " ")
    assert page.count("<svg") == 1
    assert '<table class="heat few">' in page
    assert "203.5 N s/m, 95 % from 199.6 to 207.4 (identified)" in page


def test_an_extended_law_is_offered_where_held_out_data_prefer_it_alone():
    _, found = axis()

    def told(ahead):
        # A narrow console breaks lines anywhere.
        return " ".join(printed(summary.show_axis, laws(found, ahead=ahead)).split())

    enough, better = told(6.9e-3), told(5.9e-3)
    assert "the usual law is enough" in enough
    assert "what was held out prefers the extended law" in better
    assert "viscous friction forwards minus backwards −83.0 N s/m" in better


def test_a_law_that_does_not_fit_is_told_above_the_table():
    _, found = axis()
    failed = dataclasses.replace(found, status=(DOES_NOT_FIT,) * 4)
    text = printed(summary.show_axis, laws(failed, ahead=6.9e-3))
    assert text.startswith("THE LAW DOES NOT FIT")


def test_halves_that_disagree_are_told_above_the_table():
    _, found = axis()
    changed = dataclasses.replace(found, changes=(Change("coulomb", 22.0, 44.0),))
    text = " ".join(printed(summary.show_axis, laws(changed, ahead=6.9e-3)).split())
    assert text.startswith("ONE LAW DOESN'T FIT THE WHOLE RECORD: Coulomb friction 22")
