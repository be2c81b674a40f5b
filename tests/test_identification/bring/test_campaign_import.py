import log_styles
import numpy as np
import plain_runs
import pytest

from identification.bring.campaign_import import import_campaign
from identification.campaign import CampaignError, read_campaign

MAPPING = """\
format = 1
[campaign]
counts_per_rev = 1000
[[run]]
name = "0001-step"
kind = "torque_step"
pretension = "350 N"
drive_log = {log}
{part}
[drive.columns]
{clock}
voltage_1 = {{ channel = "u1", unit = "V" }}
voltage_2 = {{ channel = "u2", unit = "V" }}
alpha_1 = {{ channel = "n1", unit = "count" }}
alpha_2 = {{ channel = "n2", unit = "rad" }}
"""
STATED = 't = { channel = "t", unit = "s" }'


@pytest.fixture
def imported(tmp_path):
    """How to import text logs by a mapping: the first run's drive stream."""

    def bring(logs, clock=STATED, part="", change=("", "")):
        for name, text in logs.items():
            (tmp_path / name).write_text(text, encoding="utf-8")
        names = "[" + ", ".join(f'"{name}"' for name in logs) + "]"
        text = MAPPING.format(log=names, clock=clock, part=part)
        (tmp_path / "m.toml").write_text(text.replace(*change) if change[0] else text)
        return import_campaign(tmp_path / "m.toml", tmp_path / "out").runs[0]

    return bring


def table(time, header="t,u1,u2,n1,n2", start=0):
    rows = [f"{t},{k},{-k},{10 * k},{k / 8}" for k, t in enumerate(time, start=start)]
    return "\n".join([header, *rows]) + "\n"


@pytest.mark.parametrize("seed", [3, 4])
@pytest.mark.parametrize("kind", log_styles.STYLES)
def test_a_campaign_of_any_style_is_imported_as_it_was(kind, seed, tmp_path):
    random = np.random.default_rng([seed, log_styles.STYLES.index(kind)])
    campaign, style = plain_runs.campaign(seed), log_styles.draw_style(kind, random)
    counts = campaign.counts_per_rev
    files = [
        log_styles.write_run(tmp_path, run, style, random, counts, f"log{k:03d}")
        for k, run in enumerate(campaign.runs)
    ]
    stated = {"drive": kind != "tdms", "camera": True}
    mapping = log_styles.mapping_of(style, campaign, files, home=tmp_path, time_of=stated)
    (tmp_path / "m.toml").write_text(mapping, encoding="utf-8")
    import_campaign(tmp_path / "m.toml", tmp_path / "out")
    found = log_styles.differences(campaign, read_campaign(tmp_path / "out"))
    # Some tens of radians, and a second, through two changes of unit: a few roundings.
    assert max(found.values()) < 1e-13


def test_what_is_missing_is_told_at_once_and_nothing_is_written(imported, tmp_path):
    with pytest.raises(CampaignError) as caught:
        imported({"a.csv": table([0, 1e-3])}, change=('"u1", unit = "V"', '"u9", unit = "V"'),
                 part='[run.knock]\nstart = ""\nduration = "30 ms"')  # fmt: skip
    assert [fault.what for fault in caught.value.faults] == ["left empty"]
    with pytest.raises(CampaignError) as caught:
        imported({"a.csv": table([0, 1e-3])}, change=('"u1", unit = "V"', '"u9", unit = ""'))
    (fault,) = caught.value.faults
    assert (fault.what, fault.column) == ("no such channel", "voltage_1")
    assert not (tmp_path / "out").exists()


def test_pieces_follow_each_other_whether_their_clock_begins_anew_or_not(imported):
    first, second = np.arange(5) / 8, np.arange(5, 9) / 8
    run = imported({"a.csv": table(first), "b.csv": table(second, start=5)})
    np.testing.assert_array_equal(run.drive.time, np.arange(9) / 8)
    np.testing.assert_array_equal(run.drive.voltage[:, 0], np.arange(9))


def test_a_clock_that_begins_anew_goes_on_a_sample_after_the_last(imported):
    run = imported({"a.csv": table(np.arange(5) / 8), "b.csv": table(np.arange(4) / 8)})
    np.testing.assert_array_equal(run.drive.time, np.arange(9) / 8)
    assert "begins anew in b.csv" in run.notes


def test_pieces_that_overlap_are_refused(imported):
    with pytest.raises(CampaignError, match=r"b\.csv: pieces that overlap"):
        imported({"a.csv": table(np.arange(9) / 8), "b.csv": table(np.arange(5, 9) / 8 + 0.01)})


