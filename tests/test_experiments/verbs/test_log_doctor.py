"""`scdpr check` by its exit status and files, and verbs that refuse what contradicts itself."""

import csv
import json
import subprocess
import sys

import loose_rig
import numpy as np
import planted_slips
import pytest

from experiments.cli import main
from identification.campaign import Campaign, read_campaign, write_campaign

RUNS = ("0003-torque-step", "0006-manoeuvre", "0009-pseudo-impulse", "0013-motor-step")


@pytest.fixture(scope="module")
def good() -> Campaign:
    (campaign,) = loose_rig.campaigns([42], elastic=False)
    return campaign.with_runs(RUNS)


@pytest.fixture
def good_folder(good, tmp_path):
    write_campaign(good, tmp_path / "good")
    return tmp_path / "good"


@pytest.fixture
def slipped_folder(good, tmp_path):
    plant = planted_slips.PLANTED["y downwards"][1]
    write_campaign(plant(good, np.random.default_rng(1)), tmp_path / "slipped")
    return tmp_path / "slipped"


def test_a_good_campaign_passes(good_folder):
    assert main(["check", str(good_folder)]) == 0


def test_a_contradiction_exits_1_and_is_in_the_file(slipped_folder, tmp_path):
    file = tmp_path / "findings.json"
    assert main(["check", str(slipped_folder), "--json", str(file)]) == 1
    document = json.loads(file.read_text())
    assert document["format"] == 1
    first = document["findings"][0]
    assert (first["id"], first["severity"]) == ("sign.y_e", "contradiction")
    assert set(first) == {
        "id",
        "severity",
        "runs",
        "stream",
        "column",
        "row",
        "evidence",
        "what",
        "cause",
        "remedy",
        "alternatives",
        "mend",
    }


def test_a_fault_exits_2_and_is_in_the_file(good_folder, tmp_path):
    log = good_folder / RUNS[0] / "drive.csv"
    lines = log.read_text().splitlines()
    log.write_text("\n".join([*lines[:100], *lines[50:]]) + "\n")
    file = tmp_path / "findings.json"
    assert main(["check", str(good_folder), "--json", str(file)]) == 2
    first = json.loads(file.read_text())["findings"][0]
    assert (first["id"], first["severity"], first["row"]) == ("time.jump", "fault", 101)


def test_a_mended_copy_passes_and_the_original_stays(slipped_folder, tmp_path):
    before = (slipped_folder / RUNS[0] / "camera.csv").read_bytes()
    assert main(["check", str(slipped_folder), "--mend", str(tmp_path / "mended")]) == 1
    assert (slipped_folder / RUNS[0] / "camera.csv").read_bytes() == before
    assert main(["check", str(tmp_path / "mended")]) == 0


@pytest.mark.parametrize("verb", ["identify", "calibrate", "frequencies"])
def test_a_contradiction_is_refused_before_any_work(verb, slipped_folder, tmp_path, capfd):
    assert main([verb, str(slipped_folder), "--out", str(tmp_path / "out")]) == 2
    assert "sign.y_e" in capfd.readouterr().err
    assert not (tmp_path / "out").exists()


def test_what_is_accepted_is_told(slipped_folder, tmp_path, capfd):
    out = tmp_path / "out"
    call = ["frequencies", str(slipped_folder), "--out", str(out), "--accept", "sign.y_e"]
    assert main(call) == 0
    assert "accepted contradiction: sign.y_e" in " ".join(capfd.readouterr().out.split())


def test_an_unknown_identifier_is_bad_input(slipped_folder, tmp_path, capfd):
    call = ["frequencies", str(slipped_folder), "--out", str(tmp_path), "--accept", "sign.z"]
    assert main(call) == 2
    assert "sign.z" in capfd.readouterr().err


def test_a_knock_that_is_not_stated_gives_its_frequency(good, tmp_path):
    knock = RUNS[2]
    plant = planted_slips.each_run(good, planted_slips.no_knock)
    for name, campaign in (("stated", good), ("found", plant)):
        write_campaign(campaign, tmp_path / name)
        call = ["frequencies", str(tmp_path / name), "--out", str(tmp_path / f"{name}-out")]
        assert main(call) == 0
    stated, found = (
        next(csv.DictReader(text.splitlines()))
        for text in (
            (tmp_path / f"{name}-out" / "frequencies.csv").read_text()
            for name in ("stated", "found")
        )
    )
    assert stated["run"] == found["run"] == knock
    column = "frequency [Hz]"
    assert float(found[column]) == pytest.approx(float(stated[column]), rel=0.01)


def test_check_imports_no_jax(good_folder):
    code = (
        "import sys\nfrom experiments.cli import main\n"
        f"assert main(['check', {str(good_folder)!r}]) == 0\n"
        "assert 'jax' not in sys.modules"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert ran.returncode == 0, ran.stderr


def test_reading_a_mended_campaign_gives_its_notes(slipped_folder, tmp_path):
    main(["check", str(slipped_folder), "--mend", str(tmp_path / "mended")])
    assert "sign.y_e" in read_campaign(tmp_path / "mended").runs[0].notes
