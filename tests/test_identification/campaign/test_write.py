import dataclasses
import pathlib

import good_campaign
import hypothesis
import hypothesis.strategies as st
import numpy as np
import pytest

from identification.campaign.faults import CampaignError
from identification.campaign.quantities import format_quantity
from identification.campaign.read import read_campaign
from identification.campaign.types import (
    CAMERA_COORDINATES,
    KINDS,
    CameraStream,
    Campaign,
    DriveStream,
    Initial,
    Knock,
    Run,
    Sensors,
    default_sensors,
    encoder_resolution,
)
from identification.campaign.write import write_campaign
from scdpr_jax.robot.quantities import QUANTITIES

SHARED = pathlib.Path(__file__).parents[3].parent / "shared" / "data" / "campaigns"

number = st.floats(-1e9, 1e9)
positive = st.floats(1e-9, 1e9)
text = st.text(st.characters(exclude_categories=["Cs"], exclude_characters="\0"))
header = st.sampled_from(["air [degC]", "µ, a [1]", 'b"c [m/s]', "é [%]"])


def array(draw, shape, elements=number):
    size = int(np.prod(shape))
    values = draw(st.lists(elements, min_size=size, max_size=size))
    return np.array(values, dtype=np.float64).reshape(shape)


def time(draw, rows):
    values = draw(st.lists(number, min_size=rows, max_size=rows, unique=True))
    return np.array(sorted(values))


def extra(draw, rows):
    cells = st.floats(allow_infinity=False)
    words = st.text("abc ,;\"'é", min_size=1)
    columns = {}
    for name in draw(st.lists(header, max_size=2, unique=True)):
        is_text = draw(st.booleans())
        values = draw(st.lists(words if is_text else cells, min_size=rows, max_size=rows))
        columns[name] = np.array(values, dtype=str if is_text else np.float64)
    return columns


@st.composite
def drives(draw, counts_per_rev):
    rows = draw(st.integers(2, 4))
    angle = array(draw, (rows, 2))
    if counts_per_rev is not None and draw(st.booleans()):
        angle = np.rint(angle) * encoder_resolution(counts_per_rev)
    pair = st.booleans().flatmap(lambda there: st.just((rows, 2) if there else None))
    current, reference = draw(pair), draw(pair)
    return DriveStream(
        time=time(draw, rows),
        voltage=array(draw, (rows, 2)),
        angle=angle,
        current=None if current is None else array(draw, current),
        tension=array(draw, (rows,)) if draw(st.booleans()) else None,
        reference=None if reference is None else array(draw, reference),
        extra=extra(draw, rows),
    )


@st.composite
def cameras(draw):
    rows = draw(st.integers(2, 4))
    return CameraStream(
        time=time(draw, rows),
        position=array(draw, (rows, 5), number | st.just(np.nan)),
        extra=extra(draw, rows),
    )


@st.composite
def runs(draw, name, counts_per_rev):
    pretension = draw(positive)
    drive = draw(drives(counts_per_rev))
    kind = draw(st.sampled_from(KINDS))
    start = draw(st.floats(drive.time[0], drive.time[-1], exclude_max=True))
    knock = Knock(start=float(start), duration=draw(positive))
    initial = Initial(x_e=draw(number), y_e=draw(number), placement_sigma=draw(positive))
    return Run(
        name=name,
        kind=kind,
        pretension=pretension,
        pretension_label=format_quantity(pretension, "N"),
        notes=draw(text),
        initial=draw(st.sampled_from([None, initial])),
        knock=draw(st.sampled_from([None, knock])) if kind == "pseudo_impulse" else None,
        clock_offset=draw(st.none() | number),
        drive=drive,
        camera=draw(st.none() | cameras()),
        camera_sigma=draw(
            st.dictionaries(st.sampled_from(CAMERA_COORDINATES), positive, max_size=3)
        ),
    )


@st.composite
def campaigns(draw):
    """Fields of a campaign: its own constructor is checked with random samples of them."""
    counted = st.floats(1e-5, 1e14) | st.integers(1, 10**6).map(float)
    counts = draw(st.none() | counted)
    names = draw(st.sampled_from([("0001-a",), ("0001-a", "0002 é")]))
    given = draw(st.sets(st.sampled_from([quantity.name for quantity in QUANTITIES])))
    sigmas = [draw(positive) for _ in range(3)]
    return {
        "name": draw(text.filter(bool)),
        "counts_per_rev": counts,
        "robot": {name: draw(positive) for name in sorted(given)},
        "sensors": Sensors(
            encoder_sigma=sigmas[0],
            camera_position_sigma=sigmas[1],
            camera_angle_sigma=sigmas[2],
        ),
        "runs": tuple(draw(runs(name, counts)) for name in names),
    }


def same(one, other):
    """Whether two campaigns, or parts of them, hold the same data to the last bit."""
    if type(one) is not type(other):
        return False
    if dataclasses.is_dataclass(one):
        # A copy's files aren't those that it was read from.
        names = [field.name for field in dataclasses.fields(one) if field.name != "source"]
        return all(same(getattr(one, name), getattr(other, name)) for name in names)
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, np.ndarray):
        return np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    return one == other


