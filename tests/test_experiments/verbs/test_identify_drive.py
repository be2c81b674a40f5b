"""`scdpr identify-drive` by its files and exit status, on logs with their usual troubles."""

import json

import jax.numpy as jnp
import numpy as np
import pytest

from experiments.cli import main
from identification.axis.motion import AxisParameters, axis_positions

TRUTH = {"mass": 0.002, "viscous": 0.004, "coulomb": 0.02, "offset": 0.003}
GAIN = 0.05


def rows(*, wrapped=False, gap=False, reversed_=False):
    """A rotary axis's log in degrees: time [s], voltage [V], position [deg]."""
    time = 0.004 * np.arange(700)
    voltage = 2.0 * np.sin(3.0 * time) + 1.0 * np.sin(9.0 * time)
    angle = axis_positions(
        AxisParameters(*TRUTH.values()),
        GAIN * jnp.asarray(voltage[:-1]),
        steps=jnp.full(len(time) - 1, 0.004),
        start=jnp.array(0.0),
    )
    degrees = np.round(np.degrees(np.asarray(angle)), 2) * (-1 if reversed_ else 1)
    if wrapped:
        degrees = np.mod(degrees, 360.0)
    table = np.column_stack([time, voltage, degrees])
    return np.delete(table, slice(300, 390), axis=0) if gap else table


def identified(folder, *, header="t [s],voltage [V],position [deg]", gain="0.05 N m/V", **made):
    log = folder / "log.csv"
    np.savetxt(log, rows(**made), delimiter=",", header=header, comments="", fmt="%.6f")
    return main(["identify-drive", str(log), "--gain", gain, "--out", str(folder / "out")])


@pytest.mark.slow
def test_a_rotary_axis_is_told_in_its_units_through_wraps_and_a_gap(tmp_path):
    assert identified(tmp_path, wrapped=True, gap=True) == 0
    document = json.loads((tmp_path / "out" / "parameters.json").read_text())
    units = {row["name"]: row["unit"] for row in document["parameters"]}
    assert units == {"mass": "kg m^2", "viscous": "N m s", "coulomb": "N m", "offset": "N m"}
    for row in document["parameters"]:
        assert row["value"] == pytest.approx(TRUTH[row["name"]], rel=0.01), row
        assert row["status"] == "identified"
    assert document["open_loop_rmse_rad"] < 1e-3
    assert [note.split()[0] for note in document["notes"]] == ["The", "Samples"]
    assert (tmp_path / "out" / "report.html").exists()


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"gain": "0.05 N/V"}, "[N m/V]"),
        ({"gain": "0.05"}, "a number without its unit"),
        ({"header": "t [s],voltage [V],position"}, "column 'position'"),
        ({"reversed_": True}, "the encoder counts the other way"),
    ],
)
def test_what_is_wrong_is_named_and_nothing_is_written(changes, message, tmp_path, capfd):
    assert identified(tmp_path, **changes) == 2
    assert message in " ".join(capfd.readouterr().err.split())
    assert not (tmp_path / "out").exists()
