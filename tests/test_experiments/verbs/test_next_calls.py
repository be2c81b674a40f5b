"""What a verb says to do next."""

import ast
import contextlib
import dataclasses
import pathlib
import shlex

import pytest
from report_samples import campaign, estimate, frequencies, tuning

import experiments.verbs
from experiments.reports import written_files
from experiments.reports.tuning import files
from experiments.studies import pipeline
from experiments.studies.findings.findings import findings
from experiments.studies.findings.tuning import tuning_findings
from experiments.verbs import console, log_doctor
from experiments.verbs.main import calibrate
from identification import campaign as logs
from scdpr_jax.numerics.progress import SILENT
from scdpr_jax.robot.parameters import exact
from scdpr_jax.robot.prototype import consistent
from tuning.result.tuning import FittedSetting

OPENER = console.open_call(pathlib.Path("report.html")).split()[0]
TAKES = {"simulate": "parameters.json", "plan": "tuning.json", OPENER: "report.html"}
"""The file that each call takes which `scdpr calibrate` may say to make next."""


def calibration(*, knocks):
    robots = (FittedSetting(350.0, exact(consistent())),)
    fitted = dataclasses.replace(tuning(), robots=robots)
    made = findings(
        estimate(), campaign=campaign(), frequencies=frequencies() if knocks else None
    )
    # Without its maps of the workspace, which take a minute and say nothing of what is next.
    tuned = dataclasses.replace(tuning_findings(tuning()), tuning=fitted)
    return dataclasses.replace(made, tuning=tuned)


@pytest.fixture
def calls(monkeypatch, tmp_path, capsys, request):
    """The calls that `scdpr calibrate` says to make next, split into words."""
    made = calibration(knocks=request.param)
    monkeypatch.setattr(calibrate, "set_up", lambda: None)
    monkeypatch.setattr(
        calibrate,
        "shown_progress",
        lambda console, name, given: contextlib.nullcontext(SILENT),
    )
    # The sample's streams are made up one by one, which the log doctor would object to.
    monkeypatch.setattr(log_doctor, "examined", lambda campaign, accept, *, verb: campaign)
    monkeypatch.setattr(logs, "read_campaign", lambda *path, **options: made.campaign)
    monkeypatch.setattr(pipeline, "calibrate", lambda *campaign, **options: made)
    # It takes a minute to draw, and says nothing of what comes next.
    monkeypatch.setattr(
        written_files, "write_report", lambda path, *findings, **content: path.write_text("")
    )
    # Nor do the programs for other machines, which take a minute to print.
    monkeypatch.setattr(files, "write_exports", lambda folder, tuning: [])
    assert calibrate.calibrate(tmp_path / "campaign", tmp_path / "out") == 0
    lines = capsys.readouterr().out.splitlines()
    prefix = "next: "
    return [shlex.split(line[len(prefix) :]) for line in lines if line.startswith(prefix)]


@pytest.mark.parametrize("calls", [True, False], ids=["knocks", "none"], indirect=True)
def test_every_call_that_comes_next_is_given_the_file_that_it_takes(calls):
    for words in calls:
        verb = words[1] if words[0] == "scdpr" else words[0]
        files = [pathlib.Path(word) for word in words if pathlib.Path(word).is_file()]
        assert [file.name for file in files] == [TAKES[verb]], words
    assert len(calls) == len(TAKES)


def test_no_verb_picks_what_it_wrote_by_its_place():
    folder = pathlib.Path(experiments.verbs.__file__).parent
    for path in folder.rglob("*.py"):
        for call in ast.walk(ast.parse(path.read_text())):
            if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name)):
                continue
            if call.func.id in ("suggest", "plan_call", "wrote"):
                by_place = [n for n in ast.walk(call) if isinstance(n, ast.Subscript)]
                assert not by_place, f"{path}:{call.lineno}"


def test_a_call_longer_than_the_terminal_is_one_line(capsys):
    call = "scdpr plan " + 20 * "a-long-folder/" + 'tuning.json --from "0.3 m, 0.55 m"'
    console.suggest(call)
    assert capsys.readouterr().out == f"next: {call}\n"
