"""Many campaigns in one call: one table, each failure a row, and the bytes of single calls."""

import csv
import json

import numpy as np
import pytest
import xarray as xr

from experiments.cli import main
from experiments.runtime.executors.chosen import chosen
from experiments.runtime.executors.here import ThisProcess
from experiments.runtime.parcel import unpacked
from experiments.studies.campaigns.files import packed_files, unpack_files
from experiments.studies.campaigns.identified import Question, identified
from experiments.studies.campaigns.places import is_one, places
from experiments.studies.campaigns.run import identify_campaigns
from experiments.studies.campaigns.table import MEANINGS, rows, write_csv
from experiments.studies.campaigns.unit import Answer
from experiments.virtual_rig.recovery import campaign, draw
from experiments.virtual_rig.simulated import COUNTS_PER_REV
from identification.campaign import (
    Campaign,
    DriveStream,
    Run,
    read_campaign,
    write_campaign,
)
from identification.campaign.types import default_sensors, encoder_resolution
from identification.doctor.accepted import admission
from identification.result.parameters_file import write_parameters
from scdpr_jax.numerics.progress import Progress
from scdpr_jax.provenance import made_today
from scdpr_jax.robot.prototype import consistent

DRIVES = Question(free=("drive_inertia", "drive_damping"))
ACCEPT = ("unexplained",)


def drives(seed):
    """A step of bare drives without dry friction, in closed form, rounded to counts."""
    inertia, damping = (draw(seed).values[name] for name in DRIVES.free)
    time = 5e-3 * np.arange(361)
    voltage = np.where(time >= 0.1, 6.0, 0.0)
    elapsed, decay = np.maximum(time - 0.1, 0), inertia / damping
    speed = 6.0 * float(consistent().drive.torque_per_volt) / damping
    angle = speed * (elapsed - decay * (1 - np.exp(-elapsed / decay)))
    count = encoder_resolution(COUNTS_PER_REV)
    rounded = np.round(np.stack([angle, angle + 0.3 * count], axis=1) / count) * count
    run = Run(
        name="0001-motor-step",
        kind="motor_step",
        pretension=350.0,
        pretension_label="350 N",
        drive=DriveStream(time=time, voltage=np.stack([voltage] * 2, axis=1), angle=rounded),
    )
    return Campaign(
        name=f"drives {seed}",
        runs=(run,),
        counts_per_rev=COUNTS_PER_REV,
        sensors=default_sensors(COUNTS_PER_REV),
    )


@pytest.fixture(scope="module")
def rigs(tmp_path_factory):
    """Two campaigns of bare drives, which are fitted in no time, and two that can't be read."""
    folder = tmp_path_factory.mktemp("rigs")
    for seed in (1, 2):
        write_campaign(drives(seed), folder / f"rig-{seed}")
    (folder / "=bad()").mkdir()
    (folder / "=bad()" / "campaign.toml").write_text("no = 'campaign'")
    (folder / "notes").mkdir()
    (folder / "notes" / "campaign.txt").write_text("of no interest")
    return folder


def identified_all(rigs, out, **options):
    return identify_campaigns(
        places([rigs]), DRIVES, out, executor=ThisProcess(), accept=ACCEPT, **options
    )


def contents(out):
    files = [path for path in out.rglob("*") if path.is_file()]
    return {str(path.relative_to(out)): path.read_bytes() for path in files}


@pytest.fixture(scope="module")
def batch(rigs, tmp_path_factory):
    """What came of the campaigns, and its folder."""
    out = tmp_path_factory.mktemp("batch") / "out"
    return identified_all(rigs, out), out


