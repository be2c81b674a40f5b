"""Files that mean harm: each is refused with its own message, or shown harmlessly."""

import os

import given_files
import pytest
from hostile_files import HOSTILE, KNOWN_HERE

from experiments.cli import main
from scdpr_jax.numerics.files.harmless import LINES, printable

pytestmark = pytest.mark.skipif(
    not KNOWN_HERE, reason="pipes, sockets and names that aren't UTF-8 are made on Linux alone"
)


@pytest.mark.parametrize("hostile", HOSTILE, ids=lambda own: own.name.replace(" ", "-"))
def test_each_is_refused_with_its_own_message(hostile, tmp_path):
    if hostile.name.startswith(("a photo", "a video")):
        pytest.importorskip("cv2", reason="OpenCV isn't installed")
    given_files.write(tmp_path)
    hostile.make(tmp_path)
    with pytest.raises(ValueError) as caught:
        hostile.read(tmp_path)
    lines = str(caught.value).split("\n")
    assert hostile.told in str(caught.value)
    assert len(lines) <= LINES
    assert all(printable(line) == line for line in lines)
    assert "root:x" not in str(caught.value)


def test_there_are_forty():
    assert len({hostile.name for hostile in HOSTILE}) >= 40


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("campaign.toml", '"small rig"', '"a\\u001b]0;x\\u0007 [/nope] \\u202e"'),
        ("0001-step/drive.csv", "t [ms]", "=cmd|'/c calc'!A0 [1],t [ms]"),
        ("0001-step/drive.csv", "t [ms]", "a\x1bc [1],t [ms]"),
        ("0001-step/drive.csv", "t [ms]", '"a\n0009  forged [1]",t [ms]'),
        ("0001-step/run.toml", '"slow"', '"[/bold] \\u001b[31m"'),
    ],
)
def test_what_may_be_in_a_log_is_shown_harmlessly(file, old, new, tmp_path, capfd):
    folder = given_files.write(tmp_path) / "campaign"
    text = (folder / file).read_text(encoding="utf-8").replace(old, new)
    if new.endswith(",t [ms]"):
        head, *rows = text.rsplit("alpha_2 [deg],current_1 [mA],current_2 [A]\n", 1)
        body = "".join(f"0,{row}\n" for row in rows[0].splitlines())
        text = f"{head}alpha_2 [deg],current_1 [mA],current_2 [A]\n{body}"
    (folder / file).write_text(text, encoding="utf-8")
    assert main(["check", str(folder)]) in (0, 1)
    told = capfd.readouterr().out
    assert all(printable(line) == line for line in told.splitlines())
    assert not any(line.startswith("0009") for line in told.splitlines())


def test_markup_in_a_runs_name_is_shown_as_it_is(tmp_path, capfd):
    folder = given_files.write(tmp_path) / "campaign"
    os.rename(folder / "0001-step", folder / "[bold]0001[nope]")
    assert main(["check", str(folder)]) in (0, 1)
    assert "[bold]0001[nope]" in capfd.readouterr().out
