"""What every verb prints, in the columns that a terminal has."""

import dataclasses
import fcntl
import io
import os
import pathlib
import pty
import re
import struct
import subprocess
import sys
import termios

import good_campaign
import jax
import numpy as np
import pytest
import xarray as xr
from axis_samples import axis, laws
from codesign_samples import co_design
from report_samples import (
    TRUTH,
    campaign,
    estimate,
    frequencies,
    tracking_run,
    tuning,
)
from rich.console import Console
from terminal import PIPED, WIDTHS, check_fits, tokens

from experiments.benchmarks.line import Line
from experiments.benchmarks.report import HEADER, cells
from experiments.cli import VERBS, main
from experiments.page.console_text import print_table, print_text
from experiments.page.table import Table
from experiments.reports import codesign_report, plan_report, shaper_report, summary
from experiments.studies.findings.findings import findings
from experiments.studies.legs import planned_leg
from experiments.sweep.show import show as show_sweep
from experiments.verbs import console
from tuning.plan.expectation import Expectation
from tuning.plan.leg import Leg
from tuning.plan.plan import Plan
from tuning.plan.planning import Planned
from tuning.shapers.catalogue import CATALOGUE, zv
from tuning.shapers.comparison import Fitted
from tuning.shapers.design import Design
from tuning.shapers.spectrum import Spectrum
from tuning.shapers.spectrum_design import Compared, SpectrumDesign
from tuning.shapers.spectrum_file import SpectrumFile

EVERY_VERB = tuple(verb for wing in VERBS.values() for verb in wing)


def shown_fit(out):
    made = findings(estimate(), campaign=campaign())
    summary.show(out, made, truth=TRUTH)
    summary.show_influence(out, made)


def shown_plan(out):
    time = 1e-3 * np.arange(2001)
    place = np.stack([0.3 + 0.8 * time, np.full(2001, 0.55)], axis=1)
    plan = Plan(time, place, place, np.zeros((2001, 2)))
    left = Expectation(np.full(2, 1e-3), np.zeros(2))
    planned = Planned(Leg((0.3, 0.55), (1.9, 0.55), 2.0), plan, plan, 1.5, left, left)
    moved = (tracking_run(swing=swing) for swing in (1e-3, 2e-3))
    runs = tuple(jax.tree.map(np.asarray, run) for run in moved)
    names = ("as fitted", "lower carriage ahead by 0.3 of what friction holds")
    plan_report.show(out, planned, planned_leg.Compared(names, runs, runs), voltage_limit=10.0)


def shown_shaper(out):
    frequency = np.linspace(10.0, 100.0, 60)
    spectrum = Spectrum(frequency, np.exp(-((frequency - 40) ** 2) / 50))
    design = Design(zv(40.0, 0.1), 0.062, 0.06)
    fit = Fitted(CATALOGUE[0], 40.0, design.shaper, design.residual)
    compared = (Compared(fit, design, design),)
    told = SpectrumDesign(spectrum, 0.1, (0.1,), design, compared, fit, (design,))
    note = ("A note on the columns.",)
    file = SpectrumFile(pathlib.Path("resonances_x.csv"), spectrum, ("psd_xyz",), False, note)
    shaper_report.show(out, file, told)


def shown_codesign(out):
    design = co_design()
    (chosen,) = design.held_out.values()
    held = {"Eq. (25)": chosen, "Eq. (25) with a ZV shaper": chosen}
    codesign_report.show(out, dataclasses.replace(design, held_out={**design.held_out, **held}))


def shown_sweep(out):
    y = xr.DataArray([0.2, 0.9], dims="y", attrs={"units": "m"})
    values = xr.DataArray(
        np.array([[3.1, 4.2], [3.6, 4.9]]),
        dims=("y", "condition"),
        coords={"condition": ["lower held, upper held", "lower held, upper free"]},
        attrs={"units": "Hz"},
        name="frequency",
    )
    show_sweep(out, xr.Dataset({"frequency": values}, {"y": y}), axes=1)


def shown_benchmark(out):
    lines = [
        Line("forward-nonlinear", "this engine, native", 4096, 1.2e-3, 3.4e6, "robot-s", 2.0),
        Line("fit", "diffrax, Tsit5", 1, note="not run: it takes more than ten minutes here"),
    ]
    print_table(
        out,
        Table(
            "",
            HEADER,
            tuple(map(cells, lines)),
            words=(0, 1, 8),
            spare=((8,), (5,), (6,)),
        ),
    )