def test_a_folders_campaigns_are_a_row_for_each_quantity_and_the_reason_of_a_failure(batch):
    found, out = batch
    with (out / "campaigns.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    assert list(table[0]) == list(MEANINGS)
    failed = [row for row in table if not row["name"]]
    assert [row["campaign"] for row in failed] == ["'=bad()"]  # no formula
    assert failed[0]["reason"].startswith("campaign =bad(): ")
    assert list(found.failed) == ["=bad()"]
    for seed in (1, 2):
        truth = draw(seed).values["drive_inertia"]
        (row,) = (
            row
            for row in table
            if (row["campaign"], row["name"]) == (f"rig-{seed}", "drive_inertia")
        )
        assert float(row["value"]) == pytest.approx(truth, rel=0.02)
        assert float(row["low"]) < float(row["value"]) < float(row["high"])
        assert (row["unit"], row["status"], row["reason"]) == ("kg m^2", "identified", "")
        written = json.loads((out / f"rig-{seed}" / "parameters.json").read_text())
        assert row["logs"] == written["provenance"]["source"]


def test_both_tables_say_the_same(batch):
    _, out = batch
    with (out / "campaigns.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    with xr.open_dataset(out / "campaigns.nc", engine="h5netcdf") as found:
        assert list(found) == list(MEANINGS)
        numbers = [float(row["value"] or "nan") for row in table]
        np.testing.assert_array_equal(found.value.values, numbers)
        assert [*found.reason.values] == [row["reason"] for row in table]
        assert [*found.campaign.values] == [row["campaign"].lstrip("'") for row in table]


def test_each_campaigns_parameters_are_those_of_a_call_of_its_own(batch, rigs, tmp_path):
    _, out = batch
    admitted, _ = admission(read_campaign(rigs / "rig-1"), ACCEPT)
    alone = identified(admitted, DRIVES)
    made = made_today(admitted.name, admitted.source).model_copy(update={"date": ""})
    write_parameters(tmp_path / "alone.json", *alone, admitted.accepted, made)
    written = (out / "rig-1" / "parameters.json").read_bytes()
    assert written == (tmp_path / "alone.json").read_bytes()
    assert json.loads(written)["fits"] is True


def test_a_batch_that_is_stopped_goes_on_to_the_same_bytes(batch, rigs, tmp_path):
    def tell(doing, share):
        if share > 0.4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        identified_all(rigs, tmp_path / "out", progress=Progress(tell))
    assert not (tmp_path / "out" / "campaigns.csv").exists()
    told = []
    progress = Progress(lambda doing, share: told.append((doing, share)))
    identified_all(rigs, tmp_path / "out", progress=progress)
    assert contents(tmp_path / "out") == contents(batch[1])
    assert next(share for doing, share in told if doing == "beginning") > 0.3


def test_what_failed_leaves_no_earlier_calls_parameters(rigs, tmp_path):
    (tmp_path / "out" / "=bad()").mkdir(parents=True)
    stale = tmp_path / "out" / "=bad()" / "parameters.json"
    stale.write_text("{}")
    identified_all(rigs, tmp_path / "out")
    assert not stale.exists()


def test_the_verb_falls_short_where_one_fails(rigs, batch, tmp_path, capfd):
    call = ["identify", str(rigs), "--out", str(tmp_path / "out"), "--cores", "1"]
    status = main([*call, "--accept", *ACCEPT, "--free", *DRIVES.free])
    told = capfd.readouterr().out
    assert status == 1
    assert "2 of 3 campaigns identified." in told
    assert "failed: =bad(): campaign =bad(): " in told
    assert contents(tmp_path / "out") == contents(batch[1])


# Which campaigns


def test_a_single_campaign_is_no_batch(rigs):
    assert is_one([rigs / "rig-1"])
    assert is_one([rigs / "nowhere"])
    assert not is_one([rigs])
    assert not is_one([rigs / "rig-1", rigs / "rig-2"])


def test_a_call_names_campaigns_and_folders_of_them(rigs, tmp_path):
    names = [place.name for place in places([tmp_path / "gone", rigs])]
    assert names == ["gone", "=bad()", "rig-1", "rig-2"]


@pytest.mark.parametrize("name", ["campaigns.nc", ".hidden"])
def test_a_campaign_that_cannot_have_a_folder_of_its_name_is_refused(tmp_path, name):
    with pytest.raises(ValueError, match="can't be called so"):
        places([tmp_path / name, tmp_path / "other"])


def test_two_campaigns_of_one_name_are_refused(rigs):
    with pytest.raises(ValueError, match="two campaigns have one name"):
        places([rigs, rigs / "rig-1"])


# Files on their way


def test_a_campaigns_files_arrive_as_they_are(rigs, tmp_path):
    unpack_files(unpacked(packed_files(rigs / "rig-1")), tmp_path / "there")
    assert contents(tmp_path / "there") == contents(rigs / "rig-1")


def test_a_link_that_leads_out_of_a_campaign_is_not_followed(tmp_path):
    (tmp_path / "secret").write_text("mine")
    (tmp_path / "rig" / "0001").mkdir(parents=True)
    (tmp_path / "rig" / "campaign.toml").symlink_to(tmp_path / "secret")
    content = packed_files(tmp_path / "rig")
    assert b"mine" not in content
    with pytest.raises(ValueError, match=r"can't be read: campaign\.toml is no file"):
        unpack_files(unpacked(content), tmp_path / "there")


def test_a_reason_makes_no_row_of_its_own(tmp_path):
    answer = Answer("", 'first\nsecond,"third"\r\x1b[2Jfourth')
    write_csv(tmp_path / "table.csv", list(rows("rig\nforged,row", answer)))
    with (tmp_path / "table.csv").open(newline="") as file:
        (row,) = csv.DictReader(file)
    assert row["campaign"] == r"rig\nforged,row"
    assert row["reason"] == r'first second,"third" \x1b[2Jfourth'


# Shared out


@pytest.mark.slow
def test_a_hundred_campaigns_give_the_same_bytes_whoever_computes_them(tmp_path, monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")
    for seed in range(100):
        write_campaign(campaign(draw(seed), seed), tmp_path / "rigs" / f"rig-{seed:03d}")
    found = []
    for cluster, cores in ((None, 1), (None, 2), ("local:4", 1)):
        out = tmp_path / f"out-{len(found)}"
        with chosen(cluster, None, cores) as executor:
            batch = identify_campaigns(
                places([tmp_path / "rigs"]), Question(), out, executor=executor
            )
        found.append(contents(out))
    assert found[0] == found[1] == found[2]
    # Two tables, and parameters of each but what contradicts itself by chance: one of these.
    assert len(found[0]) == 102 - len(batch.failed)
    assert len(batch.failed) <= 2
