import dataclasses
import html
import os
import re

import pytest
from report_samples import (
    TRUTH,
    campaign,
    estimate,
    frequencies,
    skipped_run,
    tuning,
)

from experiments.reports.calibration.fit_pictures import RUNS_DRAWN, runs_to_draw
from experiments.reports.report import method_notes, write_report
from experiments.studies.findings.findings import findings


def written(folder, *, title="Calibration", truth=None, **changes):
    path = folder / "report.html"
    content = {
        "campaign": campaign(),
        # One run keeps it short.
        "estimate": dataclasses.replace(estimate(), comparisons=estimate().comparisons[:1]),
    }
    write_report(path, findings(**(content | changes)), title=title, truth=truth)
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    return written(
        tmp_path_factory.mktemp("report"),
        title="Calibration of <script>alert(1)</script>",
        campaign=campaign(
            name='<script>alert("x")</script>', clock=None, skipped=skipped_run()
        ),
        estimate=dataclasses.replace(
            estimate(), comparisons=(*estimate().comparisons[:2], estimate().comparisons[3])
        ),
        frequencies=frequencies(),
        tuning=tuning(),
        truth=TRUTH,
        notes=("mind the <b>gap</b>",),
    )


def words(page):
    """The page's text as a reader sees it."""
    text = re.sub(r"<style>.*?</style>|<svg.*?</svg>", " ", page, flags=re.DOTALL)
    return re.sub(r"\s+", " ", html.unescape(re.sub(r"<[^>]+>", " ", text)))


def cells(page, first):
    """Cells of the table row that has a text in it."""
    row = next(row for row in re.findall(r"<tr>.*?</tr>", page, re.DOTALL) if first in row)
    return [
        html.unescape(re.sub(r"<[^>]+>", "", cell)).strip()
        for cell in re.findall(r"<td.*?</td>", row, re.DOTALL)
    ]


def test_a_report_asks_nothing_of_the_network(full):
    assert re.search("https?:", full) is None
    assert re.search(r'\b(?:src|href)="(?!#|data:image/png;base64,)', full) is None
    assert "url(" not in re.sub(r"url\(#fig", "", full)


def test_a_report_has_no_script_even_if_the_campaign_is_called_one(full):
    assert "<script" not in full
    assert "&lt;script&gt;" in full


def test_tags_in_notes_are_text(full):
    for tag in ("<b>gap</b>", "<b>twice</b>", "<tuning>"):
        assert tag not in full
        assert tag in words(full)


def test_no_identifier_stands_twice_in_a_report(full):
    found = re.findall(r'\bid="([^"]+)"', full)
    assert len(found) == len(set(found)) > 100


def test_every_reference_inside_a_report_has_its_target(full):
    targets = set(re.findall(r'\bid="([^"]+)"', full))
    asked = set(re.findall(r'href="#([^"]+)"', full)) | set(
        re.findall(r"url\(#([^)]+)\)", full)
    )
    assert asked
    assert asked <= targets


def test_a_parameter_stands_in_the_table_with_its_interval(full):
    row = cells(full, "effective pretension of the loop")
    assert row[:6] == ["350 N", "85.000", "84.900", "85.100", "N", "0.12 %"]


def test_the_truth_stands_beside_the_estimate_with_its_verdict(full):
    row = " ".join(cells(full, "effective pretension of the loop"))
    # 85.0 ± 0.05 against 85.5: ten standard errors.
    assert "85.500" in row
    assert "−0.58 %" in row
    assert row.endswith("no")
    # 0.01300 ± 0.00001 against 0.01301: one.
    assert cells(full, "friction coefficient of the carriages")[-1] == "yes"


def test_without_a_truth_there_is_no_column_for_it(tmp_path):
    assert "inside 99.7" not in written(tmp_path)


def test_an_estimated_clock_is_told_in_milliseconds(full):
    assert "0001-manoeuvre 12.3 ms" in words(full)


def test_a_skipped_run_is_told_with_its_fault(full):
    assert "0009-x was skipped: 0009-x/drive.csv: voltage is missing. Log it." in words(full)


def test_gains_and_predictions_stand_in_the_report(full):
    text = words(full)
    for number in ("36 V/rad", "0.7 V s/rad", "21 mm before, 1.4 mm after", "5.7 %", "157"):
        assert number in text


def test_every_section_has_its_figures(full):
    # Intervals; map, heights, one ring-down; Bode, shaper, tracking, path; two for each of
    # three runs; two films, each with a strip of four poses.
    pictures = 1 + 3 + 4 + 6
    assert full.count('<figure id="fig') == pictures
    assert full.count('<div class="film"') == 2
    assert full.count("<figcaption>") == pictures + 2 + 8


def test_a_held_out_run_is_marked(full):
    text = words(full)
    assert "Run 0002-manoeuvre, which was not fitted, is predicted to" in text
    assert "not fitted" in full[full.index("0002-manoeuvre <span") :][:300]


def test_the_method_is_told_in_the_words_of_the_code():
    text = " ".join(method_notes())
    assert "sandwich" in text
    assert "C = (JᵀJ)⁻¹" in text
    assert "$" not in text
    assert "Args" not in text


def test_a_report_that_fails_leaves_the_old_one(tmp_path, monkeypatch):
    path = tmp_path / "report.html"
    path.write_text("before")

    def fail(*args):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        written(tmp_path)
    assert path.read_text() == "before"
    assert [entry.name for entry in tmp_path.iterdir()] == ["report.html"]


def test_of_many_runs_the_held_out_and_the_worst_are_drawn():
    good, held_out, *_ = estimate().comparisons
    bad = estimate(off=5e-3).comparisons[0]
    many = [dataclasses.replace(good, name=f"good {n}") for n in range(RUNS_DRAWN + 5)]
    drawn, left_out = runs_to_draw([*many, held_out, bad])
    assert len(drawn) == RUNS_DRAWN
    assert {held_out.name, bad.name} <= {one.name for one in drawn}
    assert len(left_out) == 7


def test_a_report_says_which_run_moves_which_quantity(full):
    assert "Which run moves which quantity" in words(full)
    assert "+0.50 (1.0)" in words(full)
    assert "Too few runs for a bootstrap" in words(full)