# Drawing a campaign, writing and reading it takes some 0.1 s an example.
@hypothesis.settings(max_examples=30)
@hypothesis.given(fields=campaigns())
def test_what_is_written_is_read_back_to_the_last_bit(tmp_path_factory, fields):
    campaign = Campaign(**fields)
    folder = tmp_path_factory.mktemp("written") / "campaign"
    write_campaign(campaign, folder)
    assert same(read_campaign(folder), campaign)


def test_the_comparison_sees_a_last_bit(tmp_path):
    campaign = read_campaign(good_campaign.write(tmp_path / "small"))
    run = campaign.runs[0]
    off = run.camera.position.copy()
    off[0, 0] = np.nextafter(off[0, 0], 1)
    camera = dataclasses.replace(run.camera, position=off)
    other = dataclasses.replace(
        campaign, runs=(dataclasses.replace(run, camera=camera), *campaign.runs[1:])
    )
    assert same(campaign, campaign)
    assert not same(campaign, other)


@pytest.mark.skipif(not SHARED.is_dir(), reason="the shared campaigns are absent")
@pytest.mark.parametrize("rig", ["rig-a", "rig-b"])
def test_a_shared_campaign_survives_a_round_trip(tmp_path, rig):
    campaign = read_campaign(SHARED / rig)
    write_campaign(campaign, tmp_path / "copy")
    assert same(read_campaign(tmp_path / "copy"), campaign)
    drive = tmp_path / "copy" / "0001-torque-step" / "drive.csv"
    assert "alpha_1 [count],alpha_2 [count]" in drive.read_text().splitlines()[0]


def test_written_files_look_like_the_formats_example(tmp_path):
    campaign = read_campaign(good_campaign.write(tmp_path / "small"))
    write_campaign(campaign, tmp_path / "copy")
    assert (tmp_path / "copy" / "0001-step" / "camera.csv").read_text() == (
        "t [s],x_e [mm],y_e [mm],delta_e [rad],q_3 [mm],q_4 [mm]\n"
        "0.0,26,300,0.0,26,26\n"
        f"0.002,27,,{1.8 * (np.pi / 180)!r},27,\n"
        f"0.004,28,300,{3.6 * (np.pi / 180)!r},28,28\n"
    )
    assert (tmp_path / "copy" / "0001-step" / "run.toml").read_text() == (
        'format = 1\nkind = "torque_step"\npretension = "350 N"\nnotes = "slow"\n\n'
        '[initial]\nx_e = "0.173 m"\ny_e = "0.3 m"\nplacement_sigma = "0.001 m"\n\n'
        '[camera]\nclock_offset = "0.002 s"\n'
    )


@pytest.fixture
def campaign(tmp_path):
    return read_campaign(good_campaign.write(tmp_path / "small"))


def test_nothing_is_overwritten(tmp_path, campaign):
    target = tmp_path / "there"
    target.mkdir()
    (target / "precious.txt").write_text("mine")
    with pytest.raises(FileExistsError, match=r"there: .* nothing is overwritten"):
        write_campaign(campaign, target)
    with pytest.raises(FileExistsError, match="nothing is overwritten"):
        write_campaign(campaign, target / "precious.txt")
    assert [path.name for path in target.iterdir()] == ["precious.txt"]
    assert (target / "precious.txt").read_text() == "mine"


def test_an_empty_folder_is_filled(tmp_path, campaign):
    (tmp_path / "empty").mkdir()
    write_campaign(campaign, tmp_path / "empty")
    assert len(read_campaign(tmp_path / "empty").runs) == 2


def test_folders_above_are_made(tmp_path, campaign):
    write_campaign(campaign, tmp_path / "a" / "b" / "campaign")
    assert len(read_campaign(tmp_path / "a" / "b" / "campaign").runs) == 2


def test_what_could_not_be_read_back_is_not_written_and_leaves_nothing(tmp_path, campaign):
    run = campaign.runs[0]
    voltage = run.drive.voltage.copy()
    voltage[1, 0] = np.nan
    bad = dataclasses.replace(run, drive=dataclasses.replace(run.drive, voltage=voltage))
    with pytest.raises(CampaignError, match=r"drive\.csv, row 3, column 'voltage_1 \[V\]'"):
        write_campaign(dataclasses.replace(campaign, runs=(bad,)), tmp_path / "copy")
    assert [path.name for path in tmp_path.iterdir()] == ["small"]


def test_an_unknown_quantity_is_not_written_and_leaves_nothing(tmp_path, campaign):
    bad = dataclasses.replace(campaign, robot={"radius": 1.0})
    with pytest.raises(ValueError, match="unknown quantity 'radius'"):
        write_campaign(bad, tmp_path / "copy")
    assert [path.name for path in tmp_path.iterdir()] == ["small"]


@pytest.mark.parametrize("name", ["", "..", ".hidden", "a/b", "a\\b", "c:d"])
def test_a_runs_name_is_that_of_a_folder(tmp_path, campaign, name):
    run = dataclasses.replace(campaign.runs[0], name=name)
    with pytest.raises(ValueError, match="can't be that of a folder"):
        write_campaign(dataclasses.replace(campaign, runs=(run,)), tmp_path / "copy")
    assert not (tmp_path / "copy").exists()


def test_default_noise_follows_the_encoders_resolution():
    # A uniform error over one count of 26624 a turn: the paper's rig, as rig A states it.
    assert abs(default_sensors(26624.0).encoder_sigma - 0.068e-3) < 0.5e-6
    assert default_sensors(None) == Sensors()
