import pytest

from experiments.cli import main
from experiments.verbs.exit_status import BAD_INPUT, DONE

MAPPING = """\
format = 1
[[run]]
name = "0001-step"
kind = "torque_step"
pretension = {pretension}
drive_log = "log.csv"
[drive.columns]
t = {{ channel = "t", unit = "s" }}
voltage_1 = {{ channel = "u1", unit = "V" }}
voltage_2 = {{ channel = "u2", unit = "V" }}
alpha_1 = {{ channel = "a1", unit = "rad" }}
alpha_2 = {{ channel = "a2", unit = "rad" }}
"""


@pytest.fixture
def mapping(tmp_path):
    """How to write a mapping beside its log."""
    rows = [f"{k / 1000};{int(k > 200)};0;{k**2 / 1e6:g};0" for k in range(600)]
    (tmp_path / "log.csv").write_text("\n".join(["t;u1;u2;a1;a2", *rows]) + "\n")

    def write(pretension='"350 N"'):
        (tmp_path / "m.toml").write_text(MAPPING.format(pretension=pretension))
        return str(tmp_path / "m.toml")

    return write


def test_a_mapping_is_imported(mapping, tmp_path, capsys):
    assert main(["import", mapping(), "--into", str(tmp_path / "rig")]) == DONE
    assert (tmp_path / "rig" / "0001-step" / "drive.csv").exists()
    told = capsys.readouterr().out
    assert "0001-step: torque_step, 600 samples" in told
    assert f"next: scdpr check {tmp_path / 'rig'}" in told


def test_what_is_missing_is_one_message_and_nothing_is_written(mapping, tmp_path, capsys):
    assert main(["import", mapping('""'), "--into", str(tmp_path / "rig")]) == BAD_INPUT
    assert "left empty" in capsys.readouterr().err
    assert not (tmp_path / "rig").exists()


def test_a_proposal_is_written_and_says_what_comes_next(mapping, tmp_path, capsys):
    mapping()
    made = tmp_path / "proposed.toml"
    assert main(["import", str(tmp_path / "log.csv"), "--propose", str(made)]) == DONE
    assert 'pretension = ""' in made.read_text()
    call = f"next: scdpr import {made} --into {tmp_path / 'campaign'}"
    assert call in capsys.readouterr().out


@pytest.mark.parametrize("arguments", [[], ["a.toml"], ["a.toml", "b.toml", "--into", "rig"]])
def test_nothing_to_do_is_said(arguments, capsys):
    assert main(["import", *arguments]) == BAD_INPUT
    assert "scdpr import: " in capsys.readouterr().err


def test_names_cannot_move_the_cursor(mapping, tmp_path, capsys):
    (tmp_path / "log.csv").write_text("t;\x1b[2Ju1;u2;a1;a2\n0;1;2;3;4\n1;1;2;3;4\n")
    assert main(["import", mapping(), "--into", str(tmp_path / "rig")]) == BAD_INPUT
    assert "\x1b" not in capsys.readouterr().err
