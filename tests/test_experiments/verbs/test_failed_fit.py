"""A fit that has failed says so in its files and exit status, and gives nothing away."""

import json
import pathlib

import loose_rig
import numpy as np
import planted_slips
import pytest

from experiments.cli import main
from identification.campaign import write_campaign

SLIP = "sign.voltage_1"


@pytest.fixture(scope="module")
def identified(tmp_path_factory):
    """Exit status and folder of a fit of bare drives, one of which turns the other way."""
    folder: pathlib.Path = tmp_path_factory.mktemp("failed")
    (campaign,) = loose_rig.campaigns([42], elastic=False)
    drives = campaign.with_runs([r.name for r in campaign.runs if r.kind == "motor_step"])
    slipped = planted_slips.PLANTED["voltage 1"][1](drives, np.random.default_rng(1))
    write_campaign(slipped, folder / "campaign")
    out = folder / "out"
    accept = [SLIP, "sign.alpha_1", "unexplained"]
    call = ["identify", str(folder / "campaign"), "--out", str(out), "--accept", *accept]
    return main([*call, "--free", "drive_inertia", "drive_damping"]), out


def test_the_verb_falls_short(identified):
    assert identified[0] == 1


def test_no_quantity_has_another_status_or_an_error(identified):
    document = json.loads((identified[1] / "parameters.json").read_text())
    estimated = [p for p in document["parameters"] if p["status"] != "fixed"]
    assert {p["status"] for p in estimated} == {"model_does_not_fit"}
    assert all(p["sigma"] is None and p["interval95"] == [None, None] for p in estimated)
    assert document["fits"] is False
    assert document["unexplained"]


@pytest.mark.parametrize("verb", ["tune", "codesign"])
def test_nothing_is_made_from_it_without_force(verb, identified, tmp_path, capfd):
    parameters, out = str(identified[1] / "parameters.json"), tmp_path / "out"
    table = "x [m],y [m],pretension [N],frequency [Hz],frequency_sigma [Hz],"
    table += "damping_ratio [1],damping_ratio_sigma [1],run"
    frequencies = tmp_path / "frequencies.csv"
    frequencies.write_text(table + "\n0.5,0.5,350,3.1,0.01,0.01,0.001,0001\n")
    call = {
        "tune": ["--parameters", parameters, "--frequencies", str(frequencies)],
        "codesign": [parameters],
    }[verb]
    assert main([verb, *call, "--out", str(out)]) == 2
    assert "--force" in capfd.readouterr().err
    assert not out.exists()


def test_what_is_simulated_from_it_says_so_and_falls_short(identified, tmp_path, capfd):
    parameters, out = str(identified[1] / "parameters.json"), tmp_path / "out"
    call = ["simulate", "--parameters", parameters, "--setting", "350 N", "--out", str(out)]
    assert main(call) == 1
    assert capfd.readouterr().out.startswith("THE MODEL DOES NOT FIT")
