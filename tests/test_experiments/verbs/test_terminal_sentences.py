"""What design, simulate, reproduce, import and track print, in the columns of a terminal.

The others have tables, see `test_terminal`; these say sentences, of results that are prepared
here or small.
"""

import json
import pathlib
import shutil
import types

import numpy as np
import pytest
from report_samples import tracking_run
from terminal import PIPED, WIDTHS, check_fits

from experiments.cli import main
from experiments.page.console_text import print_lines, print_table
from experiments.paper import report
from experiments.paper.catalogue import SECTIONS
from experiments.paper.claim import Printed
from experiments.paper.content import Content
from experiments.studies import next_run, simulated_run
from experiments.studies.known_rig import caution, known_rig
from experiments.verbs import console
from experiments.verbs.identification import track
from identification.next_run.excitation import Excitation
from identification.next_run.next_experiment import Candidate
from identification.result.fitted_robot import Residual
from identification.result.parameters_file import ParametersDocument
from identification.vision import camera_file
from scdpr_jax.robot.prototype import consistent
from scdpr_jax.robot.quantities import QUANTITIES, value

LOST = Residual(channel="x_e", rms=2e-3, noise_sigma=2e-4, is_noise=False)


def known():
    """A fitted robot of which the friction is known within a hundredth."""
    rows = [
        {
            "name": own.name,
            "setting": "350 N" if own.name == "effective_pretension" else None,
            "value": float(value(consistent(), own.name)),
            "unit": own.unit,
            "sigma": 1e-4 if own.name == "friction_coefficient" else 0.0,
            "status": "identified" if own.name == "friction_coefficient" else "fixed",
        }
        for own in QUANTITIES
    ]
    correlation = {"names": ["friction_coefficient"], "matrix": [[1.0]]}
    document = json.dumps({"format": 1, "parameters": rows, "correlation": correlation})
    fitted = ParametersDocument.model_validate_json(document).fitted_robot()
    return known_rig(fitted, setting=None, log_rate=1000.0, top_speed=1.5)


def designed(monkeypatch):
    moved = next_run._Moved(np.array([0.2, 0.3]), np.array([1.9, 0.7]), 1.41)
    monkeypatch.setattr(next_run, "_moved", lambda rig, candidate: moved)
    rig = known()
    runs = [
        Excitation(name, (0.3, 0.55), np.full((100, 2), 6.0), knock, built)
        for name, knock, built in (("multisine, improved", 0.0, True), ("knock", 30.0, False))
    ]
    candidates = [Candidate(run, np.array([5e-5]), 0.7) for run in runs]
    aim = next_run.aim_for("mu", rig)
    print_table(console.OUT, next_run.candidate_table(rig, aim, candidates))
    sentences = (next_run.chosen_sentence(candidates), caution((LOST,)))
    print_lines(console.OUT, (*sentences, *next_run.instructions(candidates[0])))


def simulated(monkeypatch):
    console.say(simulated_run.sentence(tracking_run(swing=1e-3)))


def reproduced(monkeypatch):
    printed = Printed("Table 2", "12.3", "mm")
    claims = (
        printed.reproduced("the largest error of the horizontal manoeuvre", lambda: 12.3),
        printed.not_reproducible("the same along the diagonal", lambda: 12.3, "it is another"),
    )
    judged = tuple(report.Judged(one, 12.3) for one in claims)
    part = report.Reproduced(SECTIONS[0], Content(), judged)
    for line in report.told([part]):
        console.say(line)


def tracked(monkeypatch):
    told = {
        "frames": 900, "posed": 899, "dropped": 1, "doubled": 0,
        "sigma": {"x_e": "0.19 mm", "y_e": "0.2 mm", "delta_e": "1 mrad", "q_3": None},
        "camera_position_sigma": "0.19 mm", "camera_angle_sigma": "1 mrad",
    }  # fmt: skip
    monkeypatch.setattr(camera_file, "summary", lambda result: told)
    lens = types.SimpleNamespace(rms=0.173)
    marks = types.SimpleNamespace(view=types.SimpleNamespace(lens=lens), rms=0.412)
    note = "the marker of the lower carriage is near the picture's edge in 14 pictures"
    track._show(types.SimpleNamespace(marks=marks, warnings=(note,)))


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("show", [designed, simulated, reproduced, tracked])
def test_what_a_verb_says_fits_and_no_word_is_broken(show, width, monkeypatch, capsys):
    printed = []
    for columns in (width, PIPED):
        for out in (console.OUT, console.ERRORS):
            monkeypatch.setattr(out, "width", columns)
        show(monkeypatch)
        printed.append(capsys.readouterr().out)
    assert printed[1]
    check_fits(*printed, width)


ROWS = [f"{k / 1000};{int(k > 200)};0;{k**2 / 1e6:g};0" for k in range(600)]
LOG = "\n".join(["t [s];u1 [V];u2 [V];enc1 [deg];enc2 [deg]", *ROWS])


@pytest.mark.parametrize("width", WIDTHS)
def test_what_an_import_says_fits_and_no_word_is_broken(width, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)  # A path isn't broken, however long.
    pathlib.Path("log.csv").write_text(LOG + "\n")
    printed = []
    for columns in (width, PIPED):
        for out in (console.OUT, console.ERRORS):
            monkeypatch.setattr(out, "width", columns)
        assert main(["import", "log.csv", "--propose", "m.toml"]) == 0
        text = pathlib.Path("m.toml").read_text(encoding="utf-8")
        text = text.replace('pretension = ""', 'pretension = "350 N"')
        pathlib.Path("whole.toml").write_text(text, encoding="utf-8")
        status = main(["import", "whole.toml", "--into", "rig"])
        told = capsys.readouterr()
        printed.append(told.out + told.err)
        assert (status, "next: scdpr" in printed[-1]) == (0, True), printed[-1]
        shutil.rmtree("rig")
    check_fits(*printed, width)