def test_a_part_keeps_its_clock(imported):
    part = 'from = "250 ms"\nto = "0.75 s"'
    run = imported({"a.csv": table(np.arange(9) / 8)}, part=part)
    np.testing.assert_array_equal(run.drive.time, np.arange(2, 7) / 8)
    assert "cut to 5 of 9 samples" in run.notes


@pytest.mark.parametrize(
    "stamp",
    [
        "2026-11-30T23:59:59.{}Z",
        "2026-11-30 23:59:59.{}",
        "30.11.2026 23:59:59.{}",
        "11/30/2026 23:59:59.{}",
        "23:59:59.{}",
        "1796083199.{}",
        "1796083199{}",
    ],
)
def test_stamps_count_from_the_first_sample(imported, stamp):
    time = [stamp.format(f"{ms:03d}") for ms in (125, 250, 375, 875)]
    run = imported({"a.csv": table(time)}, clock='t = { channel = "t", unit = "UTC" }')
    # Ten digits before the point aren't to take any from those behind it.
    np.testing.assert_allclose(
        run.drive.time - run.drive.time[0], [0, 0.125, 0.25, 0.75], atol=1e-12
    )


def test_a_rate_is_a_clock(imported):
    run = imported({"a.csv": table(np.arange(5))}, clock='t = { rate = "8 Hz" }')
    np.testing.assert_array_equal(run.drive.time, np.arange(5) / 8)


def test_another_clock_is_interpolated_and_commands_are_held(imported):
    rows = [f"{k / 8},{k},{-k},{10 * k},{k / 8},{k / 8 + 1 / 32}" for k in range(9)]
    text = "\n".join(["t,u1,u2,n1,n2,t2", *rows]) + "\n"
    other = ', t = { channel = "t2", unit = "s" } }'
    text_of = ('"count" }', '"count"' + other)
    run = imported({"a.csv": text}, change=text_of)
    # A quarter of a sample later: a quarter of a step less; the first instant is before it.
    count = 2 * np.pi / 1000
    np.testing.assert_allclose(run.drive.angle[:, 0] / count, 10 * np.arange(1, 9) - 2.5)
    np.testing.assert_array_equal(run.drive.voltage[:, 0], np.arange(1, 9))
    assert "alpha_1: linear interpolation from its own clock" in run.notes


def test_a_command_on_another_clock_is_held_until_its_next_sample(imported):
    rows = [f"{k / 8},{k},{-k},{10 * k},{k / 8},{k / 8 + 1 / 32}" for k in range(9)]
    text = "\n".join(["t,u1,u2,n1,n2,t2", *rows]) + "\n"
    change = ('"u2", unit = "V" }', '"u2", unit = "V", t = { channel = "t2", unit = "s" } }')
    run = imported({"a.csv": text}, change=change)
    np.testing.assert_array_equal(run.drive.voltage[:, 1], -np.arange(8))


def test_wraps_signs_and_scales_are_undone(imported):
    counts = np.array([0, 900, 1800, 2700, 1800, 900, 0])
    rows = [f"{k / 8},{k},{-k},{n % 1024},{k / 8}" for k, n in enumerate(counts)]
    text = "\n".join(["t,u1,u2,n1,n2", *rows]) + "\n"
    change = ('"n1", unit = "count" }',
              '"n1", unit = "count", wraps = 1024, sign = -1, scale = 0.5 }')  # fmt: skip
    run = imported({"a.csv": text}, change=change)
    # Steps of 900 counts are steps of -124: a counter that goes round can't tell.
    steps = np.array([0, -124, -248, -372, -248, -124, 0])
    np.testing.assert_allclose(run.drive.angle[:, 0], -steps / 2 * 2 * np.pi / 1000, atol=1e-15)
    assert "wraps at 1024 taken out" in run.notes


def test_a_run_that_is_there_is_not_overwritten(imported, tmp_path):
    imported({"a.csv": table(np.arange(5))})
    before = (tmp_path / "out" / "0001-step" / "drive.csv").read_bytes()
    with pytest.raises(CampaignError, match="a run of that name is there already"):
        imported({"a.csv": table(np.arange(6))})
    assert (tmp_path / "out" / "0001-step" / "drive.csv").read_bytes() == before


def test_runs_are_added_to_a_campaign_that_keeps_its_own(imported, tmp_path):
    imported({"a.csv": table(np.arange(5))})
    rig = (tmp_path / "out" / "campaign.toml").read_bytes()
    imported({"a.csv": table(np.arange(6))}, change=("0001-step", "0002-step"))
    assert (tmp_path / "out" / "campaign.toml").read_bytes() == rig
    assert [run.name for run in read_campaign(tmp_path / "out").runs] == [
        "0001-step",
        "0002-step",
    ]