SHOWN = {
    "demo": shown_fit,
    "calibrate": lambda out: (shown_fit(out), summary.show_tuning(out, tuning())),
    "identify": shown_fit,
    "identify-drive": lambda out: summary.show_axis(out, laws(axis()[1], ahead=5.9e-3)),
    "frequencies": lambda out: summary.show_frequencies(out, frequencies()),
    "tune": lambda out: summary.show_tuning(out, tuning()),
    "plan": shown_plan,
    "shape": shown_shaper,
    "codesign": shown_codesign,
    "sweep": shown_sweep,
    "benchmark": shown_benchmark,
}
"""What a verb prints of a prepared result. The rest print sentences by `say`, see below."""


def rendered(show, width):
    file = io.StringIO()
    show(Console(file=file, width=width, highlight=False))
    return file.getvalue()


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("verb", SHOWN)
def test_what_a_verb_prints_fits_and_no_word_is_broken(verb, width):
    check_fits(rendered(SHOWN[verb], width), rendered(SHOWN[verb], PIPED), width)


@pytest.mark.parametrize("width", WIDTHS)
def test_what_the_doctor_prints_fits_and_no_word_is_broken(
    width, tmp_path, monkeypatch, capsys
):
    folder = good_campaign.write(tmp_path / "rig")
    text = (folder / "0001-step" / "drive.csv").read_text()
    (folder / "0001-step" / "drive.csv").write_text(text.replace("alpha_1 [count]", "alpha_1"))
    printed = []
    for columns in (width, PIPED):
        for out in (console.OUT, console.ERRORS):
            monkeypatch.setattr(out, "width", columns)
        assert main(["check", str(folder)]) == 2
        told = capsys.readouterr()
        printed.append(told.out + told.err)
    check_fits(*printed, width)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("verb", EVERY_VERB)
def test_help_fits_and_no_word_is_broken(verb, width, monkeypatch, capsys):
    printed = []
    for columns in (width, 400):
        monkeypatch.setenv("COLUMNS", str(columns))
        with pytest.raises(SystemExit):
            main([verb, "--help"])
        printed.append(capsys.readouterr().out)
    narrow, wide = printed
    assert all(len(line) <= width for line in narrow.splitlines())
    drawn = str.maketrans("", "", "│╭╮╰╯─-")
    assert tokens(narrow.translate(drawn)) == tokens(wide.translate(drawn))


@pytest.mark.parametrize("width", WIDTHS)
def test_the_list_of_verbs_fits(width, monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", str(width))
    main(["--help"])
    assert all(len(line) <= width for line in capsys.readouterr().out.splitlines())


def test_in_a_pipe_a_sentence_is_one_line_and_a_path_is_whole(capsys, monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    sentence = "note: " + 40 * "a word and " + "/a/long/path/of/somebody's.json"
    print_text(Console(highlight=False, width=console._width(False)), sentence)
    assert capsys.readouterr().out == f"{sentence}\n"


CHECK = [sys.executable, "-m", "experiments.cli", "check"]


def in_a_terminal(call, *, columns, **environment):
    """What a call prints in a terminal of so many columns."""
    leader, follower = pty.openpty()
    fcntl.ioctl(follower, termios.TIOCSWINSZ, struct.pack("HHHH", 40, columns, 0, 0))
    clean = {k: v for k, v in os.environ.items() if k not in ("COLUMNS", "NO_COLOR", "TERM")}
    child = subprocess.Popen(
        call, stdout=follower, stderr=follower, env={**clean, **environment}, close_fds=True
    )
    os.close(follower)
    printed = b""
    while True:
        try:
            piece = os.read(leader, 65536)
        except OSError:  # The other end is closed: all has been read.
            break
        if not piece:
            break
        printed += piece
    child.wait()
    os.close(leader)
    return printed.decode()


@pytest.mark.parametrize(
    "environment", [{"TERM": "dumb"}, {"TERM": "xterm", "NO_COLOR": "1"}], ids=["dumb", "plain"]
)
def test_without_colour_there_are_the_same_words_and_no_escape(environment, tmp_path):
    folder = good_campaign.write(tmp_path / "rig")
    printed = in_a_terminal([*CHECK, str(folder)], columns=80, **environment)
    piped = subprocess.run([*CHECK, str(folder)], capture_output=True, text=True).stdout
    assert not re.search("\x1b\\[[0-9;]*[34][0-9]", printed)
    told = re.sub("\x1b\\[[0-9;]*m", "", printed)
    assert environment["TERM"] != "dumb" or told == printed
    assert tokens(told) == tokens(piped)
    assert all(len(line) <= 80 or line.startswith("next:") for line in told.splitlines())
